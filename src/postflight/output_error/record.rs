//! The published vocabulary of output error that is run while the flight goes on.

use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::realtime::modes::record::{OscillatoryMode, RealRoot};
use core::fmt::{self, Write};
use heapless::{String, Vec};

/// Derivatives that there is room for: all.
pub const PARAMETERS: usize = AXES * VARIABLES;
/// Bytes of a reason.
pub const REASON: usize = 120;

/// How far it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputErrorProgress {
    /// Nothing has been flown yet that it could be fitted to.
    Waiting,
    /// There are numbers; they still move or are still uncertain.
    Converging,
    /// The numbers have settled, and the Dutch roll (or the short period) is known.
    Converged,
    /// There are numbers, from before: nothing new has come for a while.
    Stale,
    /// The last fit gave none, for a reason; numbers that stand beside it are from before.
    Failed,
    /// There are numbers; the regression gives others, further away than both standard errors allow.
    Disagree,
}

impl OutputErrorProgress {
    /// Every one, in the order of their places.
    pub const ALL: [OutputErrorProgress; 6] = [
        OutputErrorProgress::Waiting,
        OutputErrorProgress::Converging,
        OutputErrorProgress::Converged,
        OutputErrorProgress::Stale,
        OutputErrorProgress::Failed,
        OutputErrorProgress::Disagree,
    ];

    /// Its place in [`OutputErrorProgress::ALL`].
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            OutputErrorProgress::Waiting => "waiting",
            OutputErrorProgress::Converging => "converging",
            OutputErrorProgress::Converged => "converged",
            OutputErrorProgress::Stale => "stale",
            OutputErrorProgress::Failed => "failed",
            OutputErrorProgress::Disagree => "disagree",
        }
    }
}

/// A derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterRecord {
    /// Axis of its equation.
    pub axis: Axis,
    /// Its variable.
    pub variable: Variable,
    /// Its value, SI and radians.
    pub value: f64,
    /// Standard error corrected for the colour of the residuals; where these are far from white, or the search has not ended,
    /// scaled to the regression's.
    pub std: f64,
    /// The same by the bound of Cramer and Rao: right only for white residuals.
    pub std_cramer_rao: f64,
}

/// Output error as it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputErrorRecord {
    /// Time of the newest sample when this was said, s.
    pub time_s: f64,
    /// Time of the newest sample that the numbers rest on, s; NaN where there are none.
    pub fitted_s: f64,
    /// How far it is.
    pub progress: OutputErrorProgress,
    /// Why the last fit gave no numbers, or what is to be known of them.
    pub reason: String<REASON>,
    /// The derivatives.
    pub parameters: Vec<ParameterRecord, PARAMETERS>,
    /// Dutch roll of the lateral subsystem.
    pub dutch_roll: Option<OscillatoryMode>,
    /// Roll subsidence.
    pub roll: Option<RealRoot>,
    /// Spiral.
    pub spiral: Option<RealRoot>,
    /// The slower pair where roll and spiral have joined.
    pub lateral_phugoid: Option<OscillatoryMode>,
    /// Dutch roll of the whole aircraft.
    pub coupled: Option<OscillatoryMode>,
    /// Short period of the longitudinal subsystem.
    pub short_period: Option<OscillatoryMode>,
    /// Manoeuvres that the numbers rest on.
    pub manoeuvres: u32,
    /// Manoeuvres that were left behind because there is no more room.
    pub dropped: u32,
    /// Samples that the numbers rest on.
    pub samples: u32,
}

impl OutputErrorRecord {
    /// Nothing yet.
    pub const EMPTY: OutputErrorRecord = OutputErrorRecord {
        time_s: 0.0,
        fitted_s: f64::NAN,
        progress: OutputErrorProgress::Waiting,
        reason: String::new(),
        parameters: Vec::new(),
        dutch_roll: None,
        roll: None,
        spiral: None,
        lateral_phugoid: None,
        coupled: None,
        short_period: None,
        manoeuvres: 0,
        dropped: 0,
        samples: 0,
    };

    /// A derivative.
    pub fn parameter(&self, axis: Axis, variable: Variable) -> Option<&ParameterRecord> {
        self.parameters.iter().find(|one| one.axis == axis && one.variable == variable)
    }

    /// Takes every number out: the fit counts as failed.
    pub fn withhold(&mut self) {
        *self = OutputErrorRecord {
            time_s: self.time_s,
            progress: OutputErrorProgress::Failed,
            manoeuvres: self.manoeuvres,
            dropped: self.dropped,
            ..OutputErrorRecord::EMPTY
        };
    }

    /// Puts a reason in, cut where there is no room for it; nothing is allocated.
    pub fn explain(&mut self, reason: impl fmt::Display) {
        self.reason.clear();
        let _ = write!(CutText(&mut self.reason), "{reason}");
    }
}

/// Text that ends where there is no more room, in the middle of what is written if need be.
struct CutText<'a>(&'a mut String<REASON>);

impl fmt::Write for CutText<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.chars().try_for_each(|letter| self.0.push(letter).map_err(|_| fmt::Error))
    }
}
