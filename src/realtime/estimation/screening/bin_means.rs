//! Means of a channel over consecutive bins of time, of readings at any rate joined by straight lines.
//!
//! Consumes readings in order of time; produces the mean over each of the last [`BINS`] bins, and the noise of the readings
//! from their third differences d3 = x_k - 3 x_(k-1) + 3 x_(k-2) - x_(k-3), of variance 20 sigma^2 for white noise. Silence of
//! more than `SILENCE_S` is a hole.

/// Length of a bin, s.
pub const BIN_S: f64 = 0.1;
/// Bins that are kept.
pub const BINS: usize = 16;
/// Readings further apart are not joined, s: a channel of 4 Hz is complete so long after a bin has ended.
pub const SILENCE_S: f64 = 0.3;
/// Part of a bin that has to be covered.
const COVERED: f64 = 0.8;
/// Readings that the noise is averaged over.
const NOISE_COUNT: u32 = 200;

#[derive(Clone, Copy, Debug)]
struct Bin {
    /// The lower half of its number: nothing that is kept is that far apart.
    number: i32,
    integral: f64,
    covered_s: f32,
}

/// Bins of one channel.
#[derive(Clone, Debug)]
pub struct BinMeans {
    bins: [Bin; BINS],
    newest: Option<(f64, f64)>,
    interval_s: f64,
    /// The last readings, newest first, and how many in a row.
    past: [f64; 3],
    filled: u32,
    third_difference_var: f64,
}

impl BinMeans {
    /// Without readings.
    pub const EMPTY: BinMeans = BinMeans {
        bins: [Bin { number: i32::MIN, integral: 0.0, covered_s: 0.0 }; BINS],
        newest: None,
        interval_s: 0.0,
        past: [0.0; 3],
        filled: 0,
        third_difference_var: 0.0,
    };

    /// One reading; an angle that goes round by `turn` is unwrapped.
    pub fn take(&mut self, time_s: f64, value: f64, turn: Option<f64>) {
        let Some((before_s, before)) = self.newest.filter(|(before_s, _)| time_s > *before_s && time_s - before_s <= SILENCE_S)
        else {
            self.newest = Some((time_s, value));
            self.filled = 0;
            self.remember(value);
            return;
        };
        let value = turn.map_or(value, |turn| value - turn * libm::round((value - before) / turn));
        self.newest = Some((time_s, value));
        self.interval_s = time_s - before_s;
        let slope = (value - before) / (time_s - before_s);
        let mut from_s = before_s;
        let first = libm::floor(from_s / BIN_S) as i64;
        // At most the bins of a silence, however the numbers are rounded.
        for number in first..first.saturating_add(BINS as i64) {
            let to_s = ((number as f64 + 1.0) * BIN_S).min(time_s);
            if to_s > from_s {
                let middle = before + slope * (0.5 * (from_s + to_s) - before_s);
                self.add(number, middle * (to_s - from_s), to_s - from_s);
                from_s = to_s;
            }
            if !(from_s < time_s) {
                break;
            }
        }
        self.remember(value);
    }

    fn add(&mut self, number: i64, integral: f64, covered_s: f64) {
        let place = number.rem_euclid(BINS as i64) as usize;
        let Some(bin) = self.bins.get_mut(place) else { return };
        if bin.number != number as i32 {
            *bin = Bin { number: number as i32, integral: 0.0, covered_s: 0.0 };
        }
        bin.integral += integral;
        bin.covered_s += covered_s as f32;
    }

    fn remember(&mut self, value: f64) {
        let [one, two, three] = self.past;
        if self.filled >= 3 {
            let third = value - 3.0 * one + 3.0 * two - three;
            let gain = 1.0 / f64::from((self.filled - 2).min(NOISE_COUNT));
            self.third_difference_var += gain * (third * third - self.third_difference_var);
        }
        self.past = [value, one, two];
        self.filled = self.filled.saturating_add(1);
    }

    /// Mean over the bin of that number, from number * [`BIN_S`] on.
    pub fn mean(&self, number: i64) -> Option<f64> {
        let bin = self.bins.get(number.rem_euclid(BINS as i64) as usize)?;
        let covered_s = f64::from(bin.covered_s);
        (bin.number == number as i32 && covered_s > COVERED * BIN_S).then(|| bin.integral / covered_s)
    }

    /// Whether there has been a reading.
    pub fn has_begun(&self) -> bool {
        self.newest.is_some()
    }

    /// Variance of the noise of such a mean.
    pub fn noise_var(&self) -> f64 {
        let averaged = if self.interval_s > 0.0 { (BIN_S / self.interval_s).max(1.0) } else { 1.0 };
        self.third_difference_var / 20.0 / averaged
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn means_of_a_straight_line_at_any_rate_are_its_values_in_the_middle() {
        for rate_hz in [7.0, 32.0, 101.0] {
            let mut bins = BinMeans::EMPTY;
            for k in 0..(3.0 * rate_hz) as u32 {
                let time_s = 100.0 + f64::from(k) / rate_hz;
                bins.take(time_s, 2.0 * (time_s - 100.0) - 1.0, None);
            }
            for number in 1016..1025 {
                let middle_s = (number as f64 + 0.5) * BIN_S - 100.0;
                assert!((bins.mean(number).unwrap() - (2.0 * middle_s - 1.0)).abs() < 1e-6, "{rate_hz} Hz");
            }
            assert_eq!(bins.mean(1040), None, "not yet");
            assert_eq!(bins.mean(1000), None, "no longer kept");
        }
    }

    #[test]
    fn a_silence_is_a_hole_and_an_angle_goes_on_beyond_its_turn() {
        let mut bins = BinMeans::EMPTY;
        for k in (0..50).chain(110..150) {
            let time_s = 0.01 * f64::from(k);
            bins.take(time_s, libm::remainder(PI - 0.1 + 0.4 * time_s, 2.0 * PI), Some(2.0 * PI));
        }
        let at = |number: i64| PI - 0.1 + 0.4 * (number as f64 + 0.5) * BIN_S;
        assert!((bins.mean(3).unwrap() - at(3)).abs() < 1e-6);
        assert!((5..11).all(|number| bins.mean(number).is_none()));
        let after = bins.mean(13).unwrap() - at(13);
        assert!((after - 2.0 * PI * libm::round(after / (2.0 * PI))).abs() < 1e-6);
    }
}
