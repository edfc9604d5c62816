//! Level-1 simulation: a helicopter as a rigid body, its rotor loads integrated analytically over blade span and azimuth.
//!
//! In: velocity through the air, angular rates, blade pitch, rotor speed, density. Out: specific force and angular acceleration,
//! for the same equations of motion, control path, effects and instruments as a linear model (`fly`); trim, and a linear model
//! about it. Assumed: incompressible, unstalled sections of constant lift slope; flap to the first harmonic; uniform inflow with
//! one harmonic from the wake skew; constant density in a flight. Refused: a file with a missing or unknown key (`file`); a
//! flight without trim, or with a trim beyond these assumptions (`trim`).
//!
//! One file for each component: [`hub`], `inflow`, [`flapping`], [`rotor`], [`tail_rotor`], [`fin`], [`tailplane`], [`fuselage`],
//! [`engine`], [`actuator`]; [`aircraft`] sums their loads, [`internal_states`] holds the states besides those of the rigid body,
//! `dynamics` their rates.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch. 3 and appendix 4B.

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
