//! One measurement after the other on the factors, against the textbook's joint update on the whole covariance.

use crate::support::uniform::Uniform;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::estimation::aid;
use sideslip::realtime::estimation::aid::inertial;
use sideslip::realtime::estimation::aid::prediction::Prediction;
use sideslip::realtime::estimation::config::Noise;
use sideslip::realtime::estimation::ekf::{Ekf, ProcessNoise};
use sideslip::realtime::estimation::process::{ACCELEROMETER_BIAS, GYRO_BIAS, MOVING, NAVIGATION, STATES, jacobian, rate};
use sideslip::realtime::estimation::record::Aid;

type Covariance = SMatrix<f64, STATES, STATES>;

const NOISE: Noise = Noise {
    accelerometer_std: [0.05; 3],
    gyro_std: [0.002; 3],
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
    ProcessNoise {
        angular_acceleration: [0.5, 0.3, 0.2],
        specific_force: [4.0, 2.0, 9.0],
        measured: [true; 3],
        accelerometer_walk_var: 1e-8,
        gyro_walk_var: 1e-10,
    }
}

const INERTIAL: usize = 6;

fn predict(ekf: &Ekf, which: usize, geometry: &RunGeometry) -> Prediction {
    match which.checked_sub(INERTIAL) {
        Some(aid) => aid::predict(Aid::ALL[aid], ekf.state(), geometry, &NOISE).unwrap(),
        None => inertial::predict(which, ekf.state(), &NOISE),
    }
}

