//! The published vocabulary of the diagnosis: causes with their probabilities, why a run is not used and why there is no
//! diagnosis; and while the flight goes on the findings as they are reported, refined and withdrawn.

use crate::flight::channel::{Channel, ControlNames};
use crate::flight::derivative::Axis;
use crate::flight::effect::Effect;
use crate::flight::file::effect_file::DeclaredEffect;
use crate::postflight::reconstruction::record::VerdictReason;

/// An effect with how probable it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankedCause {
    /// The effect.
    pub effect: Effect,
    /// Standard error of its main number.
    pub std: f64,
    /// Its posterior probability, (1) of `diagnose`.
    pub probability: f64,
    /// Twice the logarithm of its odds against nothing; of the cause found.
    pub odds: f64,
}

/// Motion on an axis that no cause explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnexplainedAxis {
    /// Where.
    pub axis: Axis,
    /// The band that holds most of it, Hz.
    pub band_hz: (f64, f64),
    /// What a free force or moment there would lower the cost by.
    pub worth: f64,
}

/// Standard errors from zero beyond which a difference of trim is reported.
const TRIM_DIFFERENCE_SIGNIFICANT: f64 = 3.0;

/// Where the runs begin, less the model's trim; of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrimDifference {
    /// The channel.
    pub channel: Channel,
    /// Mean over the runs, the channel's SI unit.
    pub value: f64,
    /// Standard error of that.
    pub std: f64,
    /// The largest of any run, without its sign.
    pub largest: f64,
    /// Standard deviation of one sample's noise.
    pub noise_std: f64,
}

impl TrimDifference {
    /// Whether it is known from zero, and more than a sample's noise.
    pub fn is_significant(&self) -> bool {
        libm::fabs(self.value) > (TRIM_DIFFERENCE_SIGNIFICANT * self.std).max(self.noise_std)
    }
}

/// Shorter runs are not used, s.
pub const LENGTH_MIN_S: f64 = 3.0;

/// Why a run is not used.
#[derive(Clone, Debug, PartialEq)]
pub enum Unusable {
    /// Its instruments do not agree, with no model of the forces in the loop.
    Instruments(InstrumentDisagreement),
    /// A control that the model answers to is not recorded.
    NoControl(&'static str),
    /// Time goes back.
    Back {
        /// Which sample, from 1.
        sample: usize,
        /// Time of the one before, s.
        before_s: f64,
        /// Its time, s.
        time_s: f64,
    },
    /// Channels read as if in a unit that is not the one declared.
    Unit {
        /// The channels.
        channels: Vec<Channel>,
        /// How the run calls its controls.
        controls: ControlNames,
        /// The symbol of the unit.
        unit: &'static str,
    },
    /// A rate is not recorded: its channel.
    NoRates(&'static str),
    /// Length of the time that has rates, s, less than [`LENGTH_MIN_S`].
    Short(f64),
    /// Interval of the rates, s, which is too long.
    Seldom(f64),
    /// Rates are interrupted between these times, s.
    Gap(f64, f64),
}

/// How the instruments of a run disagree.
#[derive(Clone, Debug, PartialEq)]
pub enum InstrumentDisagreement {
    /// With each other: the check's reason why the run is not fit.
    NotFit(VerdictReason),
    /// With those of the other runs.
    OtherRuns {
        /// Errors found in this run.
        own: Vec<DeclaredEffect>,
        /// Errors that the other runs share.
        others: Vec<DeclaredEffect>,
    },
}

/// Why there is no diagnosis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum DiagnosisError {
    #[error("no run is left to diagnose: {0}: {1}")]
    NoRun(String, Unusable),
    #[error("expected at least one run to diagnose, found none")]
    Empty,
    #[error("the model has no derivatives on any axis")]
    Silent,
    #[error("no control moves in any run: no cause is identifiable")]
    Still,
    #[error("the model cannot be filtered along these runs: it leaves the range of the equations of motion")]
    Diverged,
    #[error("{0}: {1}")]
    Holdout(String, Unusable),
}

/// Bytes of a statement.
pub const STATEMENT: usize = 240;

/// How a finding stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FindingStatus {
    /// Nothing has been flown yet that could be diagnosed.
    Waiting,
    /// It holds by the newest manoeuvres.
    Found,
    /// It held before; the newest manoeuvres do not show it.
    Retracted,
    /// The last diagnosis had no result, for the reason in the statement; earlier findings remain.
    Failed,
}

