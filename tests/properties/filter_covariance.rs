//! The filter's own covariance, all 25 states with the transitions and measurements of its models, in any units and in either
//! precision: symmetric and positive throughout, and the same whatever the units are.
//!
//! The states along the way are random attitudes and rates, so that every entry of F and H comes into play. The long run takes a
//! tenth of the steps of `covariance` (`SIDESLIP_COVARIANCE_STEPS`).

use super::covariance::Scalar;
use crate::support::uniform::Uniform;
use nalgebra::SMatrix;
use proptest::prelude::*;
use sideslip::flight::run::RunGeometry;
use sideslip::num::ud::UdFactor;
use sideslip::realtime::estimation::aid::{inertial, predict};
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::ekf::{DRIVERS, Transition};
use sideslip::realtime::estimation::process::{
    ACCELEROMETER_BIAS, ANGULAR_ACCELERATION, GYRO_BIAS, MOVING, NAVIGATION, RATES, SPECIFIC_FORCE, STATES, State, VELOCITY,
    jacobian,
};
use sideslip::realtime::estimation::record::Aid;

/// Standard deviations at the start, in the order of the states.
const START_STD: State = [
    0.5, 0.5, 0.5, 0.01, 0.01, 3.0, 1e3, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 30.0, 30.0, 30.0, 0.1, 0.1, 0.1, 3e-3, 3e-3, 3e-3, 1e-9,
    0.02, 0.02,
];

/// One thing that the filter does.
enum Step {
    Propagate { top: Box<Transition>, input: Box<[[f64; DRIVERS]; MOVING]>, var: [f64; DRIVERS] },
    Fuse { row: Box<State>, var: f64 },
    Inflate { state: usize, by: f64 },
}

/// Somewhere in flight.
fn state(uniform: &mut Uniform) -> State {
    let mut x: State = std::array::from_fn(|i| uniform.within(START_STD[i].min(1.0)));
    x[VELOCITY] = uniform.between(20.0, 120.0);
    x[VELOCITY + 1] = uniform.within(10.0);
    x[VELOCITY + 2] = uniform.within(15.0);
    x[3] = uniform.within(1.2);
    x[4] = uniform.within(1.2);
    x
}

/// What the filter does at one sample, by its own models: a time step with what drives it, a few measurements, now and then the
/// walk of a bias.
fn sample(uniform: &mut Uniform, steps: &mut Vec<Step>) {
    let config = EstimationConfig::default();
    let x = state(uniform);
    let dt = uniform.between(0.004, 0.1);
    let half = 0.5 * dt * dt;
    let mut measured = [true; 3];
    measured.fill_with(|| !uniform.bits().is_multiple_of(4));
    let a = jacobian(&x, &measured).unwrap();
    let mut top: Transition = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let mut input = [[0.0; DRIVERS]; MOVING];
    for i in 0..NAVIGATION {
        for j in 0..MOVING {
            top[i][j] += dt * a[i][j];
        }
        for j in 0..3 {
            top[i][ANGULAR_ACCELERATION + j] = half * a[i][RATES + j];
        }
    }
    for i in 0..3 {
        top[RATES + i][ANGULAR_ACCELERATION + i] = dt;
        input[RATES + i][i] = half;
        input[ANGULAR_ACCELERATION + i][i] = dt;
        input[SPECIFIC_FORCE + i][3 + i] = dt;
        input[VELOCITY + i][3 + i] = if measured[i] { half } else { dt };
    }
    // Walks from a tenth to ten times the usual ones.
    let mut walk = |usual: f64| (usual * 10_f64.powf(uniform.within(1.0))).powi(2) / dt;
    let (angular, force) = (config.angular_acceleration_walk, config.specific_force_walk);
    let var = std::array::from_fn(|i| walk(if i < 3 { angular[i] } else { force[i - 3] }));
    steps.push(Step::Propagate { top: Box::new(top), input: Box::new(input), var });
    let geometry = RunGeometry { vane_position_m: [6.0, 0.5, -1.0], ..RunGeometry::default() };
    for place in 0..6 {
        if place < 3 || measured[place - 3] {
            let prediction = inertial::predict(place, &x, &config.noise);
            steps.push(Step::Fuse { row: Box::new(prediction.row), var: prediction.noise_var });
        }
    }
    for aid in Aid::ALL {
        if uniform.bits().is_multiple_of(3)
            && let Some(prediction) = predict(aid, &x, &geometry, &config.noise)
        {
            steps.push(Step::Fuse { row: Box::new(prediction.row), var: prediction.noise_var });
        }
    }
    let bias = (uniform.bits() % 3) as usize;
    steps.push(Step::Inflate { state: ACCELEROMETER_BIAS + bias, by: config.accelerometer_bias_walk.powi(2) * dt });
    steps.push(Step::Inflate { state: GYRO_BIAS + bias, by: config.gyro_bias_walk.powi(2) * dt });
}

