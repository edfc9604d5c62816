//! The smoothed yaw acceleration against the truth, beside the best filter that anybody could have chosen by hand.
//!
//! The Puma at 100 kn, pedal doublet and 3211, with the instruments of the flight-test file: words of 12 bits, lags, dropouts,
//! vibration at the blades' passing. The fixed-interval smoother's errors are smaller than the filter's in every state. Rival of
//! its yaw acceleration: a Butterworth filter of second order run forwards and backwards over the yaw gyro,
//! then central differences; its cut-off is the one that comes nearest the truth, which only a simulation knows.

use crate::support::asked::seeds;
use crate::support::manoeuvre::{LEAD_S, over_seeds};
use crate::support::puma::puma_100kn;
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::estimation::config::{EstimationConfig, NoiseSource};
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::estimation::fixed_interval::smooth;
use sideslip::realtime::estimation::record::StateRecord;
use sideslip::simulation::fly::{Flight, FlightResult, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::instrument_file::InstrumentFile;
use sideslip::simulation::integrate::TrueState;
use std::f64::consts::TAU;

const FILE: &str = include_str!("../../replay/instruments/flight-test.toml");
const RATE_HZ: f64 = 256.0;

pub(crate) fn instruments(noise: f64) -> InstrumentSet {
    InstrumentFile::parse(FILE, |_| true).unwrap().applied_to(InstrumentSet::flight_quality(noise), 1.0)
}

pub(crate) fn geometry(instruments: &InstrumentSet) -> RunGeometry {
    RunGeometry {
        accelerometer_position_m: instruments.accelerometer_position_m,
        vane_position_m: instruments.vane_position_m,
        blades: instruments.blades.map(|blades| blades as u32),
        ..RunGeometry::default()
    }
}

pub(crate) fn fly(input: &str, instruments: &InstrumentSet, seed: u64) -> Option<FlightResult> {
    let mut model = puma_100kn()?;
    model.trim.rotor_speed = Some(27.0);
    let mut flight = Flight::of(model);
    flight.times_s = uniform_times(0.0, 20.0, RATE_HZ).unwrap();
    let place = Control::Pedal.index();
    let deviation = InputSpec::parse(input).unwrap().deviation(LEAD_S);
    flight.inputs.controls[place] = flight.inputs.controls[place].plus(1.0, &deviation);
    flight.instruments = instruments.clone();
    flight.seed = seed;
    Some(flight.fly().unwrap())
}

/// Butterworth of second order over evenly spaced values, from rest at the first.
fn butterworth(values: &[f64], cut_hz: f64) -> Vec<f64> {
    let k = (0.5 * TAU * cut_hz / RATE_HZ).tan();
    let norm = 1.0 / (1.0 + 2f64.sqrt() * k + k * k);
    let (b0, a1, a2) = (k * k * norm, 2.0 * (k * k - 1.0) * norm, (1.0 - 2f64.sqrt() * k + k * k) * norm);
    let first = values[0];
    let (mut x1, mut x2, mut y1, mut y2) = (first, first, first, first);
    values
        .iter()
        .map(|&x| {
            let y = b0 * (x + 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
            (x2, x1, y2, y1) = (x1, x, y1, y);
            y
        })
        .collect()
}

fn slope(values: &[f64]) -> Vec<f64> {
    (0..values.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(values.len() - 1));
            (values[b] - values[a]) / ((b - a) as f64 / RATE_HZ)
        })
        .collect()
}

fn zero_phase_slope(gyro: &[f64], cut_hz: f64) -> Vec<f64> {
    let mut back = butterworth(gyro, cut_hz);
    back.reverse();
    let mut both = butterworth(&back, cut_hz);
    both.reverse();
    slope(&both)
}

