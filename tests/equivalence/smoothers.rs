//! The fixed-lag smoother against the fixed-interval one over a record that ends there, and that against the textbook.

use crate::support::manoeuvre::{INPUTS, fly};
use crate::support::puma::puma_100kn;
use nalgebra::{SMatrix, SVector};
use sideslip::flight::channel::Channel;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::config::{EstimationConfig, NoiseSource};
use sideslip::realtime::estimation::ekf::{FilterObserver, Fusion, Transition};
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::estimation::fixed_interval::smooth;
use sideslip::realtime::estimation::process::{MOVING, STATES, State};
use sideslip::realtime::estimation::record::{LaggedRecord, StateRecord};
use sideslip::simulation::instrument::InstrumentSet;

fn configured() -> EstimationConfig {
    EstimationConfig { noise_source: NoiseSource::Configured, ..EstimationConfig::default() }
}

fn flight(seconds: f64, seed: u64) -> Option<Vec<Sample>> {
    let flown = fly(&puma_100kn()?, &INPUTS, &InstrumentSet::flight_quality(1.0), seed);
    Some(flown.samples.into_iter().filter(|sample| sample.time_s < seconds).collect())
}

/// Every number of the two that smoothing moves, with the standard deviation it is judged by.
fn moving(state: &StateRecord) -> Vec<(f64, f64)> {
    let s = state;
    let values = [s.velocity, s.attitude, s.rates, s.angular_acceleration, s.specific_force].concat();
    let std = [s.velocity_std, s.attitude_std, s.rates_std, s.angular_acceleration_std, s.specific_force_std].concat();
    values.into_iter().zip(std).chain([(s.altitude, s.altitude_std)]).collect()
}

#[test]
fn the_fixed_lag_smoother_is_the_fixed_interval_smoother_stopped_at_its_lag() {
    let Some(samples) = flight(8.0, 5) else { return };
    let mut estimator = Box::new(Estimator::new(configured(), RunGeometry::default()).unwrap());
    let mut compared = 0;
    for (k, sample) in samples.iter().enumerate() {
        let Some(lagged) = estimator.step(sample).lagged else { continue };
        let (lagged, lag_s) = (lagged.state, lagged.lag_s);
        if k % 5 != 0 {
            continue;
        }
        let whole = smooth(&samples[..=k], &configured(), RunGeometry::default()).unwrap();
        let same = whole.states.iter().find(|state| (state.time_s - lagged.time_s).abs() < 1e-9).unwrap();
        for (i, ((found, found_std), (expected, std))) in moving(&lagged).into_iter().zip(moving(same)).enumerate() {
            assert!((found - expected).abs() <= 1e-9 * std.max(expected.abs()), "{i} at {}: {found} {expected}", lagged.time_s);
            assert!((found_std / std - 1.0).abs() <= 1e-9, "std {i} at {}: {found_std} {std}", lagged.time_s);
        }
        assert!((0.5..0.52).contains(&lag_s) && (sample.time_s - lagged.time_s - lag_s).abs() < 1e-12, "{lag_s}");
        compared += 1;
    }
    assert!(compared > 10, "{compared}");
}

/// Steady flight, every channel at that rate.
fn steady(rate_hz: f64) -> Vec<Sample> {
    let (alpha, gravity) = (0.04_f64, 9.806_65);
    let at_rest = [Channel::P, Channel::Q, Channel::R, Channel::Ay, Channel::Beta, Channel::Phi, Channel::Psi];
    let sample = |k: u32| {
        let mut sample = Sample::new(f64::from(k) / rate_hz);
        at_rest.into_iter().for_each(|channel| sample.set(channel, 0.0));
        sample.set(Channel::Tas, 51.0);
        sample.set(Channel::Altitude, 1000.0);
        sample.set(Channel::Alpha, alpha);
        sample.set(Channel::Theta, alpha);
        sample.set(Channel::Ax, gravity * alpha.sin());
        sample.set(Channel::Az, -gravity * alpha.cos());
        sample
    };
    (0..(6.0 * rate_hz) as u32).map(sample).collect()
}

