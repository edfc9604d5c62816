//! Where telemetry comes from: `--source` of `ingest` and `live`, and the recordings that commands read.

use crate::command::terminal::console::message_once;
use crate::command::terminal::output_file::same_place;
use clap::builder::{OsStringValueParser, TypedValueParser};
use sideslip::io::telemetry::alignment::aligned_recording::TimeSpan;
use sideslip::io::telemetry::chapter10::channel_choice::FrameDescription;
use sideslip::io::telemetry::format::RecordingFormat;
use sideslip::io::telemetry::mavlink::link::Url;
use sideslip::io::telemetry::read_recording::{KeptRecording, ReadRecording};
use sideslip::io::telemetry::record::RecordingError;
use sideslip::io::telemetry::recording::Recording;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

/// What `--source` accepts, for help and messages.
const SOURCES: &str = "udpin://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT, serial://DEVICE?baud=N (MAVLink), \
    file://PATH (a recording), pcm+file://PATH?format=FRAME.toml, pcm+udp://HOST:PORT?format=FRAME.toml or \
    pcm+tcp://HOST:PORT?format=FRAME.toml (a stream of PCM), ch10+udp://HOST:PORT or ch10+file://PATH (IRIG 106 Chapter 10, \
    with ?format=FILE.toml where its setup does not name the channels)";

/// What is said beside the name of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum RecordingKind {
    /// Nothing: its content tells the format.
    ByContent,
    /// It is a stream of PCM of that format.
    Pcm(PathBuf),
    /// It holds packets of Chapter 10, of that format where it is named.
    Chapter10(Option<PathBuf>),
}

/// A recording, how it is read, and what of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecordingSource {
    pub(crate) file: PathBuf,
    pub(crate) kind: RecordingKind,
    /// The times that are read.
    pub(crate) span: TimeSpan,
    /// The number of the manoeuvre at those times, where one was asked for.
    pub(crate) manoeuvre: Option<usize>,
    /// Keys of the run that are overridden, `key=value`.
    pub(crate) set: Vec<String>,
    /// What was read of it before, which is not read again.
    pub(crate) kept: Option<KeptRows>,
}

/// A recording in memory; two are the same where they are one.
#[derive(Clone, Debug)]
pub(crate) struct KeptRows(pub(crate) Arc<ReadRecording>);

impl PartialEq for KeptRows {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl RecordingSource {
    /// The whole of it, as it says itself.
    pub(crate) fn whole(file: PathBuf, kind: RecordingKind) -> Self {
        RecordingSource { file, kind, span: TimeSpan::default(), manoeuvre: None, set: Vec::new(), kept: None }
    }

    /// The name of its file without the ending, and the manoeuvre: `flight-m2`.
    pub(crate) fn stem(&self) -> String {
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        self.manoeuvre.map_or_else(|| stem.to_string(), |number| format!("{stem}-m{number}"))
    }

    /// Opens it.
    pub(crate) fn open(&self, config: &RecordingConfig) -> Result<Recording, RecordingError> {
        if let Some(KeptRows(read)) = &self.kept {
            return Ok(Recording::Kept(KeptRecording::new(Arc::clone(read))));
        }
        match &self.kind {
            RecordingKind::ByContent => Recording::open_with(&self.file, config),
            RecordingKind::Pcm(format) => Recording::open_pcm(&self.file, format),
            RecordingKind::Chapter10(None) => Recording::open_chapter10(&self.file, &config.chapter10),
            RecordingKind::Chapter10(Some(format)) => Recording::open_chapter10(&self.file, &FrameDescription::read(format)?),
        }
    }

    /// The same, and notes the measurements of its setup that are not read.
    pub(crate) fn open_with_note(&self, config: &RecordingConfig) -> Result<Recording, RecordingError> {
        let recording = self.open(config)?;
        note_setup(&self.file.display(), recording.left_out(), recording.assumed());
        if !recording.found_out().is_empty() {
            message_once(format_args!("note: {}: {}", self.file.display(), recording.found_out().join("; ")));
        }
        Ok(recording)
    }

    /// Whether it is read as packets of Chapter 10; what cannot be read is refused later.
    pub(crate) fn is_chapter10(&self) -> bool {
        let mut head = [0; 2];
        let mut read = || std::fs::File::open(&self.file).and_then(|mut file| file.read_exact(&mut head));
        match self.kind {
            RecordingKind::Chapter10(_) => true,
            RecordingKind::Pcm(_) => false,
            RecordingKind::ByContent => read().is_ok() && RecordingFormat::of(&head) == RecordingFormat::Chapter10,
        }
    }

