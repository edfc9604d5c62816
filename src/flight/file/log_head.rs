//! Head of a log before the first sample: description of the run, its columns, names of its controls.
//!
//! Written and read by the same type, so that a round trip keeps every column, unknown ones too, in order.

use crate::flight::channel::{CHANNELS, Channel, ControlNames};
use std::collections::BTreeMap;

/// The name of the metadata record that holds the head.
pub const RUN_METADATA: &str = "run";

/// Version of the head and of the topics' fields; a reader refuses one that it does not know.
pub const LOG_FORMAT: &str = "1";

/// Columns that a head can name; more are refused.
pub const MOST_COLUMNS: usize = 4096;

/// Keys of the origin: the call that wrote the log, and the files that it read (JSON: name, SHA-256, bytes, date).
pub const ORIGIN: [&str; 2] = ["command_line", "files"];

const ROTORCRAFT: &str = "rotorcraft";
const FIXED_WING: &str = "fixed_wing";

/// The head of a log.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct LogHead {
    /// The run's keys as one TOML document, as they were in effect.
    pub run_toml: String,
    /// Name and unit of each column without `time`, in order: SI for a known channel, as text for an unknown one.
    pub channels: Vec<(String, String)>,
    /// How the controls are called.
    pub controls: ControlNames,
    /// Where the log comes from, texts by [`ORIGIN`]; empty where a log does not say.
    pub origin: BTreeMap<String, String>,
}

/// Why a head cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum LogHeadError {
    #[error("expected the key `{0}` in the metadata record `run`, found none")]
    Missing(&'static str),
    #[error("expected a log of format {LOG_FORMAT}, found format `{0}`")]
    Format(String),
    #[error("{key}: expected {expected}, found `{found}`")]
    Text { key: &'static str, expected: &'static str, found: String },
    #[error("channels: two columns are called `{0}`")]
    Ambiguous(String),
}

/// Where a column of the head goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnTarget {
    /// A channel that the program knows.
    Known(Channel),
    /// A column that is carried along; its place among the unknown ones.
    Unknown(usize),
}

impl LogHead {
    /// A head with every channel that the program knows: for live sources, which cannot say beforehand what will come.
    pub fn every_channel(run_toml: String, controls: ControlNames) -> Self {
        let mut channels = Vec::with_capacity(CHANNELS);
        for channel in Channel::ALL {
            channels.push((channel.name(controls).to_owned(), channel.si_unit().to_owned()));
        }
        LogHead { run_toml, channels, controls, origin: BTreeMap::new() }
    }

    /// The head as the texts of a metadata record, with the program's name and version.
    pub fn to_metadata(&self, program: &str) -> BTreeMap<String, String> {
        let controls = match self.controls {
            ControlNames::Rotorcraft => ROTORCRAFT,
            ControlNames::FixedWing => FIXED_WING,
        };
        let channels =
            serde_json::Value::from_iter(self.channels.iter().map(|(name, unit)| [name.as_str(), unit.as_str()].to_vec()));
        let mut texts = self.origin.clone();
        texts.extend([
            ("format".to_owned(), LOG_FORMAT.to_owned()),
            ("program".to_owned(), program.to_owned()),
            ("toml".to_owned(), self.run_toml.clone()),
            ("channels".to_owned(), channels.to_string()),
            ("controls".to_owned(), controls.to_owned()),
        ]);
        texts
    }

