//! Payload of a status with its reason: two codes, two indices, two values.

use super::message::{ABSENT, at, place};
use crate::flight::channel::Channel;
use crate::flight::derivative::{Axis, Variable};
use crate::io::bus::error::BusError;
use crate::realtime::regression::record::{Reason, Status};
use iceoryx2::prelude::ZeroCopySend;

const SCHEMA: &str = "sideslip.Status.1";

/// How far along an answer is. Codes: 0 waiting, 1 exciting, 2 converging, 3 converged, 4 stale, 5 not identifiable,
/// 6 disagree, 7 depends on amplitude; then reasons, by [`Reason::code`]: 0 no rates, 1 no accelerometer (channel), 2 rate too
/// low (Hz, Hz needed), 3 unobserved (variable, channel), 4 collinear (condition index), 5 not excited (axis, variable),
/// 6 another equation (axis), 7 no trim (channel), 8 aid rejected (channel), 9 unresolved, 10 instrument doubted (channel or
/// none), 11 not confirmed (channel), 12 no input, 13 no control.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Status.1")]
pub struct StatusBody {
    /// Which status.
    pub code: u32,
    /// Which reason; [`ABSENT`] without one.
    pub reason: u32,
    /// What the reason is about, as listed.
    pub places: [u32; 2],
    /// Its numbers, as listed.
    pub numbers: [f64; 2],
}

impl From<Status> for StatusBody {
    fn from(status: Status) -> Self {
        let plain = |code| StatusBody { code, reason: ABSENT, places: [ABSENT; 2], numbers: [0.0; 2] };
        let reason = match status {
            Status::Waiting => return plain(0),
            Status::Exciting => return plain(1),
            Status::Converging => return plain(2),
            Status::Converged => return plain(3),
            Status::Stale => return plain(4),
            Status::Disagree => return plain(6),
            Status::DependsOnAmplitude => return plain(7),
            Status::NotIdentifiable(reason) => reason,
        };
        let (places, numbers) = match reason {
            Reason::NoRates | Reason::Unresolved | Reason::NoInput | Reason::NoControl => ([ABSENT; 2], [0.0; 2]),
            Reason::NoAccelerometer { channel }
            | Reason::NoTrim { channel }
            | Reason::AidRejected { channel }
            | Reason::NotConfirmed { channel } => ([place(channel.index()), ABSENT], [0.0; 2]),
            Reason::RateTooLow { hz, needed_hz } => ([ABSENT; 2], [hz, needed_hz]),
            Reason::Unobserved { variable, missing } => ([place(variable.index()), place(missing.index())], [0.0; 2]),
            Reason::Collinear { condition_index } => ([ABSENT; 2], [condition_index, 0.0]),
            Reason::NotExcited { axis, variable } => ([place(axis.index()), place(variable.index())], [0.0; 2]),
            Reason::Equation { axis } => ([place(axis.index()), ABSENT], [0.0; 2]),
            Reason::InstrumentDoubted { channel } => {
                ([channel.map_or(ABSENT, |channel| place(channel.index())), ABSENT], [0.0; 2])
            }
        };
        StatusBody { reason: reason.code(), places, numbers, ..plain(5) }
    }
}

impl StatusBody {
    /// The status.
    ///
    /// # Errors
    /// [`BusError::Payload`] for a code or place that there is not.
    pub fn status(&self) -> Result<Status, BusError> {
        let [first, second] = self.places;
        let [number, needed] = self.numbers;
        let variable = |index| at(&Variable::ALL, index, SCHEMA, "variable");
        let axis = |index| at(&Axis::ALL, index, SCHEMA, "axis");
        let channel = |index| at(&Channel::ALL, index, SCHEMA, "channel");
        Ok(match (self.code, self.reason) {
            (0, _) => Status::Waiting,
            (1, _) => Status::Exciting,
            (2, _) => Status::Converging,
            (3, _) => Status::Converged,
            (4, _) => Status::Stale,
            (5, reason) => Status::NotIdentifiable(match reason {
                0 => Reason::NoRates,
                1 => Reason::NoAccelerometer { channel: channel(first)? },
                2 => Reason::RateTooLow { hz: number, needed_hz: needed },
                3 => Reason::Unobserved { variable: variable(first)?, missing: channel(second)? },
                4 => Reason::Collinear { condition_index: number },
                5 => Reason::NotExcited { axis: axis(first)?, variable: variable(second)? },
                6 => Reason::Equation { axis: axis(first)? },
                7 => Reason::NoTrim { channel: channel(first)? },
                8 => Reason::AidRejected { channel: channel(first)? },
                9 => Reason::Unresolved,
                10 if first == ABSENT => Reason::InstrumentDoubted { channel: None },
                10 => Reason::InstrumentDoubted { channel: Some(channel(first)?) },
                11 => Reason::NotConfirmed { channel: channel(first)? },
                12 => Reason::NoInput,
                13 => Reason::NoControl,
                found => {
                    return Err(BusError::Payload { schema: SCHEMA, field: "reason", expected: "0 to 13", found: found.into() });
                }
            }),
            (6, _) => Status::Disagree,
            (7, _) => Status::DependsOnAmplitude,
            (found, _) => {
                return Err(BusError::Payload { schema: SCHEMA, field: "code", expected: "0 to 7", found: found.into() });
            }
        })
    }
}
