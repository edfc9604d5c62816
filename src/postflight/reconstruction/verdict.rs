//! The check as a whole: runs by name in, a verdict on each out.
//!
//! Damaged samples are screened where a run is not screened yet, gross errors tested, runs that no fit can use refused; the
//! others are fitted together, but for those whose instruments are not those of the others.

use super::fault_selection::run_of;
use super::fit::RunWithNoise;
use super::observability::absent;
use super::outlier_runs::{RunGroup, groups};
use super::record::VerdictReason;
use super::refusal::refusal;
use super::run_channels::RunChannels;
use super::run_verdict::run_verdict;
pub use super::run_verdict::{Fitness, RunVerdict};
use super::screening::{Screened, screen};
use crate::flight::sample::Sample;
use crate::postflight::recorded_run::RecordedRun;
use crate::postflight::work_progress::{Watch, is_stopped};
use std::borrow::Cow;

/// Checks all runs together.
pub fn check(candidates: &[RecordedRun]) -> Vec<RunVerdict> {
    check_watched(candidates, None).unwrap_or_default()
}

/// The same for who watches; `None` where the check was asked to end.
pub fn check_watched(candidates: &[RecordedRun], watch: Watch) -> Option<Vec<RunVerdict>> {
    let screened: Vec<(Cow<'_, [Sample]>, Vec<Screened>)> = candidates.iter().map(without_damage).collect();
    let gathered = candidates.iter().zip(&screened);
    let records: Vec<RunChannels> = gathered.map(|(one, (samples, _))| RunChannels::of(samples, &one.geometry)).collect();
    let gathered = records.iter().zip(&screened);
    let refusals: Vec<Option<VerdictReason>> =
        gathered.map(|(record, (samples, taken))| refusal(record, samples, taken)).collect();
    let usable: Vec<usize> = (0..records.len()).filter(|&place| refusals.get(place).is_some_and(Option::is_none)).collect();
    let runs: Vec<RunWithNoise> = usable
        .iter()
        .filter_map(|&place| records.get(place).cloned())
        .map(|record| RunWithNoise { watch, ..run_of(record) })
        .collect();
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
    if is_stopped(watch) {
        return None;
    }
    let rows = verdicts.into_iter().zip(candidates).zip(records.iter().zip(refusals)).zip(screened);
    let judged = rows.map(|(((verdict, candidate), (record, refusal)), (_, screened))| {
        let verdict = verdict.unwrap_or_else(|| RunVerdict {
            run: candidate.name.clone(),
            fitness: Fitness::NotFit,
            reason: refusal.unwrap_or(VerdictReason::NotFollowed),
            corrections: Vec::new(),
            consistency: [None; 2],
            not_observable: absent(record),
            screened: Vec::new(),
            long_gaps: Vec::new(),
        });
        RunVerdict { screened, long_gaps: record.long_gaps.clone(), ..verdict }
    });
    Some(judged.collect())
}

/// A run's samples without the damaged ones, and what was taken out of them here.
fn without_damage(run: &RecordedRun) -> (Cow<'_, [Sample]>, Vec<Screened>) {
    if run.screened {
        return (Cow::Borrowed(&run.samples), Vec::new());
    }
    let mut samples = run.samples.clone();
    let taken = screen(&mut samples);
    (Cow::Owned(samples), taken)
}

/// The verdicts on a group's runs, by their places among all.
fn of_group(group: &RunGroup, names: &[String]) -> Vec<(usize, RunVerdict)> {
    let names: Vec<String> = group.members.iter().filter_map(|&run| names.get(run).cloned()).collect();
    let one = |(number, (&run, name)): (usize, (&usize, &String))| {
        let mut verdict = run_verdict(name, &group.found, number, &names, &group.alone)?;
        if group.apart {
            let unexplained = verdict.corrections.is_empty();
            let reason = Box::new(verdict.reason);
            verdict.reason = VerdictReason::Outlier { alone: group.members.len() == 1, unexplained, reason };
        }
        Some((run, verdict))
    };
    group.members.iter().zip(&names).enumerate().filter_map(one).collect()
}
