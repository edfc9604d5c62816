//! Events in words: kind, severity, subject, and one sentence.
//!
//! Consumes records of events and the names of the controls; produces `core::fmt` text without allocation, so that log, terminal
//! and a firmware's event dump have the same sentence.

use super::estimation_sentence::estimation_sentence;
use super::status_text::StatusText;
use crate::flight::channel::ControlNames;
use crate::io::outputs::record::EventKind;
use crate::realtime::estimation::record::EstimationEvent;
use crate::realtime::regression::record::{RegressionEvent, Status};
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
pub const EVENT_KINDS: usize = 27;

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
    "stands_still",
    "gross_error",
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
            EstimationEvent::StandsStill { .. } => 25,
            EstimationEvent::GrossError { .. } => 26,
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
            | EstimationEvent::StandsStill { .. }
            | EstimationEvent::GrossError { .. }
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
            | EstimationEvent::StandsStill { channel }
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
                write!(f, "{} was silent for longer than its last value is held; the regression", channel.name(self.controls))?;
                f.write_str(" leaves those instants out")
            }
            EventKind::Regression(RegressionEvent::NoTrim { channel }) => {
                write!(f, "{} was not sampled in the trim window; the regression leaves it out", channel.name(self.controls))
            }
            EventKind::Regression(RegressionEvent::StatusChanged { axis, status }) => {
                write!(f, "status of the {} equation: {}", axis.name(), StatusText { status: *status, controls: self.controls })
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
    fn channels_are_called_as_the_run_calls_them() {
        let event = EstimationEvent::NotFinite { channel: Channel::Pedal };
        assert_eq!(sentence(event, ControlNames::FixedWing), "rudder gave no number (NaN or infinity); taken as not sampled");
        assert!(sentence(event, ControlNames::Rotorcraft).starts_with("pedal "));
    }
}
