//! Words for people: one sentence for each event, status and reason, in the field's words.
//!
//! Consumes records and the naming of the controls; produces `core::fmt` text without allocation, so that the same
//! sentence stands in the log, on the terminal and in a firmware's event dump.

use super::estimation_sentence::estimation_sentence;
use crate::flight::channel::ControlNames;
use crate::flight::derivative::{Axis, Variable};
use crate::io::outputs::record::EventKind;
use crate::realtime::estimation::record::{Aid, EstimationEvent};
use crate::realtime::regression::record::{Reason, RegressionEvent, Status};
use core::fmt::{self, Display, Formatter};

/// How much an event matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing.
    Info,
    /// The answer may be worse for it.
    Warning,
    /// Something that was recorded did not take part.
    DataLost,
}

impl Severity {
    /// The word in logs.
    pub const fn name(self) -> &'static str {
        match self {
            Severity::Info => "info",
            Severity::Warning => "warning",
            Severity::DataLost => "data lost",
        }
    }
}

/// How many kinds of event there are.
pub const EVENT_KINDS: usize = 25;

/// The names of all kinds of event, by [`event_place`].
pub const EVENT_NAMES: [&str; EVENT_KINDS] = [
    "not_finite",
    "out_of_range",
    "time_not_finite",
    "duplicate_time",
    "time_went_back",
    "gap",
    "segment_restart",
    "initialised",
    "no_accelerometer",
    "aid_missing",
    "aid_rejected",
    "aid_accepted",
    "kinematics_disagree",
    "innovations_too_large",
    "trim_not_steady",
    "numeric_breakdown",
    "excitation_began",
    "excitation_ended",
    "status_changed",
    "signal_missing",
    "no_trim",
    "rates_silent",
    "states_chosen",
    "lines_notched",
    "line_folded",
];

/// Place of the event's kind in tables per kind.
pub const fn event_place(kind: &EventKind) -> usize {
    match kind {
        EventKind::Estimation(event) => match event {
            EstimationEvent::NotFinite { .. } => 0,
            EstimationEvent::OutOfRange { .. } => 1,
            EstimationEvent::TimeNotFinite => 2,
            EstimationEvent::DuplicateTime => 3,
            EstimationEvent::TimeWentBack { .. } => 4,
            EstimationEvent::Gap { .. } => 5,
            EstimationEvent::SegmentRestart => 6,
            EstimationEvent::Initialised => 7,
            EstimationEvent::NoAccelerometer { .. } => 8,
            EstimationEvent::AidMissing { .. } => 9,
            EstimationEvent::AidRejected { .. } => 10,
            EstimationEvent::AidAccepted { .. } => 11,
            EstimationEvent::KinematicsDisagree { .. } => 12,
            EstimationEvent::InnovationsTooLarge { .. } => 13,
            EstimationEvent::TrimNotSteady { .. } => 14,
            EstimationEvent::NumericBreakdown => 15,
            EstimationEvent::RatesSilent { .. } => 21,
            EstimationEvent::StatesChosen { .. } => 22,
            EstimationEvent::LinesNotched { .. } => 23,
            EstimationEvent::LineFolded => 24,
        },
        EventKind::Regression(event) => match event {
            RegressionEvent::ExcitationBegan => 16,
            RegressionEvent::ExcitationEnded => 17,
            RegressionEvent::StatusChanged { .. } => 18,
            RegressionEvent::SignalMissing { .. } => 19,
            RegressionEvent::NoTrim { .. } => 20,
        },
    }
}

/// The name of the event's kind, for programs.
pub fn event_name(kind: &EventKind) -> &'static str {
    EVENT_NAMES.get(event_place(kind)).copied().unwrap_or("event")
}

/// How much the event matters.
pub const fn event_severity(kind: &EventKind) -> Severity {
    match kind {
        EventKind::Estimation(event) => match event {
            EstimationEvent::NotFinite { .. }
            | EstimationEvent::OutOfRange { .. }
            | EstimationEvent::TimeNotFinite
            | EstimationEvent::DuplicateTime
            | EstimationEvent::TimeWentBack { .. } => Severity::DataLost,
            EstimationEvent::Initialised
            | EstimationEvent::AidAccepted { .. }
            | EstimationEvent::StatesChosen { .. }
            | EstimationEvent::LinesNotched { .. } => Severity::Info,
            EstimationEvent::Gap { .. }
            | EstimationEvent::RatesSilent { .. }
            | EstimationEvent::SegmentRestart
            | EstimationEvent::NoAccelerometer { .. }
            | EstimationEvent::AidMissing { .. }
            | EstimationEvent::AidRejected { .. }
            | EstimationEvent::KinematicsDisagree { .. }
            | EstimationEvent::InnovationsTooLarge { .. }
            | EstimationEvent::TrimNotSteady { .. }
            | EstimationEvent::LineFolded
            | EstimationEvent::NumericBreakdown => Severity::Warning,
        },
        EventKind::Regression(event) => match event {
            RegressionEvent::ExcitationBegan | RegressionEvent::ExcitationEnded => Severity::Info,
            RegressionEvent::StatusChanged { status: Status::NotIdentifiable(_), .. } => Severity::Warning,
            RegressionEvent::StatusChanged { .. } => Severity::Info,
            RegressionEvent::SignalMissing { .. } | RegressionEvent::NoTrim { .. } => Severity::Warning,
        },
    }
}

