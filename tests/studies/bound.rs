//! The Cramer-Rao bound of the manoeuvre: what no method could do better than with those instruments.
//!
//! Of the lateral derivatives Y, L, N with respect to v, p, r and the lateral controls that move, all unknown, with an unknown
//! bias in every channel; known are the longitudinal derivatives, the controls and the steady start. omega and zeta follow by
//! the delta method, as for the estimates.

use sideslip::flight::control::{CONTROLS, Control};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::model::LinearModel;
use sideslip::flight::signal::piecewise_linear::History;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::regression::record::{LATERAL, LateralDerivatives, Status};
use sideslip::simulation::input_design::information::{DesignManoeuvre, DesignParameter, InputInformation, outputs};
use sideslip::simulation::instrument::InstrumentSet;

/// Derivatives whose bound is wanted.
pub(crate) const DERIVATIVES: [(Axis, Variable); 3] = [(Axis::N, Variable::R), (Axis::N, Variable::V), (Axis::L, Variable::P)];

/// Bounds of the standard errors of [`DERIVATIVES`], then of omega and zeta; NaN where the manoeuvre does not tell them.
pub(crate) fn bounds(
    model: &LinearModel,
    controls: &[History; CONTROLS],
    instruments: &InstrumentSet,
    duration_s: f64,
    rate_hz: f64,
) -> [f64; 5] {
    // A control that moves in the last half second only tells nothing yet.
    let moved = |control: Control| controls[control.index()].times().any(|time_s| time_s > 0.0 && time_s < duration_s - 0.5);
    let lateral_controls = [Control::LatCyclic, Control::Pedal].into_iter().filter(|&control| moved(control));
    let variables: Vec<Variable> =
        [Variable::V, Variable::P, Variable::R].into_iter().chain(lateral_controls.map(Control::variable)).collect();
    let parameters: Vec<DesignParameter> = [Axis::Y, Axis::L, Axis::N]
        .into_iter()
        .flat_map(|axis| variables.iter().map(move |&variable| DesignParameter { axis, variable }))
        .collect();
    let manoeuvre = DesignManoeuvre { controls: controls.clone(), duration_s, rate_hz };
    let information = InputInformation::of(model, &parameters, &outputs(model, instruments), &manoeuvre);
    let Ok(dispersion) = information.dispersion() else { return [f64::NAN; 5] };
    let place = |(axis, variable): (Axis, Variable)| {
        parameters.iter().position(|parameter| parameter.axis == axis && parameter.variable == variable).unwrap()
    };
    let mut known = LateralDerivatives::of(model);
    let places = LateralDerivatives::NAMES.map(place);
    known.cov = std::array::from_fn::<_, LATERAL, _>(|i| std::array::from_fn(|j| dispersion[places[i]][places[j]]));
    let dutch_roll = lateral::modes(0.0, Status::Converged, &known).and_then(|modes| modes.dutch_roll);
    let [n_r, n_v, l_p] = DERIVATIVES.map(|name| dispersion[place(name)][place(name)].sqrt());
    let [omega, zeta] = dutch_roll.map_or([f64::NAN; 2], |found| [found.std_omega, found.std_zeta]);
    [n_r, n_v, l_p, omega, zeta]
}