#[test]
fn live_smoothed_states_come_at_10_hz_or_more_and_no_faster_than_the_smoother_s_grid() {
    for rate_hz in [25.0, 32.0, 40.0, 50.0, 64.0, 100.0, 128.0, 200.0, 256.0] {
        let mut estimator = Box::new(Estimator::new(EstimationConfig::default(), RunGeometry::default()).unwrap());
        let of_age = |sample: &Sample| estimator.step(sample).lagged;
        let lagged: Vec<LaggedRecord> = steady(rate_hz).iter().filter_map(of_age).collect();
        assert!(lagged.len() > 50, "{rate_hz} Hz: {}", lagged.len());
        for [before, after] in lagged.array_windows() {
            let apart_s = after.state.time_s - before.state.time_s;
            assert!((0.079..0.1 + 1e-9).contains(&apart_s), "{rate_hz} Hz: {apart_s} s");
        }
        for LaggedRecord { lag_s, .. } in &lagged {
            assert!((0.5..0.5 + 1.01 / rate_hz).contains(lag_s), "{rate_hz} Hz: {lag_s} s");
        }
    }
}

type Matrix = SMatrix<f64, STATES, STATES>;

/// The filter's states and covariances before and after each sample.
#[derive(Default)]
struct Way {
    transitions: Vec<Matrix>,
}

impl FilterObserver for Way {
    fn propagate(&mut self, transition: &Transition) {
        let entry = |i: usize, j: usize| if i < MOVING && j < MOVING { transition[i][j] } else { f64::from(u8::from(i == j)) };
        self.transitions.push(Matrix::from_fn(entry));
    }
    fn fuse(&mut self, _: &State, _: &Fusion) {}
}

/// Rauch-Tung-Striebel, with every inverse: x_s = x + A (x_s' - f(x)), P_s = P + A (P_s' - P') A', A = P F' P'^-1, where the
/// predictions come from a filter that propagates a copy of the state without measurements.
#[test]
fn the_fixed_interval_smoother_is_the_textbook_s() {
    let Some(samples) = flight(3.0, 6) else { return };
    let samples = &samples[..200];
    let config = EstimationConfig { accelerometer_bias_walk: 0.0, gyro_bias_walk: 0.0, ..configured() };
    let mut estimator = Box::new(Estimator::new(config, RunGeometry::default()).unwrap());
    let mut way = Way::default();
    let mut posterior: Vec<(f64, SVector<f64, STATES>, Matrix)> = Vec::new();
    let mut predicted: Vec<(SVector<f64, STATES>, Matrix)> = Vec::new();
    for sample in samples {
        // The same sample without its measurements leaves the prediction.
        let mut blind = estimator.clone();
        let ran = estimator.step_with(sample, &mut way).state.is_some();
        let mut time_alone = Sample::new(sample.time_s);
        time_alone.present = 0;
        if ran {
            blind.step(&time_alone);
            let (filter, before) = (estimator.filter().unwrap(), blind.filter().unwrap());
            let matrix =
                |filter: &sideslip::realtime::estimation::ekf::Ekf| Matrix::from_fn(|i, j| filter.covariance().covariance(i, j));
            posterior.push((sample.time_s, SVector::from(*filter.state()), matrix(filter)));
            predicted.push((SVector::from(*before.state()), matrix(before)));
        }
    }
    let n = posterior.len();
    assert!(n > 100 && way.transitions.len() == n);
    let found = smooth(samples, &config, RunGeometry::default()).unwrap().states;
    let (_, mut x, mut p) = posterior[n - 1];
    for k in (0..n).rev() {
        if k + 1 < n {
            let (_, xk, pk) = &posterior[k];
            let (xp, pp) = &predicted[k + 1];
            // Scaled to unit variances first: the states' units span twelve decades.
            let scale = Matrix::from_diagonal(&pp.diagonal().map(|var| 1.0 / var.sqrt()));
            let inverse = scale * (scale * pp * scale).try_inverse().unwrap() * scale;
            let gain = pk * way.transitions[k + 1].transpose() * inverse;
            x = xk + gain * (x - xp);
            p = pk + gain * (p - pp) * gain.transpose();
        }
        let expected: Vec<f64> = (0..3).map(|i| x[i]).chain((0..3).map(|i| x[3 + i])).chain((0..9).map(|i| x[7 + i])).collect();
        for (i, ((found, std), expected)) in moving(&found[k]).into_iter().zip(expected).enumerate() {
            assert!((found - expected).abs() <= 1e-6 * std, "{i} at {k}: {found} {expected}, std {std}");
            let place = if i < 6 { i } else { i + 1 };
            assert!((std / p[(place, place)].sqrt() - 1.0).abs() <= 1e-6, "std {i} at {k}: {std} {}", p[(place, place)].sqrt());
        }
    }
}
