//! Readings that stand still while the aircraft moves: a frozen, clipped or dead instrument.
//!
//! Consumes the readings of every channel; produces whether one stands. Of N readings whose values repeat with probability rho
//! elsewhere, n equal ones in a row are no chance where
//!     N rho^(n-1) < `CHANCE`                                                                          (1)
//! of the readings so far, and from `LEAST` repeats and `LEAST_S` on. Only while another channel moves, and not of a channel
//! that goes in steps: its own slow motion stands as well; that one stands where other instruments say that it moved
//! ([`ConstantReadings::declare`]). A control may rest: it stands only where its readings hardly ever repeat, at an end of its
//! travel sooner than elsewhere.

use crate::flight::channel::{CHANNELS, Channel, MOTION_CHANNELS};

/// (1).
const CHANCE: f64 = 1e-5;
/// Fewest repeats of a reading, and least time of them, s.
const LEAST: f64 = 5.0;
const LEAST_S: f64 = 0.05;
/// The same before so many readings are known.
const UNKNOWN: f64 = 100.0;
const UNKNOWN_S: f64 = 2.0;
/// The same of a control, with the largest part of its readings that may repeat one before: at an end of its range, elsewhere.
const CONTROL_LEAST: f64 = 10.0;
const CONTROL_AT_END: (f64, f64) = (0.25, 0.1);
const CONTROL_ELSEWHERE: (f64, f64) = (2.0, 0.02);
/// Mean change over the smallest of a channel that does not go in steps.
const FINE: f64 = 6.0;
/// Part of a channel's whole span that counts as no change: rounding, as of a simulated trim without noise.
pub const ROUNDING: f64 = 1e-4;

/// The same before the span is known, SI: below what any instrument resolves.
const ROUNDING_SI: f64 = 1e-9;

#[derive(Clone, Copy, Debug)]
struct LastReadings {
    newest: Option<f64>,
    /// Since when the newest reading stands, s, and how many equal ones followed it.
    since_s: f64,
    equal: f64,
    count: f64,
    repeats: f64,
    changes: f64,
    change_sum: f64,
    change_min: f64,
    change_last: f64,
    range: [f64; 2],
    moved_s: f64,
    /// When it moved again after it had stood for `UNKNOWN_S`, s.
    began_s: f64,
    /// Whether it is known to stand until its next change, and repeats in such runs before.
    declared: bool,
    set_aside: f64,
}

/// Every channel's newest readings.
#[derive(Clone, Debug)]
pub struct ConstantReadings {
    runs: [LastReadings; CHANNELS],
}

impl ConstantReadings {
    /// Without readings.
    pub const NEW: ConstantReadings = ConstantReadings {
        runs: [LastReadings {
            newest: None,
            since_s: 0.0,
            equal: 0.0,
            count: 0.0,
            repeats: 0.0,
            changes: 0.0,
            change_sum: 0.0,
            change_min: f64::INFINITY,
            change_last: f64::INFINITY,
            range: [f64::INFINITY, f64::NEG_INFINITY],
            moved_s: f64::NEG_INFINITY,
            began_s: f64::NEG_INFINITY,
            declared: false,
            set_aside: 0.0,
        }; CHANNELS],
    };