/// Rms errors of the yaw acceleration from 1 s to 1 s before the end: smoother, best cut-off, 8 Hz, fixed lag; the best cut-off.
fn errors(input: &str, noise: f64, seed: u64) -> Option<[f64; 5]> {
    let instruments = instruments(noise);
    let flown = fly(input, &instruments, seed)?;
    // The gyro on its own even grid, a straight line where the link lost it.
    let read: Vec<(f64, f64)> =
        flown.samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(Channel::R)?))).collect();
    let times: Vec<f64> = flown.truth.iter().enumerate().map(|(i, _)| i as f64 / RATE_HZ).collect();
    let line = |read: &[(f64, f64)], time: f64| {
        let after = read.partition_point(|&(t, _)| t < time).clamp(1, read.len() - 1);
        let ((ta, a), (tb, b)) = (read[after - 1], read[after]);
        a + (b - a) * ((time - ta) / (tb - ta)).clamp(0.0, 1.0)
    };
    let gyro: Vec<f64> = times.iter().map(|&time| line(&read, time)).collect();
    let truth = slope(&flown.truth.iter().map(|truth| truth.motion.rates[2]).collect::<Vec<_>>());
    let inside = |time: f64| time > 1.0 && time < 19.0;
    let rms = |found: &dyn Fn(f64) -> Option<f64>| {
        let (mut sum, mut count) = (0.0, 0.0);
        for (&time, &truth) in times.iter().zip(&truth).filter(|&(&time, _)| inside(time)) {
            if let Some(found) = found(time) {
                sum += (found - truth) * (found - truth);
                count += 1.0;
            }
        }
        assert!(count > 100.0, "{count}");
        f64::sqrt(sum / count)
    };
    let rival = |cut_hz: f64| {
        let found = zero_phase_slope(&gyro, cut_hz);
        rms(&|time| found.get((time * RATE_HZ).round() as usize).copied())
    };
    let (best_hz, best) =
        (0..60).map(|i| 0.5 * 1.07f64.powi(i)).map(|cut_hz| (cut_hz, rival(cut_hz))).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let whole = smooth(&flown.samples, &EstimationConfig::default(), geometry(&instruments)).unwrap();
    let smoothed: Vec<(f64, f64)> = whole.states.iter().map(|s| (s.time_s, s.angular_acceleration[2])).collect();
    let mut estimator = Box::new(Estimator::new(EstimationConfig::default(), geometry(&instruments)).unwrap());
    let lagged: Vec<(f64, f64)> = flown
        .samples
        .iter()
        .filter_map(|sample| {
            estimator.step(sample).lagged.map(|lagged| lagged.state).map(|s| (s.time_s, s.angular_acceleration[2]))
        })
        .collect();
    let at = |times: &[(f64, f64)], time: f64| {
        let place = times.partition_point(|&(t, _)| t < time - 1e-6);
        times.get(place).filter(|(t, _)| (t - time).abs() < 1e-6).map(|&(_, value)| value)
    };
    Some([rms(&|time| at(&smoothed, time)), best, rival(8.0), rms(&|time| at(&lagged, time)), best_hz])
}

#[test]
#[ignore = "a study"]
fn yaw_acceleration_is_as_good_as_the_best_filter_that_knew_the_truth() {
    for (input, noise) in [
        ("pedal:doublet:0.02:1.0", 1.0),
        ("pedal:3211:0.02:0.7", 1.0),
        ("pedal:doublet:0.02:1.0", 3.0),
        ("pedal:3211:0.02:0.7", 3.0),
    ] {
        let all: Vec<[f64; 5]> = over_seeds(seeds(10), |seed| errors(input, noise, seed)).into_iter().flatten().collect();
        if all.is_empty() {
            return;
        }
        let mean = |place: usize| all.iter().map(|one| one[place]).sum::<f64>() / all.len() as f64;
        let [smoother, best, eight, lagged, best_hz]: [f64; 5] = std::array::from_fn(mean);
        eprintln!(
            "{input}, noise x {noise}: smoother {smoother:.5} rad/s^2, fixed lag {lagged:.5}, best zero-phase filter {best:.5} \
             (at {best_hz:.2} Hz), 8 Hz {eight:.5}: {:.3} and {:.3} times",
            smoother / best,
            smoother / eight
        );
        assert!(smoother <= 1.05 * best);
    }
}

const STATES: [&str; 16] =
    ["u", "v", "w", "phi", "theta", "psi", "altitude", "p", "q", "r", "p-dot", "q-dot", "r-dot", "ax", "ay", "az"];

