//! The run's trim: means over the first second, about which perturbations are taken (PERTURB of Padfield et al. 1987).
//!
//! Consumes ticks of a run; produces their mean once, when the window is over. A signal that was never sampled in the
//! window has no trim: NaN (a control that the run does not carry).

use super::record::TrimRecord;

/// Root mean square of a body rate in the window above which the aircraft was not in trim, rad/s.
pub const STEADY_RATE_RMS: f64 = 0.05;

const SIGNALS: usize = 15;

/// Sums over the window.
#[derive(Clone, Debug)]
pub struct TrimWindow {
    length_s: f64,
    begin_s: Option<f64>,
    sums: [f64; SIGNALS],
    counts: [f64; SIGNALS],
    rate_squares: [f64; 3],
    done: bool,
}

impl TrimWindow {
    /// A window of that length from the first tick on.
    pub const fn new(length_s: f64) -> Self {
        TrimWindow { length_s, begin_s: None, sums: [0.0; SIGNALS], counts: [0.0; SIGNALS], rate_squares: [0.0; 3], done: false }
    }

    /// Takes a tick in; the trim and the largest rms rate when the window is over, once.
    pub fn take(&mut self, time_s: f64, tick: &TrimRecord) -> Option<(TrimRecord, f64)> {
        if self.done {
            return None;
        }
        let begin_s = *self.begin_s.get_or_insert(time_s);
        if time_s - begin_s < self.length_s {
            let signals = tick.velocity.iter().chain(&tick.rates).chain(&tick.attitude).chain(&tick.specific_force);
            for (i, &signal) in signals.chain(&tick.controls).enumerate() {
                if signal.is_finite() {
                    self.sums[i] += signal;
                    self.counts[i] += 1.0;
                }
            }
            for (square, rate) in self.rate_squares.iter_mut().zip(tick.rates) {
                if rate.is_finite() {
                    *square += rate * rate;
                }
            }
            return None;
        }
        self.done = true;
        let mean = |i: usize| if self.counts[i] > 0.0 { self.sums[i] / self.counts[i] } else { f64::NAN };
        let ticks = self.counts[3].max(1.0);
        let rate_rms = self.rate_squares.iter().fold(0.0, |largest: f64, square| largest.max(libm::sqrt(square / ticks)));
        let trim = TrimRecord {
            velocity: core::array::from_fn(mean),
            // Errors of the filter hardly change in a second, so their mean is as uncertain as the last of them.
            velocity_std: tick.velocity_std,
            rates: core::array::from_fn(|i| mean(3 + i)),
            attitude: core::array::from_fn(|i| mean(6 + i)),
            specific_force: core::array::from_fn(|i| mean(8 + i)),
            controls: core::array::from_fn(|i| mean(11 + i)),
        };
        Some((trim, rate_rms))
    }
}
