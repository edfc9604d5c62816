//! Forces and moments of a linear model with the effects that change it, and its matrices.
//!
//! Consumes deviations from trim (velocity through the air, rates, blade positions, rotor speed); produces
//!     ax = g sin(theta0) + X_u (u - u0) + ...                                            (1)
//!     ay = -g cos(theta0) sin(phi0) + Y_v (v - v0) + ...                                 (2)
//!     az = -g cos(theta0) cos(phi0) + Z_w (w - w0) + ...                                 (3)
//!     dp/dt = L_v (v - v0) + ..., and likewise dq/dt, dr/dt                              (4)
//! and, linearised about trim with the motion's kinematics, `dx/dt = A x + B c` with x = u w q theta v p phi r and
//! c = collective, lon_cyclic, lat_cyclic, pedal [8 x 8, 8 x 4], where the kinematics add to the derivatives
//!     u row: -w0 q + v0 r - g cos(theta0) theta
//!     v row: +w0 p - u0 r - g sin(theta0) sin(phi0) theta + g cos(theta0) cos(phi0) phi
//!     w row: -v0 p + u0 q - g sin(theta0) cos(phi0) theta - g cos(theta0) sin(phi0) phi  (5)
//!     theta row: cos(phi0) q - sin(phi0) r;  phi row: p + tan(theta0) (sin(phi0) q + cos(phi0) r)
//! Nonlinear terms are products of deviations, so they add nothing to A. A flight-path effect acts with the flight-path
//! angle of the trim, absolute (zero in level flight), and stays as it is during the flight.

use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::effect::Effect;
use crate::flight::model::{LinearModel, TooManyTerms, Trim};
use crate::flight::unit::STANDARD_GRAVITY;
use nalgebra::SMatrix;

/// States of the linearised motion, in the order of rows and columns.
pub const STATES: [&str; 8] = ["u", "w", "q", "theta", "v", "p", "phi", "r"];

/// Controls of the linearised motion, in the order of columns.
pub const INPUTS: [Control; CONTROLS] = [Control::Collective, Control::LonCyclic, Control::LatCyclic, Control::Pedal];

/// The model with those effects in it that change its derivatives and terms: `derivative`, `nonlinear`,
/// `control_effectiveness`, `rotor_speed`, `flight_path`, in the order given. The others do not belong to it. A rotor's reaction
/// is in what the model then says of N.
///
/// # Errors
/// [`TooManyTerms`] where a nonlinear term finds no room.
pub fn with_effects(model: &LinearModel, effects: &[Effect]) -> Result<LinearModel, TooManyTerms> {
    let reactions = effects.iter().filter_map(|effect| match *effect {
        Effect::RotorReaction { reaction } => Some(reaction),
        _ => None,
    });
    model.reacting(reactions.sum(), |changed| effects.iter().try_for_each(|effect| change(changed, effect)))
}

fn change(model: &mut LinearModel, effect: &Effect) -> Result<(), TooManyTerms> {
    match *effect {
        Effect::Derivative { axis, variable, delta } => *model.derivative_mut(axis, variable) += delta,
        Effect::Nonlinear { axis, term, coefficient } => model.add_term(axis, term, coefficient)?,
        Effect::ControlEffectiveness { control, factor } => {
            for axis in Axis::ALL {
                *model.derivative_mut(axis, control.variable()) *= factor;
            }
        }
        Effect::RotorSpeed { axis, coefficient } => model.rotor_speed[axis.index()] += coefficient,
        Effect::FlightPath { axis, variable, slope } => {
            *model.derivative_mut(axis, variable) += slope * model.trim.flight_path_angle();
        }
        _ => {}
    }
    Ok(())
}

/// What the rotor does: its speed's deviation from trim, rad/s, and its rate of change, rad/s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turning {
    /// Omega - Omega_0.
    pub deviation: f64,
    /// dOmega/dt.
    pub rate: f64,
}

/// Specific force that holds the trim, equations (1) to (3) without deviations, m/s^2.
pub fn trim_specific_force(trim: &Trim) -> [f64; 3] {
    let (sin_phi, cos_phi) = libm::sincos(trim.phi);
    let (sin_theta, cos_theta) = libm::sincos(trim.theta);
    let g = STANDARD_GRAVITY;
    [g * sin_theta, -g * cos_theta * sin_phi, -g * cos_theta * cos_phi]
}

/// Specific force (m/s^2) and angular acceleration (rad/s^2) by axis for these deviations from trim, equations (1) to (4).
pub fn forces(model: &LinearModel, deviations: &[f64; VARIABLES], rotor: Turning) -> [f64; AXES] {
    let [x, y, z] = trim_specific_force(&model.trim);
    let mut sums = [x, y, z, 0.0, 0.0, 0.0];
    for ((sum, row), by_rotor) in sums.iter_mut().zip(&model.derivatives).zip(model.rotor_speed) {
        *sum += row.iter().zip(deviations).map(|(derivative, deviation)| derivative * deviation).sum::<f64>();
        *sum += by_rotor * rotor.deviation;
    }
    sums[Axis::N.index()] += model.reaction * model.share_of_yaw() * rotor.rate;
    for term in &model.terms {
        sums[term.axis.index()] += term.coefficient * term.term.value(deviations);
    }
    sums
}