/// What the event is about: a channel, an aid's channel or an axis; `None` for the run as a whole.
pub const fn event_subject(kind: &EventKind, controls: ControlNames) -> Option<&'static str> {
    match kind {
        EventKind::Estimation(event) => match event {
            EstimationEvent::NotFinite { channel }
            | EstimationEvent::OutOfRange { channel, .. }
            | EstimationEvent::NoAccelerometer { channel } => Some(channel.name(controls)),
            EstimationEvent::AidMissing { aid }
            | EstimationEvent::AidRejected { aid, .. }
            | EstimationEvent::AidAccepted { aid }
            | EstimationEvent::KinematicsDisagree { aid, .. }
            | EstimationEvent::InnovationsTooLarge { aid, .. } => Some(aid.channel().name(controls)),
            _ => None,
        },
        EventKind::Regression(RegressionEvent::StatusChanged { axis, .. }) => Some(axis.name()),
        EventKind::Regression(RegressionEvent::SignalMissing { channel } | RegressionEvent::NoTrim { channel }) => {
            Some(channel.name(controls))
        }
        EventKind::Regression(_) => None,
    }
}

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

/// A number to that many significant digits, plain between 1e-4 and 1e6 in size; `-` where it is not finite.
#[derive(Clone, Copy, Debug)]
pub struct Digits(pub f64, pub u8);

impl Display for Digits {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Digits(value, digits) = *self;
        if !value.is_finite() {
            return f.write_str("-");
        }
        let digits = i32::from(digits.clamp(1, 17));
        let size = libm::fabs(value);
        if size > 0.0 && !(1e-4..1e6).contains(&size) {
            let decimals = usize::try_from(digits - 1).unwrap_or(0);
            return write!(f, "{value:.decimals$e}");
        }
        let magnitude = if size > 0.0 { libm::floor(libm::log10(size)) as i32 } else { 0 };
        let decimals = usize::try_from(digits - 1 - magnitude).unwrap_or(0);
        write!(f, "{value:.decimals$}")
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
            Status::Stale => f.write_str("stale"),
            Status::NotIdentifiable(reason) => {
                write!(f, "not identifiable: {}", ReasonText { reason, controls: self.controls })
            }
        }
    }
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
                write!(f, "nothing observes {}; the channel {} would", variable.name(self.controls), missing.name(self.controls))
            }
            Reason::AidRejected { channel } => {
                write!(f, "{} is rejected: it disagrees with the other instruments", channel.name(self.controls))
            }
            Reason::Collinear { condition_index } => {
                write!(f, "the regressors cannot be told apart (condition index {})", Digits(condition_index, 3))
            }
            Reason::NotExcited { axis, variable } => {
                let name = variable.name(self.controls);
                write!(f, "{}_{name} is not known: {name} hardly moved", axis.name())
            }
            Reason::Equation { axis } => write!(f, "the {} equation has no numbers", axis.name()),
        }
    }
}

/// An event as one sentence, without its time.
#[derive(Clone, Copy, Debug)]
pub struct EventText<'a> {
    /// The event.
    pub kind: &'a EventKind,
    /// How the controls are called.
    pub controls: ControlNames,
}

impl Display for EventText<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.kind {
            EventKind::Estimation(event) => estimation_sentence(f, event, self.controls),
            EventKind::Regression(RegressionEvent::ExcitationBegan) => f.write_str("the aircraft is being excited"),
            EventKind::Regression(RegressionEvent::ExcitationEnded) => f.write_str("the excitation has ended"),
            EventKind::Regression(RegressionEvent::SignalMissing { channel }) => {
                write!(f, "{} was silent for longer than its last value serves; the regression", channel.name(self.controls))?;
                f.write_str(" leaves those instants out")
            }
            EventKind::Regression(RegressionEvent::NoTrim { channel }) => {
                write!(f, "{} was not sampled in the trim window; the regression leaves it out", channel.name(self.controls))
            }
            EventKind::Regression(RegressionEvent::StatusChanged { axis, status }) => {
                write!(f, "the {} equation is {}", axis.name(), StatusText { status: *status, controls: self.controls })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;

    fn sentence(event: EstimationEvent, controls: ControlNames) -> String {
        EventText { kind: &EventKind::Estimation(event), controls }.to_string()
    }

    #[test]
    fn numbers_have_that_many_digits() {
        let cases = [
            (0.0, "0.00"),
            (1.814_9, "1.81"),
            (-0.087_26, "-0.0873"),
            (0.000_123_4, "0.000123"),
            (12_345.6, "12346"),
            (0.000_012_34, "1.23e-5"),
            (9.0e7, "9.00e7"),
            (f64::NAN, "-"),
            (f64::NEG_INFINITY, "-"),
        ];
        for (value, text) in cases {
            assert_eq!(Digits(value, 3).to_string(), text);
        }
    }

    #[test]
    fn channels_are_called_as_the_run_calls_them() {
        let event = EstimationEvent::NotFinite { channel: Channel::Pedal };
        assert_eq!(sentence(event, ControlNames::FixedWing), "rudder gave no number (NaN or infinity); taken as not sampled");
        assert!(sentence(event, ControlNames::Rotorcraft).starts_with("pedal "));
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
