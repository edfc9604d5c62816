//! Payload of the lateral modes with their standard errors.

use super::message::{MessageHeader, service};
use super::status::StatusBody;
use crate::io::bus::error::BusError;
use crate::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use iceoryx2::prelude::ZeroCopySend;

/// The modes at one time; `time_s` of the header is the record's.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Modes.1")]
#[expect(missing_docs, reason = "fields are what their names say")]
pub struct ModesPayload {
    pub header: MessageHeader,
    /// How far they are.
    pub status: StatusBody,
    /// What is there: 1 Dutch roll, 2 roll, 4 spiral, 8 lateral phugoid, 16 coupled Dutch roll; zeros in what is not.
    pub present: u64,
    pub dutch_roll: OscillatoryMode,
    /// Roll subsidence.
    pub roll: RealRoot,
    pub spiral: RealRoot,
    /// The slower pair where roll and spiral have joined.
    pub lateral_phugoid: OscillatoryMode,
    /// Dutch roll of the whole aircraft.
    pub coupled: OscillatoryMode,
}
service!(ModesPayload, "sideslip/modes", "sideslip.Modes.1", buffer 64, history 1);

impl From<&ModesRecord> for ModesPayload {
    fn from(record: &ModesRecord) -> Self {
        let there = [
            record.dutch_roll.is_some(),
            record.roll.is_some(),
            record.spiral.is_some(),
            record.lateral_phugoid.is_some(),
            record.coupled.is_some(),
        ];
        ModesPayload {
            header: MessageHeader { time_s: record.time_s, ..MessageHeader::default() },
            status: record.status.into(),
            present: there.iter().rev().fold(0, |bits, &there| bits * 2 + u64::from(there)),
            dutch_roll: record.dutch_roll.unwrap_or_default(),
            roll: record.roll.unwrap_or_default(),
            spiral: record.spiral.unwrap_or_default(),
            lateral_phugoid: record.lateral_phugoid.unwrap_or_default(),
            coupled: record.coupled.unwrap_or_default(),
        }
    }
}

impl ModesPayload {
    /// The record.
    ///
    /// # Errors
    /// [`BusError::Payload`] for a code that there is not.
    pub fn record(&self) -> Result<ModesRecord, BusError> {
        let there = |bit: u64| self.present & bit != 0;
        if self.present > 31 {
            let found = self.present;
            return Err(BusError::Payload { schema: "sideslip.Modes.1", field: "present", expected: "0 to 31", found });
        }
        Ok(ModesRecord {
            time_s: self.header.time_s,
            status: self.status.status()?,
            dutch_roll: there(1).then_some(self.dutch_roll),
            roll: there(2).then_some(self.roll),
            spiral: there(4).then_some(self.spiral),
            lateral_phugoid: there(8).then_some(self.lateral_phugoid),
            coupled: there(16).then_some(self.coupled),
        })
    }
}
