//! The states of a Level-1 aircraft besides those of the rigid body: flap, inflow, rotor speed, engine, actuators.
//!
//! The options ([`Options`]) select which of them are states; the others keep their values, and their rates are zero.

use super::flapping::Flap;
use crate::flight::control::CONTROLS;

/// How the disc flaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flapping {
    /// At once.
    QuasiSteady,
    /// Three states.
    FirstOrder,
    /// Six states.
    SecondOrder,
}

/// The options of a Level-1 model, each at its plainest by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Flap states.
    pub flapping: Flapping,
    /// Whether the uniform inflow is a state.
    pub dynamic_inflow: bool,
    /// Whether rotor speed and engine are states; else the speed is held.
    pub governed: bool,
    /// Whether the actuators are states; else the blade follows at once.
    pub actuators: bool,
    /// Whether linearisation takes the file's finite perturbations.
    pub finite_perturbation: bool,
}

/// How many inner states there can be.
pub const INNER: usize = 14;

/// Inner states, or their rates a second.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct InternalStates {
    /// Flap in the rotor's own (anticlockwise) hub axes, rad.
    pub flap: Flap,
    /// Its rates, rad/s.
    pub flap_rate: Flap,
    /// lambda0.
    pub inflow: f64,
    /// Speed of the main rotor, rad/s.
    pub rotor_speed: f64,
    /// Engine torque at the main rotor, N m.
    pub torque: f64,
    /// Its rate, N m/s.
    pub torque_rate: f64,
    /// Blade pitch by control place, rad.
    pub blade: [f64; CONTROLS],
}

impl InternalStates {
    /// As one vector.
    pub fn to_vector(self) -> [f64; INNER] {
        let (f, g, [b0, b1, b2, b3]) = (self.flap, self.flap_rate, self.blade);
        let rotor = [self.inflow, self.rotor_speed, self.torque, self.torque_rate];
        let [inflow, speed, torque, torque_rate] = rotor;
        [f.coning, f.cosine, f.sine, g.coning, g.cosine, g.sine, inflow, speed, torque, torque_rate, b0, b1, b2, b3]
    }

    /// From one vector.
    pub fn from_vector([a, b, c, d, e, f, inflow, rotor_speed, torque, torque_rate, b0, b1, b2, b3]: [f64; INNER]) -> Self {
        InternalStates {
            flap: Flap { coning: a, cosine: b, sine: c },
            flap_rate: Flap { coning: d, cosine: e, sine: f },
            inflow,
            rotor_speed,
            torque,
            torque_rate,
            blade: [b0, b1, b2, b3],
        }
    }
}

impl Options {
    /// The plain model: nothing but the motion is a state.
    pub const PLAIN: Options = Options {
        flapping: Flapping::QuasiSteady,
        dynamic_inflow: false,
        governed: false,
        actuators: false,
        finite_perturbation: false,
    };

    /// Which places of an [`InternalStates`] vector are states.
    pub fn active(&self) -> [bool; INNER] {
        let (flap, rates) = (self.flapping != Flapping::QuasiSteady, self.flapping == Flapping::SecondOrder);
        let (inflow, engine, blade) = (self.dynamic_inflow, self.governed, self.actuators);
        [flap, flap, flap, rates, rates, rates, inflow, engine, engine, engine, blade, blade, blade, blade]
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are carried, not computed")]
mod tests {
    use super::*;

    #[test]
    fn a_vector_and_back_is_the_same_and_places_agree_with_options() {
        let vector: [f64; INNER] = std::array::from_fn(|place| place as f64 + 0.5);
        assert_eq!(InternalStates::from_vector(vector).to_vector(), vector);
        let count = |options: Options| options.active().iter().filter(|&&active| active).count();
        assert_eq!(count(Options::PLAIN), 0);
        assert_eq!(count(Options { flapping: Flapping::FirstOrder, dynamic_inflow: true, ..Options::PLAIN }), 4);
        let all =
            Options { flapping: Flapping::SecondOrder, dynamic_inflow: true, governed: true, actuators: true, ..Options::PLAIN };
        assert_eq!(count(all), INNER);
    }
}