/// The matrix A of equation (5).
pub fn state_matrix(model: &LinearModel) -> SMatrix<f64, 8, 8> {
    let mut a = SMatrix::zeros();
    for (axis, row) in AXIS_ROWS {
        for (variable, column) in VARIABLE_STATES {
            a[(row, column)] = model.derivative(axis, variable);
        }
    }
    let Trim { u, v, w, phi, theta, .. } = model.trim;
    for (row, column, value) in kinematic_entries([u, v, w], phi, theta) {
        a[(row, column)] += value;
    }
    a
}

/// What the kinematics add to the derivatives in A, equation (5), about a trim at that velocity, m/s, bank and pitch attitude,
/// rad: row, column, value.
pub fn kinematic_entries([u, v, w]: [f64; 3], phi: f64, theta: f64) -> [(usize, usize, f64); 16] {
    let (sin_phi, cos_phi) = libm::sincos(phi);
    let (sin_theta, cos_theta) = libm::sincos(theta);
    let tan_theta = sin_theta / cos_theta;
    let g = STANDARD_GRAVITY;
    [
        (0, 2, -w),
        (0, 7, v),
        (0, 3, -g * cos_theta),
        (4, 5, w),
        (4, 7, -u),
        (4, 3, -g * sin_theta * sin_phi),
        (4, 6, g * cos_theta * cos_phi),
        (1, 5, -v),
        (1, 2, u),
        (1, 3, -g * sin_theta * cos_phi),
        (1, 6, -g * cos_theta * sin_phi),
        (3, 2, cos_phi),
        (3, 7, -sin_phi),
        (6, 5, 1.0),
        (6, 2, sin_phi * tan_theta),
        (6, 7, cos_phi * tan_theta),
    ]
}

/// The matrix B of equation (5); a cross feed gives its source's column a share of its target's.
pub fn input_matrix(model: &LinearModel, effects: &[Effect]) -> SMatrix<f64, 8, 4> {
    let mut mixing = SMatrix::<f64, CONTROLS, CONTROLS>::identity();
    for effect in effects {
        if let Effect::CrossFeed { from, to, gain } = *effect {
            mixing[(to.index(), from.index())] += gain;
        }
    }
    let mut b = SMatrix::zeros();
    for (axis, row) in AXIS_ROWS {
        for (column, input) in INPUTS.into_iter().enumerate() {
            let moved = Control::ALL
                .into_iter()
                .map(|moved| model.derivative(axis, moved.variable()) * mixing[(moved.index(), input.index())]);
            b[(row, column)] = moved.sum();
        }
    }
    b
}

/// Place in the states of u v w p q r, and with it the row of the axis that drives each: X Y Z L M N.
pub(crate) const MOTION_PLACES: [usize; AXES] = [0, 4, 1, 5, 2, 7];

/// Place in the states of each variable that is one.
pub(crate) const VARIABLE_STATES: [(Variable, usize); 6] =
    [(Variable::U, 0), (Variable::W, 1), (Variable::Q, 2), (Variable::V, 4), (Variable::P, 5), (Variable::R, 7)];

pub(crate) const AXIS_ROWS: [(Axis, usize); AXES] =
    [(Axis::X, 0), (Axis::Z, 1), (Axis::M, 2), (Axis::Y, 4), (Axis::L, 5), (Axis::N, 7)];

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are exact in binary")]
mod tests {
    use super::*;
    use crate::flight::term::Term;

    #[test]
    fn forces_are_those_computed_by_hand() {
        let mut model = LinearModel::about(Trim { u: 50.0, ..Trim::default() });
        *model.derivative_mut(Axis::N, Variable::V) = 0.5;
        *model.derivative_mut(Axis::X, Variable::Pedal) = 2.0;
        let effects = [
            Effect::Nonlinear { axis: Axis::N, term: Term::SignedSquare(Variable::V), coefficient: 0.25 },
            Effect::ControlEffectiveness { control: Control::Pedal, factor: 0.5 },
            Effect::RotorSpeed { axis: Axis::L, coefficient: 4.0 },
            Effect::Derivative { axis: Axis::M, variable: Variable::Q, delta: -1.0 },
        ];
        let changed = with_effects(&model, &effects).unwrap();
        let mut deviations = [0.0; VARIABLES];
        deviations[Variable::V.index()] = -2.0;
        deviations[Variable::Q.index()] = 3.0;
        deviations[Variable::Pedal.index()] = 8.0;
        assert_eq!(
            forces(&changed, &deviations, Turning { deviation: 0.5, rate: 9.0 }),
            [8.0, 0.0, -STANDARD_GRAVITY, 2.0, -3.0, -1.0 - 1.0]
        );
    }

    #[test]
    fn a_flight_path_effect_acts_with_the_trim_angle() {
        let climbing = Trim { u: 50.0, theta: 0.1, ..Trim::default() };
        let effect = Effect::FlightPath { axis: Axis::N, variable: Variable::P, slope: 2.0 };
        let changed = with_effects(&LinearModel::about(climbing), &[effect]).unwrap();
        assert!((changed.derivative(Axis::N, Variable::P) - 0.2).abs() < 1e-14);
    }

    #[test]
    fn a_cross_feed_adds_to_the_column_of_its_source() {
        let mut model = LinearModel::default();
        *model.derivative_mut(Axis::N, Variable::Pedal) = -8.0;
        *model.derivative_mut(Axis::N, Variable::Collective) = 1.0;
        let feed = Effect::CrossFeed { from: Control::Collective, to: Control::Pedal, gain: 0.25 };
        assert_eq!(input_matrix(&model, &[feed]).row(7).iter().copied().collect::<Vec<f64>>(), [-1.0, 0.0, 0.0, -8.0]);
    }
}
