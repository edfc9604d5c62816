//! The check as a whole: runs by name in, a verdict on each out.
//!
//! Damaged samples are screened, coarse errors looked for, runs that no fit can use refused; the others are fitted together, but
//! for those whose instruments are not those of the others.

use super::fault_selection::run_of;
use super::fit::RunWithNoise;
use super::observability::absent;
use super::outlier_runs::{RunGroup, groups};
use super::record::RunChannels;
use super::refusal::refusal;
use super::run_verdict::run_verdict;
pub use super::run_verdict::{Fitness, RunVerdict};
use super::screening::{Screened, screen};
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;

/// A run to be checked.
#[derive(Clone, Debug)]
pub struct CheckedRun {
    /// What it is called.
    pub name: String,
    /// Its samples in order of time.
    pub samples: Vec<Sample>,
    /// Where its instruments are said to stand.
    pub geometry: RunGeometry,
}

/// Checks all runs together.
pub fn check(candidates: &[CheckedRun]) -> Vec<RunVerdict> {
    let screened: Vec<(Vec<Sample>, Vec<Screened>)> = candidates
        .iter()
        .map(|one| {
            let mut samples = one.samples.clone();
            let taken = screen(&mut samples);
            (samples, taken)
        })
        .collect();
    let gathered = candidates.iter().zip(&screened);
    let records: Vec<RunChannels> = gathered.map(|(one, (samples, _))| RunChannels::of(samples, &one.geometry)).collect();
    let gathered = records.iter().zip(&screened);
    let refusals: Vec<Option<String>> = gathered.map(|(record, (samples, taken))| refusal(record, samples, taken)).collect();
    let usable: Vec<usize> = (0..records.len()).filter(|&place| refusals.get(place).is_some_and(Option::is_none)).collect();
    let runs: Vec<RunWithNoise> = usable.iter().filter_map(|&place| records.get(place).cloned()).map(run_of).collect();
    let names: Vec<String> = usable.iter().filter_map(|&place| Some(candidates.get(place)?.name.clone())).collect();
    let mut verdicts: Vec<Option<RunVerdict>> = vec![None; candidates.len()];
    for group in groups(&runs) {
        for (number, verdict) in of_group(&group, &names) {
            if let Some(place) = usable.get(number)
                && let Some(there) = verdicts.get_mut(*place)
            {
                *there = Some(verdict);
            }
        }
    }
    let rows = verdicts.into_iter().zip(candidates).zip(records.iter().zip(refusals)).zip(screened);
    rows.map(|(((verdict, candidate), (record, refusal)), (_, screened))| {
        let verdict = verdict.unwrap_or_else(|| RunVerdict {
            run: candidate.name.clone(),
            fitness: Fitness::NotFit,
            reason: refusal.unwrap_or_else(|| "the kinematics cannot follow its motion".to_owned()),
            corrections: Vec::new(),
            consistency: [None; 2],
            not_observable: absent(record),
            screened: Vec::new(),
        });
        RunVerdict { screened, ..verdict }
    })
    .collect()
}

/// The verdicts on a group's runs, by their places among all.
fn of_group(group: &RunGroup, names: &[String]) -> Vec<(usize, RunVerdict)> {
    let names: Vec<String> = group.members.iter().filter_map(|&run| names.get(run).cloned()).collect();
    let one = |(number, (&run, name)): (usize, (&usize, &String))| {
        let mut verdict = run_verdict(name, &group.found, number, &names, &group.alone)?;
        if group.apart {
            let alike = if group.members.len() > 1 { "those it is like" } else { "itself" };
            let why =
                if verdict.corrections.is_empty() { " and nothing found that tells why (do not pool it with them)" } else { "" };
            verdict.reason = format!("unlike the other runs, so checked by {alike}{why}: {}", verdict.reason);
        }
        Some((run, verdict))
    };
    group.members.iter().zip(&names).enumerate().filter_map(one).collect()
}