    /// Whether it is the same file, read alike, and the same manoeuvre of it.
    pub(crate) fn is_same(&self, other: &RecordingSource) -> bool {
        self.manoeuvre == other.manoeuvre && self.is_same_file(other)
    }

    /// Whether it is the same file, read alike.
    pub(crate) fn is_same_file(&self, other: &RecordingSource) -> bool {
        self.kind == other.kind && same_place(&self.file, &other.file)
    }

    /// As a URL.
    pub(crate) fn url(&self) -> OsString {
        let (scheme, format) = match &self.kind {
            RecordingKind::ByContent => ("file://", None),
            RecordingKind::Pcm(format) => ("pcm+file://", Some(format)),
            RecordingKind::Chapter10(format) => ("ch10+file://", format.as_ref()),
        };
        let mut url = OsString::from(scheme);
        url.push(&self.file);
        if let Some(format) = format {
            url.push("?format=");
            url.push(format);
        }
        url
    }

    /// The options that have another process read the same of it.
    pub(crate) fn call(&self) -> Vec<String> {
        let TimeSpan { from_s, to_s } = self.span;
        let times = [("--from", from_s), ("--to", to_s)].into_iter().filter_map(|(option, s)| Some(format!("{option}={}", s?)));
        times.chain(self.set.iter().map(|set| format!("--set={set}"))).collect()
    }

    /// The files that it reads.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let format = match &self.kind {
            RecordingKind::Pcm(format) | RecordingKind::Chapter10(Some(format)) => Some(format),
            RecordingKind::ByContent | RecordingKind::Chapter10(None) => None,
        };
        std::iter::once(&self.file).chain(format).cloned().collect()
    }

    /// What a command reads: any path, or a URL of a recording.
    pub(crate) fn parser() -> impl TypedValueParser<Value = RecordingSource> {
        OsStringValueParser::new().try_map(|argument| match argument.to_str() {
            Some(text) => RecordingSource::of_path_or_url(text),
            None => Ok(RecordingSource::whole(argument.into(), RecordingKind::ByContent)),
        })
    }

    fn of_path_or_url(text: &str) -> Result<Self, String> {
        let Some((scheme, _)) = text.split_once("://") else {
            return Ok(RecordingSource::whole(Path::new(text).into(), RecordingKind::ByContent));
        };
        match text.parse() {
            Ok(TelemetrySource::Recording(recording)) => Ok(recording),
            Err(wrong) if ["file", "pcm+file", "ch10+file"].contains(&scheme) => Err(wrong),
            Ok(TelemetrySource::Link(_) | TelemetrySource::PcmLink { .. } | TelemetrySource::Chapter10Link { .. }) | Err(_) => {
                Err(format!(
                    "expected a recording: a path, file://PATH, pcm+file://PATH?format=FRAME.toml or ch10+file://PATH; found `{}`",
                    text.chars().take(60).collect::<String>()
                ))
            }
        }
    }
}

/// What is noted of a setup by name, at most.
const NOTED: usize = 4;

