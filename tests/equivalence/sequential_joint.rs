//! One measurement after the other on the factors, against the textbook's joint update on the whole covariance.

use crate::uniform::Uniform;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use sideslip::estimation::aid::{self, Prediction};
use sideslip::estimation::config::Noise;
use sideslip::estimation::ekf::{Ekf, ProcessNoise};
use sideslip::estimation::process::{
    ACCELEROMETER_BIAS, GYRO_BIAS, INPUTS, Input, NAVIGATION, STATES, jacobians, rate, unbiased,
};
use sideslip::estimation::record::Aid;
use sideslip::flight::run::RunGeometry;

type Covariance = SMatrix<f64, STATES, STATES>;

const NOISE: Noise = Noise {
    accelerometer_std: 0.05,
    gyro_std: 0.002,
    airspeed_std: 0.5,
    incidence_std: 0.003,
    sideslip_std: 0.004,
    bank_std: 0.003,
    pitch_std: 0.005,
    heading_std: 0.01,
    altitude_std: 2.0,
};

fn covariance(ekf: &Ekf) -> Covariance {
    Covariance::from_fn(|i, j| ekf.covariance().covariance(i, j))
}

fn process_noise() -> ProcessNoise {
    let (a, g) = (NOISE.accelerometer_std * NOISE.accelerometer_std, NOISE.gyro_std * NOISE.gyro_std);
    ProcessNoise { input_var: [a, a, a, g, g, g], accelerometer_walk_var: 1e-8, gyro_walk_var: 1e-10 }
}

fn input(uniform: &mut Uniform) -> Input {
    let force = [uniform.within(1.0), uniform.within(1.0), -9.8 + uniform.within(1.0)];
    let [ax, ay, az] = force;
    [ax, ay, az, uniform.within(0.3), uniform.within(0.3), uniform.within(0.3)]
}

/// A filter in flight: propagated and corrected until everything is correlated with everything.
fn in_flight(uniform: &mut Uniform) -> (Ekf, Input) {
    let mut state = [0.0; STATES];
    [state[0], state[1], state[2], state[4], state[6]] = [50.0, uniform.within(3.0), uniform.within(5.0), 0.05, 300.0];
    let variances = [0.3, 0.2, 0.2, 1e-4, 1e-4, 1e-3, 4.0, 0.01, 0.01, 0.01, 1e-5, 1e-5, 1e-5];
    let mut ekf = Ekf::new(state, variances);
    let mut from = input(uniform);
    for step in 0..60 {
        let to = input(uniform);
        ekf.propagate(&from, &to, 0.02, &process_noise()).unwrap();
        from = to;
        let aid = Aid::ALL[step % Aid::ALL.len()];
        let prediction = aid::predict(aid, ekf.state(), &from, &RunGeometry::default(), &NOISE).unwrap();
        let observation = prediction.value + 0.5 * uniform.within(libm::sqrt(prediction.noise_var));
        ekf.fuse(0.0, aid, observation, &prediction, 5.0).unwrap();
    }
    (ekf, from)
}

/// x + K nu and (I - K H) P (I - K H)' + K R K' for all rows at once.
fn joint(ekf: &Ekf, predictions: &[Prediction], innovations: &[f64]) -> (SVector<f64, STATES>, Covariance) {
    let n = predictions.len();
    let h = DMatrix::from_fn(n, STATES, |i, j| predictions[i].row[j]);
    let r = DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| predictions[i].noise_var));
    let p = DMatrix::from_fn(STATES, STATES, |i, j| ekf.covariance().covariance(i, j));
    let s = &h * &p * h.transpose() + &r;
    let k = &p * h.transpose() * s.try_inverse().unwrap();
    let x = DVector::from_column_slice(ekf.state()) + &k * DVector::from_column_slice(innovations);
    let rest = DMatrix::identity(STATES, STATES) - &k * h;
    let p = &rest * p * rest.transpose() + &k * r * k.transpose();
    (SVector::from_fn(|i, _| x[i]), Covariance::from_fn(|i, j| p[(i, j)]))
}

/// Each state, and each covariance on the scale of its two standard deviations, to 1e-9.
fn assert_same(ekf: &Ekf, before: &Covariance, x: &SVector<f64, STATES>, p: &Covariance) {
    let found = covariance(ekf);
    for i in 0..STATES {
        let std = libm::sqrt(before[(i, i)]);
        assert!((ekf.state()[i] - x[i]).abs() <= 1e-9 * std, "state {i}: {} and {}", ekf.state()[i], x[i]);
        for j in 0..STATES {
            let scale = libm::sqrt(p[(i, i)] * p[(j, j)]);
            assert!((found[(i, j)] - p[(i, j)]).abs() <= 1e-9 * scale, "P {i} {j}: {} and {}", found[(i, j)], p[(i, j)]);
        }
    }
}

const LINEAR: [Aid; 4] = [Aid::Bank, Aid::Pitch, Aid::Heading, Aid::Altitude];

#[test]
fn attitude_and_altitude_one_by_one_are_the_joint_update_in_any_order() {
    let mut uniform = Uniform(51);
    for round in 0..50 {
        let (ekf, input) = in_flight(&mut uniform);
        let predict = |ekf: &Ekf, aid| aid::predict(aid, ekf.state(), &input, &RunGeometry::default(), &NOISE).unwrap();
        let at_start: Vec<Prediction> = LINEAR.iter().map(|&aid| predict(&ekf, aid)).collect();
        let innovations: Vec<f64> =
            at_start.iter().map(|prediction| uniform.within(2.0 * libm::sqrt(prediction.noise_var))).collect();
        let (x, p) = joint(&ekf, &at_start, &innovations);
        let mut one_by_one = ekf.clone();
        for k in 0..LINEAR.len() {
            let k = (k + round) % LINEAR.len();
            let observation = at_start[k].value + innovations[k];
            let prediction = predict(&one_by_one, LINEAR[k]);
            let said = one_by_one.fuse(0.0, LINEAR[k], observation, &prediction, 100.0).unwrap();
            assert!(said.fused);
        }
        assert_same(&one_by_one, &covariance(&ekf), &x, &p);
    }
}

