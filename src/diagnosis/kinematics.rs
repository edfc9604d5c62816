//! Instruments first: what the kinematics alone say of the runs, with no model of the forces in the loop.
//!
//! Consumes the runs as they were recorded; produces the runs that are set aside, for their instruments do not agree or are not
//! those of the others, and the instruments' errors that all others share, each with what else it may be.

use super::diagnose::Recorded;
use super::explain::value;
use crate::estimation::compatibility::correction::Correction;
use crate::estimation::compatibility::verdict::{Candidate, Fitness, Verdict, check};
use crate::flight::channel::ControlNames;
use crate::flight::effect::same_cause;
use crate::flight::effect_file::DeclaredEffect;

/// What the kinematics alone say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kinematics {
    /// Runs by place that are not to be used, and why.
    pub set_aside: Vec<(usize, String)>,
    /// Errors of instruments: each explanation of one, the likeliest first.
    pub known: Vec<Vec<DeclaredEffect>>,
}

/// Standard errors of their difference by which numbers of one error are apart.
const APART: f64 = 5.0;

/// Whether two runs have the same instruments. What one bias is in each run is its own: an instrument starts anew with each.
fn alike(one: &Verdict, other: &Verdict) -> bool {
    let same = |a: &DeclaredEffect, b: &DeclaredEffect| {
        let std = libm::hypot(a.std.unwrap_or(0.0), b.std.unwrap_or(0.0));
        let near = |(a, b): (f64, f64)| libm::fabs(a - b) <= APART * std;
        same_cause(&a.effect, &b.effect) && a.effect.main_number().zip(b.effect.main_number()).is_none_or(near)
    };
    one.corrections.len() == other.corrections.len()
        && one.corrections.iter().all(|a| other.corrections.iter().any(|b| same(&a.effect, &b.effect)))
}

/// Why a run is set aside: it is not fit, or its instruments are not those of the usual one.
fn why(one: &Verdict, usual: &Verdict) -> String {
    if one.fitness == Fitness::NotFit {
        return one.reason.clone();
    }
    let errors = |verdict: &Verdict| match verdict.corrections.as_slice() {
        [] => "none".to_owned(),
        all => all.iter().map(error).collect::<Vec<_>>().join(", "),
    };
    format!("errors found in it: {}; in the other runs: {}", errors(one), errors(usual))
}

/// An instrument's error: its kind, the channel where it is on one, the number.
fn error(correction: &Correction) -> String {
    let DeclaredEffect { effect, std } = correction.effect;
    let channel = effect.sensor_channel().map(|channel| channel.name(ControlNames::Rotorcraft).to_owned());
    let number = effect.main_number().map(|number| value(number, std.unwrap_or(0.0)));
    let parts = [Some(effect.kind().name().to_owned()), channel, number];
    parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// Checks the runs together.
pub fn kinematics(runs: &[Recorded]) -> Kinematics {
    let candidate = |run: &Recorded| Candidate { name: run.name.clone(), samples: run.samples.clone(), geometry: run.geometry };
    let verdicts = check(&runs.iter().map(candidate).collect::<Vec<_>>());
    let fit: Vec<(usize, &Verdict)> =
        verdicts.iter().enumerate().filter(|(_, verdict)| verdict.fitness != Fitness::NotFit).collect();
    // The instruments of most runs; of two alike the first.
    let like = |one: &Verdict| fit.iter().filter(|(_, other)| alike(other, one)).count();
    let usual = fit.iter().rev().max_by_key(|(_, verdict)| like(verdict)).map(|(_, verdict)| *verdict);
    let Some(usual) = usual else {
        return Kinematics { set_aside: verdicts.iter().map(|one| one.reason.clone()).enumerate().collect(), known: Vec::new() };
    };
    let aside = verdicts.iter().enumerate().filter(|(_, one)| one.fitness == Fitness::NotFit || !alike(one, usual));
    let explanations = |correction: &Correction| -> Vec<DeclaredEffect> {
        core::iter::once(correction.effect).chain(correction.alternatives.iter().map(|one| one.effect)).collect()
    };
    Kinematics {
        set_aside: aside.map(|(place, one)| (place, why(one, usual))).collect(),
        known: usual.corrections.iter().map(explanations).collect(),
    }
}
