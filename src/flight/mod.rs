//! Vocabulary of flight that every stage shares: channels, units, derivative names, axes, runs and models.
//!
//! In: texts and numbers from outside the program. Out: typed names, SI values, body axes.
//! Assumed: body axes x forward, y right, z down, origin at the centre of mass; gravity 9.80665 m/s^2.
//! Refused: an unknown unit on a known channel, a name that is not a derivative's, a value that is not finite.

pub mod channel;
pub mod control;
pub mod derivative;
pub mod effect;
pub mod effect_field;
#[cfg(feature = "std")]
pub mod file;
pub mod model;
pub mod positioned_sensor;
pub mod run;
pub mod sample;
pub mod setting;
#[cfg(feature = "std")]
pub mod signal;
pub mod term;
pub mod unit;