    /// One reading; whether the channel stands still. Never of altitude, which goes in steps whatever it is written as.
    pub fn take(&mut self, channel: Channel, time_s: f64, value: f64) -> bool {
        let Some(run) = self.runs.get_mut(channel.index()) else { return false };
        run.count += 1.0;
        run.range = [run.range[0].min(value), run.range[1].max(value)];
        match run.newest {
            // Zeros of either sign are one reading.
            Some(newest) if newest.to_bits() == value.to_bits() || newest.abs() + value.abs() <= 0.0 => {
                run.equal += 1.0;
                run.repeats += 1.0;
            }
            newest => {
                if run.declared {
                    run.set_aside += run.equal;
                    run.declared = false;
                }
                if let Some(newest) = newest {
                    let change = (value - newest).abs();
                    let span = run.range[1] - run.range[0];
                    run.change_last = change;
                    if change > ROUNDING * span && change > ROUNDING_SI {
                        if time_s - run.moved_s >= UNKNOWN_S {
                            run.began_s = time_s;
                        }
                        run.moved_s = time_s;
                        run.changes += 1.0;
                        run.change_sum += change;
                        run.change_min = run.change_min.min(change);
                    }
                }
                run.newest = Some(value);
                run.since_s = time_s;
                run.equal = 0.0;
            }
        }
        if run.declared {
            return true;
        }
        let stands_s = time_s - run.since_s;
        let known = run.count - run.equal > UNKNOWN;
        if Channel::CONTROLS.contains(&channel) {
            let at_end = value <= run.range[0] || value >= run.range[1];
            let (least_s, repeats) = if at_end { CONTROL_AT_END } else { CONTROL_ELSEWHERE };
            run.declared = known && run.equal >= CONTROL_LEAST && stands_s >= least_s && elsewhere(run) < repeats;
            return run.declared;
        }
        let run = *run;
        let least_s = if known && !came_to_rest(&run) { LEAST_S } else { UNKNOWN_S };
        if channel == Channel::Altitude || run.equal < LEAST || stands_s < least_s || in_steps(&run) {
            return false;
        }
        is_improbable(run.count, run.repeats, run.equal) && self.others_move(channel, run.since_s, time_s - least_s)
    }

    /// Other instruments say that the channel moves: it stands until its readings change.
    pub fn declare(&mut self, channel: Channel) {
        if let Some(run) = self.runs.get_mut(channel.index()).filter(|run| run.equal >= LEAST) {
            run.declared = true;
        }
    }

    /// The smallest change of every channel's readings; infinite where there was none.
    pub fn steps(&self) -> [f64; MOTION_CHANNELS] {
        core::array::from_fn(|channel| self.runs.get(channel).map_or(f64::INFINITY, |run| run.change_min))
    }

    /// Whether two others have moved since then, and did not begin after `began_s`: of an aircraft at rest, as one simulated
    /// without noise is, not all begin at once.
    fn others_move(&self, channel: Channel, since_s: f64, began_s: f64) -> bool {
        let others = Channel::ALL.into_iter().zip(&self.runs).filter(|(other, _)| *other != channel);
        others.filter(|(_, run)| run.moved_s > since_s && run.began_s <= began_s).count() >= 2
    }
}

/// (1) for a reading that is repeated `repeated` times in a row, of `count` readings with `repeats` repeats in all.
pub fn is_improbable(count: f64, repeats: f64, repeated: f64) -> bool {
    let elsewhere = (repeats - repeated + 1.0) / (count - repeated + 1.0);
    count * libm::pow(elsewhere.min(1.0), repeated) < CHANCE
}

/// Part of the readings that repeat one before, without the newest run and those that were found to stand.
fn elsewhere(run: &LastReadings) -> f64 {
    let left_out = run.equal + run.set_aside;
    (run.repeats - left_out) / (run.count - left_out).max(1.0)
}

/// Whether the readings ended their motion slowly, as those without noise do at the turn of a motion; a frozen instrument stops
/// from one reading to the next.
fn came_to_rest(run: &LastReadings) -> bool {
    run.change_last < FINE * run.change_min
}

