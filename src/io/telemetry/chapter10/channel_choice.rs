//! Which PCM channel of a recording gives the samples, and the format of its frames.
//!
//! Consumes the setup (TMATS), or a format of PCM frames as for a stream without one; produces a [`ChosenChannel`]. By the
//! setup it is the channel that has measurements that are channels of the program, by their own names or by a
//! [map](super::measurement_map). Refused: a setup without any, with a sentence that lists the measurements found; several
//! channels that have some, of which one must be said; a measurement of the map that the setup does not have.

use super::measurement_map::MeasurementMap;
use super::tmats::Tmats;
use super::tmats_format::TmatsChannel;
use super::tmats_pcm::TmatsPcmFormat;
use crate::flight::channel::Channel;
use crate::flight::file::run_file::RunInfo;
use crate::io::telemetry::pcm::format_file::{PcmFormatFile, PcmFormatFileError};
use crate::io::telemetry::pcm::layout::PcmFormat;
use crate::io::telemetry::record::RecordingError;
use crate::io::text_file::read_text;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Channels of the recorder that are looked at in a setup at most.
const CHANNELS: usize = 256;
/// Names that a sentence lists at most.
const LISTED: usize = 12;
/// Keys of a format of PCM frames that a map of measurements does not have.
const OF_FRAMES: [&str; 4] = ["bit_rate", "words", "sync", "parameter"];

/// Where the format of the frames comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameDescription {
    /// The setup, and which of its measurements are channels under other names.
    Setup(MeasurementMap),
    /// A file.
    Frames(Box<PcmFormatFile>),
}

impl Default for FrameDescription {
    fn default() -> Self {
        FrameDescription::Setup(MeasurementMap::default())
    }
}

/// What is read of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenChannel {
    /// The channel; the first of PCM that comes where `None`.
    pub channel: Option<u16>,
    /// The format of its frames.
    pub format: PcmFormat,
    /// What is known of the run.
    pub info: RunInfo,
    /// What the setup says, where that is the source.
    pub written: Option<TmatsPcmFormat>,
    /// Measurements of the setup that are left out, each in a sentence.
    pub left_out: Vec<String>,
    /// What the setup does not say of channels and was assumed, each in a sentence.
    pub assumed: Vec<String>,
}

impl FrameDescription {
    /// Whether these top-level keys are those of such a file.
    pub fn has_keys(table: &toml::Table) -> bool {
        ["measurements", "channel"].iter().chain(&OF_FRAMES).any(|key| table.contains_key(*key))
    }

    /// Reads the text of a format of frames or of a map of measurements, told by its keys.
    ///
    /// # Errors
    /// As of either.
    pub fn from_toml(text: &str) -> Result<Self, PcmFormatFileError> {
        let table = text.parse::<toml::Table>().unwrap_or_default();
        if OF_FRAMES.iter().any(|key| table.contains_key(*key)) {
            PcmFormatFile::from_toml(text).map(|file| FrameDescription::Frames(Box::new(file)))
        } else {
            MeasurementMap::from_toml(text).map(FrameDescription::Setup)
        }
    }

    /// Reads the file.
    ///
    /// # Errors
    /// [`RecordingError`] with path, line and column.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let text = read_text(path).map_err(|wrong| whole(wrong.to_string()))?;
        let expected = "expected a format of PCM frames, or a map of measurements";
        FrameDescription::from_toml(&text).map_err(|wrong| whole(format!("{expected}: {wrong}")))
    }

    /// Whether the setup is needed.
    pub fn needs_setup(&self) -> bool {
        matches!(self, FrameDescription::Setup(_))
    }

    /// The channel and its format.
    ///
    /// # Errors
    /// A sentence that says what the setup lacks, what it has, and what to do.
    pub fn choose(&self, setup: &[u8]) -> Result<ChosenChannel, String> {
        match self {
            FrameDescription::Frames(file) => Ok(ChosenChannel {
                channel: file.channel,
                format: file.format.clone(),
                info: file.info.clone(),
                written: None,
                left_out: Vec::new(),
                assumed: Vec::new(),
            }),
            FrameDescription::Setup(map) => by_setup(&Tmats::parse(setup), map),
        }
    }
}

