//! Payload of an event: code of its kind, its subject (channel, axis or aid), its value.

use super::message::{ABSENT, MessageHeader, at, place, service};
use super::status::StatusBody;
use crate::flight::channel::Channel;
use crate::flight::derivative::Axis;
use crate::io::bus::error::BusError;
use crate::io::outputs::record::{EventKind, EventRecord};
use crate::realtime::estimation::record::{Aid, EstimationEvent as Noticed, GrossError, StateSet};
use crate::realtime::regression::record::RegressionEvent;
use iceoryx2::prelude::ZeroCopySend;

const SCHEMA: &str = "sideslip.Event.1";

/// An event. A kind keeps its code for good; a new kind takes the next number (now 27), whichever stage it is of.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Event.1")]
pub struct EventPayload {
    /// Its header; `time_s` is the event's.
    pub header: MessageHeader,
    /// Which kind.
    pub code: u32,
    /// Place of the channel, aid or axis that it is about; [`ABSENT`] for the run as a whole.
    pub subject: u32,
    /// Its number, with the unit of the event's own field; 0 without one.
    pub value: f64,
    /// The new status of an equation; waiting for every other kind.
    pub status: StatusBody,
}
service!(EventPayload, "sideslip/event", "sideslip.Event.1", buffer 256, history 64);

impl From<&EventRecord> for EventPayload {
    fn from(record: &EventRecord) -> Self {
        let channel = |channel: Channel| place(channel.index());
        let aid = |aid: Aid| place(aid.index());
        let mut status = StatusBody::default();
        let (code, subject, value) = match record.kind {
            EventKind::Estimation(event) => match event {
                Noticed::NotFinite { channel: which } => (0, channel(which), 0.0),
                Noticed::OutOfRange { channel: which, value } => (1, channel(which), value),
                Noticed::TimeNotFinite => (2, ABSENT, 0.0),
                Noticed::DuplicateTime => (3, ABSENT, 0.0),
                Noticed::TimeWentBack { by_s } => (4, ABSENT, by_s),
                Noticed::Gap { seconds } => (5, ABSENT, seconds),
                Noticed::SegmentRestart => (6, ABSENT, 0.0),
                Noticed::Initialised => (7, ABSENT, 0.0),
                Noticed::NoAccelerometer { channel: which } => (8, channel(which), 0.0),
                Noticed::AidMissing { aid: which } => (9, aid(which), 0.0),
                Noticed::AidRejected { aid: which, test_ratio } => (10, aid(which), test_ratio),
                Noticed::AidAccepted { aid: which } => (11, aid(which), 0.0),
                Noticed::KinematicsDisagree { aid: which, r_squared } => (12, aid(which), r_squared),
                Noticed::InnovationsTooLarge { aid: which, mean_nis } => (13, aid(which), mean_nis),
                Noticed::TrimNotSteady { rate_rms } => (14, ABSENT, rate_rms),
                Noticed::NumericBreakdown => (15, ABSENT, 0.0),
                Noticed::RatesSilent { seconds } => (19, ABSENT, seconds),
                Noticed::StatesChosen { set } => (22, ABSENT, set.code().into()),
                Noticed::LinesNotched { passing_hz } => (23, ABSENT, passing_hz),
                Noticed::LineFolded => (24, ABSENT, 0.0),
                Noticed::StandsStill { channel: which } => (25, channel(which), 0.0),
                Noticed::GrossError { error, r_squared } => (26, place(error.index()), r_squared),
            },
            EventKind::Regression(RegressionEvent::ExcitationBegan) => (16, ABSENT, 0.0),
            EventKind::Regression(RegressionEvent::ExcitationEnded) => (17, ABSENT, 0.0),
            EventKind::Regression(RegressionEvent::SignalMissing { channel: which }) => (20, channel(which), 0.0),
            EventKind::Regression(RegressionEvent::NoTrim { channel: which }) => (21, channel(which), 0.0),
            EventKind::Regression(RegressionEvent::StatusChanged { axis, status: changed }) => {
                status = changed.into();
                (18, place(axis.index()), 0.0)
            }
        };
        EventPayload { header: MessageHeader { time_s: record.time_s, ..MessageHeader::default() }, code, subject, value, status }
    }
}

impl EventPayload {
    /// The record.
    ///
    /// # Errors
    /// [`BusError::Payload`] for a code or a place that there is not.
    pub fn record(&self) -> Result<EventRecord, BusError> {
        let channel = || at(&Channel::ALL, self.subject, SCHEMA, "subject");
        let aid = || at(&Aid::ALL, self.subject, SCHEMA, "subject");
        let value = self.value;
        let estimation = match self.code {
            0 => Noticed::NotFinite { channel: channel()? },
            1 => Noticed::OutOfRange { channel: channel()?, value },
            2 => Noticed::TimeNotFinite,
            3 => Noticed::DuplicateTime,
            4 => Noticed::TimeWentBack { by_s: value },
            5 => Noticed::Gap { seconds: value },
            6 => Noticed::SegmentRestart,
            7 => Noticed::Initialised,
            8 => Noticed::NoAccelerometer { channel: channel()? },
            9 => Noticed::AidMissing { aid: aid()? },
            10 => Noticed::AidRejected { aid: aid()?, test_ratio: value },
            11 => Noticed::AidAccepted { aid: aid()? },
            12 => Noticed::KinematicsDisagree { aid: aid()?, r_squared: value },
            13 => Noticed::InnovationsTooLarge { aid: aid()?, mean_nis: value },
            14 => Noticed::TrimNotSteady { rate_rms: value },
            15 => Noticed::NumericBreakdown,
            16 => return Ok(self.of_regression(RegressionEvent::ExcitationBegan)),
            17 => return Ok(self.of_regression(RegressionEvent::ExcitationEnded)),
            18 => {
                let axis = at(&Axis::ALL, self.subject, SCHEMA, "subject")?;
                return Ok(self.of_regression(RegressionEvent::StatusChanged { axis, status: self.status.status()? }));
            }
            19 => Noticed::RatesSilent { seconds: value },
            // A number that is no set's code is taken as the nearest one.
            22 => Noticed::StatesChosen { set: StateSet::from_code(value as u8) },
            23 => Noticed::LinesNotched { passing_hz: value },
            24 => Noticed::LineFolded,
            25 => Noticed::StandsStill { channel: channel()? },
            26 => {
                let error = GrossError::ALL.get(self.subject as usize).ok_or_else(|| BusError::Payload {
                    schema: SCHEMA,
                    field: "subject",
                    expected: "a gross error",
                    found: self.subject.into(),
                })?;
                Noticed::GrossError { error, r_squared: value }
            }
            20 => return Ok(self.of_regression(RegressionEvent::SignalMissing { channel: channel()? })),
            21 => return Ok(self.of_regression(RegressionEvent::NoTrim { channel: channel()? })),
            found => return Err(BusError::Payload { schema: SCHEMA, field: "code", expected: "0 to 26", found: found.into() }),
        };
        Ok(EventRecord { time_s: self.header.time_s, kind: EventKind::Estimation(estimation) })
    }

    fn of_regression(&self, event: RegressionEvent) -> EventRecord {
        EventRecord { time_s: self.header.time_s, kind: EventKind::Regression(event) }
    }
}
