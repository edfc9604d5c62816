//! A linear model of an aircraft about one trim: derivatives, nonlinear terms, rotor-speed derivatives.
//!
//! Data that simulation, regression and diagnosis share. Its perturbation forces are
//!     a_axis = a_axis(trim) + sum over variables (derivative * deviation) + sum over terms (coefficient * term)
//!              + rotor_speed derivative * (rotor speed - trim rotor speed)                                        (1)
//! Forces are divided by mass (m/s^2), moments carry the products of inertia (rad/s^2); see `derivative`.

use super::control::{CONTROLS, Control};
use super::derivative::{AXES, Axis, VARIABLES, Variable};
use super::term::Term;

/// The steady flight that a model is about; body rates are zero in it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Trim {
    /// Velocity along body x through the air, m/s.
    pub u: f64,
    /// Velocity along body y through the air, m/s.
    pub v: f64,
    /// Velocity along body z through the air, m/s.
    pub w: f64,
    /// Bank angle, rad.
    pub phi: f64,
    /// Pitch attitude, rad.
    pub theta: f64,
    /// Main-rotor speed, rad/s, where the model says so.
    pub rotor_speed: Option<f64>,
    /// Controls by [`Control`] place, rad.
    pub controls: [f64; CONTROLS],
}

impl Trim {
    /// True airspeed, m/s.
    pub fn airspeed(&self) -> f64 {
        libm::sqrt(self.u * self.u + self.v * self.v + self.w * self.w)
    }

    /// Incidence, rad.
    pub fn incidence(&self) -> f64 {
        libm::atan2(self.w, self.u)
    }

    /// Sideslip, rad; below 1 m/s as if at 1 m/s.
    pub fn sideslip(&self) -> f64 {
        libm::asin((self.v / self.airspeed().max(1.0)).clamp(-1.0, 1.0))
    }

    /// Flight-path angle, rad, climb positive: `sin gamma = climb rate / airspeed`; zero without airspeed.
    pub fn flight_path_angle(&self) -> f64 {
        let airspeed = self.airspeed();
        if airspeed == 0.0 {
            return 0.0;
        }
        let (sin_phi, cos_phi) = libm::sincos(self.phi);
        let (sin_theta, cos_theta) = libm::sincos(self.theta);
        let climb = self.u * sin_theta - self.v * sin_phi * cos_theta - self.w * cos_phi * cos_theta;
        libm::asin((climb / airspeed).clamp(-1.0, 1.0))
    }

    /// The trim value of a linear variable: velocities and controls as given, rates zero.
    pub const fn of(&self, variable: Variable) -> f64 {
        match variable {
            Variable::U => self.u,
            Variable::V => self.v,
            Variable::W => self.w,
            Variable::P | Variable::Q | Variable::R => 0.0,
            Variable::LonCyclic => self.controls[Control::LonCyclic.index()],
            Variable::LatCyclic => self.controls[Control::LatCyclic.index()],
            Variable::Collective => self.controls[Control::Collective.index()],
            Variable::Pedal => self.controls[Control::Pedal.index()],
        }
    }
}

/// One nonlinear term of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelTerm {
    /// The axis that it adds to.
    pub axis: Axis,
    /// The term.
    pub term: Term,
    /// Its coefficient, the axis's unit per unit of the term.
    pub coefficient: f64,
}

/// How many nonlinear terms a model may have.
pub const MODEL_TERMS: usize = 48;

/// A linear model about a trim, with nonlinear terms where it declares them.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct LinearModel {
    /// The trim that deviations are taken from.
    pub trim: Trim,
    /// Derivatives by axis and variable place; one not given is zero.
    pub derivatives: [[f64; VARIABLES]; AXES],
    /// Nonlinear terms, in the order they were declared.
    pub terms: heapless::Vec<ModelTerm, MODEL_TERMS>,
    /// Derivatives with respect to rotor speed, by axis, per rad/s.
    pub rotor_speed: [f64; AXES],
    /// c of [`super::effect::Effect::RotorReaction`]; everything that the model says of N is with its share in it.
    pub reaction: f64,
}

/// The model already has [`MODEL_TERMS`] nonlinear terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyTerms;

impl LinearModel {
    /// A model about that trim with every derivative zero.
    pub fn about(trim: Trim) -> Self {
        LinearModel { trim, ..LinearModel::default() }
    }