fn by_setup(tmats: &Tmats, map: &MeasurementMap) -> Result<ChosenChannel, String> {
    if tmats.attributes().next().is_none() {
        return Err(format!("no setup (TMATS) stands before its data; {WHAT_TO_DO}"));
    }
    let numbers: BTreeSet<u16> = tmats
        .attributes()
        .filter(|(code, _)| code.starts_with("R-") && code.contains("\\TK1-"))
        .filter_map(|(_, value)| value.parse().ok())
        .filter(|number| map.channel.is_none_or(|wanted| wanted == *number))
        .take(CHANNELS)
        .collect();
    if let (Some(wanted), true) = (map.channel, numbers.is_empty()) {
        return Err(format!("its setup (TMATS) has no channel {wanted}"));
    }
    // Only one format is kept, and each is made once: several channels may lead to one.
    let (mut first, mut candidates, mut others) = (None, Vec::new(), Vec::new());
    let mut known_of_group = BTreeMap::new();
    for channel in numbers {
        // Channels of other data than PCM lead to no format.
        let Ok(written) = TmatsPcmFormat::of_channel(tmats, channel) else { continue };
        if let Some(known) = known_of_group.get(&written.group) {
            if *known > 0 {
                candidates.push((channel, *known));
            }
            continue;
        }
        match TmatsChannel::of_channel(tmats, channel, map) {
            Ok(found) => {
                let is_known = |name: &str| Channel::from_name(name).is_some();
                let known = found.format.parameters().iter().filter(|parameter| is_known(&parameter.name)).count();
                known_of_group.insert(written.group, known);
                if known > 0 {
                    candidates.push((channel, known));
                    first.get_or_insert((channel, found));
                } else {
                    others.push(described(channel, &found));
                }
            }
            Err(why) => {
                known_of_group.insert(written.group, 0);
                others.push(format!("PCM channel {channel}: {why}"));
            }
        }
    }
    let Some((channel, found)) = first else {
        let found = if others.is_empty() { "it has no PCM channel".to_owned() } else { listed(&others, "; ") };
        return Err(format!("no measurement of its setup (TMATS) is a channel of this program: {found}; {WHAT_TO_DO}"));
    };
    if candidates.len() > 1 {
        let all: Vec<String> = candidates.iter().map(|(channel, known)| format!("channel {channel} ({known} of them)")).collect();
        return Err(format!(
            "several PCM channels have measurements that are channels of this program: {}; say one in a file, \
             `channel = {channel}`, given by --config FILE or ch10+file://PATH?format=FILE (convert --merge with \
             --clock-offset 0 joins two)",
            listed(&all, ", ")
        ));
    }
    if let Some(missing) =
        map.named.iter().find(|named| !found.format.parameters().iter().any(|parameter| parameter.name == named.channel))
    {
        let why = found.left_out.iter().find(|why| why.contains(&missing.measurement));
        let why = why.map_or_else(|| described(channel, &found), Clone::clone);
        return Err(format!(
            "expected the measurement `{}` for {} in its setup (TMATS), found none that can be read: {why}",
            missing.measurement, missing.channel
        ));
    }
    let TmatsChannel { format, written, left_out, assumed } = found;
    Ok(ChosenChannel { channel: Some(channel), format, info: map.info.clone(), written: Some(written), left_out, assumed })
}

const WHAT_TO_DO: &str = "say which measurement is which channel in a file, [measurements] p = \"ROLL RATE\", or describe the \
    frames in it as of a stream of PCM, and give it by --config FILE or ch10+file://PATH?format=FILE";

/// The measurements of a channel.
fn described(channel: u16, found: &TmatsChannel) -> String {
    let names: Vec<String> = found.format.parameters().iter().map(|parameter| format!("`{}`", parameter.name)).collect();
    let mut text = format!("PCM channel {channel} ({})", found.written.link);
    text += &match names.is_empty() {
        true => " has no measurement".to_owned(),
        false => format!(" has {}", listed(&names, ", ")),
    };
    if let Some(first) = found.left_out.first() {
        text += &format!(" ({} left out, the first: {first})", found.left_out.len());
    }
    text
}

/// The first ones, and how many more.
fn listed(names: &[String], between: &str) -> String {
    let shown = names.iter().take(LISTED).cloned().collect::<Vec<_>>().join(between);
    match names.len().saturating_sub(LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

#[cfg(test)]
#[path = "channel_choice_tests.rs"]
mod tests;
