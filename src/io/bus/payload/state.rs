//! Payloads of the state estimation: state and innovations of one sample, and the smoothed state with its delay.

use super::message::{MessageHeader, at, flag, place, service};
use crate::io::bus::error::BusError;
use crate::realtime::estimation::record::{AIDS, Aid, Innovation, LaggedRecord, StateRecord};
use iceoryx2::prelude::ZeroCopySend;

const INNOVATIONS: &str = "sideslip.Innovations.1";

/// The body of a state with both ways between it and the record, its fields listed once.
macro_rules! state_body {
    ($($field:ident: $kind:ty,)*) => {
        /// A state's numbers, with units and order of [`StateRecord`].
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
        #[type_name("sideslip.StateBody.1")]
        #[expect(missing_docs, reason = "the fields are those of the record")]
        pub struct StateBody {
            $(pub $field: $kind,)*
        }

        impl From<&StateRecord> for StateBody {
            fn from(record: &StateRecord) -> Self {
                StateBody { $($field: record.$field,)* }
            }
        }

        impl StateBody {
            /// The record at that time, with so many aids fused.
            fn record(&self, time_s: f64, fused: u8) -> StateRecord {
                StateRecord { time_s, $($field: self.$field,)* fused }
            }
        }
    };
}

state_body! {
    velocity: [f64; 3],
    velocity_std: [f64; 3],
    rates: [f64; 3],
    rates_std: [f64; 3],
    angular_acceleration: [f64; 3],
    angular_acceleration_std: [f64; 3],
    specific_force: [f64; 3],
    specific_force_std: [f64; 3],
    attitude: [f64; 3],
    attitude_std: [f64; 3],
    altitude: f64,
    altitude_std: f64,
    accelerometer_bias: [f64; 3],
    accelerometer_bias_std: [f64; 3],
    gyro_bias: [f64; 3],
    gyro_bias_std: [f64; 3],
}

/// The filtered state; `time_s` of the header is the record's.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.State.2")]
pub struct StatePayload {
    /// Its header.
    pub header: MessageHeader,
    /// Its numbers.
    pub state: StateBody,
    /// How many aids were fused at this sample.
    pub fused: u64,
}
service!(StatePayload, "sideslip/state", "sideslip.State.2", buffer 256, history 1);

impl From<&StateRecord> for StatePayload {
    fn from(record: &StateRecord) -> Self {
        let header = MessageHeader { time_s: record.time_s, ..MessageHeader::default() };
        StatePayload { header, state: record.into(), fused: record.fused.into() }
    }
}

impl StatePayload {
    /// The record.
    ///
    /// # Errors
    /// [`BusError::Payload`] where more aids were fused than there are.
    pub fn record(&self) -> Result<StateRecord, BusError> {
        let wrong = BusError::Payload { schema: "sideslip.State.2", field: "fused", expected: "0 to 255", found: self.fused };
        Ok(self.state.record(self.header.time_s, u8::try_from(self.fused).map_err(|_| wrong)?))
    }
}

/// A smoothed state of a while ago; `time_s` of the header is that of the newest sample that it rests on.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Smoothed.1")]
pub struct SmoothedPayload {
    /// Its header.
    pub header: MessageHeader,
    /// Time that the state belongs to, s.
    pub time_s: f64,
    /// How much later the newest sample is that it rests on, s.
    pub lag_s: f64,
    /// Its numbers.
    pub state: StateBody,
}
service!(SmoothedPayload, "sideslip/smoothed", "sideslip.Smoothed.1", buffer 64, history 1);

impl From<&LaggedRecord> for SmoothedPayload {
    fn from(LaggedRecord { state, lag_s }: &LaggedRecord) -> Self {
        let header = MessageHeader { time_s: state.time_s + lag_s, ..MessageHeader::default() };
        SmoothedPayload { header, time_s: state.time_s, lag_s: *lag_s, state: state.into() }
    }
}

impl SmoothedPayload {
    /// The record.
    pub fn record(&self) -> LaggedRecord {
        LaggedRecord { state: self.state.record(self.time_s, 0), lag_s: self.lag_s }
    }
}

/// What one aid did, with the meaning of [`Innovation`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Innovation.1")]
#[expect(missing_docs, reason = "the fields are those of the record")]
pub struct InnovationBody {
    pub aid: u32,
    pub fused: u32,
    pub time_s: f64,
    pub observation: f64,
    pub observation_var: f64,
    pub innovation: f64,
    pub innovation_var: f64,
    pub test_ratio: f64,
}

/// What the aids of one sample did.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Innovations.1")]
pub struct InnovationsPayload {
    /// Its header.
    pub header: MessageHeader,
    /// How many of the entries count.
    pub count: u64,
    /// The entries, in the order of fusion.
    pub entries: [InnovationBody; AIDS],
}
service!(InnovationsPayload, "sideslip/innovation", "sideslip.Innovations.1", buffer 256, history 1);

impl InnovationsPayload {
    /// The innovations of one sample; there are never more than aids.
    pub fn new(time_s: f64, innovations: &[Innovation]) -> Self {
        let mut payload = InnovationsPayload { header: MessageHeader { time_s, ..MessageHeader::default() }, ..Self::default() };
        for (to, from) in payload.entries.iter_mut().zip(innovations) {
            payload.count += 1;
            *to = InnovationBody {
                aid: place(from.aid.index()),
                fused: from.fused.into(),
                time_s: from.time_s,
                observation: from.observation,
                observation_var: from.observation_var,
                innovation: from.innovation,
                innovation_var: from.innovation_var,
                test_ratio: from.test_ratio,
            };
        }
        payload
    }

    /// The records.
    ///
    /// # Errors
    /// [`BusError::Payload`] for an aid that there is not.
    pub fn records(&self) -> Result<heapless::Vec<Innovation, AIDS>, BusError> {
        let count = usize::try_from(self.count).unwrap_or(usize::MAX);
        let wrong = |found| BusError::Payload { schema: INNOVATIONS, field: "count", expected: "0 to 7", found };
        let mut records = heapless::Vec::new();
        for body in self.entries.get(..count).ok_or_else(|| wrong(self.count))? {
            let record = Innovation {
                time_s: body.time_s,
                aid: at(&Aid::ALL, body.aid, INNOVATIONS, "aid")?,
                observation: body.observation,
                observation_var: body.observation_var,
                innovation: body.innovation,
                innovation_var: body.innovation_var,
                test_ratio: body.test_ratio,
                fused: flag(body.fused, INNOVATIONS, "fused")?,
            };
            records.push(record).map_err(|_| wrong(self.count))?;
        }
        Ok(records)
    }
}
