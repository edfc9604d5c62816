//! Dynamics: the equations of motion and what instruments sense, written once.
//!
//! In: body-axis state, forces, a linear model's derivatives, altitude. Out: state derivatives, matrices A and B, air density.
//! Assumed: a rigid body over a flat earth, body axes, SI and radians. No `std`, no allocation.

pub mod atmosphere;
pub mod kinematics;
pub mod linear;
pub mod sensors;
