//! Which measurement of a setup (TMATS) is which channel, as a TOML file, where they are not called alike.
//!
//! ```toml
//! channel = 3                      # of the recorder; default the only one whose measurements are channels
//! [measurements]                   # a channel, and what the setup calls it
//! p = "ROLL RATE"
//! ax = { name = "NX", unit = "g" } # instead of the setup's unit
//! [run]                            # keys of the run, as in the preamble of a CSV run file
//! aircraft = "Puma"
//! ```
//!
//! Consumes the text; produces a [`MeasurementMap`]. Names of measurements are compared without regard to case. Refused: names
//! that are no channels, one measurement for two channels, a unit of another quantity.

use crate::flight::channel::Channel;
use crate::flight::file::run_file::{RecordingColumn, RunInfo, quoted};
use crate::io::telemetry::pcm::format_file::PcmFormatFileError;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// Which measurement is which channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasurementMap {
    /// The channel of the recorder.
    pub channel: Option<u16>,
    /// By channel's name.
    pub named: Vec<NamedMeasurement>,
    /// The table `run`.
    pub info: RunInfo,
}

/// What the setup calls a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedMeasurement {
    /// The channel's name.
    pub channel: String,
    /// The measurement's.
    pub measurement: String,
    /// Its unit, where not that of the setup.
    pub unit: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    channel: Option<u16>,
    #[serde(default)]
    measurements: BTreeMap<Spanned<String>, Spanned<Entry>>,
    run: Option<Spanned<toml::Table>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Entry {
    Name(String),
    Whole(WholeEntry),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WholeEntry {
    name: String,
    unit: Option<String>,
}

impl MeasurementMap {
    /// Reads the file's text.
    ///
    /// # Errors
    /// [`PcmFormatFileError`] where it is not TOML, a key is not known, or a name is no channel.
    pub fn from_toml(text: &str) -> Result<Self, PcmFormatFileError> {
        let document: Document = toml::from_str(text).map_err(|error: toml::de::Error| {
            PcmFormatFileError::in_text(text, error.span().map_or(0, |span| span.start), error.message().to_owned())
        })?;
        let mut map = MeasurementMap { channel: document.channel, ..MeasurementMap::default() };
        for (key, entry) in document.measurements {
            let (start, channel) = (key.span().start, key.into_inner());
            let wrong = |what: String| PcmFormatFileError::in_text(text, start, format!("measurements: {what}"));
            if Channel::from_name(&channel).is_none() {
                return Err(wrong(format!("expected the name of a channel such as p, q, r or beta, found {}", quoted(&channel))));
            }
            let (measurement, unit) = match entry.into_inner() {
                Entry::Name(name) => (name, None),
                Entry::Whole(WholeEntry { name, unit }) => (name, unit),
            };
            RecordingColumn::new(&channel, unit.as_deref()).map_err(wrong)?;
            if map.named.iter().any(|before| before.measurement.eq_ignore_ascii_case(&measurement)) {
                return Err(wrong(format!("expected one channel for a measurement, found {} twice", quoted(&measurement))));
            }
            map.named.push(NamedMeasurement { channel, measurement, unit });
        }
        if let Some(run) = &document.run {
            let info = RunInfo::from_toml(&run.get_ref().to_string());
            map.info =
                info.map_err(|error| PcmFormatFileError::in_text(text, run.span().start, format!("run: {}", error.what)))?;
        }
        Ok(map)
    }

    /// What the map says of a measurement.
    pub fn of_measurement(&self, measurement: &str) -> Option<&NamedMeasurement> {
        self.named.iter().find(|named| named.measurement.eq_ignore_ascii_case(measurement))
    }

    /// What the map says of a channel.
    pub fn of_channel(&self, channel: &str) -> Option<&NamedMeasurement> {
        self.named.iter().find(|named| named.channel == channel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_gives_names_and_units() {
        let map = MeasurementMap::from_toml(
            "channel = 3\n[measurements]\np = \"ROLL RATE\"\nax = { name = \"NX\", unit = \"g\" }\n[run]\naircraft = \"Puma\"\n",
        )
        .unwrap();
        assert_eq!((map.channel, map.info.aircraft()), (Some(3), Some("Puma")));
        assert_eq!(map.of_measurement("roll rate").map(|named| named.channel.as_str()), Some("p"));
        assert_eq!(map.of_channel("ax").and_then(|named| named.unit.as_deref()), Some("g"));
        assert_eq!(map.of_measurement("p"), None);
    }

    #[test]
    fn mistakes_have_a_line() {
        for (text, line, expected) in [
            ("[measurements]\nspeed = \"V\"\n", 2, "name of a channel"),
            ("[measurements]\np = \"A\"\nq = \"a\"\n", 3, "found `a` twice"),
            ("[measurements]\np = { name = \"A\", unit = \"kg\" }\n", 2, "expected a unit of rad/s"),
            ("channel = 3\n[run]\nblades = 0\n", 2, "run: blades"),
            ("names = 1\n", 1, "unknown field"),
        ] {
            let wrong = MeasurementMap::from_toml(text).unwrap_err();
            assert_eq!(wrong.line, line, "{wrong}");
            assert!(wrong.what.contains(expected), "{wrong}");
        }
    }
}
