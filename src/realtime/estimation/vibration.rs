//! Blade-passing vibration: an adaptive notch at blades times rotor speed, and twice that, on every channel alike.
//!
//! Consumes admitted samples with the rotor's speed; changes their channels. With B blades and the azimuth psi = integral of
//! the rotor's speed,
//!     c = (cos k B psi, sin k B psi), k = 1, 2,   e = x - sum_k w_k c_k                               (1)
//!     h = e - slow part of e,   w_k <- w_k + 2 (T/tau) h c_k                                         (2)
//! e replaces x. For a steady rotor (1), (2) are a linear notch of half width 1/tau about each line. Below it e
//! is x, late by less than 2 k/(tau (k B Omega)^2), a fifth of a millisecond at 17 Hz, and so in every channel: none is
//! skewed against another. The slow part in (2) keeps gravity and trim out of the lines.
//! Source: J. R. Glover, Adaptive noise cancelling applied to sinusoidal interferences, IEEE Trans. ASSP-25, 1977.
//! Assumed: lines of constant amplitude over about `TAU_S`. A line that is aliased below `CLEAR_HZ` cannot be distinguished from
//! the motion and stays, which [`LineNotch::folded`] reports. Without blades or rotor speed samples stay unchanged.

use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::sample::Sample;
use core::f64::consts::TAU;

/// Time constant of the adaptation, s.
const TAU_S: f64 = 1.0;
/// Lines: the blades' passing and its double.
const LINES: usize = 2;
/// Aliased frequency below which a line is left, Hz.
const CLEAR_HZ: f64 = 4.0;
/// Samples that determine a channel's interval, and intervals without one that are a gap.
const SAMPLED: u32 = 8;
const GAP_INTERVALS: f64 = 4.0;
/// Corner of the slow part, as a part of the blades' passing.
const SLOW: f64 = 0.25;

#[derive(Clone, Copy, Debug)]
struct Lines {
    weights: [[f64; 2]; LINES],
    slow: f64,
    /// Of an angle: what is added to the reading so that it does not jump by a revolution.
    revolutions: f64,
    last_s: f64,
    count: u32,
    interval_s: f64,
    /// Whether the last interval was a gap.
    gap: bool,
}

/// The notch of every channel.
#[derive(Clone, Debug)]
pub struct LineNotch {
    blades: Option<u32>,
    lines: [Lines; CHANNELS],
    /// k B psi for k = 1, wrapped.
    phase: f64,
    /// Rate of the phase, rad/s, and its time.
    passing: Option<(f64, f64)>,
    hold_s: f64,
    folded: bool,
}

impl LineNotch {
    /// A rotor with so many blades; its speed serves for `hold_s`.
    pub const fn new(blades: Option<u32>, hold_s: f64) -> Self {
        let none =
            Lines { weights: [[0.0; 2]; LINES], slow: 0.0, revolutions: 0.0, last_s: 0.0, count: 0, interval_s: 0.0, gap: false };
        LineNotch { blades, lines: [none; CHANNELS], phase: 0.0, passing: None, hold_s, folded: false }
    }

    /// Whether a line was left because it is aliased into the bandwidth of the motion.
    pub fn folded(&self) -> bool {
        self.folded
    }

    /// Blade-passing frequency where the notch is active, Hz.
    pub fn passing_hz(&self) -> Option<f64> {
        self.passing.map(|(rate, _)| rate / TAU)
    }

