//! The linearised model against central differences of the nonlinear one; the flight against the matrix exponential
//! and against itself at half the step.

use nalgebra::SMatrix;
use sideslip::dynamics::linear::{INPUTS, Turning, forces, input_matrix, state_matrix, trim_specific_force};
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, VARIABLES, Variable};
use sideslip::flight::model::{LinearModel, Trim};
use sideslip::flight::signal::piecewise_linear::History;
use sideslip::flight::term::Term;
use sideslip::num::random::NormalNoise;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::regression::record::{LATERAL, LateralDerivatives};
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::motion::Motion;

/// A model with every derivative, banked and slipping, so that every entry of the matrices is at work.
fn model(seed: u64) -> LinearModel {
    let mut noise = NormalNoise::new(seed, 0);
    let trim = Trim {
        u: 50.0 + noise.draw(),
        v: 2.0 * noise.draw(),
        w: 3.0 * noise.draw(),
        phi: 0.2 * noise.draw(),
        theta: 0.2 * noise.draw(),
        rotor_speed: None,
        controls: [0.01, -0.02, 0.2, 0.1],
    };
    let mut model = LinearModel::about(trim);
    for axis in Axis::ALL {
        for variable in Variable::ALL {
            *model.derivative_mut(axis, variable) = 0.02 * noise.draw();
        }
    }
    for (axis, variable) in [
        (Axis::X, Variable::U),
        (Axis::Y, Variable::V),
        (Axis::Z, Variable::W),
        (Axis::L, Variable::P),
        (Axis::M, Variable::Q),
        (Axis::N, Variable::R),
    ] {
        *model.derivative_mut(axis, variable) = -0.5;
    }
    *model.derivative_mut(Axis::N, Variable::V) = 0.02;
    *model.derivative_mut(Axis::N, Variable::Pedal) = -2.0;
    model
}

/// Where the states u w q theta v p phi r stand in a motion's vector u v w p q r phi theta psi altitude.
const PLACES: [usize; 8] = [0, 2, 4, 7, 1, 3, 6, 5];

/// Rates of the eight states for deviations of the eight states and of the four controls.
fn rates(model: &LinearModel, x: [f64; 8], controls: [f64; 4]) -> [f64; 8] {
    let mut motion = Flight::trim_motion(model).to_vector();
    for (place, deviation) in PLACES.into_iter().zip(x) {
        motion[place] += deviation;
    }
    let motion = Motion::from_vector(motion);
    let mut deviations = [0.0; VARIABLES];
    let body = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R];
    for (variable, value) in body.into_iter().zip(motion.velocity.into_iter().chain(motion.rates)) {
        deviations[variable.index()] = value - model.trim.of(variable);
    }
    for (input, value) in INPUTS.into_iter().zip(controls) {
        deviations[input.variable().index()] = value;
    }
    let [x, y, z, l, m, n] = forces(model, &deviations, Turning::default());
    let change = motion.rate_of_change([x, y, z], [l, m, n]).to_vector();
    PLACES.map(|place| change[place])
}

#[test]
fn a_and_b_are_the_central_differences() {
    for seed in 0..50 {
        let mut model = model(seed);
        // Products of deviations vanish at trim with their first derivatives.
        model.add_term(Axis::N, Term::SignedSquare(Variable::V), 0.3).unwrap();
        model.add_term(Axis::L, Term::Product(Variable::P, Variable::R), 0.3).unwrap();
        let (a, b) = (state_matrix(&model), input_matrix(&model, &[]));
        let step = 1e-5;
        for column in 0..8 {
            let mut x = [0.0; 8];
            x[column] = step;
            let (up, down) = (rates(&model, x, [0.0; 4]), rates(&model, x.map(|value| -value), [0.0; 4]));
            for row in 0..8 {
                let difference = (up[row] - down[row]) / (2.0 * step);
                let entry = a[(row, column)];
                assert!((difference - entry).abs() < 5e-6, "seed {seed}, A({row}, {column}): {entry}, differences {difference}");
            }
        }
        for column in 0..4 {
            let mut controls = [0.0; 4];
            controls[column] = step;
            let (up, down) = (rates(&model, [0.0; 8], controls), rates(&model, [0.0; 8], controls.map(|value| -value)));
            for row in 0..8 {
                let difference = (up[row] - down[row]) / (2.0 * step);
                assert!((difference - b[(row, column)]).abs() < 1e-8, "seed {seed}, B({row}, {column})");
            }
        }
    }
}

