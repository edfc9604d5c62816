//! The lateral modes on the bus.

use crate::io::bus::error::BusError;
use crate::io::bus::payload::{MessageHeader, StatusBody, service};
use crate::realtime::modes::record::{ModesRecord, Oscillation, RealRoot};
use iceoryx2::prelude::ZeroCopySend;

/// A complex pair, with the meaning of [`Oscillation`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Oscillation.1")]
#[expect(missing_docs, reason = "the fields are those of the record")]
pub struct OscillationBody {
    pub real: f64,
    pub imag: f64,
    pub omega: f64,
    pub zeta: f64,
    pub std_omega: f64,
    pub std_zeta: f64,
}

/// A real root, with the meaning of [`RealRoot`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Root.1")]
#[expect(missing_docs, reason = "the fields are those of the record")]
pub struct RootBody {
    pub value: f64,
    pub std: f64,
}

/// The modes at one time; `time_s` of the header is the record's.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Modes.1")]
pub struct ModesPayload {
    /// Its header.
    pub header: MessageHeader,
    /// How far they are.
    pub status: StatusBody,
    /// What is there: 1 Dutch roll, 2 roll, 4 spiral, 8 lateral phugoid, 16 coupled Dutch roll; zeros in what is not.
    pub present: u64,
    /// Dutch roll.
    pub dutch_roll: OscillationBody,
    /// Roll subsidence.
    pub roll: RootBody,
    /// Spiral.
    pub spiral: RootBody,
    /// The slower pair where roll and spiral have joined.
    pub lateral_phugoid: OscillationBody,
    /// Dutch roll of the whole aircraft.
    pub coupled: OscillationBody,
}
service!(ModesPayload, "sideslip/modes", "sideslip.Modes.1", buffer 64, history 1);

impl From<Oscillation> for OscillationBody {
    fn from(pair: Oscillation) -> Self {
        let Oscillation { real, imag, omega, zeta, std_omega, std_zeta } = pair;
        OscillationBody { real, imag, omega, zeta, std_omega, std_zeta }
    }
}

impl From<OscillationBody> for Oscillation {
    fn from(body: OscillationBody) -> Self {
        let OscillationBody { real, imag, omega, zeta, std_omega, std_zeta } = body;
        Oscillation { real, imag, omega, zeta, std_omega, std_zeta }
    }
}

impl From<RealRoot> for RootBody {
    fn from(root: RealRoot) -> Self {
        RootBody { value: root.value, std: root.std }
    }
}

impl From<RootBody> for RealRoot {
    fn from(body: RootBody) -> Self {
        RealRoot { value: body.value, std: body.std }
    }
}

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
            dutch_roll: record.dutch_roll.map(Into::into).unwrap_or_default(),
            roll: record.roll.map(Into::into).unwrap_or_default(),
            spiral: record.spiral.map(Into::into).unwrap_or_default(),
            lateral_phugoid: record.lateral_phugoid.map(Into::into).unwrap_or_default(),
            coupled: record.coupled.map(Into::into).unwrap_or_default(),
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
            dutch_roll: there(1).then_some(self.dutch_roll.into()),
            roll: there(2).then_some(self.roll.into()),
            spiral: there(4).then_some(self.spiral.into()),
            lateral_phugoid: there(8).then_some(self.lateral_phugoid.into()),
            coupled: there(16).then_some(self.coupled.into()),
        })
    }
}
