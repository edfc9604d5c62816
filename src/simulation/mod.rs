//! Simulation: an aircraft's model flown on given controls, seen through instruments.
//!
//! In: a model file's model and effects (`flight::model`, `flight::effect`), controls over time (`input`, `history`),
//! instruments. Out: samples as a recording would hold them, and the true state behind them (`fly`); the linearised
//! model's matrices (`linear`).
//! Assumed: body axes, SI, gravity 9.80665 m/s^2; controls in straight lines between samples; forces as deviations from
//! one trim; air at rest but for gusts.
//! Refused: an effect of kind `unknown`, a channel that is not modelled, times that do not increase. A motion
//! that diverges is a result, cut where it leaves the kinematics.
//!
//! The path of a control: `input` (hand) and `pilot` -> `control_path` (dead zone, mixing, delay, rate limit, lag) -> `linear` or
//! [`level1`] (forces) -> `integrate` (`motion`), one `segment` after the other -> `instrument` (position, `vibration`, lag,
//! delay, scale, bias, noise, word, `dropout`).

pub(crate) mod control_path;
pub mod dropout;
pub mod flight_model;
#[cfg(test)]
mod flown_model_tests;
pub mod fly;
pub mod input;
pub mod input_design;
pub mod instrument;
pub mod instrument_file;
pub mod integrate;
pub mod level1;
pub mod motion;
pub mod pilot;
mod prbs;
mod segment;
pub mod simulation_error;
pub mod turbulence;
pub mod unmodelled;
mod vibration;