#[test]
fn the_trim_is_steady() {
    for seed in 0..20 {
        let model = model(seed);
        let rates = rates(&model, [0.0; 8], [0.0; 4]);
        assert!(rates.iter().all(|rate| rate.abs() < 1e-13), "{rates:?}");
        let [x, y, z] = trim_specific_force(&model.trim);
        assert!(((x * x + y * y + z * z).sqrt() - 9.80665).abs() < 1e-12);
    }
}

/// exp(A t) by its Taylor series over a small step, squared up.
fn exponential<const N: usize>(a: &SMatrix<f64, N, N>, time_s: f64) -> SMatrix<f64, N, N> {
    let small = a * (time_s / 1024.0);
    let mut term = SMatrix::<f64, N, N>::identity();
    let mut sum = term;
    for order in 1..20 {
        term = term * small / f64::from(order);
        sum += term;
    }
    for _ in 0..10 {
        sum *= sum;
    }
    sum
}

#[test]
fn small_motions_follow_the_matrix_exponential() {
    // A pedal ramp x_c = s t is two more states: d(x_c)/dt = s, ds/dt = 0.
    let model = model(3);
    let (a, b) = (state_matrix(&model), input_matrix(&model, &[]));
    let mut augmented = SMatrix::<f64, 10, 10>::zeros();
    augmented.fixed_view_mut::<8, 8>(0, 0).copy_from(&a);
    augmented.fixed_view_mut::<8, 1>(0, 8).copy_from(&b.column(3));
    augmented[(8, 9)] = 1.0;
    for (slope, bound) in [(1e-4, 2e-4), (1e-6, 2e-8)] {
        let mut flight = Flight::of(model.clone());
        let at_trim = model.trim.controls[3];
        flight.inputs.controls[Control::Pedal.index()] =
            History::through(vec![(0.0, at_trim), (10.0, at_trim + 10.0 * slope)]).unwrap();
        flight.times_s = uniform_times(0.0, 6.0, 10.0).unwrap();
        let flown = flight.fly().unwrap();
        let trim = Flight::trim_motion(&model).to_vector();
        for state in &flown.truth {
            let exact = exponential(&augmented, state.time_s).column(9) * slope;
            let motion = state.motion.to_vector();
            for (row, place) in PLACES.into_iter().enumerate() {
                let off = (motion[place] - trim[place] - exact[row]).abs();
                // What is left is quadratic in the motion: a hundredth of the slope leaves a ten-thousandth of it.
                assert!(off < bound, "slope {slope}, {} s, state {row}: {off:e}", state.time_s);
            }
        }
    }
}

#[test]
fn half_the_step_changes_nothing_that_matters() {
    let model = model(5);
    let input = InputSpec::parse("pedal:3211:0.05:0.7:1").unwrap().deviation(1.0);
    let mut flight = Flight::of(model.clone());
    let pedal = &mut flight.inputs.controls[Control::Pedal.index()];
    *pedal = pedal.plus(1.0, &input);
    flight.times_s = uniform_times(0.0, 12.0, 50.0).unwrap();
    let whole = flight.fly().unwrap();
    flight.max_step_s = Some(0.0025);
    let half = flight.fly().unwrap();
    let mut largest = [0.0f64; 10];
    for (whole, half) in whole.truth.iter().zip(&half.truth) {
        for ((largest, a), b) in largest.iter_mut().zip(whole.motion.to_vector()).zip(half.motion.to_vector()) {
            *largest = largest.max((a - b).abs());
        }
    }
    eprintln!("largest differences between step and half step: {largest:?}");
    assert!(largest.iter().all(|&difference| difference < 1e-8), "{largest:?}");
    assert_eq!(whole.diverged_at_s, None);
}

/// Rows and columns v p phi r of the whole matrix, banked, pitched and with w0: every kinematic entry of the modes' own.
#[test]
fn the_lateral_subsystem_of_the_modes_is_that_of_the_whole_matrix() {
    const LATERAL_STATES: [usize; 4] = [4, 5, 6, 7];
    for seed in 0..50 {
        let model = model(seed);
        let (trim, whole) = (&model.trim, state_matrix(&model));
        let derivatives = LateralDerivatives {
            values: LateralDerivatives::NAMES.map(|(axis, variable)| model.derivative(axis, variable)),
            cov: [[0.0; LATERAL]; LATERAL],
            u0: trim.u,
            w0: trim.w,
            trim_std: [0.0; 2],
            phi0: trim.phi,
            theta0: trim.theta,
        };
        let found = lateral::matrix(&derivatives);
        for (i, row) in LATERAL_STATES.into_iter().enumerate() {
            for (j, column) in LATERAL_STATES.into_iter().enumerate() {
                let expected = whole[(row, column)];
                assert!((found[i][j] - expected).abs() < 1e-13, "seed {seed}, A({i}, {j}): {} is not {expected}", found[i][j]);
            }
        }
    }
}
