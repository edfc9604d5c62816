//! Where telemetry comes from: `--source` of `ingest` and `live`, and what `convert` reads.

use sideslip::io::telemetry::mavlink::link::Url;
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::io::telemetry::record::RecordingError;
use sideslip::io::telemetry::recording::Recording;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What `--source` accepts, for help and messages.
const SOURCES: &str = "udpin://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT, serial://DEVICE?baud=N (MAVLink), \
    file://PATH (a recording), pcm+file://PATH?format=FRAME.toml, pcm+udp://HOST:PORT?format=FRAME.toml or \
    pcm+tcp://HOST:PORT?format=FRAME.toml (a stream of PCM)";

/// A recording and, of a stream of PCM, the format of its frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RecordingSource {
    pub(crate) file: PathBuf,
    pub(crate) pcm_format: Option<PathBuf>,
}

impl RecordingSource {
    /// Opens it.
    pub(crate) fn open(&self, mavlink: &MavlinkConfig) -> Result<Recording, RecordingError> {
        match &self.pcm_format {
            None => Recording::open_with(&self.file, mavlink),
            Some(format) => Recording::open_pcm(&self.file, format),
        }
    }

    /// The files that it reads.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        std::iter::once(&self.file).chain(&self.pcm_format).cloned().collect()
    }

    /// A path, or a URL of a recording.
    pub(crate) fn of_path_or_url(text: &str) -> Result<Self, String> {
        let is_url = ["file://", "pcm+file://"].iter().any(|scheme| text.starts_with(scheme));
        if !is_url {
            return Ok(RecordingSource { file: Path::new(text).into(), pcm_format: None });
        }
        match text.parse()? {
            TelemetrySource::Recording(recording) => Ok(recording),
            TelemetrySource::Link(_) | TelemetrySource::PcmLink { .. } => {
                Err(format!("expected a recording, found the link `{text}`"))
            }
        }
    }
}

/// Where telemetry comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TelemetrySource {
    /// A recording of any format that is read.
    Recording(RecordingSource),
    /// A link that brings MAVLink.
    Link(Url),
    /// A link that brings PCM, and the format of its frames.
    PcmLink { url: Url, format: PathBuf },
}

impl FromStr for TelemetrySource {
    type Err = String;

    fn from_str(url: &str) -> Result<Self, String> {
        if Url::is_link(url) {
            return Url::parse(url).map(TelemetrySource::Link).map_err(|wrong| wrong.to_string());
        }
        match url.split_once("://") {
            Some(("file", path)) if !path.is_empty() => {
                Ok(TelemetrySource::Recording(RecordingSource { file: path.into(), pcm_format: None }))
            }
            Some((scheme @ ("pcm+udp" | "pcm+tcp"), rest)) => match rest.split_once("?format=") {
                Some((address, format)) if !format.is_empty() => {
                    // A ground station listens for datagrams.
                    let link = if scheme == "pcm+udp" { "udpin" } else { "tcp" };
                    let url = Url::parse(&format!("{link}://{address}")).map_err(|wrong| wrong.to_string())?;
                    Ok(TelemetrySource::PcmLink { url, format: format.into() })
                }
                _ => Err(format!(
                    "expected {scheme}://HOST:PORT?format=FRAME.toml: a stream of PCM needs the format of its frames"
                )),
            },
            Some(("pcm+file", rest)) => match rest.split_once("?format=") {
                Some((file, format)) if !file.is_empty() && !format.is_empty() => {
                    let pcm_format = Some(PathBuf::from(format));
                    Ok(TelemetrySource::Recording(RecordingSource { file: file.into(), pcm_format }))
                }
                _ => Err("expected pcm+file://PATH?format=FRAME.toml: a stream of PCM needs the format of its frames".to_owned()),
            },
            _ => Err(format!("expected {SOURCES}; found `{}`", url.chars().take(60).collect::<String>())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{RecordingSource, TelemetrySource};

    #[test]
    fn a_source_is_a_url_of_a_known_kind() {
        let of = |file: &str, format: Option<&str>| {
            TelemetrySource::Recording(RecordingSource { file: file.into(), pcm_format: format.map(Into::into) })
        };
        assert_eq!("file://a/b.csv".parse(), Ok(of("a/b.csv", None)));
        assert_eq!("file:///a b.csv".parse(), Ok(of("/a b.csv", None)));
        assert_eq!("pcm+file://a.pcm?format=b/c.toml".parse(), Ok(of("a.pcm", Some("b/c.toml"))));
        for wrong in [
            "pcm+udp://127.0.0.1:1",
            "pcm+tcp://127.0.0.1:1?format=",
            "pcm+file://a.pcm",
            "pcm+file://?format=b",
            "pcm+file://a?format=",
        ] {
            assert!(wrong.parse::<TelemetrySource>().unwrap_err().contains("needs the format"), "{wrong}");
        }
        assert!(matches!("pcm+udp://127.0.0.1:1?format=a".parse(), Ok(TelemetrySource::PcmLink { .. })));
        let source = RecordingSource::of_path_or_url("a.csv");
        assert_eq!(source, Ok(RecordingSource { file: "a.csv".into(), pcm_format: None }));
        assert!(RecordingSource::of_path_or_url("pcm+file://a").is_err());
        for wrong in ["", "file://", "a.csv", "ftp://x"] {
            let said = wrong.parse::<TelemetrySource>().unwrap_err();
            assert!(said.contains("expected udpin://HOST:PORT") && said.contains("found `"), "{said}");
        }
        assert!(matches!("udpin://127.0.0.1:14550".parse(), Ok(TelemetrySource::Link(_))));
        assert!("udpin://127.0.0.1".parse::<TelemetrySource>().unwrap_err().contains("expected host:port"));
    }
}
