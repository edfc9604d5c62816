//! The filter's process and its Jacobians against (1) to (7) in dual numbers.

use crate::dual::Dual;
use crate::states::{DRAWS, assert_close, draw, variables};
use crate::uniform::Uniform;
use sideslip::estimation::process::{ACCELEROMETER_BIAS, INPUTS, NAVIGATION, STATES, jacobians, rate, unbiased};

const G0: f64 = 9.80665;

/// Rigid-body kinematics as published, inputs as measured, biases from the state.
fn published(x: &[Dual; STATES], measured: &[Dual; INPUTS]) -> [Dual; NAVIGATION] {
    let g = Dual::constant(G0);
    let [u, v, w, phi, theta, ..] = *x;
    let [ax, ay, az, p, q, r]: [Dual; INPUTS] = std::array::from_fn(|i| measured[i] - x[ACCELEROMETER_BIAS + i]);
    [
        -w * q + v * r + ax - g * theta.sin(),
        -u * r + w * p + ay + g * theta.cos() * phi.sin(),
        -v * p + u * q + az + g * theta.cos() * phi.cos(),
        p + q * phi.sin() * theta.tan() + r * phi.cos() * theta.tan(),
        q * phi.cos() - r * phi.sin(),
        (q * phi.sin() + r * phi.cos()) / theta.cos(),
        u * theta.sin() - v * phi.sin() * theta.cos() - w * phi.cos() * theta.cos(),
    ]
}

#[test]
fn process_and_jacobians_are_the_published_ones() {
    let mut uniform = Uniform(41);
    for _ in 0..DRAWS {
        let (state, measured) = draw(&mut uniform);
        let (x, inputs) = variables(&state, &measured);
        let expected = published(&x, &inputs);
        let input = unbiased(&state, &measured);
        let found = rate(&state, &input).unwrap();
        let (a, g) = jacobians(&state, &input).unwrap();
        for i in 0..NAVIGATION {
            assert_close(found[i], expected[i].value, &|| format!("rate {i} at {state:?} {measured:?}"));
            for j in 0..STATES {
                // What the filter puts into its transition: A, then less G for the biases, one for one.
                let entry = if j < NAVIGATION { a[i][j] } else { -g[i][j - ACCELEROMETER_BIAS] };
                assert_close(entry, expected[i].partials[j], &|| format!("d rate {i}/d state {j} at {state:?}"));
            }
            for (j, entry) in g[i].into_iter().enumerate() {
                assert_close(entry, expected[i].partials[STATES + j], &|| format!("d rate {i}/d input {j} at {state:?}"));
            }
        }
    }
}

#[test]
fn near_the_pole_of_the_euler_angles_both_are_refused() {
    let mut uniform = Uniform(42);
    let (mut refused, mut given) = (0, 0);
    for _ in 0..DRAWS {
        let (mut state, input) = draw(&mut uniform);
        state[4] = uniform.within(std::f64::consts::PI);
        let (slope, jacobians) = (rate(&state, &input), jacobians(&state, &input));
        assert_eq!(slope.is_some(), jacobians.is_some());
        assert_eq!(slope.is_some(), state[4].cos() > 0.05, "at {}", state[4]);
        if let (Some(slope), Some((a, g))) = (slope, jacobians) {
            given += 1;
            assert!(slope.iter().chain(a.as_flattened()).chain(g.as_flattened()).all(|entry| entry.is_finite()));
        } else {
            refused += 1;
        }
    }
    assert!(refused > DRAWS / 3 && given > DRAWS / 3);
    let (mut state, input) = draw(&mut uniform);
    state[4] = f64::NAN;
    assert!(rate(&state, &input).is_none() && jacobians(&state, &input).is_none());
}
