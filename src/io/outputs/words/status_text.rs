//! Names, units, numbers and statuses in words, for people.
//!
//! Consumes records and the naming of the controls; produces `core::fmt` text without allocation, so that the same
//! words stand in the log, on the terminal and in a firmware's event dump.

use crate::flight::channel::{Channel, ControlNames};
use crate::flight::derivative::{Axis, Variable};
use crate::io::outputs::number::Digits;
use crate::realtime::estimation::record::Aid;
use crate::realtime::regression::record::{Reason, Status};
use core::fmt::{self, Display, Formatter};

/// The aid in words.
pub const fn aid_name(aid: Aid) -> &'static str {
    match aid {
        Aid::Airspeed => "airspeed",
        Aid::Incidence => "incidence",
        Aid::Sideslip => "sideslip",
        Aid::Bank => "bank",
        Aid::Pitch => "pitch",
        Aid::Heading => "heading",
        Aid::Altitude => "altitude",
    }
}

/// The unit of a derivative, radians taken as 1 where they cancel; `None` is the bias.
pub const fn derivative_unit(axis: Axis, variable: Option<Variable>) -> &'static str {
    match (axis.is_force(), variable) {
        (true, None) => "m/s^2",
        (false, None) => "rad/s^2",
        (true, Some(Variable::U | Variable::V | Variable::W)) => "1/s",
        (false, Some(Variable::U | Variable::V | Variable::W)) => "rad/(m s)",
        (true, Some(Variable::P | Variable::Q | Variable::R)) => "m/(s rad)",
        (false, Some(Variable::P | Variable::Q | Variable::R)) => "1/s",
        (true, Some(_)) => "m/(s^2 rad)",
        (false, Some(_)) => "1/s^2",
    }
}

/// A derivative's name, `N_v` or `N_0`.
#[derive(Clone, Copy, Debug)]
pub struct DerivativeLabel {
    /// Its axis.
    pub axis: Axis,
    /// Its variable; `None` is the bias.
    pub variable: Option<Variable>,
    /// How the controls are called.
    pub controls: ControlNames,
}

impl Display for DerivativeLabel {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.axis.name())?;
        f.write_str("_")?;
        f.write_str(self.variable.map_or("0", |variable| variable.name(self.controls)))
    }
}

/// A status with its reason, as on topics: `converged`, `not identifiable: ...`.
#[derive(Clone, Copy, Debug)]
pub struct StatusText {
    /// The status.
    pub status: Status,
    /// How the controls are called.
    pub controls: ControlNames,
}

impl Display for StatusText {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.status {
            Status::Waiting => f.write_str("waiting"),
            Status::Exciting => f.write_str("exciting"),
            Status::Converging => f.write_str("converging"),
            Status::Converged => f.write_str("converged"),
            Status::Disagree => f.write_str("disagree"),
            Status::DependsOnAmplitude => f.write_str("depends on amplitude"),
            Status::Stale => f.write_str("stale"),
            Status::NotIdentifiable(reason) => {
                write!(f, "not identifiable: {}", ReasonText { reason, controls: self.controls })
            }
        }
    }
}

/// Why the Dutch roll of the whole aircraft has no number where that of the lateral subsystem has one.
pub const WHOLE_NOT_AVAILABLE: &str = "not available yet: not all six equations have the terms of its coupling to u w q";

/// Why there is no Dutch roll where the equations have numbers.
pub const DUTCH_ROLL_WITHHELD: &str = "no number: a pair that grows is reported once it has done so for 2 s, any other once its \
                                       standard errors resolve it; or no pair of roots oscillates";

/// The status with what it means where there is no number yet.
pub fn status_in_words(status: Status, controls: ControlNames) -> String {
    let more = match status {
        Status::Waiting => {
            ": no test input has excited the aircraft yet; gusts, controls that answer them, and small or slow inputs do not"
        }
        Status::Exciting => ": the excitation so far does not resolve the derivatives",
        Status::Stale => ": no new input for a while",
        Status::Disagree => ": the frequency domain, or output error, gives other numbers",
        Status::DependsOnAmplitude => ": the numbers hold for this amplitude of motion",
        Status::Converging | Status::Converged | Status::NotIdentifiable(_) => "",
    };
    format!("{}{more}", StatusText { status, controls })
}

