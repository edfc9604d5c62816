//! Real time: the stages that run in the aircraft as well as on the ground.
//!
//! In: time-aligned samples. Out: state, smoothed state, derivatives, modes, each as the record of its stage.
//! No `std`, no allocation, no clock, no input or output: live, replay and firmware run this same code.

pub mod estimation;
pub mod modes;
pub mod pipeline;
pub mod regression;
