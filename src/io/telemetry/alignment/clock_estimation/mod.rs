//! Estimation of the relation of two clocks from a channel that both recordings have.
//!
//! Consumes the samples of the channel in both recordings, each in order of its own clock, of any rates, with gaps; theirs may
//! have another bias, trend, scale and sign. Produces [`ClockEstimate`]: the relation with standard errors, and what it rests on.
//! 1. Search over all offsets that leave an overlap, on several widths of bins and, for long records, several drifts:
//!    significance of the correlation of the whitened records ([`correlation`]). The best width is where both agree most.
//! 2. Maximum likelihood from there ([`joint_fit`]), on splines of ever closer knots while cross-validation gains by it.
//! 3. Standard errors with the colour of the residuals ([`coloured_residuals`]).
//!
//! Refused ([`ClockUnknown`]), never answered with a wrong number: too little in common; no significant correlation; two peaks of
//! similar height (a periodic manoeuvre); a record too short for the drift; a search that does not settle. On unrelated records
//! a relation comes out in less than [`ClockSearch::false_alarm_rate`] of cases, by a bound that holds for any record of
//! symmetric noise of one spectrum ([`correlation`] (2)).
//! Assumed: noise of the samples is white or nearly so (else see 3), and clocks run at constant rates: a clock that jumps within
//! the record is for [`super::reorder`]. Memory: both records, and ten numbers for each interval of knots.
//! Source: C. H. Knapp and G. C. Carter, IEEE Trans. ASSP-24, 1976: the standard error is held against their bound,
//!     var m >= 1/(2 T int_0^inf (2 pi f)^2 S^2/(S (N_1 + N_2) + N_1 N_2) df)                            (1)
//! with S, N_1, N_2 the two-sided densities of signal and noises.

mod coloured_residuals;
mod correlation;
mod joint_fit;
mod prewhitening;
mod refinement;
mod spline;

use super::clock_relation::ClockRelation;
use crate::flight::signal::series::Series;
use correlation::{LagPeak, significances, threshold};
use prewhitening::{BinnedRecord, whitened};
use refinement::refined;

/// Bins of one record at most: wider ones where it is longer.
const BINS_MAX: f64 = 262_144.0;
/// Bins of the shorter record at least; no wider ones are tried.
const BINS_LEAST: f64 = 25.0;
/// Each width is so many times the one before.
const WIDTH_RATIO: f64 = 2.0;
/// Begins of bins that are tried, and bins from which one is enough.
const BEGINS: usize = 4;
const BEGINS_BINS: f64 = 2000.0;
/// Drifts that are tried at most.
const DRIFTS_MAX: usize = 41;
/// Peaks so many bins apart are two.
const APART: i64 = 4;

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

/// Samples of each recording at least.
const SAMPLES_LEAST: usize = 100;

/// A place where the records agree.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    width_s: f64,
    drift: f64,
    /// Our time less theirs in the middle of theirs, s.
    difference_s: f64,
    significance: f64,
}

/// Estimates the relation from the channel in our and in their recording.
///
/// # Errors
/// [`ClockUnknown`] where the recordings do not determine it.
pub fn estimate_clock_relation(ours: &Series, theirs: &Series, search: &ClockSearch) -> Result<ClockEstimate, ClockUnknown> {
    let samples = ours.len().min(theirs.len());
    if samples < SAMPLES_LEAST {
        return Err(ClockUnknown::TooFewSamples { samples, needed: SAMPLES_LEAST });
    }
    let (best, needed, second) = searched(ours, theirs, search)?;
    let second_significance = second.map_or(0.0, |second| second.significance);
    if let Some(second) = second.filter(|second| second.significance > search.second_peak * best.significance) {
        return Err(ClockUnknown::Ambiguous {
            first_s: best.difference_s,
            first: best.significance,
            second_s: second.difference_s,
            second: second.significance,
        });
    }
    let refined = refined(ours, theirs, search, &best)?;
    Ok(ClockEstimate { significance: (best.significance, needed), second_significance, ..refined })
}

fn middle(series: &Series) -> f64 {
    series.range_s().map_or(0.0, |(from_s, to_s)| 0.5 * (from_s + to_s))
}