/// A reading that is not linear: one update is the textbook's at the same point of linearisation.
#[test]
fn each_aid_alone_is_the_textbook_update() {
    let mut uniform = Uniform(52);
    let geometry =
        RunGeometry { accelerometer_position_m: [0.7, -0.3, 0.2], vane_position_m: [6.0, 0.5, -0.4], ..RunGeometry::default() };
    for _ in 0..50 {
        let (ekf, input) = in_flight(&mut uniform);
        for aid in Aid::ALL {
            let prediction = aid::predict(aid, ekf.state(), &input, &geometry, &NOISE).unwrap();
            let innovation = uniform.within(libm::sqrt(prediction.noise_var));
            let (x, p) = joint(&ekf, &[prediction], &[innovation]);
            let mut updated = ekf.clone();
            let said = updated.fuse(3.0, aid, prediction.value + innovation, &prediction, 100.0).unwrap();
            assert_same(&updated, &covariance(&ekf), &x, &p);
            let h = SVector::from(prediction.row);
            let s = (h.transpose() * covariance(&ekf) * h)[0] + prediction.noise_var;
            assert!(said.fused && (said.innovation - innovation).abs() < 1e-12);
            assert!((said.innovation_var / s - 1.0).abs() < 1e-9);
            assert!((said.test_ratio / (innovation * innovation / (1e4 * s)) - 1.0).abs() < 1e-6);
            // Beyond the gate nothing moves.
            let mut gated = ekf.clone();
            let far = prediction.value + if prediction.wraps { 1.0 } else { 1e3 };
            let said = gated.fuse(3.0, aid, far, &prediction, 5.0).unwrap();
            assert!(!said.fused && said.test_ratio > 1.0);
            assert_eq!((gated.state(), covariance(&gated)), (ekf.state(), covariance(&ekf)));
        }
    }
}

/// The factors' time update against F P F' + G Q G' written out, with the biases' walk where half a second of it has gathered.
#[test]
fn propagation_is_the_textbook_prediction() {
    let mut uniform = Uniform(53);
    let noise = ProcessNoise { accelerometer_walk_var: 1e-3, gyro_walk_var: 1e-6, ..process_noise() };
    // What has gathered since the last walk in the 60 steps before.
    let gathered_s = (0..60).fold(0.0, |gathered: f64, _| if gathered + 0.02 >= 0.5 { 0.0 } else { gathered + 0.02 });
    let mut walks = 0;
    for _ in 0..50 {
        let (mut ekf, from) = in_flight(&mut uniform);
        let to = input(&mut uniform);
        let dt = uniform.between(0.004, 0.8);
        let mean: Input = std::array::from_fn(|i| 0.5 * (from[i] + to[i]));
        let m = unbiased(ekf.state(), &mean);
        let mut middle = *ekf.state();
        let slope = rate(&middle, &m).unwrap();
        for i in 0..NAVIGATION {
            middle[i] += 0.5 * dt * slope[i];
        }
        let slope = rate(&middle, &m).unwrap();
        let x = SVector::from_fn(|i, _| ekf.state()[i] + if i < NAVIGATION { dt * slope[i] } else { 0.0 });
        let (a, g) = jacobians(&middle, &m).unwrap();
        let mut f = Covariance::identity();
        let mut input_matrix = SMatrix::<f64, STATES, INPUTS>::zeros();
        for i in 0..NAVIGATION {
            for j in 0..NAVIGATION {
                f[(i, j)] += dt * a[i][j];
            }
            for j in 0..INPUTS {
                input_matrix[(i, j)] = dt * g[i][j];
                f[(i, ACCELEROMETER_BIAS + j)] = -dt * g[i][j];
            }
        }
        let before = covariance(&ekf);
        let q = SMatrix::<f64, INPUTS, INPUTS>::from_diagonal(&noise.input_var.into());
        let mut p = f * before * f.transpose() + input_matrix * q * input_matrix.transpose();
        if gathered_s + dt >= 0.5 {
            walks += 1;
            for i in 0..3 {
                p[(ACCELEROMETER_BIAS + i, ACCELEROMETER_BIAS + i)] += noise.accelerometer_walk_var * (gathered_s + dt);
                p[(GYRO_BIAS + i, GYRO_BIAS + i)] += noise.gyro_walk_var * (gathered_s + dt);
            }
        }
        ekf.propagate(&from, &to, dt, &noise).unwrap();
        assert_same(&ekf, &before, &x, &p);
    }
    assert!((10..40).contains(&walks), "{walks}");
}

/// A heading that a compass reads as -3.1 is 0.083 past 3.1, not 6.2 before it.
#[test]
fn an_angle_is_compared_the_short_way_round() {
    let mut uniform = Uniform(54);
    let (ekf, input) = in_flight(&mut uniform);
    let mut state = *ekf.state();
    state[5] = 3.1;
    let mut turned = Ekf::new(state, [0.01; STATES]);
    let prediction = aid::predict(Aid::Heading, &state, &input, &RunGeometry::default(), &NOISE).unwrap();
    let said = turned.fuse(0.0, Aid::Heading, -3.1, &prediction, 5.0).unwrap();
    assert!(said.fused && (said.innovation - (2.0 * std::f64::consts::PI - 6.2)).abs() < 1e-12, "{said:?}");
    assert!(turned.state()[5] > 3.1);
}
