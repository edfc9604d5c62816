//! Modes as JSON objects: the payload of `/modes`, and the roots under the same keys in every result that contains modes.

use super::message_json::{reason_text, status_text};
use crate::flight::channel::ControlNames;
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use serde::Serialize;

#[derive(Serialize)]
pub(crate) struct RootsJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    dutch_roll: Option<OscillatoryMode>,
    #[serde(skip_serializing_if = "Option::is_none")]
    roll: Option<RealRoot>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spiral: Option<RealRoot>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lateral_phugoid: Option<OscillatoryMode>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coupled_dutch_roll: Option<OscillatoryMode>,
}

impl From<&ModesRecord> for RootsJson {
    fn from(record: &ModesRecord) -> Self {
        RootsJson {
            dutch_roll: record.dutch_roll,
            roll: record.roll,
            spiral: record.spiral,
            lateral_phugoid: record.lateral_phugoid,
            coupled_dutch_roll: record.coupled,
        }
    }
}

impl From<&OutputErrorRecord> for RootsJson {
    fn from(record: &OutputErrorRecord) -> Self {
        RootsJson {
            dutch_roll: record.dutch_roll,
            roll: record.roll,
            spiral: record.spiral,
            lateral_phugoid: record.lateral_phugoid,
            coupled_dutch_roll: record.coupled,
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