    /// Whether it says anything of what acts on that axis: a derivative, the rotor's speed or a nonlinear term.
    pub fn speaks_of(&self, axis: Axis) -> bool {
        let linear = self.derivatives.get(axis.index()).into_iter().flatten().chain(self.rotor_speed.get(axis.index()));
        let mut linear = linear.map(|derivative| libm::fabs(*derivative));
        linear.any(|size| size > 0.0) || self.terms.iter().any(|term| term.axis == axis)
    }

    /// What of a yawing moment turns the fuselage, the rest turns the rotor with it: 1/(1 + |c|).
    pub fn share_of_yaw(&self) -> f64 {
        1.0 / (1.0 + libm::fabs(self.reaction))
    }

    /// Multiplies everything that acts on N.
    fn times_yaw(&mut self, factor: f64) {
        let place = Axis::N.index();
        let row = self.derivatives.get_mut(place).into_iter().flatten();
        row.chain(self.rotor_speed.get_mut(place)).for_each(|derivative| *derivative *= factor);
        let terms = self.terms.iter_mut().filter(|term| term.axis == Axis::N);
        terms.for_each(|term| term.coefficient *= factor);
    }

    /// The model with what `change` does to it as if its rotor did not react, which then does by so much more.
    ///
    /// # Errors
    /// Those of `change`.
    pub fn reacting(&self, more: f64, change: impl FnOnce(&mut Self) -> Result<(), TooManyTerms>) -> Result<Self, TooManyTerms> {
        let mut changed = self.clone();
        changed.times_yaw(1.0 / self.share_of_yaw());
        change(&mut changed)?;
        changed.reaction += more;
        changed.times_yaw(changed.share_of_yaw());
        Ok(changed)
    }

    /// A derivative.
    pub const fn derivative(&self, axis: Axis, variable: Variable) -> f64 {
        self.derivatives[axis.index()][variable.index()]
    }

    /// A derivative, to be changed.
    pub const fn derivative_mut(&mut self, axis: Axis, variable: Variable) -> &mut f64 {
        &mut self.derivatives[axis.index()][variable.index()]
    }

    /// Adds `coefficient * term` to the axis; a term that is there already is added to, a linear one to its derivative.
    ///
    /// # Errors
    /// [`TooManyTerms`] where there is no room for another nonlinear term.
    pub fn add_term(&mut self, axis: Axis, term: Term, coefficient: f64) -> Result<(), TooManyTerms> {
        if let Term::Linear(variable) = term {
            *self.derivative_mut(axis, variable) += coefficient;
            return Ok(());
        }
        if let Some(there) = self.terms.iter_mut().find(|there| there.axis == axis && there.term == term) {
            there.coefficient += coefficient;
            return Ok(());
        }
        self.terms.push(ModelTerm { axis, term, coefficient }).map_err(|_| TooManyTerms)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are carried, not computed")]
mod tests {
    use super::*;

    #[test]
    fn flight_path_angle_is_pitch_less_incidence_wings_level() {
        let trim = Trim { u: 50.0, w: 2.0, theta: 0.1, ..Trim::default() };
        assert!((trim.flight_path_angle() - (0.1 - (2.0f64 / 50.0).atan())).abs() < 1e-15);
        assert_eq!(Trim::default().flight_path_angle(), 0.0);
        assert_eq!(trim.of(Variable::W), 2.0);
    }

    #[test]
    fn a_term_added_twice_is_one_term() {
        let mut model = LinearModel::about(Trim { u: 50.0, ..Trim::default() });
        let term = Term::SignedSquare(Variable::V);
        model.add_term(Axis::N, term, 0.5).unwrap();
        model.add_term(Axis::N, term, 0.25).unwrap();
        model.add_term(Axis::N, Term::Linear(Variable::V), 0.1).unwrap();
        assert_eq!(model.terms.as_slice(), [ModelTerm { axis: Axis::N, term, coefficient: 0.75 }]);
        assert_eq!(model.derivative(Axis::N, Variable::V), 0.1);
    }

    #[test]
    fn the_last_free_place_is_used_and_no_more() {
        let mut model = LinearModel::default();
        let added = Axis::ALL.into_iter().flat_map(|axis| Term::library().map(move |term| (axis, term)));
        let refused = added.map(|(axis, term)| model.add_term(axis, term, 1.0)).filter(Result::is_err).count();
        assert_eq!((model.terms.len(), refused), (MODEL_TERMS, 6 * 27 - MODEL_TERMS));
    }
}
