//! The profile flies its own manoeuvre and tells the Dutch roll that was put into it.

use crate::manoeuvre::{LATERAL, ManoeuvreSamples, TRIM};
use crate::{Profile, SETTINGS};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::regression::record::{LATERAL as ENTRIES, LateralDerivatives, Status};

extern crate std;

#[test]
fn the_flights_own_dutch_roll_comes_out() {
    let mut profile = std::boxed::Box::new(Profile::new(&SETTINGS, RunGeometry::DEFAULT));
    for sample in ManoeuvreSamples::default() {
        profile.step(&sample);
    }
    let tick = profile.finish();
    let derivatives = tick.derivatives.as_ref().unwrap();
    let terms = [
        (Axis::Y, Variable::V),
        (Axis::L, Variable::V),
        (Axis::L, Variable::P),
        (Axis::L, Variable::R),
        (Axis::N, Variable::V),
        (Axis::N, Variable::P),
        (Axis::N, Variable::R),
    ];
    for ((axis, variable), truth) in terms.into_iter().zip(LATERAL) {
        let term = derivatives.equations[axis.index()].term(variable).unwrap();
        std::println!("{axis:?}_{variable:?} {:.5} +- {:.5}, truth {truth}", term.value, term.std);
        assert!((term.value - truth).abs() < 4.0 * term.std, "{axis:?} {variable:?}: {term:?}, truth {truth}");
    }
    let [y_v, l_v, l_p, l_r, n_v, n_p, n_r] = LATERAL;
    let [u0, w0, theta0] = TRIM;
    let values = [y_v, 0.0, 0.0, l_v, l_p, l_r, n_v, n_p, n_r];
    let truth = LateralDerivatives { values, cov: [[0.0; ENTRIES]; ENTRIES], u0, w0, trim_std: [0.0; 2], phi0: 0.0, theta0 };
    let truth = lateral::modes(0.0, Status::Converged, &truth).unwrap().dutch_roll.unwrap();
    let modes = tick.modes.unwrap();
    assert_eq!(modes.status, Status::Converged);
    let found = modes.dutch_roll.unwrap();
    std::println!("{found:?}, truth {truth:?}");
    assert!((found.omega - truth.omega).abs() < 4.0 * found.std_omega && found.std_omega < 0.008);
    assert!((found.zeta - truth.zeta).abs() < 4.0 * found.std_zeta && found.std_zeta < 0.005);
}
