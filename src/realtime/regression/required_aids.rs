//! Which aids an equation, and a velocity among its regressors, rest on.

use crate::flight::channel::Channel;
use crate::flight::derivative::{Axis, Variable};
use crate::realtime::estimation::record::{Aid, Instrumentation};

/// The aids that observe the motion of the axis: v is the sideslip vane's, w the incidence vane's.
pub const fn needs(axis: Axis) -> [Aid; 3] {
    if axis.is_lateral() { [Aid::Sideslip, Aid::Bank, Aid::Airspeed] } else { [Aid::Incidence, Aid::Pitch, Aid::Airspeed] }
}

/// Whether the velocity is observed: without its vane it drifts with the accelerometers' bias.
pub fn observed(variable: Variable, instruments: &Instrumentation) -> bool {
    match variable {
        Variable::V => instruments.aids[Aid::Sideslip.index()],
        Variable::W => instruments.aids[Aid::Incidence.index()],
        _ => true,
    }
}

/// The accelerometer that measures the response of a force equation.
pub const fn accelerometer(axis: Axis) -> Option<Channel> {
    match axis {
        Axis::X => Some(Channel::Ax),
        Axis::Y => Some(Channel::Ay),
        Axis::Z => Some(Channel::Az),
        Axis::L | Axis::M | Axis::N => None,
    }
}