/// A filter in flight: propagated and corrected until everything is correlated with everything.
fn in_flight(uniform: &mut Uniform) -> Ekf {
    let mut state = [0.0; STATES];
    [state[0], state[1], state[2], state[4], state[6]] = [50.0, uniform.within(3.0), uniform.within(5.0), 0.05, 300.0];
    state[15] = -9.8;
    let navigation = [0.3, 0.2, 0.2, 1e-4, 1e-4, 1e-3, 4.0];
    let inertial = [0.01, 0.01, 0.01, 0.1, 0.1, 0.1, 1.0, 1.0, 1.0];
    let errors = [0.01, 0.01, 0.01, 1e-5, 1e-5, 1e-5, 1e-4, 4e-4, 4e-4];
    let mut variances = [0.0; STATES];
    for (variance, value) in variances.iter_mut().zip(navigation.into_iter().chain(inertial).chain(errors)) {
        *variance = value;
    }
    let mut ekf = Ekf::new(state, variances);
    for step in 0..60 {
        ekf.propagate(0.02, &process_noise()).unwrap();
        for which in [step % INERTIAL, INERTIAL + step % Aid::ALL.len()] {
            let prediction = predict(&ekf, which, &RunGeometry::default());
            let observation = prediction.value + 0.5 * uniform.within(libm::sqrt(prediction.noise_var));
            ekf.fuse(observation, &prediction, 5.0).unwrap();
        }
    }
    ekf
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

/// Gyros, accelerometers, attitude and altitude: what is linear in the state.
const LINEAR: [usize; 10] = [0, 1, 2, 3, 4, 5, 9, 10, 11, 12];

#[test]
fn what_is_linear_one_by_one_are_the_joint_update_in_any_order() {
    let mut uniform = Uniform(51);
    for round in 0..50 {
        let ekf = in_flight(&mut uniform);
        let predict = |ekf: &Ekf, which| predict(ekf, which, &RunGeometry::default());
        let at_start: Vec<Prediction> = LINEAR.iter().map(|&which| predict(&ekf, which)).collect();
        let innovations: Vec<f64> =
            at_start.iter().map(|prediction| uniform.within(2.0 * libm::sqrt(prediction.noise_var))).collect();
        let (x, p) = joint(&ekf, &at_start, &innovations);
        let mut one_by_one = ekf.clone();
        for k in 0..LINEAR.len() {
            let k = (k + round) % LINEAR.len();
            let observation = at_start[k].value + innovations[k];
            let prediction = predict(&one_by_one, LINEAR[k]);
            let said = one_by_one.fuse(observation, &prediction, 100.0).unwrap();
            assert!(said.gain.is_some());
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
        let ekf = in_flight(&mut uniform);
        for which in 0..INERTIAL + Aid::ALL.len() {
            let prediction = predict(&ekf, which, &geometry);
            let innovation = uniform.within(libm::sqrt(prediction.noise_var));
            let (x, p) = joint(&ekf, &[prediction], &[innovation]);
            let mut updated = ekf.clone();
            let said = updated.fuse(prediction.value + innovation, &prediction, 100.0).unwrap();
            assert_same(&updated, &covariance(&ekf), &x, &p);
            let h = SVector::from(prediction.row);
            let s = (h.transpose() * covariance(&ekf) * h)[0] + prediction.noise_var;
            assert!(said.gain.is_some() && (said.innovation - innovation).abs() < 1e-12);
            assert!((said.innovation_var / s - 1.0).abs() < 1e-9);
            assert!((said.test_ratio / (innovation * innovation / (1e4 * s)) - 1.0).abs() < 1e-6);
            // Beyond the gate nothing moves.
            let mut gated = ekf.clone();
            let far = prediction.value + if prediction.wraps { 1.0 } else { 1e3 };
            let said = gated.fuse(far, &prediction, 5.0).unwrap();
            assert!(said.gain.is_none() && said.test_ratio > 1.0);
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
        let mut ekf = in_flight(&mut uniform);
        let noise = ProcessNoise { measured: [uniform.within(1.0) > 0.0, true, uniform.within(1.0) > 0.0], ..noise };
        let dt = uniform.between(0.004, 0.8);
        let mut middle = *ekf.state();
        for (x, slope) in middle.iter_mut().zip(rate(ekf.state(), &noise.measured).unwrap()) {
            *x += 0.5 * dt * slope;
        }
        let slope = rate(&middle, &noise.measured).unwrap();
        let x = SVector::from_fn(|i, _| ekf.state()[i] + slope.get(i).map_or(0.0, |slope| dt * slope));
        let a = jacobian(&middle, &noise.measured).unwrap();
        let mut f = Covariance::identity();
        for i in 0..NAVIGATION {
            for j in 0..MOVING {
                f[(i, j)] += dt * a[i][j];
            }
            for j in 0..3 {
                // Through the rates, to second order.
                f[(i, 10 + j)] = 0.5 * dt * dt * a[i][7 + j];
            }
        }
        let mut driver = SMatrix::<f64, STATES, 6>::zeros();
        let mut q = SMatrix::<f64, 6, 6>::zeros();
        for i in 0..3 {
            f[(7 + i, 10 + i)] = dt;
            (driver[(7 + i, i)], driver[(10 + i, i)]) = (0.5 * dt * dt, dt);
            (driver[(i, 3 + i)], driver[(13 + i, 3 + i)]) = (if noise.measured[i] { 0.5 * dt * dt } else { dt }, dt);
            (q[(i, i)], q[(3 + i, 3 + i)]) = (noise.angular_acceleration[i] / dt, noise.specific_force[i] / dt);
        }
        let before = covariance(&ekf);
        let mut p = f * before * f.transpose() + driver * q * driver.transpose();
        if gathered_s + dt >= 0.5 {
            walks += 1;
            for i in 0..3 {
                p[(ACCELEROMETER_BIAS + i, ACCELEROMETER_BIAS + i)] += noise.accelerometer_walk_var * (gathered_s + dt);
                p[(GYRO_BIAS + i, GYRO_BIAS + i)] += noise.gyro_walk_var * (gathered_s + dt);
            }
        }
        ekf.propagate(dt, &noise).unwrap();
        assert_same(&ekf, &before, &x, &p);
    }
    assert!((10..40).contains(&walks), "{walks}");
}

/// A heading that a compass reads as -3.1 is 0.083 past 3.1, not 6.2 before it.
#[test]
fn an_angle_is_compared_the_short_way_round() {
    let mut uniform = Uniform(54);
    let mut state = *in_flight(&mut uniform).state();
    state[5] = 3.1;
    let mut turned = Ekf::new(state, [0.01; STATES]);
    let prediction = aid::predict(Aid::Heading, &state, &RunGeometry::default(), &NOISE).unwrap();
    let said = turned.fuse(-3.1, &prediction, 5.0).unwrap();
    assert!(said.gain.is_some() && (said.innovation - (2.0 * std::f64::consts::PI - 6.2)).abs() < 1e-12, "{said:?}");
    assert!(turned.state()[5] > 3.1);
}
