//! Gusts that the air-data instruments measure, as part of the velocity through the air.
//!
//! Consumes, an instant of the regression grid, the smoothed velocity V through the air, its rate, and the smoothed readings of
//! airspeed, incidence and sideslip brought to the same point; produces the velocity of the gusts, to be added to V.
//! Aerodynamic derivatives are with respect to the velocity through the air. The filter's V follows accelerometers and gyros over
//! short times, so a gust is missing in it, and stays in what a reading y leaves:
//!     d_i = y_i - h_i(V),   i = tas, alpha, beta, by (2) to (4) of `sensors`                          (1)
//!     gust = V(h + k d) - V(h),   V(.) by (5) of `sensors`                                            (2)
//!     k_i = max(0, 1 - (F n_i + x_i)/s_i)                                                            (3)
//! s is the mean of d^2 over `MEMORY_S`, n the variance of the reading's noise as configured (what is estimated of it contains
//! the gusts) with the margin F, and x that part of s which an instrument's scale error a and lag tau explain,
//!     d = a (h - mean h) - tau h' + rest,   |a| <= `SCALE_MOST`,   0 <= tau <= `LAG_MOST_S`            (4)
//! by least squares, less what two parameters explain of independent noise by chance. In still air k is zero and V is untouched.
//! (3) is the gain of a scalar Wiener filter with the signal's power found by spectral subtraction.
//! Source: E. A. Morelli and K. Cunningham, AIAA 2012-4650 (air data in turbulence taken as the aircraft feels it); (3): S. F.
//! Boll, IEEE Trans. ASSP 27, 1979. The part x in (3) is ours.
//! Assumed: the gust is the same over the whole aircraft; its gradients stay a disturbance of the equations.

use crate::dynamics::sensors::{AirData, velocity_of_air_data};

/// F of (3).
const MARGIN: f64 = 2.0;
/// Time over which the means of (3) and (4) forget, s.
const MEMORY_S: f64 = 60.0;
/// Time before which nothing is known of them, s.
const LEAST_S: f64 = 2.0;
/// Bounds of (4): what a flow vane, or a probe with its tubes, reaches. An aircraft answers a gust within a few tenths of a
/// second, so with wider ones part of the gust is taken for a lag, and what is left out of the regressors biases them.
const SCALE_MOST: f64 = 0.1;
const LAG_MOST_S: f64 = 0.1;
/// Interval of independent values of d: the equivalent width of the smoothing kernel, s.
const INDEPENDENT_S: f64 = 0.5;
/// Root mean squares of d, or standard deviations F^(1/2) n^(1/2), beyond which a value of it is cut: a spike of one sample.
const CUT: f64 = 4.0;

/// A smoothed reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothedReading {
    /// m/s or rad.
    pub value: f64,
    /// Variance that the instrument's white noise leaves in it.
    pub noise_var: f64,
}

/// Running means of one instrument.
#[derive(Clone, Copy, Debug)]
struct ReadingLessMotion {
    seconds: f64,
    mean_predicted: f64,
    /// Means of d^2, of d times (h - mean h, h'), and of the products of these two: 11, 12, 22.
    squares: f64,
    with_motion: [f64; 2],
    motion: [f64; 3],
    /// k of (3).
    gain: f64,
}

impl ReadingLessMotion {
    const NEW: ReadingLessMotion =
        ReadingLessMotion { seconds: 0.0, mean_predicted: 0.0, squares: 0.0, with_motion: [0.0; 2], motion: [0.0; 3], gain: 0.0 };

    /// One instant: the prediction h, its rate and the reading; the part k d of it that is gust.
    fn step(&mut self, interval_s: f64, predicted: f64, rate: f64, reading: SmoothedReading) -> f64 {
        let SmoothedReading { value, noise_var } = reading;
        let limit = CUT * libm::sqrt(self.squares.max(MARGIN * noise_var));
        let d = value - predicted;
        if !(d.is_finite() && rate.is_finite() && limit > 0.0) {
            return 0.0;
        }
        let d = d.clamp(-limit, limit);
        self.seconds = libm::exp(-interval_s / MEMORY_S) * self.seconds + interval_s;
        let weight = interval_s / self.seconds;
        let mean = |mean: &mut f64, value: f64| *mean += weight * (value - *mean);
        mean(&mut self.mean_predicted, predicted);
        let e = predicted - self.mean_predicted;
        mean(&mut self.squares, d * d);
        for (product, value) in self.with_motion.iter_mut().zip([d * e, d * rate]) {
            mean(product, value);
        }
        for (product, value) in self.motion.iter_mut().zip([e * e, e * rate, rate * rate]) {
            mean(product, value);
        }
        let known = self.seconds >= LEAST_S && self.squares > 0.0;
        let by_instrument = MARGIN * noise_var + self.by_scale_and_lag();
        self.gain = if known { (1.0 - by_instrument / self.squares).max(0.0) } else { 0.0 };
        self.gain * d
    }

    /// x of (3): the part of s that (4) explains.
    fn by_scale_and_lag(&self) -> f64 {
        let ([with_e, with_rate], [ee, er, rr]) = (self.with_motion, self.motion);
        let determinant = ee * rr - er * er;
        if !(determinant > 0.0) {
            return 0.0;
        }
        let scale = ((rr * with_e - er * with_rate) / determinant).clamp(-SCALE_MOST, SCALE_MOST);
        // Minus tau; then the scale again, given it.
        let lead = ((with_rate - er * scale) / rr).clamp(-LAG_MOST_S, 0.0);
        let scale = ((with_e - er * lead) / ee).clamp(-SCALE_MOST, SCALE_MOST);
        let explained =
            2.0 * (scale * with_e + lead * with_rate) - (scale * scale * ee + 2.0 * scale * lead * er + lead * lead * rr);
        let by_chance = 2.0 * INDEPENDENT_S / self.seconds;
        (explained - by_chance * self.squares).max(0.0)
    }
}

