//! The vocabulary of the estimation: what is searched, what comes out, and why nothing does.

use crate::io::telemetry::alignment::clock_relation::ClockRelation;

/// What is searched, and what is taken for an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockSearch {
    /// Our time less theirs in the middle of their record, from, to, s; every offset that leaves an overlap where `None`.
    pub difference_s: Option<(f64, f64)>,
    /// The overlap is at least so long, s.
    pub least_overlap_s: f64,
    /// Drifts between minus and plus this are searched.
    pub drift_max: f64,
    /// The drift where it is known (0 for one clock that only started elsewhere); estimated where `None`.
    pub drift: Option<f64>,
    /// An estimate of the drift that is less certain is none.
    pub drift_std_max: f64,
    /// Part of unrelated pairs that may be taken for related ones.
    pub false_alarm_rate: f64,
    /// A second peak of this part of the first makes the answer ambiguous.
    pub second_peak: f64,
}

impl Default for ClockSearch {
    fn default() -> Self {
        ClockSearch {
            difference_s: None,
            least_overlap_s: 10.0,
            drift_max: 250e-6,
            drift: None,
            drift_std_max: 100e-6,
            false_alarm_rate: 1e-3,
            second_peak: 0.7,
        }
    }
}

/// The relation, and what it rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockEstimate {
    /// The relation with its standard errors.
    pub relation: ClockRelation,
    /// Theirs over ours in the channel, with its standard error.
    pub scale: (f64, f64),
    /// Standard deviation of the white noise of ours and theirs, in the unit of each.
    pub noise_std: [f64; 2],
    /// Significance of the correlation, and what it had to be.
    pub significance: (f64, f64),
    /// Of the second peak.
    pub second_significance: f64,
    /// Factor on the variances for colour of the residuals; 1 where they are white.
    pub colour_factor: f64,
    /// Length of the overlap on our clock, s.
    pub overlap_s: f64,
    /// Distance of the spline's knots, s: the signals were compared below half of its inverse.
    pub knots_s: f64,
}

/// Why there is no relation.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum ClockUnknown {
    #[error("not known, because {samples} samples of the shared channel are too few: {needed} are needed in each recording")]
    TooFewSamples { samples: usize, needed: usize },
    #[error("not known, because the shared channel does not move in one of the recordings")]
    NoMotion,
    #[error("not known, because no offset leaves an overlap of {least_s} s with the shared channel in both")]
    NoOverlap { least_s: f64 },
    #[error("not known, because the recordings agree nowhere: significance {found:.1}, needed {needed:.1}")]
    NoPeak { found: f64, needed: f64 },
    #[error(
        "not known, because two offsets explain the recordings: our time less theirs may be {first_s:.3} s \
         (significance {first:.1}) or {second_s:.3} s ({second:.1})"
    )]
    Ambiguous { first_s: f64, first: f64, second_s: f64, second: f64 },
    #[error(
        "not known, because {overlap_s:.1} s in common are too short for the drift: its standard error would be \
         {:.0} ppm, {:.0} are admitted (with a drift that is given, our time less theirs would be {difference_s:.6} +- {time_std_s:.2e} s)",
        1e6 * drift_std, 1e6 * admitted
    )]
    TooShortForDrift { overlap_s: f64, drift_std: f64, admitted: f64, difference_s: f64, time_std_s: f64 },
    #[error("not known, because the drift found, {:.0} ppm, is beyond the {:.0} ppm that are searched", 1e6 * drift, 1e6 * admitted)]
    DriftBeyond { drift: f64, admitted: f64 },
    #[error("not known, because the shared channel is too noisy for its time: the search does not settle")]
    NotSettled,
    #[error("not known, because the search settles {moved_s:.3} s away from the peak of the correlation")]
    LeftPeak { moved_s: f64 },
}

/// A place where the records agree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) width_s: f64,
    pub(super) drift: f64,
    /// The middle of their record, s, and our time less theirs there.
    pub(super) center_s: f64,
    pub(super) difference_s: f64,
    pub(super) significance: f64,
}
