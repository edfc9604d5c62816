//! Estimation of the relation of two clocks from a channel that both recordings have.
//!
//! Consumes the samples of the channel in both recordings, each in order of its own clock, of any rates, with gaps; theirs may
//! have another bias, trend, scale and sign. Produces [`ClockEstimate`]: the relation with standard errors, and what it rests on.
//! 1. Search over all offsets that leave an overlap, on several widths of bins and, for long records, several drifts:
//!    significance of the correlation of the whitened records (`correlation`). The best width is where both agree most.
//! 2. Maximum likelihood from there (`joint_fit`), on splines of ever closer knots while cross-validation gains by it.
//! 3. Standard errors with the colour of the residuals (`coloured_residuals`).
//!
//! Refused ([`ClockUnknown`]), never answered with a wrong number: too little in common; no significant correlation; two peaks of
//! similar height (a periodic manoeuvre); a record too short for the drift; a search that does not settle. Of unrelated records
//! at most a part [`ClockSearch::false_alarm_rate`] gets past the search (`correlation` (4)); none of 1000 pairs did, see
//! `tests/telemetry/clock_coverage.rs`. What a model of the record foretells is no evidence: channels that move much (rates,
//! forces, airspeed in gusts) tell more than attitude and altitude, and one free oscillation looks like another. Where a short
//! record gives nothing, [`ClockSearch::difference_s`] with what is known of the offset lowers what is needed.
//! Assumed: noise of the samples is white or nearly so (else see 3), and clocks run at constant rates: a clock that jumps within
//! the record is for [`super::reorder`]. Memory: both records, and ten numbers for each interval of knots.
//! Source: C. H. Knapp and G. C. Carter, IEEE Trans. ASSP-24, 1976: the standard error is held against their bound,
//!     var m >= 1/(2 T int_0^inf (2 pi f)^2 S^2/(S (N_1 + N_2) + N_1 N_2) df)                            (1)
//! with S, N_1, N_2 the two-sided densities of signal and noises.

mod coloured_residuals;
mod correlation;
mod joint_fit;
mod prewhitening;
pub mod record;
mod refinement;
mod spline;

use crate::flight::signal::series::Series;
use correlation::{LagPeak, significances, threshold};
use prewhitening::{BinnedRecord, whitened};
use record::{Candidate, ClockEstimate, ClockSearch, ClockUnknown};
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

/// Samples of each recording at least.
const SAMPLES_LEAST: usize = 100;

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

/// The best place, the significance that it needed, and the second best apart from it on the same bins.
fn searched(ours: &Series, theirs: &Series, search: &ClockSearch) -> Result<(Candidate, f64, Option<Candidate>), ClockUnknown> {
    let length = |series: &Series| series.range_s().map_or(0.0, |(from_s, to_s)| to_s - from_s);
    let interval = |series: &Series| series.interval_s().unwrap_or(0.0);
    let (longest_s, shortest_s) = (length(ours).max(length(theirs)), length(ours).min(length(theirs)));
    let center_s = theirs.range_s().map_or(0.0, |(from_s, to_s)| 0.5 * (from_s + to_s));
    let mut width_s = (2.0 * interval(ours).max(interval(theirs))).max(longest_s / BINS_MAX);
    let (mut tried, mut best, mut moved) = (0, None::<(Candidate, Option<Candidate>)>, false);
    while shortest_s / width_s >= BINS_LEAST {
        if let Some(our_bins) = BinnedRecord::of(ours, width_s, 0.0) {
            for (drift, late_s) in tries(search, shortest_s, width_s) {
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
                        center_s,
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
