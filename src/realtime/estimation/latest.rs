//! The newest value of every channel, with its age: zero-order hold of channels of different rates.
//!
//! Consumes admitted samples; produces held values, the filter's inputs, and which instruments there are. A value serves
//! for at most the hold time; then the channel counts as silent.

use super::process::{ATTITUDE, State};
use super::record::{AIDS, Aid, Confirmation, Instrumentation, SignalNoise};
use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::sample::Sample;
use crate::flight::unit::STANDARD_GRAVITY as G0;

/// Weight of the newest interval in the running mean of the gyros' interval.
const INTERVAL_GAIN: f64 = 0.05;

/// Inertial inputs: three specific forces, three rates.
pub const INPUTS: usize = 6;
/// ax ay az p q r.
pub type Input = [f64; INPUTS];

/// Newest values and their times.
#[derive(Clone, Debug)]
pub struct Latest {
    hold_s: f64,
    values: [f64; CHANNELS],
    times_s: [f64; CHANNELS],
    /// Changes of the inertial channels from the last sample but one to the last, a second; zero where that is too old.
    slopes: [f64; INPUTS],
    seen: u32,
    /// Gyros sampled since the last tick, a bit each.
    rates: u8,
    tick_s: Option<f64>,
    interval_s: f64,
}

const ALL_RATES: u8 = 0b111;

/// The rates of a sample, a bit each.
fn rates_of(sample: &Sample) -> u8 {
    Channel::GYROS.iter().enumerate().map(|(i, &gyro)| u8::from(sample.get(gyro).is_some()) << i).sum()
}

impl Latest {
    /// Values serve for `hold_s`.
    pub const fn new(hold_s: f64) -> Self {
        Latest {
            hold_s,
            values: [0.0; CHANNELS],
            times_s: [f64::NEG_INFINITY; CHANNELS],
            slopes: [0.0; INPUTS],
            seen: 0,
            rates: 0,
            tick_s: None,
            interval_s: 0.0,
        }
    }

    /// Forgets the values, not which instruments there are.
    pub fn clear(&mut self) {
        self.times_s = [f64::NEG_INFINITY; CHANNELS];
        self.slopes = [0.0; INPUTS];
        self.rates = 0;
        self.tick_s = None;
    }

    /// Whether each rate was sampled since the last tick, with this sample: together, or one after the other as the words of a
    /// slow telemetry frame.
    pub fn completes_rates(&self, sample: &Sample) -> bool {
        self.rates | rates_of(sample) == ALL_RATES
    }

    /// Takes a sample in; says whether it is a tick: it completes the rates.
    pub fn take(&mut self, sample: &Sample) -> bool {
        for (slope, channel) in self.slopes.iter_mut().zip(Channel::ACCELEROMETERS.into_iter().chain(Channel::GYROS)) {
            if let Some(value) = sample.get(channel) {
                let interval_s = sample.time_s - self.times_s[channel.index()];
                let fresh = interval_s > 0.0 && interval_s <= self.hold_s;
                *slope = if fresh { (value - self.values[channel.index()]) / interval_s } else { 0.0 };
            }
        }
        for channel in Channel::ALL {
            if let Some(value) = sample.get(channel) {
                self.values[channel.index()] = value;
                self.times_s[channel.index()] = sample.time_s;
            }
        }
        self.seen |= sample.present;
        let rates = self.rates | rates_of(sample);
        let tick = rates == ALL_RATES;
        self.rates = if tick { 0 } else { rates };
        if tick {
            if let Some(before_s) = self.tick_s {
                let interval_s = sample.time_s - before_s;
                let gain = if self.interval_s > 0.0 { INTERVAL_GAIN } else { 1.0 };
                self.interval_s += gain * (interval_s - self.interval_s);
            }
            self.tick_s = Some(sample.time_s);
        }
        tick
    }

    /// How long ago the rates were last complete, s.
    pub fn silence_s(&self, time_s: f64) -> f64 {
        self.tick_s.map_or(0.0, |tick_s| time_s - tick_s)
    }

    /// Running mean of the gyros' interval, s; 0 before two of their samples.
    pub fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// The channel's value, where it is no older than the hold time.
    pub fn get(&self, channel: Channel, time_s: f64) -> Option<f64> {
        let i = channel.index();
        (time_s - self.times_s[i] <= self.hold_s).then_some(self.values[i])
    }

