//! What a file that the user gives says of recordings: which message, or which measurement, carries which channel.
//!
//! Consumes the text; produces a [`RecordingConfig`]. By its keys the file is one of MAVLink, a map of the measurements of an
//! IRIG 106 Chapter 10 setup, or a format of PCM frames for a Chapter 10 recording.

use super::channel_map::map_file::ChannelMap;
use super::chapter10::channel_choice::FrameDescription;
use super::mavlink::mapping::MavlinkConfig;
use crate::flight::file::run_file::RunFileError;

/// How recordings are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingConfig {
    /// Of messages of MAVLink.
    pub mavlink: MavlinkConfig,
    /// Of Chapter 10.
    pub chapter10: FrameDescription,
    /// Of tables and logs of other programs.
    pub map: Option<ChannelMap>,
}

impl RecordingConfig {
    /// Reads the file's text.
    ///
    /// # Errors
    /// [`RunFileError`] with line and column, as of the kind of file that its keys show.
    pub fn from_toml(text: &str) -> Result<Self, RunFileError> {
        if text.parse::<toml::Table>().is_ok_and(|table| FrameDescription::has_keys(&table)) {
            let chapter10 = FrameDescription::from_toml(text).map_err(|wrong| RunFileError {
                line: wrong.line,
                column: wrong.column,
                what: wrong.what,
            })?;
            return Ok(RecordingConfig { chapter10, ..RecordingConfig::default() });
        }
        Ok(RecordingConfig { mavlink: MavlinkConfig::from_toml(text)?, ..RecordingConfig::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kind_of_file_is_told_by_its_keys() {
        let map = RecordingConfig::from_toml("[measurements]\np = \"ROLL RATE\"\n").unwrap();
        assert!(matches!(map.chapter10, FrameDescription::Setup(map) if map.named.len() == 1));
        let frames = "channel = 3\nbit_rate = 1e5\nwords = 3\nword_bits = 16\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n";
        let frames = RecordingConfig::from_toml(frames).unwrap();
        assert!(matches!(frames.chapter10, FrameDescription::Frames(file) if file.channel == Some(3)));
        let mavlink = RecordingConfig::from_toml("system = 7\n").unwrap();
        assert_eq!((mavlink.mavlink.system, mavlink.chapter10), (Some(7), FrameDescription::default()));
        assert_eq!(RecordingConfig::from_toml("system = 7\n[measurements]\np = \"X\"\n").unwrap_err().line, 1);
    }
}