/// Why there is no number.
#[derive(Clone, Copy, Debug)]
pub struct ReasonText {
    /// The reason.
    pub reason: Reason,
    /// How the controls are called.
    pub controls: ControlNames,
}

impl Display for ReasonText {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.reason {
            Reason::NoRates => f.write_str("p, q and r come together too rarely or not at all"),
            Reason::NoAccelerometer { channel } => {
                write!(f, "no accelerometer on this axis (channel {})", channel.name(self.controls))
            }
            Reason::NoTrim { channel } => {
                write!(f, "{} was not sampled in the trim window", channel.name(self.controls))
            }
            Reason::RateTooLow { hz, needed_hz } => {
                write!(f, "the rates come at {} Hz, derivatives need {needed_hz} Hz", Digits(hz, 3))
            }
            Reason::Unobserved { variable, missing } => {
                write!(
                    f,
                    "{} is not observable; the channel {} would make it so",
                    variable.name(self.controls),
                    missing.name(self.controls)
                )
            }
            Reason::AidRejected { channel } => {
                let cause = if matches!(channel, Channel::Alpha | Channel::Beta | Channel::Tas) {
                    "moving air, or a fault"
                } else {
                    "a fault"
                };
                write!(
                    f,
                    "{} is rejected: it contradicts the motion that gyros and accelerometers measure ({cause})",
                    channel.name(self.controls)
                )
            }
            Reason::InstrumentDoubted { channel: Some(channel) } => {
                write!(f, "{} is doubted (unit, sign, wiring, clipped or frozen)", channel.name(self.controls))
            }
            Reason::InstrumentDoubted { channel: None } => {
                f.write_str("the instruments contradict each other as with a wrong unit or sign, not yet known whose")
            }
            Reason::NotConfirmed { channel } => {
                write!(
                    f,
                    "sign and unit of {} are not confirmed: too little motion, the air moves, or they are wrong",
                    channel.name(self.controls)
                )
            }
            Reason::Collinear { condition_index } => {
                write!(
                    f,
                    "the variables moved together (collinear, condition index {}); an input that moves one of them by itself separates them",
                    Digits(condition_index, 3)
                )
            }
            Reason::NotExcited { axis, variable } => {
                let name = variable.name(self.controls);
                write!(f, "{}_{name} is not identified: {name} hardly moved; fly an input that moves it", axis.name())
            }
            Reason::Unresolved => f.write_str(
                "the standard errors are too large to tell it, or whether it is stable; more or larger inputs make them smaller",
            ),
            Reason::NoInput => f.write_str(
                "no input moved this plane of motion, nor is it known to follow from the other plane: the air may move it",
            ),
            Reason::NoControl => f.write_str(
                "no control deflection is known at the start of the run, and without one an input is not told from gusts; record deflections in rad or deg, or state by --map what the command columns mean",
            ),
            Reason::Equation { axis } => write!(f, "the {} equation has no numbers", axis.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn controls_are_called_as_the_run_calls_them() {
        let name = DerivativeLabel { axis: Axis::N, variable: Some(Variable::Pedal), controls: ControlNames::FixedWing };
        assert_eq!(name.to_string(), "N_rudder");
        assert_eq!(DerivativeLabel { variable: None, ..name }.to_string(), "N_0");
    }

    #[test]
    fn a_status_carries_its_reason() {
        let status = Status::NotIdentifiable(Reason::RateTooLow { hz: 4.0, needed_hz: 8.0 });
        assert_eq!(
            StatusText { status, controls: ControlNames::Rotorcraft }.to_string(),
            "not identifiable: the rates come at 4.00 Hz, derivatives need 8 Hz"
        );
    }

    #[test]
    fn units_of_derivatives_follow_from_their_definition() {
        assert_eq!(derivative_unit(Axis::Y, Some(Variable::V)), "1/s");
        assert_eq!(derivative_unit(Axis::N, Some(Variable::V)), "rad/(m s)");
        assert_eq!(derivative_unit(Axis::L, Some(Variable::P)), "1/s");
        assert_eq!(derivative_unit(Axis::Z, Some(Variable::Collective)), "m/(s^2 rad)");
        assert_eq!(derivative_unit(Axis::M, None), "rad/s^2");
    }
}