impl FindingStatus {
    /// Every one, in the order of their places.
    pub const ALL: [FindingStatus; 4] =
        [FindingStatus::Waiting, FindingStatus::Found, FindingStatus::Retracted, FindingStatus::Failed];

    /// Its place in [`FindingStatus::ALL`].
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            FindingStatus::Waiting => "waiting",
            FindingStatus::Found => "found",
            FindingStatus::Retracted => "taken back",
            FindingStatus::Failed => "failed",
        }
    }
}

/// One finding as it stands, or that there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct FindingRecord {
    /// Time of the newest sample that it rests on, s.
    pub time_s: f64,
    /// How it stands.
    pub standing: FindingStatus,
    /// Which finding of this run, from 1: the same while its cause is the same. 0 for what is no finding.
    pub number: u32,
    /// The cause; `none` where the model explains what was flown, `unknown` where no effect explains it.
    pub effect: Effect,
    /// Standard error of its main number; NaN where it has none.
    pub std: f64,
    /// How likely this is the cause; NaN where that cannot be said.
    pub probability: f64,
    /// Other causes that the data do not rule out.
    pub rivals: u32,
    /// Manoeuvres that it rests on.
    pub manoeuvres: u32,
    /// One sentence for a person.
    pub statement: heapless::String<STATEMENT>,
}

impl FindingRecord {
    /// Nothing yet.
    pub const EMPTY: FindingRecord = FindingRecord {
        time_s: 0.0,
        standing: FindingStatus::Waiting,
        number: 0,
        effect: Effect::None,
        std: f64::NAN,
        probability: f64::NAN,
        rivals: 0,
        manoeuvres: 0,
        statement: heapless::String::new(),
    };

    /// Puts a statement in, cut where there is no room for it.
    pub fn set_statement(&mut self, statement: &str) {
        self.statement.clear();
        for letter in statement.chars() {
            if self.statement.push(letter).is_err() {
                break;
            }
        }
    }
}

/// Findings in order of their numbers; the newest of each, and the newest word that is of none. Of more than there is room for
/// the last are not kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FindingsSoFar {
    kept: heapless::Vec<FindingRecord, 16>,
}

impl FindingsSoFar {
    /// None yet.
    pub const fn new() -> Self {
        FindingsSoFar { kept: heapless::Vec::new() }
    }

    /// Takes the place of what was said of it before.
    pub fn update(&mut self, record: &FindingRecord) {
        // A finding ends the report that there was nothing to diagnose, and the report of a diagnosis that failed.
        if record.number > 0 {
            self.kept.retain(|one| one.number > 0);
        }
        match self.kept.iter_mut().find(|one| one.number == record.number) {
            Some(before) => before.clone_from(record),
            None => {
                if self.kept.push(record.clone()).is_ok() {
                    self.kept.sort_unstable_by_key(|one| one.number);
                }
            }
        }
    }

    /// Every one.
    pub fn records(&self) -> &[FindingRecord] {
        &self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_word_of_each_finding_is_kept() {
        let word = |number, standing| FindingRecord { number, standing, ..FindingRecord::EMPTY };
        let mut so_far = FindingsSoFar::new();
        so_far.update(&FindingRecord::EMPTY);
        assert_eq!(so_far.records().len(), 1);
        for (number, standing) in
            [(2, FindingStatus::Found), (1, FindingStatus::Found), (2, FindingStatus::Retracted), (0, FindingStatus::Failed)]
        {
            so_far.update(&word(number, standing));
        }
        let kept: Vec<_> = so_far.records().iter().map(|one| (one.number, one.standing)).collect();
        assert_eq!(kept, [(0, FindingStatus::Failed), (1, FindingStatus::Found), (2, FindingStatus::Retracted)]);
        for number in 3..100 {
            so_far.update(&word(number, FindingStatus::Found));
        }
        assert_eq!(so_far.records().len(), 16);
    }

    #[test]
    fn a_statement_is_cut_between_letters() {
        let mut record = FindingRecord::EMPTY;
        record.set_statement(&"a\u{e9}".repeat(100));
        assert_eq!(record.statement.len(), STATEMENT);
    }
}
