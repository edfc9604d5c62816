//! Recovery: a simulated aircraft whose derivatives are known gives them back inside their own standard errors.

mod gusts;
mod instrument_faults;
mod instruments;
mod live_output_error;
mod pilot;
mod puma_100kn;
mod recorded_faults;
mod recordings;
mod tlog;

use sideslip::flight::derivative::{Axis, Variable};

/// What is asked of every way of telemetry and flying: the derivatives of yaw and roll that the modes are made of.
const WANTED: [(Axis, Variable); 8] = [
    (Axis::N, Variable::V),
    (Axis::N, Variable::P),
    (Axis::N, Variable::R),
    (Axis::N, Variable::Pedal),
    (Axis::L, Variable::V),
    (Axis::L, Variable::P),
    (Axis::L, Variable::R),
    (Axis::L, Variable::LatCyclic),
];

/// Places of [`WANTED`].
const N_V: usize = 0;
const N_R: usize = 2;
const L_P: usize = 5;
