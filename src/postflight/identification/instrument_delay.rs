//! The delayed reading of an instrument: a pure delay, a first-order lag, or a mixture of both.
//!
//! Consumes an output y of the model \[samples\], a delay tau (s) and the share s of it that is a lag; produces the reading
//!     y_read = y + s (lag y - y) + (1 - s) (delay y - y)                                               (1)
//!     lag:  tau y_lag' = y - y_lag,  y_lag(0) = y(0)     delay:  y(t - tau), y(0) before the start
//! exactly for y linear between samples, and (1) linearised about (tau0, s0) as three inputs of a linear model,
//!     y_read - y = offset + tau by_tau + s by_part                                                     (2)
//! The first-order expansion tau dy/dt is not enough: at a step of a control it biases L_p by half a per cent for a delay of 8 ms
//! and a roll rate sampled at 256 Hz. For smooth y a delay and a lag of one tau are equal to first order.
//! Assumed: a constant delay over a run. tau < 0, where the controls are delayed, mirrors tau > 0. Source: ours.

/// Half of the step in tau for the slope, s.
const STEP_S: f64 = 5e-4;

/// (2), by sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct DelayedReading {
    /// Value of the linearisation (2) at tau = s = 0, in the unit of y.
    pub(crate) offset: Vec<f64>,
    /// Derivative with respect to tau, unit of y per s.
    pub(crate) by_tau: Vec<f64>,
    /// Derivative with respect to s, unit of y.
    pub(crate) by_part: Vec<f64>,
}

impl DelayedReading {
    /// (2) about this delay (s) and share; empty of an empty series.
    pub(crate) fn about(times_s: &[f64], values: &[f64], late_s: f64, part: f64) -> Self {
        let at = |late_s: f64| -> (Vec<f64>, Vec<f64>) { (lagged(times_s, values, late_s), delayed(times_s, values, late_s)) };
        let blend = |(lag, delay): &(Vec<f64>, Vec<f64>)| -> Vec<f64> {
            lag.iter().zip(delay).map(|(lag, delay)| part * lag + (1.0 - part) * delay).collect()
        };
        let (before, here, after) = (at(late_s - STEP_S), at(late_s), at(late_s + STEP_S));
        let slopes = blend(&after).into_iter().zip(blend(&before));
        let by_tau: Vec<f64> = slopes.map(|(after, before)| (after - before) / (2.0 * STEP_S)).collect();
        let by_part: Vec<f64> = here.0.iter().zip(&here.1).map(|(lag, delay)| lag - delay).collect();
        let known = blend(&here).into_iter().zip(values).zip(by_tau.iter().zip(&by_part));
        let offset = known.map(|((read, y), (by_tau, by_part))| read - y - late_s * by_tau - part * by_part).collect();
        DelayedReading { offset, by_tau, by_part }
    }
}

/// y_lag of (1), steady before the first sample.
fn lagged(times_s: &[f64], values: &[f64], lag_s: f64) -> Vec<f64> {
    let tau = libm::fabs(lag_s);
    if !(tau > 0.0) {
        return values.to_vec();
    }
    let mut follower = values.first().copied().unwrap_or(0.0);
    let mut before: Option<(f64, f64)> = None;
    let steps = times_s.iter().zip(values).map(|(&time_s, &value)| {
        if let Some((before_s, old)) = before {
            let (interval_s, rise) = (time_s - before_s, value - old);
            // Behind a ramp by tau times its slope, and what is not yet so dies out.
            let behind = tau * rise / interval_s;
            follower = value - behind + (follower - old + behind) * libm::exp(-interval_s / tau);
        }
        before = Some((time_s, value));
        if lag_s > 0.0 { follower } else { 2.0 * value - follower }
    });
    steps.collect()
}

/// y(t - tau) of (1), linear between samples, constant beyond the ends.
fn delayed(times_s: &[f64], values: &[f64], delay_s: f64) -> Vec<f64> {
    let mut after = 0;
    let mut at = |felt_s: f64| {
        while times_s.get(after).is_some_and(|time_s| *time_s <= felt_s) {
            after += 1;
        }
        let sample = |k: usize| times_s.get(k).copied().zip(values.get(k).copied());
        match (after.checked_sub(1).and_then(sample), sample(after)) {
            (Some((from_s, old)), Some((to_s, new))) => old + (new - old) * ((felt_s - from_s) / (to_s - from_s)),
            (Some((_, one)), None) | (None, Some((_, one))) => one,
            (None, None) => f64::NAN,
        }
    };
    times_s.iter().map(|time_s| at(time_s - delay_s)).collect()
}

#[cfg(test)]
mod tests {
    use super::{DelayedReading, delayed, lagged};

    fn ramp_from(start_s: f64, t: f64) -> f64 {
        (t - start_s).max(0.0)
    }

    #[test]
    fn a_ramp_is_followed_as_the_equations_say() {
        let times: Vec<f64> = (0..60).map(|k| 0.004 * f64::from(k)).collect();
        let values: Vec<f64> = times.iter().map(|&t| ramp_from(0.1, t)).collect();
        let tau = 0.01;
        for ((t, lag), delay) in times.iter().zip(lagged(&times, &values, tau)).zip(delayed(&times, &values, tau)) {
            let since = ramp_from(0.1, *t);
            let known = since - tau * (1.0 - f64::exp(-since / tau));
            assert!((lag - known).abs() < 1e-12, "{t}: {lag} {known}");
            assert!((delay - ramp_from(0.11, *t)).abs() < 2.1e-3, "{t}: {delay}");
            assert!((delay - ramp_from(0.11, *t)).abs() < 1e-12 || (0.108..0.116).contains(t), "{t}: {delay}");
        }
    }

    #[test]
    fn the_line_through_a_lateness_is_the_reading_there_and_near_it() {
        let times: Vec<f64> = (0..200).map(|k| 0.005 * f64::from(k)).collect();
        let values: Vec<f64> = times.iter().map(|t| f64::sin(9.0 * t) + ramp_from(0.4, *t)).collect();
        // At tau0 = 0 a straight line bends at every sample.
        for (late_s, part, step_s) in [(0.012, 0.3, 2e-4), (0.0, 0.5, 0.0), (-0.006, 1.0, 2e-4)] {
            let late = DelayedReading::about(&times, &values, late_s, part);
            let there = |late_s: f64, part: f64| -> Vec<f64> {
                let both = lagged(&times, &values, late_s).into_iter().zip(delayed(&times, &values, late_s));
                both.map(|(lag, delay)| part * lag + (1.0 - part) * delay).collect()
            };
            for (by_tau, by_part, most) in [(0.0, 0.0, 1e-12), (step_s, 0.0, 2e-5), (0.0, 0.2, 1e-12)] {
                let read = there(late_s + by_tau, part + by_part);
                for (k, (read, y)) in read.iter().zip(&values).enumerate() {
                    let line = late.offset[k] + (late_s + by_tau) * late.by_tau[k] + (part + by_part) * late.by_part[k];
                    assert!((read - y - line).abs() < most + 0.02 * by_tau, "{late_s} {k}: {} {line}", read - y);
                }
            }
        }
        assert_eq!(DelayedReading::about(&[], &[], 0.01, 0.5), DelayedReading::default());
    }
}
