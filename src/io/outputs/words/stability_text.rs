//! The verdict on lateral-directional stability in words: stable, unstable, or not known yet and why.
//!
//! Stable where Dutch roll, roll and spiral all decay by three standard errors; unstable where one grows by three; otherwise not
//! known. The Dutch roll is that of the whole aircraft where there is one, else that of the lateral subsystem.

use super::status_text::status_in_words;
use crate::flight::channel::ControlNames;
use crate::io::outputs::tables::terminal::half_or_double;
use crate::realtime::modes::record::{ModeStability, ModesRecord};
use crate::realtime::regression::record::Status;

/// What is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LateralStability {
    /// Every lateral mode decays.
    Stable,
    /// A lateral mode grows.
    Unstable,
    /// Neither is known.
    NotKnown,
}

impl LateralStability {
    /// The words at the head of the sentence.
    pub const fn words(self) -> &'static str {
        match self {
            LateralStability::Stable => "STABLE",
            LateralStability::Unstable => "UNSTABLE",
            LateralStability::NotKnown => "NOT KNOWN YET",
        }
    }
}

/// The verdict with what it rests on, or why there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityVerdict {
    /// What is known.
    pub verdict: LateralStability,
    /// The rest of the sentence: `Dutch roll, roll and spiral decay`, `because ...`.
    pub reason: String,
}

/// The verdict by the modes of one instant.
pub fn lateral_verdict(modes: &ModesRecord, controls: ControlNames) -> StabilityVerdict {
    let not_known = |why: String| StabilityVerdict { verdict: LateralStability::NotKnown, reason: format!("because {why}") };
    let reservation = match modes.status {
        Status::Waiting => return not_known("no test input has excited the aircraft yet (waiting)".to_owned()),
        Status::Exciting => return not_known("the excitation so far does not resolve the derivatives (exciting)".to_owned()),
        Status::NotIdentifiable(_) => return not_known(format!("the modes are {}", status_in_words(modes.status, controls))),
        Status::Disagree => return not_known("time and frequency domain, or output error, give different numbers".to_owned()),
        Status::Converging => " (still converging)",
        Status::DependsOnAmplitude => ", at this amplitude of motion",
        Status::Stale => " (STALE: no new input for a while)",
        Status::Converged => "",
    };
    let found: Vec<(&str, ModeStability, f64)> = [
        modes.coupled.or(modes.dutch_roll).map(|pair| ("Dutch roll", pair.stability(), pair.real)),
        modes.lateral_phugoid.map(|pair| ("lateral phugoid", pair.stability(), pair.real)),
        modes.roll.map(|root| ("roll", root.stability(), root.value)),
        modes.spiral.map(|root| ("spiral", root.stability(), root.value)),
    ]
    .into_iter()
    .flatten()
    .collect();
    if found.is_empty() {
        return not_known("there are no modes".to_owned());
    }
    let of = |wanted: ModeStability| found.iter().filter(move |(_, stability, _)| *stability == wanted);
    let growing: Vec<String> =
        of(ModeStability::Unstable).map(|(name, _, real)| format!("{name} grows, {}", half_or_double(*real))).collect();
    if !growing.is_empty() {
        return StabilityVerdict { verdict: LateralStability::Unstable, reason: format!("{}{reservation}", growing.join("; ")) };
    }
    let names = |wanted| of(wanted).map(|(name, ..)| *name).collect::<Vec<_>>();
    let (decaying, unclear) = (names(ModeStability::Stable), names(ModeStability::Unclear));
    let decay = format!("{} decay{}", listed(&decaying), if decaying.len() > 1 { "" } else { "s" });
    if !unclear.is_empty() {
        let what = if unclear.len() > 1 { "are" } else { "is" };
        let others = if decaying.is_empty() { String::new() } else { format!("; {decay}{reservation}") };
        return not_known(format!("{} {what} within three standard errors of neutral{others}", listed(&unclear)));
    }
    StabilityVerdict { verdict: LateralStability::Stable, reason: format!("{decay}{reservation}") }
}

/// `roll`, `roll and spiral`, `Dutch roll, roll and spiral`.
fn listed(names: &[&str]) -> String {
    match names {
        [rest @ .., last] if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::modes::record::{OscillatoryMode, RealRoot};
    use crate::realtime::regression::record::Reason;

    fn said(status: Status, zeta: f64, spiral: f64) -> (LateralStability, String) {
        let pair = OscillatoryMode { real: -zeta * 1.8, zeta, std_zeta: 0.01, omega: 1.8, ..OscillatoryMode::default() };
        let modes = ModesRecord {
            time_s: 1.0,
            status,
            dutch_roll: Some(pair),
            roll: Some(RealRoot { value: -2.0, std: 0.1 }),
            spiral: Some(RealRoot { value: spiral, std: 0.004 }),
            lateral_phugoid: None,
            coupled: None,
        };
        let StabilityVerdict { verdict, reason } = lateral_verdict(&modes, ControlNames::Rotorcraft);
        (verdict, reason)
    }

    #[test]
    fn it_is_stable_unstable_or_not_known_and_says_why() {
        let cases = [
            (Status::Converged, 0.1, -0.02, LateralStability::Stable, "Dutch roll, roll and spiral decay"),
            (
                Status::Stale,
                0.1,
                -0.02,
                LateralStability::Stable,
                "Dutch roll, roll and spiral decay (STALE: no new input for a while)",
            ),
            (Status::Converged, 0.1, 0.02, LateralStability::Unstable, "spiral grows, time to double 34.7 s"),
            (
                Status::Converging,
                -0.1,
                -0.02,
                LateralStability::Unstable,
                "Dutch roll grows, time to double 3.85 s (still converging)",
            ),
            (
                Status::Converged,
                0.02,
                -0.01,
                LateralStability::NotKnown,
                "because Dutch roll and spiral are within three standard errors of neutral; roll decays",
            ),
            (
                Status::Waiting,
                0.1,
                -0.02,
                LateralStability::NotKnown,
                "because no test input has excited the aircraft yet (waiting)",
            ),
            (
                Status::NotIdentifiable(Reason::NoRates),
                0.1,
                -0.02,
                LateralStability::NotKnown,
                "because the modes are not identifiable: p, q and r come together too rarely or not at all",
            ),
        ];
        for (status, zeta, spiral, verdict, reason) in cases {
            assert_eq!(said(status, zeta, spiral), (verdict, reason.to_owned()));
        }
    }
}
