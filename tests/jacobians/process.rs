//! The filter's process and its Jacobian against (1) to (8) in dual numbers.

use super::dual::Dual;
use super::states::{DRAWS, assert_close, draw, variables};
use crate::support::uniform::Uniform;
use sideslip::realtime::estimation::process::{NAVIGATION, STATES, jacobian, rate};

const G0: f64 = 9.80665;

/// Rigid-body kinematics as published; along an axis without accelerometer the specific force balances gravity.
fn published(x: &[Dual; STATES], measured: &[bool; 3]) -> [Dual; NAVIGATION + 3] {
    let g = Dual::constant(G0);
    let [u, v, w, phi, theta, _, _, p, q, r, dp, dq, dr, ax, ay, az, ..] = *x;
    let gravity = [-g * theta.sin(), g * theta.cos() * phi.sin(), g * theta.cos() * phi.cos()];
    let force: [Dual; 3] = std::array::from_fn(|i| if measured[i] { [ax, ay, az][i] } else { -gravity[i] });
    [
        -w * q + v * r + force[0] + gravity[0],
        -u * r + w * p + force[1] + gravity[1],
        -v * p + u * q + force[2] + gravity[2],
        p + q * phi.sin() * theta.tan() + r * phi.cos() * theta.tan(),
        q * phi.cos() - r * phi.sin(),
        (q * phi.sin() + r * phi.cos()) / theta.cos(),
        u * theta.sin() - v * phi.sin() * theta.cos() - w * phi.cos() * theta.cos(),
        dp,
        dq,
        dr,
    ]
}

#[test]
fn process_and_jacobian_are_the_published_ones() {
    let mut uniform = Uniform(41);
    for draw_number in 0..DRAWS {
        let state = draw(&mut uniform);
        // Every combination of accelerometers.
        let measured = [draw_number % 2 == 0, draw_number % 4 < 2, draw_number % 8 < 4];
        let expected = published(&variables(&state), &measured);
        let found = rate(&state, &measured).unwrap();
        let a = jacobian(&state, &measured).unwrap();
        for (i, (found, expected)) in found.into_iter().zip(&expected).enumerate() {
            assert_close(found, expected.value, &|| format!("rate {i} at {state:?} {measured:?}"));
        }
        for i in 0..NAVIGATION {
            for j in 0..STATES {
                let entry = a[i].get(j).copied().unwrap_or(0.0);
                assert_close(entry, expected[i].partials[j], &|| format!("d rate {i}/d state {j} at {state:?} {measured:?}"));
            }
        }
    }
}

#[test]
fn near_the_pole_of_the_euler_angles_both_are_refused() {
    let mut uniform = Uniform(42);
    let (mut refused, mut given) = (0, 0);
    let all = [true; 3];
    for _ in 0..DRAWS {
        let mut state = draw(&mut uniform);
        state[4] = uniform.within(std::f64::consts::PI);
        let (slope, jacobian) = (rate(&state, &all), jacobian(&state, &all));
        assert_eq!(slope.is_some(), jacobian.is_some());
        assert_eq!(slope.is_some(), state[4].cos() > 0.05, "at {}", state[4]);
        if let (Some(slope), Some(a)) = (slope, jacobian) {
            given += 1;
            assert!(slope.iter().chain(a.as_flattened()).all(|entry| entry.is_finite()));
        } else {
            refused += 1;
        }
    }
    assert!(refused > DRAWS / 3 && given > DRAWS / 3);
    let mut state = draw(&mut uniform);
    state[4] = f64::NAN;
    assert!(rate(&state, &all).is_none() && jacobian(&state, &all).is_none());
}
