//! Columns: what a small change of one parameter does to forces and readings at one instant.

use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::PositionedSensor;
use crate::flight::term::Term;

/// What a parameter acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column {
    /// A derivative: the variable's deviation on the axis.
    Derivative(Axis, Variable),
    /// A nonlinear term on the axis.
    Term(Axis, Term),
    /// The share of a control that acts; its place.
    Effectiveness(usize),
    /// A change of what reaches the blades, prepared for each run; its place there.
    Moved(usize),
    /// The rotor speed's deviation on the axis.
    RotorSpeed(Axis),
    /// The rotor's reaction, of a rotor that turns with or against a positive yaw: the sign of c.
    Reaction(f64),
    /// One on the axis.
    Constant(Axis),
    /// One on an output's reading.
    Bias(usize),
    /// The true value on an output's reading.
    Scale(usize),
    /// Less the rate of change on an output's reading: a skew, and a small lag.
    Timing(usize),
    /// A lag of the one output that has a state of its own.
    Lag,
    /// The place of a sensor along one body axis.
    Place(PositionedSensor, usize),
}
