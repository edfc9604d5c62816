//! Noise statistics of one channel from the record: variance of its white noise, intensity of its random walk.
//!
//! Consumes the samples of one channel; produces the variance R of its white noise and the intensity q of the random walk
//! that drives it, by maximum likelihood. The channel is taken for itself, as level x and slope y (the slope a random walk),
//!     x <- x + T y,  y <- y + T w,  var(w) = q/T,  z = x + noise of variance R                     (1)
//! whose steady filter has gains that depend on the tracking index alone,
//!     L = T^2 sqrt(q/T)/sqrt(R),  c = (4 + L - sqrt(8 L + L^2))/4,  alpha = 1 - c^2,
//!     beta = 2 (2 - alpha) - 4 sqrt(1 - alpha)                                                    (2)
//! or, for a level that is itself the random walk, var = q T,
//!     L = sqrt(q T/R),  alpha = (L sqrt(L^2 + 4) - L^2)/2,  beta = 0                              (3)
//! Innovations of variance S = R/(1 - alpha) have the log-likelihood -N/2 ln S - sum nu^2/(2 S); at its maximum over S it is
//! -N/2 ln(mean nu^2). So a bank of such filters, each with an index L of its own, runs side by side, and the likeliest
//! pair is that of the least mean squared innovation:
//!     R = (1 - alpha) mean nu^2,  q from (2) or (3)                                               (4)
//! A filter that has just begun has no prior. Its gains at the n-th sample are those of the straight line (of the mean) through
//! all of them, until they have fallen to the steady ones,
//!     alpha_n = 2 (2 n - 1)/(n (n + 1)), beta_n = 6/(n (n + 1));   level: alpha_n = 1/n              (5)
//! and its innovations, of variance R/(1 - alpha_n), count as (1 - alpha_n)/(1 - alpha) nu^2. So it begins again after
//! `GAP_INTERVALS` intervals without a sample: a gap has no innovation of (2) or (3).
//! A sample that stands out from the likeliest filter's prediction by more than `STANDS_OUT` of its innovations' root mean square
//! waits for the next. Where that one is back, it was a spike (a bit error, a contact) and does not count: the gate of the Kalman
//! filter rejects it while R is that of the noise.
//! Source: P. R. Kalata, The tracking index, IEEE Trans. AES-20, 1984 (2), (3); R. K. Mehra, Approaches to adaptive filtering,
//! IEEE Trans. AC-17, 1972 (maximum likelihood of the innovations); E. Brookner, Tracking and Kalman filtering made easy, 1998,
//! on growing memory (5).
//! Assumed: samples about evenly spaced, but for gaps; lines of vibration and quantisation count as noise.
//! Returns `None` before `COUNT_MIN` samples.

/// Filters in a bank, their tracking indexes a factor `STEP` apart from `FIRST` on.
const FILTERS: usize = 30;
const FIRST: f64 = 1e-3;
const STEP: f64 = 1.5;
/// Least number of samples of an estimate.
const COUNT_MIN: u32 = 50;
/// Samples in which a filter settles, and which do not count.
const SETTLE: u32 = 10;
/// Time over which the innovations are averaged, s: the noise of minutes ago is forgotten.
const MEMORY_S: f64 = 60.0;
/// Weight of the newest interval in the running mean of intervals.
const INTERVAL_GAIN: f64 = 0.02;
/// Length of a gap in mean intervals, and in the interval before.
const GAP_INTERVALS: f64 = 4.0;
/// Innovation of a spike in root mean squares, and the part of it that the next sample's is below where it was one.
const STANDS_OUT: f64 = 6.0;
const BACK_WITHIN: f64 = 0.5;

/// The random walk: the slope of the channel, or the channel itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wander {
    /// (2): an angular rate, a flow angle, an attitude.
    Slope,
    /// (3): a specific force.
    Level,
}

/// Noise of one channel, by (4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelNoise {
    /// Variance R of the noise of a sample, unit squared.
    pub noise_var: f64,
    /// Intensity q of the random walk, unit squared/s (level) or unit squared/s^3 (slope).
    pub intensity: f64,
}

/// The bank of one channel.
#[derive(Clone, Debug)]
pub struct NoiseBank {
    wander: Wander,
    level: [f64; FILTERS],
    slope: [f64; FILTERS],
    /// Mean squared innovations, over `MEMORY_S`.
    mean: [f64; FILTERS],
    alpha: [f64; FILTERS],
    beta: [f64; FILTERS],
    /// Innovations in the means, and samples since the signal began.
    count: u32,
    since: u32,
    last_s: f64,
    /// Time and value of a sample that may be a spike.
    waits: Option<(f64, f64)>,
    /// The interval before, and the mean.
    before_s: f64,
    interval_s: f64,
}

