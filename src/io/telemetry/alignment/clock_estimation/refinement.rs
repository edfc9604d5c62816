//! From a peak of the correlation to the relation with its standard errors.
//!
//! Consumes both records and the peak; produces the fit ([`super::joint_fit`]) on the knots that cross-validation prefers, and
//! from it the relation. Refused: what does not settle, leaves its peak, or does not determine the drift.

use super::coloured_residuals::colour_factor;
use super::joint_fit::{DRIFT, JointData, JointFit, TIME};
use super::record::{Candidate, ClockEstimate, ClockSearch, ClockUnknown};
use super::spline::SplineKnots;
use crate::flight::signal::series::Series;
use crate::io::telemetry::alignment::clock_relation::{ClockCovariance, ClockRelation};
use crate::num::dense::Dense;

/// Knots stand no closer than so many intervals of the slower record.
const KNOT_INTERVALS: f64 = 2.0;
/// The first knots are so many bins of the search apart.
const FIRST_KNOTS: f64 = 2.0;
/// The fit may leave the peak of the search by so many bins.
const LEAVES_PEAK: f64 = 3.0;
/// Least scale that is one, standard errors.
const SCALE_LEAST: f64 = 5.0;
/// Least part of the information that may be left without the noise of the slope.
const INFORMATION_LEAST: f64 = 0.25;
/// A drift beyond what is searched by so many standard errors is none.
const BEYOND: f64 = 3.0;

/// Values with their mean and standard deviation taken out, times from a reference.
fn standardised(samples: impl Iterator<Item = (f64, f64)>, reference_s: f64) -> (Vec<(f64, f64)>, f64) {
    let mut samples: Vec<(f64, f64)> = samples.collect();
    let count = samples.len().max(1) as f64;
    let mean = samples.iter().map(|(_, x)| x).sum::<f64>() / count;
    let std = libm::sqrt(samples.iter().map(|(_, x)| (x - mean) * (x - mean)).sum::<f64>() / count);
    samples.iter_mut().for_each(|(t, x)| (*t, *x) = (*t - reference_s, (*x - mean) / std));
    (samples, std)
}

