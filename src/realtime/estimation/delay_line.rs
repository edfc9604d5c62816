//! Delay line: signals are buffered until the smoothing kernel covers an instant symmetrically.
//!
//! Consumes one row of signals a tick, at uneven times, some of them not sampled; produces every signal smoothed at one instant,
//! and its slope, all by the same kernel (`num::kernel`), and the noise gain of each. A signal that comes more slowly than the
//! ticks is a straight line between its samples, as the conventions say; until the next one comes its last value stands in.
//! Returns `None` where the buffer does not cover the kernel, or with a gap longer than allowed under it; NaN of a signal that
//! was not sampled there.

use crate::num::kernel;

/// Ticks that can lie under the kernel; faster ticks are thinned to fit.
pub const CAPACITY: usize = 256;
const BUFFER: usize = 2 * CAPACITY;

/// Weight of the newest interval in the running mean of intervals.
const INTERVAL_GAIN: f64 = 0.05;

/// Intervals without a sample after which a signal is silent.
const SILENT_INTERVALS: f64 = 3.0;

/// Sampling times of a signal.
#[derive(Clone, Copy, Debug)]
struct Rhythm {
    last_s: f64,
    value: f64,
    interval_s: f64,
}

impl Rhythm {
    const NEW: Rhythm = Rhythm { last_s: f64::NAN, value: f64::NAN, interval_s: f64::NAN };

    fn beat(&mut self, time_s: f64) {
        let interval_s = time_s - self.last_s;
        self.last_s = time_s;
        if self.interval_s.is_nan() {
            self.interval_s = interval_s;
        } else {
            self.interval_s += INTERVAL_GAIN * (interval_s - self.interval_s);
        }
    }
}

/// Buffer of `S` signals.
#[derive(Clone, Debug)]
pub struct DelayLine<const S: usize> {
    half_width_s: f64,
    hold_s: f64,
    times: [f64; BUFFER],
    signals: [[f64; BUFFER]; S],
    len: usize,
    /// Ticks since each signal was last sampled.
    since: [usize; S],
    /// Last sample and mean interval of each signal.
    rhythm: [Rhythm; S],
    ticks: Rhythm,
    smooth: [f64; BUFFER],
    slope: [f64; BUFFER],
}

/// Signals at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothed<const S: usize> {
    /// Smoothed signals.
    pub value: [f64; S],
    /// Slopes of the smoothed signals, 1/s.
    pub slope: [f64; S],
    /// Variance of a slope for white noise of unit variance on the signal.
    pub slope_noise_gain: f64,
    /// Variance of a value for white noise of unit variance on the signal.
    pub value_noise_gain: f64,
}

