//! What the model says the air does to the aircraft: forces and moments, and how they change with motion and controls.
//!
//! Consumes deviations from the model's trim by [`Variable`] place, the rotor speed's deviation and its rate of change; produces
//! specific force (m/s^2) and angular acceleration (rad/s^2) by axis and their partial derivatives. A Level-1 aircraft answers
//! for itself, and what effects add stands beside it as a linear model; its inner states (flapping, inflow, actuators) are taken
//! as settled, and where its engine turns the rotor, that reacts.

use crate::dynamics::linear::{Turning, forces, trim_specific_force, with_effects};
use crate::flight::control::CONTROLS;
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::effect::Effect;
use crate::flight::model::{LinearModel, Trim};
use crate::flight::term::{MOTION, Term};
use crate::simulation::flight_model::FlightModel;
use crate::simulation::level1::aircraft::Situation;
use crate::simulation::level1::trim::Trimmed;

/// Half widths of the differences that a Level-1 aircraft is linearised with along the flight.
const VELOCITY_STEP: f64 = 0.2;
const RATE_STEP: f64 = 0.01;
const CONTROL_STEP: f64 = 0.002;

/// Partial derivatives by axis and variable.
pub type Partials = [[f64; VARIABLES]; AXES];

/// The model without the hypotheses.
#[derive(Clone, Debug)]
pub struct Aircraft {
    /// Linear, or linearised about its trim.
    pub linear: LinearModel,
    level1: Option<Box<Trimmed>>,
}

/// The model with what hypotheses add.
#[derive(Clone, Debug)]
pub struct ModifiedAircraft<'a> {
    /// Everything of a linear model; of a Level-1 aircraft what is added.
    model: LinearModel,
    level1: Option<&'a Trimmed>,
    effectiveness: [f64; CONTROLS],
    at_trim: [f64; 3],
}

impl Aircraft {
    /// Of a model file, its own effects in it.
    pub fn of(model: &FlightModel) -> Self {
        Aircraft { linear: model.linear().clone(), level1: model.level1.clone() }
    }

    /// Whether nothing is said of an axis.
    pub fn is_unmodelled(&self, axis: Axis) -> bool {
        self.level1.is_none() && !self.linear.speaks_of(axis)
    }

    /// Whether its engine turns the rotor, which then reacts.
    pub fn is_governed(&self) -> bool {
        self.level1.as_ref().is_some_and(|level1| level1.aircraft.options.governed)
    }

    /// Whether it is more than linear.
    pub fn is_curved(&self) -> bool {
        self.level1.is_some()
    }

    /// The trim.
    pub fn trim(&self) -> &Trim {
        &self.linear.trim
    }

    /// With effects and small errors of the derivatives.
    pub fn changed(&self, effects: &[Effect], small: &Partials) -> ModifiedAircraft<'_> {
        let own = match &self.level1 {
            Some(level1) => LinearModel { reaction: level1.aircraft.reaction(), ..LinearModel::about(*self.trim()) },
            None => self.linear.clone(),
        };
        let mut effectiveness = [1.0; CONTROLS];
        for effect in effects {
            if let Effect::ControlEffectiveness { control, factor } = *effect {
                effectiveness[control.index()] *= factor;
            }
        }
        let mut model = own;
        for (row, by) in model.derivatives.iter_mut().zip(small) {
            row.iter_mut().zip(by).for_each(|(derivative, by)| *derivative += by);
        }
        // A hypothesis more than there is room for is left out; there are never so many.
        let model = with_effects(&model, effects).unwrap_or(model);
        ModifiedAircraft { at_trim: trim_specific_force(&model.trim), model, level1: self.level1.as_deref(), effectiveness }
    }
}

