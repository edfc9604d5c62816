//! The profile flies its own manoeuvre and tells the Dutch roll that was put into it.

use crate::Profile;
use crate::manoeuvre::{LATERAL, Manoeuvre};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::pipeline::Config;
use sideslip::regression::record::Status;
extern crate std;

#[test]
fn nothing_comes_out_before_the_start_and_the_flights_own_dutch_roll_at_the_end() {
    let mut profile = std::boxed::Box::new(Profile::new());
    for sample in Manoeuvre::default().take(3) {
        assert!(profile.step(&sample).is_none());
    }
    assert!(profile.finish().is_none());
    profile.start(&Config::default(), RunGeometry::default()).unwrap();
    for sample in Manoeuvre::default() {
        assert!(profile.step(&sample).is_some());
    }
    let tick = profile.finish().unwrap();
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
    let modes = tick.modes.unwrap();
    assert_eq!(modes.status, Status::Converged);
    std::println!("{:?}", modes.dutch_roll);
}

#[test]
fn a_configuration_that_cannot_be_used_leaves_the_place_as_it_was() {
    let mut profile = std::boxed::Box::new(Profile::new());
    let mut config = Config::default();
    config.estimation.gap_s = f64::NAN;
    assert!(profile.start(&config, RunGeometry::default()).is_err());
    assert!(profile.step(&sideslip::telemetry::record::Sample::new(0.0)).is_none());
}
