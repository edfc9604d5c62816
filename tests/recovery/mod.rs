//! Recovery: a simulated aircraft whose derivatives are known gives them back inside their own standard errors.

mod fast_roll;
mod gusts;
mod instrument_faults;
mod instruments;
mod larger_motion;
mod live_output_error;
mod other_plane;
mod pilot;
mod puma_100kn;
mod recorded_faults;
mod recordings;
mod reported;
mod speed_drift;
mod tlog;

use crate::support::manoeuvre::WANTED;

/// Places of [`WANTED`].
const N_V: usize = 0;
const N_R: usize = 2;
const L_P: usize = 5;