fn in_steps(run: &LastReadings) -> bool {
    run.changes > 0.0 && run.change_sum / run.changes < FINE * run.change_min
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number between -1 and 1 that looks random.
    fn noise(k: u32, salt: f64) -> f64 {
        libm::sin(salt * f64::from(k) * f64::from(k % 1009))
    }

    /// Times at which the yaw rate stands, of readings at 50 Hz for 20 s beside two channels that move.
    fn standing(yaw_rate: impl Fn(u32) -> f64) -> heapless::Vec<f64, 1000> {
        let mut readings = ConstantReadings::NEW;
        let mut found = heapless::Vec::new();
        for k in 0..1000 {
            let time_s = 0.02 * f64::from(k);
            assert!(!readings.take(Channel::P, time_s, 0.1 * noise(k, 7.3)));
            assert!(!readings.take(Channel::Phi, time_s, 0.02 * noise(k, 3.1)));
            if readings.take(Channel::R, time_s, yaw_rate(k)) {
                let _ = found.push(time_s);
            }
        }
        found
    }

    #[test]
    fn frozen_clipped_and_dead_channels_stand() {
        let moving = |k: u32| 0.05 * libm::sin(0.03 * f64::from(k)) + 1e-3 * noise(k, 5.7);
        let frozen = standing(|k| moving(if (400..600).contains(&k) { 400 } else { k }));
        assert!(frozen[0] < 8.2 && frozen.len() > 190 && frozen.iter().all(|time_s| (8.0..12.0).contains(time_s)));
        let clipped = standing(|k| moving(k).clamp(-0.03, 0.03));
        assert!(clipped.len() > 150, "{}", clipped.len());
        // Zeros of both signs are one reading.
        let dead = standing(|k| if k % 2 == 0 { 0.0 } else { -0.0 });
        assert!(dead[0] < 2.1 && dead.len() > 890);
    }

    #[test]
    fn channels_that_move_repeat_or_go_in_steps_do_not_stand() {
        let moving = |k: u32| 0.05 * libm::sin(0.03 * f64::from(k)) + 1e-3 * noise(k, 5.7);
        assert!(standing(moving).is_empty());
        assert!(standing(|k| moving(k / 10 * 10)).is_empty(), "sampled at 5 Hz and repeated");
        assert!(standing(|k| libm::round(moving(k) / 0.02) * 0.02).is_empty(), "coarse steps");
        assert!(standing(|k| libm::round(moving(k) / 2e-4) * 2e-4).is_empty(), "fine steps");
    }

    #[test]
    fn a_channel_in_steps_stands_once_it_is_declared_until_it_changes() {
        let mut readings = ConstantReadings::NEW;
        for k in 0..400 {
            let reading = if k < 300 { f64::from(k / 10 % 2) } else { 0.5 };
            let stands = readings.take(Channel::R, 0.02 * f64::from(k), reading);
            assert_eq!(stands, (351..400).contains(&k), "{k}");
            if k == 350 {
                readings.declare(Channel::R);
            }
        }
        assert!(!readings.take(Channel::R, 8.0, 0.6) && readings.steps()[Channel::R.index()] < 0.6);
    }

    #[test]
    fn a_control_that_moves_all_the_time_and_then_stops_is_clipped_and_one_that_rests_is_not() {
        let clipped = |most: f64, rests: bool| {
            let mut readings = ConstantReadings::NEW;
            let standing = (0..1000).filter(|&k| {
                // Three seconds of trim before.
                let moved = if k < 150 { 0.0 } else { 0.05 * libm::sin(0.03 * f64::from(k - 150)) };
                let stick = moved + if rests { 0.0 } else { 1e-4 * noise(k, 5.7) };
                let stick = if rests && k % 200 > 60 { 0.0 } else { stick };
                readings.take(Channel::LatCyclic, 0.02 * f64::from(k), stick.clamp(-most, most))
            });
            standing.count()
        };
        assert!(clipped(0.03, false) > 300, "{}", clipped(0.03, false));
        assert_eq!((clipped(1.0, false), clipped(1.0, true)), (0, 0));
    }

    /// A simulation without noise: two seconds of trim, then all channels move by the same input, one after the other as it
    /// reaches them, and come to rest.
    #[test]
    fn an_aircraft_without_noise_that_begins_to_move_and_comes_to_rest_does_not_stand() {
        let mut readings = ConstantReadings::NEW;
        for k in 0..3000 {
            let time_s = 0.01 * f64::from(k);
            for (channel, late_s, size) in [(Channel::R, 0.0, 0.1), (Channel::P, 0.02, 0.05), (Channel::Q, 0.3, 1e-3)] {
                let t = (time_s - 2.0 - late_s).max(0.0);
                let value = 0.01 + size * libm::exp(-0.5 * t) * libm::sin(1.3 * t);
                // Rounding of the simulation moves some channels in trim.
                let rounding = if channel == Channel::Q { 0.0 } else { 1e-13 * f64::from(k % 3) };
                assert!(!readings.take(channel, time_s, value + rounding), "{channel:?} at {time_s} s");
            }
        }
    }

    #[test]
    fn a_trim_without_noise_is_no_standing_channel() {
        let mut readings = ConstantReadings::NEW;
        for k in 0..1000 {
            let time_s = 0.02 * f64::from(k);
            for channel in [Channel::P, Channel::Q, Channel::R, Channel::Phi] {
                assert!(!readings.take(channel, time_s, 0.01));
            }
        }
    }
}
