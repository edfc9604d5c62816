//! Instruments first: what the kinematics alone say of the runs, with no model of the forces in the loop.
//!
//! Consumes the runs as they were recorded; produces the runs that are set aside, for their instruments do not agree or are not
//! those of the others, and the instruments' errors that all others share, each with what else it may be.

use crate::flight::effect::same_cause;
use crate::flight::file::effect_file::DeclaredEffect;
use crate::postflight::diagnosis::record::InstrumentDisagreement;
use crate::postflight::reconstruction::correction::Correction;
use crate::postflight::reconstruction::verdict::{Fitness, RunVerdict, check_watched};
use crate::postflight::recorded_run::RecordedRun;
use crate::postflight::work_progress::Watch;

/// What the kinematics alone say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstrumentCheck {
    /// Runs by place that are not to be used, and why.
    pub set_aside: Vec<(usize, InstrumentDisagreement)>,
    /// Errors of instruments: each explanation of one, the likeliest first.
    pub known: Vec<Vec<DeclaredEffect>>,
}

/// Standard errors of their difference by which numbers of one error are apart.
const APART: f64 = 5.0;

/// Whether two runs have the same instruments. What one bias is in each run is its own: an instrument starts anew with each.
fn same_instruments(one: &RunVerdict, other: &RunVerdict) -> bool {
    let same = |a: &DeclaredEffect, b: &DeclaredEffect| {
        let std = libm::hypot(a.std.unwrap_or(0.0), b.std.unwrap_or(0.0));
        let near = |(a, b): (f64, f64)| libm::fabs(a - b) <= APART * std;
        same_cause(&a.effect, &b.effect) && a.effect.main_number().zip(b.effect.main_number()).is_none_or(near)
    };
    one.corrections.len() == other.corrections.len()
        && one.corrections.iter().all(|a| other.corrections.iter().any(|b| same(&a.effect, &b.effect)))
}

/// Why a run is set aside: it is not fit, or its instruments are not those of the usual one.
fn disagreement(one: &RunVerdict, usual: &RunVerdict) -> InstrumentDisagreement {
    if one.fitness == Fitness::NotFit {
        return InstrumentDisagreement::NotFit(one.reason.clone());
    }
    let errors = |verdict: &RunVerdict| verdict.corrections.iter().map(|correction| correction.effect).collect();
    InstrumentDisagreement::OtherRuns { own: errors(one), others: errors(usual) }
}

/// Checks the runs together; nothing is known where the check was asked to end before it was done.
pub fn check_instruments(runs: &[RecordedRun], watch: Watch) -> InstrumentCheck {
    let Some(verdicts) = check_watched(runs, watch) else { return InstrumentCheck::default() };
    let fit: Vec<(usize, &RunVerdict)> =
        verdicts.iter().enumerate().filter(|(_, verdict)| verdict.fitness != Fitness::NotFit).collect();
    // The instruments of most runs; of two alike the first.
    let like = |one: &RunVerdict| fit.iter().filter(|(_, other)| same_instruments(other, one)).count();
    let usual = fit.iter().rev().max_by_key(|(_, verdict)| like(verdict)).map(|(_, verdict)| *verdict);
    let Some(usual) = usual else {
        return InstrumentCheck {
            set_aside: verdicts.iter().map(|one| InstrumentDisagreement::NotFit(one.reason.clone())).enumerate().collect(),
            known: Vec::new(),
        };
    };
    let aside = verdicts.iter().enumerate().filter(|(_, one)| one.fitness == Fitness::NotFit || !same_instruments(one, usual));
    let explanations = |correction: &Correction| -> Vec<DeclaredEffect> {
        core::iter::once(correction.effect).chain(correction.alternatives.iter().map(|one| one.effect)).collect()
    };
    InstrumentCheck {
        set_aside: aside.map(|(place, one)| (place, disagreement(one, usual))).collect(),
        known: usual.corrections.iter().map(explanations).collect(),
    }
}