    /// An inertial channel now, extrapolated linearly from its last two samples: held, it would be delayed by half its interval
    /// relative to faster channels.
    fn now(&self, input: usize, channel: Channel, time_s: f64) -> f64 {
        self.values[channel.index()] + self.slopes[input] * (time_s - self.times_s[channel.index()])
    }

    /// The filter's inputs, and which specific forces were measured. One that was not is taken to balance gravity at the
    /// state's attitude.
    pub fn input(&self, time_s: f64, state: &State) -> (Input, [bool; 3]) {
        let (sin_phi, cos_phi) = libm::sincos(state[ATTITUDE]);
        let (sin_theta, cos_theta) = libm::sincos(state[ATTITUDE + 1]);
        let balance = [G0 * sin_theta, -G0 * cos_theta * sin_phi, -G0 * cos_theta * cos_phi];
        let mut input = [0.0; INPUTS];
        let mut measured = [false; 3];
        for i in 0..3 {
            let force = self.get(Channel::ACCELEROMETERS[i], time_s).map(|_| self.now(i, Channel::ACCELEROMETERS[i], time_s));
            measured[i] = force.is_some();
            input[i] = force.unwrap_or(balance[i]);
            input[3 + i] = self.now(3 + i, Channel::GYROS[i], time_s);
        }
        (input, measured)
    }

    /// Which instruments have been sampled.
    pub fn instrumentation(&self, running: bool) -> Instrumentation {
        let seen = |channel: Channel| self.seen & (1 << channel.index()) != 0;
        Instrumentation {
            running,
            rate_hz: if self.interval_s > 0.0 { 1.0 / self.interval_s } else { 0.0 },
            gyros: Channel::GYROS.into_iter().all(seen),
            accelerometers: Channel::ACCELEROMETERS.map(seen),
            aids: Aid::ALL.map(|aid| seen(aid.channel())),
            trusted: [true; AIDS],
            as_expected: [true; AIDS],
            vanes_disagree: [false; 2],
            vanes_contradict: [false; 2],
            controls_stood: [false; 4],
            inertial_stood: [false; Channel::INERTIAL.len()],
            confirmations: [Confirmation::Confirmed; Confirmation::CHANNELS.len()],
            noise: SignalNoise::NONE,
            doubt: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::estimation::process::STATES;

    fn sample(time_s: f64, rates: &[(Channel, f64)]) -> Sample {
        let mut sample = Sample::new(time_s);
        rates.iter().for_each(|&(channel, value)| sample.set(channel, value));
        sample
    }

    #[test]
    fn rates_in_samples_of_their_own_are_one_tick_at_the_last_of_them() {
        let mut latest = Latest::new(0.5);
        let mut ticks = Vec::new();
        for frame in 0..4 {
            let start_s = 0.04 * f64::from(frame);
            for (word, channel) in (0..).zip(Channel::GYROS) {
                let time_s = start_s + 0.004 * f64::from(word);
                if latest.take(&sample(time_s, &[(channel, 2.0 * time_s)])) {
                    ticks.push(time_s);
                }
            }
        }
        assert_eq!(ticks.len(), 4);
        assert!((latest.interval_s() - 0.04).abs() < 1e-12);
        // A straight line is read at the time of the tick, whichever word carried it.
        let (input, _) = latest.input(ticks[3], &[0.0; STATES]);
        input[3..].iter().for_each(|rate| assert!((rate - 2.0 * ticks[3]).abs() < 1e-12, "{input:?}"));
    }

    #[test]
    fn a_faster_gyro_does_not_tick_without_the_others() {
        let mut latest = Latest::new(0.5);
        let [p, q, r] = Channel::GYROS;
        let ticks = [&[(p, 0.0), (q, 0.0), (r, 0.0)][..], &[(p, 0.0)], &[(p, 0.0), (q, 0.0), (r, 0.0)], &[(q, 0.0)]]
            .iter()
            .zip(0..)
            .map(|(rates, i)| latest.take(&sample(0.01 * f64::from(i), rates)))
            .collect::<Vec<_>>();
        assert_eq!(ticks, [true, false, true, false]);
    }
}
