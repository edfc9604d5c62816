//! Modes as JSON objects: the payload of `/modes`, and the roots that every answer with modes has, under the same keys.

use super::message_json::{reason_text, status_text};
use crate::flight::channel::ControlNames;
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::modes::record::{ModesRecord, Oscillation, RealRoot};
use serde::Serialize;

/// A complex pair.
#[derive(Serialize)]
pub(crate) struct OscillationJson {
    real: f64,
    imag: f64,
    omega: f64,
    zeta: f64,
    std_omega: f64,
    std_zeta: f64,
}

impl From<Oscillation> for OscillationJson {
    fn from(o: Oscillation) -> Self {
        let Oscillation { real, imag, omega, zeta, std_omega, std_zeta } = o;
        OscillationJson { real, imag, omega, zeta, std_omega, std_zeta }
    }
}

/// A real root.
#[derive(Serialize)]
pub(crate) struct RootJson {
    value: f64,
    std: f64,
}

impl From<RealRoot> for RootJson {
    fn from(RealRoot { value, std }: RealRoot) -> Self {
        RootJson { value, std }
    }
}

/// The roots that are there.
#[derive(Serialize)]
pub(crate) struct RootsJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    dutch_roll: Option<OscillationJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    roll: Option<RootJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spiral: Option<RootJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lateral_phugoid: Option<OscillationJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coupled_dutch_roll: Option<OscillationJson>,
}

impl From<&ModesRecord> for RootsJson {
    fn from(record: &ModesRecord) -> Self {
        RootsJson {
            dutch_roll: record.dutch_roll.map(Into::into),
            roll: record.roll.map(Into::into),
            spiral: record.spiral.map(Into::into),
            lateral_phugoid: record.lateral_phugoid.map(Into::into),
            coupled_dutch_roll: record.coupled.map(Into::into),
        }
    }
}

impl From<&OutputErrorRecord> for RootsJson {
    fn from(record: &OutputErrorRecord) -> Self {
        RootsJson {
            dutch_roll: record.dutch_roll.map(Into::into),
            roll: record.roll.map(Into::into),
            spiral: record.spiral.map(Into::into),
            lateral_phugoid: record.lateral_phugoid.map(Into::into),
            coupled_dutch_roll: record.coupled.map(Into::into),
        }
    }
}

/// Modes as the object of `/modes`; an absent mode is left out.
#[derive(Serialize)]
pub(crate) struct ModesJson {
    time: f64,
    status: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    #[serde(flatten)]
    roots: RootsJson,
}

impl ModesJson {
    pub(crate) fn new(record: &ModesRecord, controls: ControlNames) -> Self {
        ModesJson {
            time: record.time_s,
            status: status_text(record.status, controls),
            reason: reason_text(record.status, controls),
            roots: record.into(),
        }
    }
}
