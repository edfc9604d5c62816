//! Level 1: a helicopter as a rigid body with a rotor whose loads are integrated by hand.
//!
//! In: velocity through the air, rates, blade pitch, rotor speed, density. Out: specific force and angular acceleration, for the
//! same motion, control path, effects and instruments as a linear model's (`fly`); trim, and a linear model about it.
//! Assumed: incompressible, unstalled sections of constant lift slope; flap to its first harmonic; uniform inflow with one
//! harmonic by the wake's skew; density constant through a flight.
//! Refused: a file with a key missing or unknown (`file`); a flight that has no trim, or only one beyond those assumptions
//! (`trim`).
//!
//! One file an element: [`hub`], `inflow`, [`flapping`], [`rotor`], [`tail_rotor`], [`fin`], [`tailplane`], [`fuselage`],
//! [`engine`], [`actuator`]; [`aircraft`] sums them up, [`internal_states`] holds the states beside the
//! motion, `dynamics` their rates.

pub mod actuator;
pub mod aircraft;
pub(crate) mod dynamics;
pub mod engine;
pub mod file;
pub mod fin;
#[cfg(test)]
mod first_principles_tests;
pub mod flapping;
pub mod fuselage;
pub mod hub;
pub(crate) mod inflow;
pub mod internal_states;
#[cfg(test)]
mod level1_tests;
pub mod linearise;
#[cfg(test)]
mod power_tests;
pub mod rotor;
pub mod tail_rotor;
pub mod tailplane;
pub mod trim;