    /// The head from the texts of a metadata record.
    ///
    /// # Errors
    /// [`LogHeadError`] where a key is missing or is not what it should be.
    pub fn from_metadata(texts: &BTreeMap<String, String>) -> Result<Self, LogHeadError> {
        let text = |key: &'static str| texts.get(key).ok_or(LogHeadError::Missing(key));
        let wrong = |key, expected, found: &str| LogHeadError::Text { key, expected, found: found.chars().take(40).collect() };
        let format = text("format")?;
        if format != LOG_FORMAT {
            return Err(LogHeadError::Format(format.chars().take(40).collect()));
        }
        let controls = match text("controls")?.as_str() {
            ROTORCRAFT => ControlNames::Rotorcraft,
            FIXED_WING => ControlNames::FixedWing,
            other => return Err(wrong("controls", "`rotorcraft` or `fixed_wing`", other)),
        };
        let listed = text("channels")?;
        let channels: Vec<(String, String)> =
            serde_json::from_str(listed).map_err(|_| wrong("channels", "a JSON list of [name, unit]", listed))?;
        if channels.len() > MOST_COLUMNS {
            return Err(wrong("channels", "at most 4096 columns", &channels.len().to_string()));
        }
        let origin = ORIGIN.iter().filter_map(|&key| Some((key.to_owned(), texts.get(key)?.clone())));
        let head = LogHead { run_toml: text("toml")?.clone(), channels, controls, origin: origin.collect() };
        match head.ambiguous_name() {
            Some(name) => Err(LogHeadError::Ambiguous(name.to_owned())),
            None => Ok(head),
        }
    }

    /// The target of each column, in their order.
    pub fn targets(&self) -> Vec<ColumnTarget> {
        let mut unknown = 0;
        let place = |name: &str| match Channel::from_name(name) {
            Some((channel, _)) => ColumnTarget::Known(channel),
            None => {
                unknown += 1;
                ColumnTarget::Unknown(unknown - 1)
            }
        };
        self.channels.iter().map(|(name, _)| name.as_str()).map(place).collect()
    }

    /// How many columns the program does not know and carries along.
    pub fn unknown_columns(&self) -> usize {
        self.channels.iter().filter(|(name, _)| Channel::from_name(name).is_none()).count()
    }

    /// The first name that stands twice or is `time`; a head with one cannot be logged.
    pub fn ambiguous_name(&self) -> Option<&str> {
        let mut seen = std::collections::BTreeSet::from(["time"]);
        self.channels.iter().map(|(name, _)| name.as_str()).find(|name| !seen.insert(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(names: &[&str]) -> LogHead {
        LogHead { channels: names.iter().map(|name| ((*name).to_owned(), "1".to_owned())).collect(), ..LogHead::default() }
    }

    #[test]
    fn columns_go_to_their_channels_and_the_rest_keeps_its_order() {
        let head = head(&["p", "fuel", "rudder", "egt"]);
        let expected = [
            ColumnTarget::Known(Channel::P),
            ColumnTarget::Unknown(0),
            ColumnTarget::Known(Channel::Pedal),
            ColumnTarget::Unknown(1),
        ];
        assert_eq!(head.targets(), expected);
        assert_eq!(head.unknown_columns(), 2);
    }

    #[test]
    fn a_head_comes_back_from_its_texts_and_a_strange_one_is_refused() {
        let mut head = head(&["p", "fuel \"left\"", "rudder"]);
        head.controls = ControlNames::FixedWing;
        head.run_toml = "run = \"1\"\n".to_owned();
        head.origin = BTreeMap::from([("command_line".to_owned(), "sideslip replay a.csv".to_owned())]);
        let texts = head.to_metadata("sideslip 0");
        assert_eq!(LogHead::from_metadata(&texts), Ok(head));
        for (key, value) in [("format", "2"), ("controls", "kite"), ("channels", "[1]"), ("channels", r#"[["p",""],["p",""]]"#)] {
            let mut strange = texts.clone();
            strange.insert(key.to_owned(), value.to_owned());
            LogHead::from_metadata(&strange).unwrap_err();
            strange.remove(key);
            assert_eq!(LogHead::from_metadata(&strange), Err(LogHeadError::Missing(key)));
        }
    }

    #[test]
    fn a_name_that_stands_twice_is_found() {
        assert_eq!(head(&["p", "fuel"]).ambiguous_name(), None);
        assert_eq!(head(&["p", "fuel", "p"]).ambiguous_name(), Some("p"));
        assert_eq!(head(&["time"]).ambiguous_name(), Some("time"));
        assert_eq!(LogHead::every_channel(String::new(), ControlNames::FixedWing).ambiguous_name(), None);
    }
}