/// A line where measurements of a setup are not read, with the reasons, and one where something was assumed.
pub(crate) fn note_setup(of: &impl std::fmt::Display, left_out: &[String], assumed: &[String]) {
    for (what, all) in [("not read of its setup", left_out), ("assumed of its setup", assumed)] {
        let Some(named) = all.get(..all.len().min(NOTED)).filter(|named| !named.is_empty()) else { continue };
        let others = match all.len() - named.len() {
            0 => String::new(),
            count => format!("; and {count} more (`inspect` lists them)"),
        };
        message_once(format_args!("note: {of}: {what}: {}{others}", named.join("; ")));
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
    /// A link that brings packets of Chapter 10, and the format of their frames where it is named.
    Chapter10Link { url: Url, format: Option<PathBuf> },
}

impl FromStr for TelemetrySource {
    type Err = String;

    fn from_str(url: &str) -> Result<Self, String> {
        if Url::is_link(url) {
            return Url::parse(url).map(TelemetrySource::Link).map_err(|wrong| wrong.to_string());
        }
        let recording = |file: &str, kind| TelemetrySource::Recording(RecordingSource::whole(file.into(), kind));
        let link = |scheme: &str, address: &str| Url::parse(&format!("{scheme}://{address}")).map_err(|wrong| wrong.to_string());
        // A format that is asked for without a name is none.
        let parts = |rest: &'_ str| match rest.split_once("?format=") {
            None => (rest.to_owned(), None),
            Some((before, format)) => (before.to_owned(), Some(PathBuf::from(format))),
        };
        let whole = |before: &str, format: &Option<PathBuf>| {
            !before.is_empty() && format.as_ref().is_none_or(|format| !format.as_os_str().is_empty())
        };
        match url.split_once("://") {
            Some(("file", path)) if !path.is_empty() => Ok(recording(path, RecordingKind::ByContent)),
            Some((scheme @ ("pcm+udp" | "pcm+tcp"), rest)) => match parts(rest) {
                (address, Some(format)) if !format.as_os_str().is_empty() => {
                    // A ground station listens for datagrams.
                    let url = link(if scheme == "pcm+udp" { "udpin" } else { "tcp" }, &address)?;
                    Ok(TelemetrySource::PcmLink { url, format })
                }
                _ => Err(format!(
                    "expected {scheme}://HOST:PORT?format=FRAME.toml: a stream of PCM needs the format of its frames"
                )),
            },
            Some(("pcm+file", rest)) => match parts(rest) {
                (file, Some(format)) if whole(&file, &Some(format.clone())) => Ok(recording(&file, RecordingKind::Pcm(format))),
                _ => Err("expected pcm+file://PATH?format=FRAME.toml: a stream of PCM needs the format of its frames".to_owned()),
            },
            Some(("ch10+udp", rest)) => match parts(rest) {
                (address, format) if whole(&address, &format) => {
                    Ok(TelemetrySource::Chapter10Link { url: link("udpin", &address)?, format })
                }
                _ => Err("expected ch10+udp://HOST:PORT or ch10+udp://HOST:PORT?format=FILE.toml".to_owned()),
            },
            Some(("ch10+file", rest)) => match parts(rest) {
                (file, format) if whole(&file, &format) => Ok(recording(&file, RecordingKind::Chapter10(format))),
                _ => Err("expected ch10+file://PATH or ch10+file://PATH?format=FILE.toml".to_owned()),
            },
            _ => Err(format!("expected {SOURCES}; found `{}`", url.chars().take(60).collect::<String>())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{RecordingKind, RecordingSource, TelemetrySource};

    #[test]
    fn a_source_is_a_url_of_a_known_kind() {
        let of = |file: &str, kind| TelemetrySource::Recording(RecordingSource::whole(file.into(), kind));
        let chapter10 = |format: Option<&str>| RecordingKind::Chapter10(format.map(Into::into));
        assert_eq!("file://a/b.csv".parse(), Ok(of("a/b.csv", RecordingKind::ByContent)));
        assert_eq!("file:///a b.csv".parse(), Ok(of("/a b.csv", RecordingKind::ByContent)));
        assert_eq!("pcm+file://a.pcm?format=b/c.toml".parse(), Ok(of("a.pcm", RecordingKind::Pcm("b/c.toml".into()))));
        assert_eq!("ch10+file://a.ch10?format=b.toml".parse(), Ok(of("a.ch10", chapter10(Some("b.toml")))));
        assert_eq!("ch10+file://a.ch10".parse(), Ok(of("a.ch10", chapter10(None))));
        for (url, named) in [("ch10+udp://127.0.0.1:1", None), ("ch10+udp://127.0.0.1:1?format=a", Some("a".into()))] {
            assert!(matches!(url.parse(), Ok(TelemetrySource::Chapter10Link { format, .. }) if format == named), "{url}");
        }
        for wrong in ["ch10+udp://", "ch10+udp://127.0.0.1:1?format=", "ch10+file://", "ch10+file://a?format="] {
            assert!(wrong.parse::<TelemetrySource>().unwrap_err().contains("expected ch10+"), "{wrong}");
        }
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
        assert_eq!(source, Ok(RecordingSource::whole("a.csv".into(), RecordingKind::ByContent)));
        assert!(RecordingSource::of_path_or_url("pcm+file://a").is_err());
        assert!(RecordingSource::of_path_or_url("udpin://127.0.0.1:1").unwrap_err().contains("expected a recording"));
        for url in ["file://a/b.csv", "pcm+file://a.pcm?format=b.toml", "ch10+file://a", "ch10+file://a?format=b"] {
            assert_eq!(RecordingSource::of_path_or_url(url).unwrap().url(), url);
        }
        for wrong in ["", "file://", "a.csv", "ftp://x"] {
            let said = wrong.parse::<TelemetrySource>().unwrap_err();
            assert!(said.contains("expected udpin://HOST:PORT") && said.contains("found `"), "{said}");
        }
        assert!(matches!("udpin://127.0.0.1:14550".parse(), Ok(TelemetrySource::Link(_))));
        assert!("udpin://127.0.0.1".parse::<TelemetrySource>().unwrap_err().contains("expected host:port"));
    }
}
