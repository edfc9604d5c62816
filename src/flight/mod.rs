//! Vocabulary of flight that every stage shares: channels, units, derivative names, axes, runs and models.
//!
//! In: texts and numbers of the outside world. Out: typed names, SI values, body axes.
//! Assumed: body axes x forward, y right, z down, origin at the centre of mass; gravity 9.80665 m/s^2.
//! Refused: an unknown unit on a known channel, a name that is not a derivative's, a value that is not finite.

pub mod channel;
pub mod control;
pub mod derivative;
pub mod effect;
#[cfg(feature = "std")]
pub mod log_head;
pub mod model;
pub mod run;
#[cfg(feature = "std")]
pub mod run_file;
pub mod setting;
pub mod term;
pub mod unit;

#[cfg(feature = "std")]
pub mod document;
#[cfg(feature = "std")]
pub mod effect_file;
#[cfg(feature = "std")]
pub mod model_file;