fn index(filter: f64) -> f64 {
    FIRST * libm::pow(STEP, filter)
}

/// alpha and beta of tracking index L, (2) and (3).
fn gains(wander: Wander, index: f64) -> (f64, f64) {
    match wander {
        Wander::Slope => {
            let c = (4.0 + index - libm::sqrt(8.0 * index + index * index)) / 4.0;
            // 2 (2 - alpha) - 4 sqrt(1 - alpha) with alpha = 1 - c^2, without its loss of digits.
            (1.0 - c * c, 2.0 * (1.0 - c) * (1.0 - c))
        }
        Wander::Level => (0.5 * index * (libm::sqrt(index * index + 4.0) - index), 0.0),
    }
}

/// alpha and beta of a filter that has begun `sample` samples ago, that one counted, (5).
fn first_gains(wander: Wander, sample: u32) -> (f64, f64) {
    let n = f64::from(sample);
    match wander {
        Wander::Slope => (2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)), 6.0 / (n * (n + 1.0))),
        Wander::Level => (1.0 / n, 0.0),
    }
}

/// What a filter of tracking index L keeps of its memory from sample to sample: c of (2), 1 - alpha of (3). About the likeliest
/// filter the mean squared innovation is a parabola in it.
fn memory(wander: Wander, index: f64) -> f64 {
    let rest = 1.0 - gains(wander, index).0;
    match wander {
        Wander::Slope => libm::sqrt(rest),
        Wander::Level => rest,
    }
}

/// A difference, of angles of period `turn` by the shorter way.
fn wrapped(difference: f64, turn: f64) -> f64 {
    if turn > 0.0 && libm::fabs(difference) > 0.5 * turn { libm::remainder(difference, turn) } else { difference }
}

/// Lowest point of the parabola through three points whose middle one is the lowest, x in order; `None` where they are on a line.
fn lowest([(x0, y0), (x1, y1), (x2, y2)]: [(f64, f64); 3]) -> Option<(f64, f64)> {
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let curvature = (right - left) / (x2 - x0);
    if !(curvature > 0.0) {
        return None;
    }
    let slope = left + curvature * (x1 - x0);
    let x = (x1 - 0.5 * slope / curvature).clamp(x0.min(x2), x0.max(x2));
    Some((x, y1 + (x - x1) * (slope + curvature * (x - x1))))
}

impl NoiseBank {
    /// Before the first sample.
    pub const fn new(wander: Wander) -> Self {
        NoiseBank {
            wander,
            level: [0.0; FILTERS],
            slope: [0.0; FILTERS],
            mean: [0.0; FILTERS],
            alpha: [0.0; FILTERS],
            beta: [0.0; FILTERS],
            count: 0,
            since: 0,
            last_s: 0.0,
            waits: None,
            before_s: 0.0,
            interval_s: 0.0,
        }
    }

    /// Restarts the filters after a gap; the noise estimate is kept.
    pub fn break_off(&mut self) {
        self.since = 0;
        self.waits = None;
    }

    /// Whether the newest sample may be a spike.
    pub const fn waits(&self) -> bool {
        self.waits.is_some()
    }

    /// One sample; `turn` is the period of an angle that wraps, 0 for what does not.
    pub fn take(&mut self, time_s: f64, value: f64, turn: f64) {
        let best = self.best();
        let apart = |time_s: f64, value: f64| {
            let predicted = self.level[best] + (time_s - self.last_s) * self.slope[best];
            libm::fabs(wrapped(value - predicted, turn))
        };
        if let Some((spike_s, spike)) = self.waits {
            if !(apart(time_s, value) < BACK_WITHIN * apart(spike_s, spike)) {
                self.follow(spike_s, spike, turn);
            }
            self.waits = None;
        } else if self.count >= SETTLE && apart(time_s, value) > STANDS_OUT * libm::sqrt(self.mean[best]) {
            self.waits = Some((time_s, value));
            return;
        }
        self.follow(time_s, value, turn);
    }

