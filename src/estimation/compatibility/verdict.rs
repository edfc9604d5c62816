//! The check as a whole: runs by name in, a verdict on each out.
//!
//! Damaged samples are screened, coarse errors looked for, runs that no fit can use refused; the others are fitted together, but
//! for those whose instruments are not those of the others.

use super::correction::Correction;
use super::fit::Run;
use super::judge::judged;
use super::observable::absent;
use super::odd::{Group, groups};
use super::record::Record;
use super::refusal::refusal;
use super::select::run_of;
use crate::estimation::screening::{Screened, screen};
use crate::flight::run::RunGeometry;
use crate::telemetry::record::Sample;

/// A run to be checked.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What it is called.
    pub name: String,
    /// Its samples in order of time.
    pub samples: Vec<Sample>,
    /// Where its instruments are said to stand.
    pub geometry: RunGeometry,
}

/// How a run is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitness {
    /// As it is.
    Fit,
    /// Once the corrections are made.
    FitCorrected,
    /// Not for identification.
    NotFit,
}

impl Fitness {
    /// The words in results.
    pub const fn words(self) -> &'static str {
        match self {
            Fitness::Fit => "fit",
            Fitness::FitCorrected => "fit after corrections",
            Fitness::NotFit => "not fit",
        }
    }
}

/// What is to be said of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Its name.
    pub run: String,
    /// Whether it is fit.
    pub fitness: Fitness,
    /// Why.
    pub reason: String,
    /// Its corrections, the most significant first.
    pub corrections: Vec<Correction>,
    /// R2 of incidence and sideslip before and after.
    pub consistency: [Option<(f64, Option<f64>)>; 2],
    /// What cannot be known, a phrase each with its reason.
    pub not_observable: Vec<String>,
    /// Samples that no instrument measured, taken out before.
    pub screened: Vec<Screened>,
}

/// Checks all runs together.
pub fn check(candidates: &[Candidate]) -> Vec<Verdict> {
    let screened: Vec<(Vec<Sample>, Vec<Screened>)> = candidates
        .iter()
        .map(|one| {
            let mut samples = one.samples.clone();
            let taken = screen(&mut samples);
            (samples, taken)
        })
        .collect();
    let gathered = candidates.iter().zip(&screened);
    let records: Vec<Record> = gathered.map(|(one, (samples, _))| Record::of(samples, &one.geometry)).collect();
    let gathered = records.iter().zip(&screened);
    let refusals: Vec<Option<String>> = gathered.map(|(record, (samples, taken))| refusal(record, samples, taken)).collect();
    let usable: Vec<usize> = (0..records.len()).filter(|&place| refusals.get(place).is_some_and(Option::is_none)).collect();
    let runs: Vec<Run> = usable.iter().filter_map(|&place| records.get(place).cloned()).map(run_of).collect();
    let names: Vec<String> = usable.iter().filter_map(|&place| Some(candidates.get(place)?.name.clone())).collect();
    let mut verdicts: Vec<Option<Verdict>> = vec![None; candidates.len()];
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
        let verdict = verdict.unwrap_or_else(|| Verdict {
            run: candidate.name.clone(),
            fitness: Fitness::NotFit,
            reason: refusal.unwrap_or_else(|| "the kinematics cannot follow its motion".to_owned()),
            corrections: Vec::new(),
            consistency: [None; 2],
            not_observable: absent(record),
            screened: Vec::new(),
        });
        Verdict { screened, ..verdict }
    })
    .collect()
}

/// The verdicts on a group's runs, by their places among all.
fn of_group(group: &Group, names: &[String]) -> Vec<(usize, Verdict)> {
    let names: Vec<String> = group.members.iter().filter_map(|&run| names.get(run).cloned()).collect();
    let one = |(number, (&run, name)): (usize, (&usize, &String))| {
        let mut verdict = judged(name, &group.found, number, &names, &group.alone)?;
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