/// What the instruments have measured of gusts.
#[derive(Clone, Debug)]
pub struct GustVelocity {
    discrepancies: [ReadingLessMotion; AirData::ALL.len()],
}

impl GustVelocity {
    /// No reading yet.
    pub const NEW: GustVelocity = GustVelocity { discrepancies: [ReadingLessMotion::NEW; AirData::ALL.len()] };

    /// k of (3) by place in `AirData::ALL`.
    pub fn gains(&self) -> [f64; 3] {
        self.discrepancies.map(|one| one.gain)
    }

    /// One instant: the gust (2), m/s, from the velocity u v w, its rate, and the readings at that point by place in
    /// `AirData::ALL`; `None` where an instrument is not to be used, which leaves its part out.
    pub fn step(
        &mut self,
        interval_s: f64,
        velocity: [f64; 3],
        velocity_rate: [f64; 3],
        readings: [Option<SmoothedReading>; 3],
    ) -> [f64; 3] {
        let mut predicted = [0.0; 3];
        let mut with_gust = [0.0; 3];
        for (i, instrument) in AirData::ALL.into_iter().enumerate() {
            let own = instrument.reading(velocity);
            predicted[i] = own.value;
            with_gust[i] = own.value;
            if let Some(reading) = readings[i] {
                let rate = own.by_velocity.iter().zip(velocity_rate).map(|(by, rate)| by * rate).sum();
                with_gust[i] += self.discrepancies[i].step(interval_s, own.value, rate, reading);
            } else {
                self.discrepancies[i].gain = 0.0;
            }
        }
        let [without, with] = [predicted, with_gust].map(|[tas, alpha, beta]| velocity_of_air_data(tas, alpha, beta));
        core::array::from_fn(|i| with[i] - without[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL_S: f64 = 0.08;
    const NOISE_STD: f64 = 1e-3;

    /// Noise of unit variance, the same every time.
    fn noise(seed: &mut u64) -> f64 {
        let mut uniform = || {
            *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        12f64.sqrt() * 0.5 * (uniform() + uniform() + uniform() + uniform())
    }

    /// Sixty seconds of a Dutch roll in sideslip, read as the closure says of time, sideslip and its rate: rms of the gust's v
    /// less what it should be over the last half, and the gain at the end.
    fn flown(read: impl Fn(f64, f64, f64) -> f64, gust: impl Fn(f64) -> f64) -> (f64, f64) {
        let (mut found, mut seed, mut squares, mut count) = (GustVelocity::NEW, 7, 0.0, 0.0);
        for n in 0..750 {
            let t = INTERVAL_S * f64::from(n);
            let (beta, rate) = (0.05 * libm::sin(1.5 * t), 0.075 * libm::cos(1.5 * t));
            let velocity = velocity_of_air_data(50.0, 0.02, beta);
            let velocity_rate = [-50.0 * libm::sin(beta) * rate, 50.0 * libm::cos(beta) * rate, 0.0];
            let value = read(t, beta, rate) + NOISE_STD * noise(&mut seed);
            let reading = SmoothedReading { value, noise_var: NOISE_STD * NOISE_STD };
            let [_, v, _] = found.step(INTERVAL_S, velocity, velocity_rate, [None, None, Some(reading)]);
            if t > 30.0 {
                squares += (v - 50.0 * gust(t)) * (v - 50.0 * gust(t));
                count += 1.0;
            }
        }
        (libm::sqrt(squares / count), found.gains()[2])
    }

    #[test]
    fn a_gust_is_found_as_well_as_the_vane_reads() {
        let gust = |t: f64| 0.01 * (libm::sin(2.1 * t) + libm::sin(0.9 * t + 1.0));
        let (error, gain) = flown(|t, beta, _| beta + gust(t), gust);
        // The noise of the vane is 0.05 m/s, the gust 0.5 m/s rms.
        assert!(gain > 0.9 && error < 0.1, "gain {gain}, error {error} m/s");
    }

    #[test]
    fn noise_a_scale_error_and_a_lag_of_the_vane_are_no_gusts() {
        for (name, scale, lag_s, most) in
            [("noise", 0.0, 0.0, 0.02), ("scale", 0.1, 0.0, 0.02), ("lag", 0.0, 0.1, 0.02), ("both", -0.1, 0.1, 0.02)]
        {
            let (error, gain) = flown(|_, beta, rate| (1.0 + scale) * (beta - lag_s * rate), |_| 0.0);
            assert!(gain < 0.05 && error < most, "{name}: gain {gain}, {error} m/s");
        }
    }

    #[test]
    fn a_spike_and_a_reading_that_is_not_finite_stay_bounded() {
        let gust = |t: f64| 0.01 * (libm::sin(2.1 * t) + libm::sin(0.9 * t + 1.0));
        let spike = |t: f64| if (t - 45.0).abs() < 0.5 * INTERVAL_S { 0.7 } else { 0.0 };
        let (error, gain) = flown(|t, beta, _| beta + gust(t) + spike(t), gust);
        assert!(gain > 0.9 && error < 0.25, "gain {gain}, error {error} m/s");
        let (error, _) = flown(|t, beta, _| if t > 40.0 && t < 41.0 { f64::NAN } else { beta }, |_| 0.0);
        assert!(error < 0.05, "error {error} m/s");
    }
}