    fn follow(&mut self, time_s: f64, value: f64, turn: f64) {
        let interval_s = time_s - self.last_s;
        self.last_s = time_s;
        // As long as the interval before: no gap, but another rate.
        let usual_s = self.interval_s.max(self.before_s);
        self.before_s = interval_s;
        if usual_s > 0.0 && interval_s > GAP_INTERVALS * usual_s {
            self.since = 0;
        }
        self.since = self.since.saturating_add(1);
        if self.since == 1 {
            if self.count == 0 {
                for (filter, (alpha, beta)) in self.alpha.iter_mut().zip(&mut self.beta).enumerate() {
                    (*alpha, *beta) = gains(self.wander, index(filter as f64));
                }
            }
            self.level = [value; FILTERS];
            self.slope = [0.0; FILTERS];
            return;
        }
        if self.interval_s == 0.0 {
            self.interval_s = interval_s;
        }
        self.interval_s += INTERVAL_GAIN * (interval_s - self.interval_s);
        let counts = self.since > SETTLE;
        if counts {
            self.count = self.count.saturating_add(1);
        }
        let weight = (interval_s / MEMORY_S).max(1.0 / f64::from(self.count.max(1)));
        let mut innovation = [0.0; FILTERS];
        for ((innovation, level), slope) in innovation.iter_mut().zip(&mut self.level).zip(&self.slope) {
            *level += interval_s * slope;
            *innovation = value - *level;
        }
        if turn > 0.0 {
            for innovation in &mut innovation {
                *innovation = wrapped(*innovation, turn);
            }
        }
        let per_s = 1.0 / interval_s;
        // (5) is never above 4/n; the slowest filter settles last.
        let young = f64::from(self.since) * self.alpha[0] < 4.0;
        let (first_alpha, first_beta) = if young { first_gains(self.wander, self.since) } else { (0.0, 0.0) };
        if first_alpha > self.alpha[0] {
            for (i, innovation) in innovation.iter_mut().enumerate() {
                let (alpha, beta) = (self.alpha[i].max(first_alpha), self.beta[i].max(first_beta));
                self.level[i] += alpha * *innovation;
                self.slope[i] += beta * per_s * *innovation;
                *innovation *= libm::sqrt(((1.0 - alpha) / (1.0 - self.alpha[i])).max(0.0));
            }
        } else {
            for (i, innovation) in innovation.iter().enumerate() {
                self.level[i] += self.alpha[i] * innovation;
                self.slope[i] += self.beta[i] * per_s * innovation;
            }
        }
        if counts {
            for (mean, innovation) in self.mean.iter_mut().zip(&innovation) {
                *mean += weight * (innovation * innovation - *mean);
            }
        }
    }

    /// The filter of the least mean squared innovation.
    fn best(&self) -> usize {
        let mut best = 0;
        for filter in 1..FILTERS {
            if self.mean[filter] < self.mean[best] {
                best = filter;
            }
        }
        best
    }

