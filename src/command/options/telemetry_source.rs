//! Where telemetry comes from: `--source` of `ingest` and `live`.

use sideslip::io::telemetry::mavlink::link::Url;
use std::path::PathBuf;
use std::str::FromStr;

/// What `--source` accepts, for help and messages.
const SOURCES: &str =
    "udpin://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT, serial://DEVICE?baud=N (MAVLink) or file://PATH (a recording)";

/// Where telemetry comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TelemetrySource {
    /// A recording of any format that is read.
    File(PathBuf),
    /// A link that brings MAVLink.
    Link(Url),
}

impl FromStr for TelemetrySource {
    type Err = String;

    fn from_str(url: &str) -> Result<Self, String> {
        if Url::is_link(url) {
            return Url::parse(url).map(TelemetrySource::Link).map_err(|wrong| wrong.to_string());
        }
        match url.split_once("://") {
            Some(("file", path)) if !path.is_empty() => Ok(TelemetrySource::File(path.into())),
            _ => Err(format!("expected {SOURCES}; found `{}`", url.chars().take(60).collect::<String>())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::TelemetrySource;

    #[test]
    fn a_source_is_a_url_of_a_known_kind() {
        assert_eq!("file://a/b.csv".parse(), Ok(TelemetrySource::File("a/b.csv".into())));
        assert_eq!("file:///a b.csv".parse(), Ok(TelemetrySource::File("/a b.csv".into())));
        for wrong in ["", "file://", "a.csv", "ftp://x"] {
            let said = wrong.parse::<TelemetrySource>().unwrap_err();
            assert!(said.contains("expected udpin://HOST:PORT") && said.contains("found `"), "{said}");
        }
        assert!(matches!("udpin://127.0.0.1:14550".parse(), Ok(TelemetrySource::Link(_))));
        assert!("udpin://127.0.0.1".parse::<TelemetrySource>().unwrap_err().contains("expected host:port"));
    }
}