impl ModifiedAircraft<'_> {
    /// Whether neither the model nor a hypothesis says anything of an axis.
    pub fn is_unmodelled(&self, axis: Axis) -> bool {
        self.level1.is_none() && !self.model.speaks_of(axis)
    }

    fn situation(&self, level1: &Trimmed, deviations: &[f64; VARIABLES], rotor: f64) -> Situation {
        let trim = &level1.trim;
        let at = |variable: Variable| trim.of(variable) + deviations[variable.index()];
        let control = |place: usize| {
            let variable = Variable::CONTROLS[place];
            trim.of(variable) + self.effectiveness[place] * deviations[variable.index()]
        };
        Situation {
            velocity: [at(Variable::U), at(Variable::V), at(Variable::W)],
            rates: [at(Variable::P), at(Variable::Q), at(Variable::R)],
            blade: core::array::from_fn(control),
            rotor_speed: trim.rotor_speed.unwrap_or(level1.aircraft.main_rotor.speed) + rotor,
            density: level1.condition.density,
        }
    }

    /// The share of a control that acts, by its place; never nothing.
    pub fn share(&self, control: usize) -> f64 {
        self.effectiveness.get(control).copied().filter(|share| libm::fabs(*share) > 1e-6).unwrap_or(1.0)
    }

    /// Specific force and angular acceleration by axis.
    pub fn forces(&self, deviations: &[f64; VARIABLES], rotor: Turning) -> [f64; AXES] {
        let mut sum = forces(&self.model, deviations, rotor);
        if let Some(level1) = self.level1 {
            let own = self.own(level1, &self.situation(level1, deviations, rotor.deviation));
            for (place, (sum, own)) in sum.iter_mut().zip(own).enumerate() {
                *sum += own - self.at_trim.get(place).copied().unwrap_or(0.0);
            }
        }
        sum
    }

    /// What a Level-1 aircraft says, its rotor's reaction in it.
    fn own(&self, level1: &Trimmed, met: &Situation) -> [f64; AXES] {
        let mut own = level1.aircraft.respond(met).accelerations;
        own[Axis::N.index()] *= self.model.share_of_yaw();
        own
    }

    /// c of [`Effect::RotorReaction`].
    pub fn reaction(&self) -> f64 {
        self.model.reaction
    }

    /// What of another yawing moment turns the fuselage.
    pub fn share_of_yaw(&self) -> f64 {
        self.model.share_of_yaw()
    }

    /// Their partial derivatives there.
    pub fn partials(&self, deviations: &[f64; VARIABLES], rotor: f64) -> Partials {
        let mut by = self.model.derivatives;
        for term in &self.model.terms {
            for variable in MOTION {
                by[term.axis.index()][variable.index()] += term.coefficient * slope(term.term, variable, deviations);
            }
        }
        if let Some(level1) = self.level1 {
            for variable in Variable::ALL {
                let step = match variable {
                    Variable::U | Variable::V | Variable::W => VELOCITY_STEP,
                    Variable::P | Variable::Q | Variable::R => RATE_STEP,
                    _ => CONTROL_STEP,
                };
                let at = |by: f64| {
                    let mut moved = *deviations;
                    moved[variable.index()] += by;
                    self.own(level1, &self.situation(level1, &moved, rotor))
                };
                let (up, down) = (at(step), at(-step));
                for (row, (up, down)) in by.iter_mut().zip(up.into_iter().zip(down)) {
                    row[variable.index()] += (up - down) / (2.0 * step);
                }
            }
        }
        by
    }

    /// Derivatives by the rotor's speed, by axis, of a linear model and of what is added to a Level-1 one.
    pub fn by_rotor(&self, deviations: &[f64; VARIABLES], rotor: f64) -> [f64; AXES] {
        let mut by = self.model.rotor_speed;
        if let Some(level1) = self.level1 {
            let at = |by: f64| self.own(level1, &self.situation(level1, deviations, rotor + by));
            for (sum, (up, down)) in by.iter_mut().zip(at(0.1).into_iter().zip(at(-0.1))) {
                *sum += (up - down) / 0.2;
            }
        }
        by
    }
}

/// Derivative of a term by a variable.
fn slope(term: Term, variable: Variable, deviations: &[f64; VARIABLES]) -> f64 {
    let at = |x: Variable| deviations[x.index()];
    match term {
        Term::Linear(x) => f64::from(u8::from(x == variable)),
        Term::SignedSquare(x) if x == variable => 2.0 * libm::fabs(at(x)),
        Term::Cube(x) if x == variable => 3.0 * at(x) * at(x),
        Term::Product(x, y) => (if x == variable { at(y) } else { 0.0 }) + (if y == variable { at(x) } else { 0.0 }),
        _ => 0.0,
    }
}