/// The step done to states whose values are `scale` times as large.
fn take<T: Scalar>(factor: &mut UdFactor<T, STATES>, step: &Step, scale: &State) {
    match step {
        Step::Propagate { top, input, var } => {
            let top: [[T; MOVING]; MOVING] =
                std::array::from_fn(|i| std::array::from_fn(|j| T::of(top[i][j] * scale[i] / scale[j])));
            let input: [[T; DRIVERS]; MOVING] = std::array::from_fn(|i| std::array::from_fn(|j| T::of(input[i][j] * scale[i])));
            factor.propagate(&top, &input, &var.map(T::of)).unwrap();
        }
        Step::Fuse { row, var } => {
            let row = std::array::from_fn(|i| T::of(row[i] / scale[i]));
            let projection = factor.project(&row, T::of(*var)).unwrap();
            assert!(projection.innovation_var.number() >= *var * (1.0 - 2.0 * T::EPSILON));
            assert!(factor.fuse(&projection).unwrap().iter().all(|entry| entry.finite()));
        }
        Step::Inflate { state, by } => factor.inflate(*state, T::of(by * scale[*state] * scale[*state])).unwrap(),
    }
}

/// Every d positive; the correlation matrix symmetric, with a Cholesky factor once its own rounding is allowed for.
fn check<T: Scalar>(factor: &UdFactor<T, STATES>) -> SMatrix<f64, STATES, STATES> {
    assert!(factor.diagonal().iter().all(|d| *d > T::ZERO && d.finite()), "{factor:?}");
    let p = SMatrix::<f64, STATES, STATES>::from_fn(|i, j| factor.covariance(i, j).number());
    assert_eq!(p, p.transpose());
    let mut correlation = SMatrix::<f64, STATES, STATES>::from_fn(|i, j| p[(i, j)] / (p[(i, i)] * p[(j, j)]).sqrt());
    assert!(correlation.iter().all(|entry| entry.abs() <= 1.0 + 8.0 * T::EPSILON), "{correlation}");
    for i in 0..STATES {
        correlation[(i, i)] += 8.0 * STATES as f64 * T::EPSILON;
    }
    assert!(correlation.cholesky().is_some(), "{correlation}");
    p
}

fn started<T: Scalar>(scale: &State) -> UdFactor<T, STATES> {
    UdFactor::from_variances(std::array::from_fn(|i| T::of((START_STD[i] * scale[i]).powi(2))))
}

fn run<T: Scalar>(steps: &[Step], scale: &State) -> SMatrix<f64, STATES, STATES> {
    let mut factor = started::<T>(scale);
    for step in steps {
        take(&mut factor, step, scale);
    }
    check(&factor)
}

proptest! {
    #![proptest_config(super::cases(48))]

    #[test]
    fn all_states_stay_symmetric_and_positive_in_any_units(
        seed in 1..u64::MAX,
        samples in 1..60_usize,
        exponents in prop::collection::vec(-4.0..4.0_f64, STATES),
    ) {
        let mut uniform = Uniform(seed);
        let mut steps = Vec::new();
        for _ in 0..samples {
            sample(&mut uniform, &mut steps);
        }
        let scale: State = std::array::from_fn(|i| 10_f64.powf(exponents[i]));
        let plain = run::<f64>(&steps, &[1.0; STATES]);
        let scaled = run::<f64>(&steps, &scale);
        run::<f32>(&steps, &[1.0; STATES]);
        run::<f32>(&steps, &scale);
        // Units change the numbers and nothing else.
        for i in 0..STATES {
            for j in 0..STATES {
                let size = (plain[(i, i)] * plain[(j, j)]).sqrt();
                let back = scaled[(i, j)] / (scale[i] * scale[j]);
                prop_assert!((back - plain[(i, j)]).abs() <= 1e-8 * size, "{i} {j}: {back} and {}", plain[(i, j)]);
            }
        }
    }
}

/// Steps of the long run, and samples between two whole checks; every d is looked at in each.
const USUAL_STEPS: f64 = 2e5;
const BETWEEN_CHECKS: u64 = 20;

fn long_run<T: Scalar>(count: u64, scale: &State) -> u64 {
    let mut uniform = Uniform(count);
    let mut factor = started::<T>(scale);
    let (mut steps, mut done, mut samples) = (Vec::new(), 0, 0);
    while done < count {
        steps.clear();
        sample(&mut uniform, &mut steps);
        for step in &steps {
            take(&mut factor, step, scale);
            assert!(factor.diagonal().iter().all(|d| *d > T::ZERO && d.finite()), "step {done}: {factor:?}");
            done += 1;
        }
        samples += 1;
        if samples % BETWEEN_CHECKS == 0 {
            check(&factor);
        }
    }
    check(&factor);
    done
}

#[test]
fn all_states_stay_symmetric_and_positive_over_a_long_run() {
    let told = std::env::var("SIDESLIP_COVARIANCE_STEPS").ok().and_then(|text| text.parse::<f64>().ok());
    let count = (told.unwrap_or(USUAL_STEPS) / 10.0) as u64;
    let badly_scaled = std::array::from_fn(|i| [1e4, 1e-4, 1e3, 1e-3][i % 4]);
    for scale in [[1.0; STATES], badly_scaled] {
        let (double, single) = (long_run::<f64>(count, &scale), long_run::<f32>(count, &scale));
        eprintln!("{double} steps of f64 and {single} of f32 with states times {scale:?}");
    }
}