fn numbers(state: &StateRecord) -> ([f64; 16], [f64; 16]) {
    let s = state;
    let flat = |a: [[f64; 3]; 2], altitude: f64, b: [[f64; 3]; 3]| {
        let mut out = [altitude; 16];
        out[..6].copy_from_slice(a.as_flattened());
        out[7..].copy_from_slice(b.as_flattened());
        out
    };
    (
        flat([s.velocity, s.attitude], s.altitude, [s.rates, s.angular_acceleration, s.specific_force]),
        flat([s.velocity_std, s.attitude_std], s.altitude_std, [s.rates_std, s.angular_acceleration_std, s.specific_force_std]),
    )
}

fn truth_of(state: &TrueState) -> [f64; 16] {
    let motion = &state.motion;
    let mut out = [motion.altitude; 16];
    out[..6].copy_from_slice([state.air_velocity, motion.attitude].as_flattened());
    out[7..].copy_from_slice([motion.rates, state.angular_acceleration, state.specific_force].as_flattened());
    out
}

/// Squared errors of filter and smoother, and squares over variances, summed over one flight.
fn squares(input: &str, seed: u64) -> Option<[[f64; 16]; 4]> {
    // Lags, delays and wrong scales are not the smoother's to mend: noise, words, rates, vibration and dropouts are.
    let mut instruments = instruments(1.0);
    for one in &mut instruments.channels {
        (one.lag_s, one.delay_s, one.factor, one.bias) = (0.0, 0.0, 1.0, 0.0);
    }
    let flown = fly(input, &instruments, seed)?;
    let whole = smooth(&flown.samples, &EstimationConfig::default(), geometry(&instruments)).unwrap();
    let config = EstimationConfig {
        noise: whole.noise.noise,
        angular_acceleration_walk: whole.noise.angular_acceleration_walk,
        specific_force_walk: whole.noise.specific_force_walk,
        noise_source: NoiseSource::Configured,
        ..EstimationConfig::default()
    };
    let mut estimator = Box::new(Estimator::new(config, geometry(&instruments)).unwrap());
    let filtered: Vec<StateRecord> = flown.samples.iter().filter_map(|sample| estimator.step(sample).state).collect();
    assert_eq!(filtered.len(), whole.states.len());
    let mut sums = [[0.0; 16]; 4];
    for (filtered, smoothed) in filtered.iter().zip(&whole.states) {
        // The truth is on the 256 Hz grid; after two seconds and before the last one.
        let place = (filtered.time_s * RATE_HZ).round();
        if (filtered.time_s * RATE_HZ - place).abs() > 1e-6 || !(2.0..19.0).contains(&filtered.time_s) {
            continue;
        }
        let truth = truth_of(&flown.truth[place as usize]);
        for (k, state) in [filtered, smoothed].into_iter().enumerate() {
            let (found, std) = numbers(state);
            for i in 0..16 {
                let error = found[i] - truth[i];
                sums[k][i] += error * error;
                sums[2 + k][i] += error * error / (std[i] * std[i]);
            }
        }
    }
    Some(sums)
}

#[test]
fn the_smoother_s_errors_are_smaller_than_the_filter_s_in_every_state() {
    let mut all: Vec<[[f64; 16]; 4]> = Vec::new();
    for input in ["pedal:doublet:0.02:1.0", "pedal:3211:0.02:0.7"] {
        all.extend(over_seeds(seeds(8), |seed| squares(input, seed)).into_iter().flatten());
    }
    if all.is_empty() {
        return;
    }
    let sum = |k: usize, i: usize| all.iter().map(|one| one[k][i]).sum::<f64>();
    for (i, name) in STATES.into_iter().enumerate() {
        let count = sum(0, i) / sum(2, i).max(f64::MIN_POSITIVE);
        eprintln!(
            "{name:9} error variance of the smoother {:.3} of the filter's (mean variance told {:.2e})",
            sum(1, i) / sum(0, i),
            count
        );
    }
    for (i, name) in STATES.into_iter().enumerate() {
        assert!(sum(1, i) < sum(0, i), "{name}");
    }
}