/// Refines one candidate; its significances are left at zero.
pub(super) fn refined(
    ours: &Series,
    theirs: &Series,
    search: &ClockSearch,
    start: &Candidate,
) -> Result<ClockEstimate, ClockUnknown> {
    let center_s = start.center_s;
    let coarse = ClockRelation::about(center_s, center_s + start.difference_s, start.drift, None);
    let (Some(coarse), Some(our_range), Some(their_range)) = (coarse, ours.range_s(), theirs.range_s()) else {
        return Err(ClockUnknown::NotSettled);
    };
    let from_s = our_range.0.max(coarse.ours_s(their_range.0));
    let to_s = our_range.1.min(coarse.ours_s(their_range.1));
    let overlap_s = to_s - from_s;
    let origin_s = 0.5 * (from_s + to_s);
    let reference_s = coarse.theirs_s(origin_s);
    let margin_s = LEAVES_PEAK * FIRST_KNOTS * start.width_s;
    let inside = |from_s: f64, to_s: f64| move |(t, _): &(f64, f64)| *t >= from_s && *t <= to_s;
    let (our_samples, our_std) = standardised(ours.samples().filter(inside(from_s - margin_s, to_s + margin_s)), origin_s);
    let their_inside = inside(coarse.theirs_s(from_s), coarse.theirs_s(to_s));
    let (their_samples, their_std) = standardised(theirs.samples().filter(their_inside), reference_s);
    let half_s = 0.5 * overlap_s;
    let data = JointData { ours: our_samples, theirs: their_samples, half_s, with_drift: search.drift.is_none() };
    let fit = best_knots(&data, ours, theirs, start, margin_s).ok_or(ClockUnknown::NotSettled)?;
    let moved_s = fit.globals[TIME];
    if !(libm::fabs(moved_s) <= LEAVES_PEAK * start.width_s) {
        return Err(ClockUnknown::LeftPeak { moved_s });
    }
    let kappa = colour_factor(&data, &fit).ok_or(ClockUnknown::NotSettled)?;
    let covariance = covariance(&fit, kappa).ok_or(ClockUnknown::NotSettled)?;
    let std = |i: usize| libm::sqrt(covariance[(i, i)]);
    if !(libm::fabs(fit.globals[2]) > SCALE_LEAST * std(2)) {
        return Err(ClockUnknown::NotSettled);
    }
    let (drift, drift_std) = (fit.globals[DRIFT] / half_s, if data.with_drift { std(DRIFT) / half_s } else { 0.0 });
    let at_reference_s = origin_s + moved_s;
    if drift_std > search.drift_std_max {
        let (difference_s, time_std_s) = (at_reference_s - reference_s, std(TIME));
        return Err(ClockUnknown::TooShortForDrift {
            overlap_s,
            drift_std,
            admitted: search.drift_std_max,
            difference_s,
            time_std_s,
        });
    }
    if data.with_drift && libm::fabs(drift) > search.drift_max + BEYOND * drift_std {
        return Err(ClockUnknown::DriftBeyond { drift, admitted: search.drift_max });
    }
    let of_both = ClockCovariance {
        time_var: covariance[(TIME, TIME)],
        time_drift_cov: if data.with_drift { covariance[(TIME, DRIFT)] / half_s } else { 0.0 },
        drift_var: drift_std * drift_std,
    };
    let relation = ClockRelation::about(reference_s, at_reference_s, drift, Some(of_both)).ok_or(ClockUnknown::NotSettled)?;
    Ok(ClockEstimate {
        relation,
        scale: (fit.globals[2] * their_std / our_std, std(2) * their_std / our_std),
        noise_std: [libm::sqrt(fit.noise_var[0]) * our_std, libm::sqrt(fit.noise_var[1]) * their_std],
        significance: (0.0, 0.0),
        second_significance: 0.0,
        colour_factor: kappa,
        overlap_s,
        knots_s: fit.knots.step_s,
    })
}

/// The fit of the least criterion, from wide knots to close ones, each from where the one before settled.
fn best_knots(data: &JointData, ours: &Series, theirs: &Series, start: &Candidate, margin_s: f64) -> Option<JointFit> {
    let interval_s = ours.interval_s()?.max(theirs.interval_s()?);
    let (mut step_s, mut time, mut drift) = (FIRST_KNOTS * start.width_s, 0.0, start.drift * data.half_s);
    let mut best: Option<JointFit> = None;
    let mut rises = 0;
    while step_s >= KNOT_INTERVALS * interval_s && rises < 2 {
        let knots = SplineKnots::over(-data.half_s - margin_s, data.half_s + margin_s, step_s);
        step_s *= 0.5;
        let Some(fit) = data.fit(knots, time, drift) else { continue };
        (time, drift) = (fit.globals[TIME], fit.globals[DRIFT]);
        // Where knots are too wide for the signal the variances settle slowly; closer ones go on from there.
        if !fit.settled {
            continue;
        }
        if best.as_ref().is_none_or(|best| fit.criterion < best.criterion) {
            (best, rises) = (Some(fit), 0);
        } else {
            rises += 1;
        }
    }
    best
}

/// P of (5) there; `None` where the signal is lost in the noise.
fn covariance(fit: &JointFit, kappa: f64) -> Option<Dense> {
    for i in [TIME, DRIFT] {
        if !(fit.observed[(i, i)] > INFORMATION_LEAST * fit.information[(i, i)]) {
            return None;
        }
    }
    let inverse = fit.observed.inverse()?;
    let sandwich = inverse.times(&fit.information).times(&inverse);
    Some(Dense::from_fn(sandwich.rows(), sandwich.columns(), |i, j| kappa * sandwich[(i, j)]))
}