    /// Removes the lines from a sample.
    pub fn clean(&mut self, sample: &mut Sample) {
        let Some(blades) = self.blades else { return };
        let time_s = sample.time_s;
        if let Some((rate, before_s)) = self.passing {
            let gone_s = time_s - before_s;
            self.phase = libm::remainder(self.phase + rate * gone_s, TAU);
            self.passing = (gone_s <= self.hold_s).then_some((rate, time_s));
        }
        if let Some(speed) = sample.get(Channel::RotorSpeed).filter(|&speed| speed > 1.0) {
            self.passing = Some((f64::from(blades) * speed, time_s));
        }
        let Some((rate, _)) = self.passing else {
            self.lines.iter_mut().for_each(|lines| lines.count = 0);
            return;
        };
        let (sin, cos) = libm::sincos(self.phase);
        let references = [[cos, sin], [cos * cos - sin * sin, 2.0 * sin * cos]];
        for channel in Channel::ALL {
            if matches!(channel, Channel::RotorSpeed | Channel::Rho) {
                continue;
            }
            let Some(read) = sample.get(channel) else { continue };
            let lines = &mut self.lines[channel.index()];
            let interval_s = time_s - lines.last_s;
            lines.last_s = time_s;
            if lines.count == 0 || interval_s > self.hold_s {
                let weights = [[0.0; 2]; LINES];
                *lines = Lines { weights, slow: read, revolutions: 0.0, last_s: time_s, count: 1, interval_s: 0.0, gap: false };
                continue;
            }
            if matches!(channel, Channel::Phi | Channel::Psi) {
                // Within half a revolution of the slow part.
                lines.revolutions = TAU * libm::round((lines.slow - read) / TAU);
            }
            let value = read + lines.revolutions;
            lines.count = lines.count.saturating_add(1);
            // What was lost on the way says nothing of how fast the channel is sampled, and one sample after it counts as one.
            let long = lines.count > SAMPLED && interval_s > GAP_INTERVALS * lines.interval_s;
            let gap = long && !lines.gap;
            if long && lines.gap {
                // Two long ones running: the channel has slowed, and this is its interval now.
                (lines.interval_s, lines.count) = (interval_s, SAMPLED);
            } else if !gap {
                lines.interval_s += (interval_s - lines.interval_s) / f64::from(lines.count.min(50));
            }
            lines.gap = gap;
            let learnt_s = if gap { lines.interval_s } else { interval_s };
            let (mut rest, mut used) = (value, [false; LINES]);
            for (k, (weights, reference)) in lines.weights.iter().zip(&references).enumerate() {
                let line_hz = (k + 1) as f64 * rate / TAU;
                let folded_hz = libm::fabs(libm::remainder(line_hz * lines.interval_s, 1.0)) / lines.interval_s;
                used[k] = folded_hz > CLEAR_HZ;
                self.folded |= !used[k] && lines.count > 50;
                if used[k] {
                    rest -= weights[0] * reference[0] + weights[1] * reference[1];
                }
            }
            lines.slow += (SLOW * rate * interval_s).min(1.0) * (rest - lines.slow);
            let fast = rest - lines.slow;
            // Quick to learn at first: the mean over what there is.
            let gain = 2.0 * (learnt_s / TAU_S).max(1.0 / f64::from(lines.count + 8)).min(0.25);
            for ((weights, reference), used) in lines.weights.iter_mut().zip(&references).zip(used) {
                if used {
                    weights[0] += gain * fast * reference[0];
                    weights[1] += gain * fast * reference[1];
                }
            }
            sample.set(channel, rest - lines.revolutions);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rate_hz: f64, signal: impl Fn(f64) -> f64, line: impl Fn(f64) -> f64, from_s: f64) -> (f64, f64, LineNotch) {
        let mut notch = LineNotch::new(Some(4), 0.5);
        let (mut left, mut was, mut count) = (0.0, 0.0, 0.0);
        for i in 0..(12.0 * rate_hz) as u32 {
            let t = f64::from(i) / rate_hz;
            let mut sample = Sample::new(t);
            sample.set(Channel::Az, signal(t) + line(t));
            sample.set(Channel::RotorSpeed, 27.0);
            notch.clean(&mut sample);
            if t > from_s {
                left += (sample.get(Channel::Az).unwrap() - signal(t)).powi(2);
                was += line(t) * line(t);
                count += 1.0;
            }
        }
        ((left / count).sqrt(), (was / count).sqrt(), notch)
    }

    #[test]
    fn the_lines_go_and_the_motion_stays() {
        let motion = |t: f64| -9.8 + 2.0 * libm::sin(3.0 * t);
        let line = |t: f64| 0.6 * libm::cos(108.0 * t + 1.0) + 0.2 * libm::sin(216.0 * t);
        for rate_hz in [256.0, 128.0, 64.0] {
            let (left, was, notch) = run(rate_hz, motion, line, 4.0);
            assert!(left < 0.05 * was, "{rate_hz}: {left} of {was}");
            assert!((notch.passing_hz().unwrap() - 108.0 / TAU).abs() < 1e-9);
        }
    }

    #[test]
    fn without_a_line_next_to_nothing_changes() {
        let motion = |t: f64| -9.8 + 2.0 * libm::sin(6.0 * t);
        let (changed, _, _) = run(256.0, motion, |_| 0.0, 4.0);
        // The delay of the header, 2 sin moved by 0.2 ms at 6 rad/s.
        assert!(changed < 0.004, "{changed}");
    }

    #[test]
    fn a_heading_that_passes_north_stays_a_heading() {
        // 0 to 2 pi and -pi to pi: what leaves differs from what came by the line alone, at the jump as elsewhere.
        for lowest in [0.0, -core::f64::consts::PI] {
            let mut notch = LineNotch::new(Some(4), 0.5);
            for t in (0..20 * 64).map(|i| f64::from(i) / 64.0) {
                let turned = 5.0 + 0.6 * t;
                let heading = |angle: f64| lowest + (angle - lowest).rem_euclid(TAU);
                let mut sample = Sample::new(t);
                sample.set(Channel::Psi, heading(turned + 0.01 * libm::cos(108.0 * t)));
                sample.set(Channel::RotorSpeed, 27.0);
                notch.clean(&mut sample);
                let error = libm::remainder(sample.get(Channel::Psi).unwrap() - turned, TAU);
                assert!(t < 4.0 || error.abs() < 2e-3, "{lowest} at {t}: {error}");
            }
        }
    }

    #[test]
    fn a_gap_unlearns_no_line() {
        let mut notch = LineNotch::new(Some(4), 0.5);
        let (mut left, mut count) = (0.0, 0.0);
        for t in (0..12 * 128).map(|i| f64::from(i) / 128.0).filter(|t| !(6.0..6.4).contains(t)) {
            let (motion, line) = (-9.8 + 2.0 * libm::sin(3.0 * t), 0.6 * libm::cos(108.0 * t + 1.0));
            let mut sample = Sample::new(t);
            sample.set(Channel::Az, motion + line);
            sample.set(Channel::RotorSpeed, 27.0);
            notch.clean(&mut sample);
            if (6.4..6.9).contains(&t) {
                left += (sample.get(Channel::Az).unwrap() - motion).powi(2);
                count += 1.0;
            }
        }
        // Half a tenth of the line, as without a gap; with the whole gap's weight a fifth of it was there again.
        assert!((left / count).sqrt() < 0.05 * 0.6, "{}", (left / count).sqrt());
        assert!(!notch.folded());
    }

    #[test]
    fn a_channel_that_slows_for_good_is_judged_at_its_new_rate() {
        // At 17 samples a second the line aliases to 0.19 Hz; at 128 before, it was a line.
        let mut notch = LineNotch::new(Some(4), 0.5);
        let before = (0..6 * 128).map(|i| f64::from(i) / 128.0);
        for t in before.chain((0..6 * 17).map(|i| 6.0 + f64::from(i) / 17.0)) {
            let mut sample = Sample::new(t);
            sample.set(Channel::Az, libm::cos(108.0 * t));
            sample.set(Channel::RotorSpeed, 27.0);
            notch.clean(&mut sample);
            if t > 6.5 {
                assert!((sample.get(Channel::Az).unwrap() - libm::cos(108.0 * t)).abs() < 1e-9, "{t}");
            }
        }
        assert!(notch.folded());
    }

    #[test]
    fn a_line_that_folds_onto_the_flight_is_left_and_said() {
        // 17.19 Hz at 17 samples a second aliases to 0.19 Hz.
        let (left, was, notch) = run(17.0, |_| 0.0, |t| libm::cos(108.0 * t), 4.0);
        assert!((left / was - 1.0).abs() < 1e-9 && notch.folded());
    }
}