    /// The likeliest noise, (4), between the filters by a parabola through ln(mean nu^2) at the best three.
    pub fn likeliest(&self) -> Option<ChannelNoise> {
        if self.count < COUNT_MIN {
            return None;
        }
        let best = self.best();
        if !(self.mean[best] > 0.0 && self.mean[best].is_finite() && self.interval_s > 0.0) {
            return None;
        }
        let (mut c, mut mean) = (memory(self.wander, index(best as f64)), self.mean[best]);
        if best > 0 && best + 1 < FILTERS {
            let point = |filter: usize| (memory(self.wander, index(filter as f64)), libm::log(self.mean[filter]));
            if let Some((at, ln)) = lowest([point(best - 1), point(best), point(best + 1)]) {
                (c, mean) = (at, libm::exp(ln));
            }
        }
        let (index, alpha) = match self.wander {
            Wander::Slope => (2.0 * (1.0 - c) * (1.0 - c) / c, 1.0 - c * c),
            Wander::Level => ((1.0 - c) / libm::sqrt(c), 1.0 - c),
        };
        let noise_var = (1.0 - alpha) * mean;
        let t = self.interval_s;
        let intensity = match self.wander {
            Wander::Slope => index * index * noise_var / (t * t * t),
            Wander::Level => index * index * noise_var / t,
        };
        Some(ChannelNoise { noise_var, intensity })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(seed: &mut u64) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (*seed >> 11) as f64 / (1u64 << 53) as f64;
        }
        sum
    }

    /// Signals made by (1): the bank finds what they were made with.
    #[test]
    fn finds_the_noise_that_the_signal_was_made_with() {
        let cases: [(Wander, f64, f64, f64); 5] = [
            (Wander::Slope, 4e-6, 0.25, 1.0 / 256.0),
            (Wander::Slope, 4e-6, 0.02, 0.02),
            (Wander::Slope, 1e-4, 1.0, 0.04),
            (Wander::Level, 2.5e-3, 4.0, 0.01),
            (Wander::Level, 0.04, 0.5, 0.02),
        ];
        for (wander, r, q, t) in cases {
            let (mut found_r, mut found_q) = (0.0, 0.0);
            for run in 0..20 {
                let mut seed = 7 + run;
                let (mut x, mut y) = (0.0, 0.0);
                let mut bank = NoiseBank::new(wander);
                for i in 0..4000 {
                    let w = normal(&mut seed);
                    match wander {
                        Wander::Slope => {
                            x += t * y + 0.5 * t * t * (q / t).sqrt() * w;
                            y += t * (q / t).sqrt() * w;
                        }
                        Wander::Level => x += (q * t).sqrt() * w,
                    }
                    bank.take(f64::from(i) * t, x + r.sqrt() * normal(&mut seed), 0.0);
                }
                let noise = bank.likeliest().unwrap();
                found_r += noise.noise_var / r / 20.0;
                found_q += noise.intensity.ln() / 20.0;
            }
            let ratio = found_q.exp() / q;
            // A walk of 16 times the noise a sample hides it: one run of 4000 knows R to 28 % (its increments' autocovariance
            // is -R/(q T + 2 R) = -0.056 +- 0.016), twenty to 6.3 %; three of those. The others know it to 2 % and better.
            let allowed = if q * t > 10.0 * r { 0.19 } else { 0.06 };
            assert!((found_r - 1.0).abs() < allowed, "{wander:?} {r} {q} {t}: R {found_r}");
            assert!((ratio - 1.0).abs() < 0.25, "{wander:?} {r} {q} {t}: q {ratio}");
        }
    }

    /// What a gap brings says nothing of a sample's noise: the answer stays, however far the signal went meanwhile.
    #[test]
    fn a_gap_changes_nothing() {
        let t: f64 = 1.0 / 256.0;
        for (wander, r, q, away) in [(Wander::Slope, 9e-6_f64, 0.03_f64, 0.3), (Wander::Level, 2.5e-3, 0.2, 20.0)] {
            for lost in [560..610, 20..150, 4900..5119] {
                let (mut found_r, mut found_q) = (0.0, 0.0);
                for run in 0..20 {
                    let mut seed = 11 + run;
                    let (mut x, mut y) = (0.0, 0.0);
                    let mut bank = NoiseBank::new(wander);
                    for i in 0..5120 {
                        let turn = if i == lost.start + 3 { away } else { 0.0 };
                        let w = normal(&mut seed);
                        match wander {
                            Wander::Slope => {
                                x += t * y + 0.5 * t * t * (q / t).sqrt() * w;
                                y += t * (q / t).sqrt() * w + turn;
                            }
                            Wander::Level => x += (q * t).sqrt() * w + turn,
                        }
                        if !lost.contains(&i) {
                            bank.take(f64::from(i) * t, x + r.sqrt() * normal(&mut seed), 0.0);
                        }
                    }
                    let noise = bank.likeliest().unwrap();
                    found_r += noise.noise_var / r / 20.0;
                    found_q += noise.intensity.ln() / 20.0;
                }
                let ratio = found_q.exp() / q;
                assert!((found_r - 1.0).abs() < 0.03, "{wander:?}, lost {lost:?}: R {found_r}");
                assert!((ratio - 1.0).abs() < 0.1, "{wander:?}, lost {lost:?}: q {ratio}");
            }
        }
    }

    /// One sample of fifty is a spike of 70 standard deviations, which as noise would make R a hundred times as large.
    #[test]
    fn spikes_are_no_noise() {
        for (wander, r, q) in [(Wander::Slope, 9e-6_f64, 0.03_f64), (Wander::Level, 2.5e-3, 0.2)] {
            let (t, mut found_r) = (0.02, 0.0);
            for run in 0..20 {
                let mut seed = 23 + run;
                let (mut x, mut y) = (0.0, 0.0);
                let mut bank = NoiseBank::new(wander);
                for i in 0..3000 {
                    let w = (q / t).sqrt() * normal(&mut seed);
                    match wander {
                        Wander::Slope => {
                            x += t * y + 0.5 * t * t * w;
                            y += t * w;
                        }
                        Wander::Level => x += t * w,
                    }
                    let spike = if i > 40 && i % 50 == run % 50 { 70.0 * r.sqrt() } else { 0.0 };
                    bank.take(f64::from(i as u32) * t, x + spike + r.sqrt() * normal(&mut seed), 0.0);
                }
                found_r += bank.likeliest().unwrap().noise_var / r / 20.0;
            }
            assert!((found_r - 1.0).abs() < 0.05, "{wander:?}: R {found_r}");
        }
    }

    #[test]
    fn a_heading_that_wraps_is_no_noise_and_few_samples_no_answer() {
        let mut bank = NoiseBank::new(Wander::Slope);
        let turn = 2.0 * core::f64::consts::PI;
        for i in 0..2000 {
            assert!(i > 40 || bank.likeliest().is_none());
            let mut seed = 3 * i as u64 + 1;
            bank.take(0.02 * f64::from(i), libm::remainder(0.5 * 0.02 * f64::from(i), turn) + 1e-3 * normal(&mut seed), turn);
        }
        let noise = bank.likeliest().unwrap();
        assert!(noise.noise_var < 4e-6, "{noise:?}");
    }
}