/// The best place, the significance that it needed, and the second best apart from it on the same bins.
fn searched(ours: &Series, theirs: &Series, search: &ClockSearch) -> Result<(Candidate, f64, Option<Candidate>), ClockUnknown> {
    let length = |series: &Series| series.range_s().map_or(0.0, |(from_s, to_s)| to_s - from_s);
    let interval = |series: &Series| series.interval_s().unwrap_or(0.0);
    let (longest_s, shortest_s) = (length(ours).max(length(theirs)), length(ours).min(length(theirs)));
    let mut width_s = (2.0 * interval(ours).max(interval(theirs))).max(longest_s / BINS_MAX);
    let (mut tried, mut best, mut moved) = (0, None::<(Candidate, Option<Candidate>)>, false);
    while shortest_s / width_s >= BINS_LEAST {
        if let Some(our_bins) = BinnedRecord::of(ours, width_s, 0.0) {
            for (drift, late_s) in tries(search, shortest_s, width_s) {
                let center_s = middle(theirs);
                let stretched = Series::of(theirs.samples().map(|(t, x)| (center_s + (1.0 + drift) * (t - center_s), x)));
                let Some(their_bins) = BinnedRecord::of(&stretched, width_s, late_s) else { continue };
                let Some(white) = whitened(&our_bins, &their_bins) else { continue };
                moved = true;
                let difference_s = |lag: i64| our_bins.from_s - their_bins.from_s + lag as f64 * width_s;
                let bins = (our_bins.bins.len() as i64, their_bins.bins.len() as i64);
                let admitted = |lag: i64| {
                    let overlap = bins.0.min(bins.1 + lag) - lag.max(0);
                    let range = search.difference_s.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                    overlap as f64 * width_s >= search.least_overlap_s
                        && (range.0 - width_s..=range.1 + width_s).contains(&difference_s(lag))
                };
                let found = significances(&white, admitted);
                tried += found.len();
                let Some(peak) = highest(found.iter()) else { continue };
                if best.as_ref().is_none_or(|(best, _)| libm::fabs(peak.significance) > best.significance) {
                    let candidate = |peak: LagPeak| Candidate {
                        width_s,
                        drift,
                        difference_s: difference_s(peak.lag),
                        significance: libm::fabs(peak.significance),
                    };
                    let apart = |other: &&LagPeak| (other.lag - peak.lag).abs() >= APART;
                    best = Some((candidate(peak), highest(found.iter().filter(apart)).map(candidate)));
                }
            }
        }
        width_s *= WIDTH_RATIO;
    }
    let Some((best, second)) = best else {
        let nowhere = ClockUnknown::NoOverlap { least_s: search.least_overlap_s };
        return Err(if moved { nowhere } else { ClockUnknown::NoMotion });
    };
    let needed = threshold(search.false_alarm_rate, tried);
    if !(best.significance > needed) {
        return Err(ClockUnknown::NoPeak { found: best.significance, needed });
    }
    Ok((best, needed, second))
}

fn highest<'a>(peaks: impl Iterator<Item = &'a LagPeak>) -> Option<LagPeak> {
    peaks.copied().max_by(|a, b| libm::fabs(a.significance).total_cmp(&libm::fabs(b.significance)))
}

/// Drifts so close to each other that none smears a bin, each with bins of theirs that begin later by parts of their width, so
/// that some fall together with ours; of many narrow bins one begin is enough.
fn tries(search: &ClockSearch, length_s: f64, width_s: f64) -> Vec<(f64, f64)> {
    let steps = (libm::ceil(search.drift_max * length_s / width_s) as usize).min(DRIFTS_MAX / 2) as i32;
    let drifts: Vec<f64> = match search.drift {
        Some(drift) => vec![drift],
        None => (-steps..=steps).map(|k| search.drift_max * f64::from(k) / f64::from(steps.max(1))).collect(),
    };
    let begins = if length_s / width_s > BEGINS_BINS { 1 } else { BEGINS };
    let late_s = |k: usize| k as f64 / begins as f64 * width_s;
    drifts.into_iter().flat_map(|drift| (0..begins).map(move |k| (drift, late_s(k)))).collect()
}