impl<const S: usize> DelayLine<S> {
    /// Kernel of that half width; a signal's last value serves for at most `hold_s`.
    pub const fn new(half_width_s: f64, hold_s: f64) -> Self {
        DelayLine {
            half_width_s,
            hold_s,
            times: [0.0; BUFFER],
            signals: [[0.0; BUFFER]; S],
            len: 0,
            since: [0; S],
            rhythm: [Rhythm::NEW; S],
            ticks: Rhythm::NEW,
            smooth: [0.0; BUFFER],
            slope: [0.0; BUFFER],
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.len = 0;
        self.since = [0; S];
        self.rhythm = [Rhythm::NEW; S];
        self.ticks = Rhythm::NEW;
    }

    /// Time of the newest tick.
    pub fn newest_s(&self) -> Option<f64> {
        self.len.checked_sub(1).map(|last| self.times[last])
    }

    /// Ticks a sample of that signal, 1 or more: the factor on its noise gains relative to a signal of every tick.
    pub fn ticks_a_sample(&self, signal: usize) -> f64 {
        let ticks = self.rhythm[signal].interval_s / self.ticks.interval_s;
        if ticks > 1.0 { ticks } else { 1.0 }
    }

    /// Whether the signal has been silent for so long that the kernel covers its held last value only.
    pub fn is_silent(&self, signal: usize) -> bool {
        let Rhythm { last_s, interval_s, .. } = self.rhythm[signal];
        !(self.ticks.last_s - last_s <= SILENT_INTERVALS * interval_s)
    }

    /// A tick: signals that were not sampled are NaN. Times must increase.
    pub fn push(&mut self, time_s: f64, row: &[f64; S]) {
        // More ticks than fit under the kernel: thin them. What they bring still counts, at its own time.
        let least_s = 2.0 * self.half_width_s / (CAPACITY - 8) as f64;
        let thinned = self.newest_s().is_some_and(|newest_s| time_s - newest_s < least_s);
        if !thinned {
            self.make_room();
            self.ticks.beat(time_s);
        }
        for (s, &value) in row.iter().enumerate() {
            if !value.is_nan() {
                self.sampled(s, time_s, value);
            }
            if thinned {
                continue;
            }
            let held = time_s - self.rhythm[s].last_s <= self.hold_s;
            self.signals[s][self.len] = if held { self.rhythm[s].value } else { f64::NAN };
            if value.is_nan() {
                self.since[s] = (self.since[s] + 1).min(self.len + 1);
            }
        }
        if !thinned {
            self.times[self.len] = time_s;
            self.len += 1;
        }
    }

    fn make_room(&mut self) {
        if self.len == BUFFER {
            self.times.copy_within(CAPACITY.., 0);
            for signal in &mut self.signals {
                signal.copy_within(CAPACITY.., 0);
            }
            self.len -= CAPACITY;
            self.since = self.since.map(|since| since.min(self.len));
        }
    }

    /// Signal `s` was sampled at that time: the ticks since it was sampled before come to lie on the straight line between.
    fn sampled(&mut self, s: usize, time_s: f64, value: f64) {
        let Rhythm { last_s, value: before, .. } = self.rhythm[s];
        let interval = time_s - last_s;
        if interval > 0.0 && interval <= self.hold_s {
            let step = (value - before) / interval;
            for between in self.len - self.since[s]..self.len {
                self.signals[s][between] = before + step * (self.times[between] - last_s);
            }
        }
        self.since[s] = 0;
        self.rhythm[s].beat(time_s);
        self.rhythm[s].value = value;
    }

    /// Every signal at `centre_s`; `None` where the line does not cover the kernel around it.
    pub fn at(&mut self, centre_s: f64) -> Option<Smoothed<S>> {
        let times = &self.times[..self.len];
        let begin = times.partition_point(|&t| t <= centre_s - self.half_width_s).checked_sub(1)?;
        let end = begin + times[begin..].partition_point(|&t| t < centre_s + self.half_width_s);
        if end >= self.len {
            return None;
        }
        let (smooth, slope) = (&mut self.smooth[begin..=end], &mut self.slope[begin..=end]);
        if !kernel::weights(&times[begin..=end], centre_s, self.half_width_s, 0.5 * self.half_width_s, smooth, slope) {
            return None;
        }
        let mut out = Smoothed { value: [0.0; S], slope: [0.0; S], slope_noise_gain: 0.0, value_noise_gain: 0.0 };
        for (s, signal) in self.signals.iter().enumerate() {
            let (mut value, mut rate) = (0.0, 0.0);
            for ((x, w), d) in signal[begin..=end].iter().zip(smooth.iter()).zip(slope.iter()) {
                value += w * x;
                rate += d * x;
            }
            out.value[s] = value;
            out.slope[s] = rate;
        }
        for (w, d) in smooth.iter().zip(slope.iter()) {
            out.value_noise_gain += w * w;
            out.slope_noise_gain += d * d;
        }
        Some(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_signal_is_a_straight_line_between_its_samples() {
        let mut line = DelayLine::<2>::new(0.2, 0.5);
        for i in 0..2000 {
            let t = 0.01 * f64::from(i);
            let slow = if i % 10 == 0 { 2.0 - 3.0 * t } else { f64::NAN };
            line.push(t, &[5.0 * t, slow]);
        }
        let out = line.at(19.5).unwrap();
        assert!((out.value[0] - 97.5).abs() < 1e-12 && (out.slope[0] - 5.0).abs() < 1e-11);
        assert!((out.value[1] + 56.5).abs() < 1e-12 && (out.slope[1] + 3.0).abs() < 1e-11);
        assert!((line.ticks_a_sample(1) - 10.0).abs() < 1e-6 && (line.ticks_a_sample(0) - 1.0).abs() < 1e-9);
        assert!(line.at(19.9).is_none(), "the future is not there yet");
    }

    #[test]
    fn a_signal_sampled_between_the_ticks_is_the_same_straight_line() {
        let mut line = DelayLine::<2>::new(0.2, 0.5);
        for i in 0..2000 {
            let t = 0.01 * f64::from(i);
            line.push(t, &[5.0 * t, f64::NAN]);
            if i % 3 == 0 {
                // Too close after the tick to be one.
                line.push(t + 0.001, &[f64::NAN, 2.0 - 3.0 * (t + 0.001)]);
            }
        }
        let out = line.at(19.5).unwrap();
        assert!((out.value[1] + 56.5).abs() < 1e-11 && (out.slope[1] + 3.0).abs() < 1e-10, "{out:?}");
    }

    #[test]
    fn a_signal_that_stops_is_not_made_up() {
        let mut line = DelayLine::<2>::new(0.2, 0.3);
        for i in 0..200 {
            let t = 0.01 * f64::from(i);
            line.push(t, &[1.0, if i < 100 { 1.0 } else { f64::NAN }]);
        }
        assert!((line.at(0.9).unwrap().value[1] - 1.0).abs() < 1e-12);
        let late = line.at(1.7).unwrap();
        assert!(late.value[1].is_nan() && late.value[0].is_finite());
    }

    #[test]
    fn fast_ticks_are_thinned_to_what_fits() {
        let mut line = DelayLine::<1>::new(0.4, 0.5);
        for i in 0..20_000 {
            let t = 1e-4 * f64::from(i);
            line.push(t, &[7.0 * t]);
        }
        let out = line.at(1.5).unwrap();
        assert!((out.value[0] - 10.5).abs() < 1e-11 && (out.slope[0] - 7.0).abs() < 1e-9);
    }
}
