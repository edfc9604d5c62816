//! `--mavlink-out`: estimates to a ground station, of `estimate` and `live`.

use super::signing_input::{STATION_LINK, link_signing};
use crate::command::message;
use sideslip::error::Failure;
use sideslip::io::ground_station::station::{GroundStation, StationReport, StationSettings};
use sideslip::io::telemetry::mavlink::link::Url;
use std::path::Path;
use std::time::Duration;

/// The longest wait for a link that takes the last messages slowly.
const LAST_WORDS: Duration = Duration::from_secs(3);

#[derive(clap::Args, Clone, Debug)]
pub(crate) struct MavlinkOutOptions {
    /// Send the estimates to a ground station: udpout://HOST:PORT, udpin://HOST:PORT, tcp://HOST:PORT or
    /// serial://DEVICE?baud=N; as HEARTBEAT of an onboard computer, NAMED_VALUE_FLOAT and STATUSTEXT, and nothing else
    #[arg(long, value_name = "URL", value_parser = url)]
    pub(crate) mavlink_out: Option<Url>,
    /// System id of what is sent there, 1 to 255; by default that of the vehicle
    #[arg(long, value_name = "ID", requires = "mavlink_out", value_parser = clap::value_parser!(u8).range(1..))]
    mavlink_system: Option<u8>,
}

fn url(text: &str) -> Result<Url, String> {
    Url::parse(text).map_err(|wrong| wrong.to_string())
}

impl MavlinkOutOptions {
    /// The same options for another process.
    pub(crate) fn call(&self) -> Vec<String> {
        let mut call = Vec::new();
        if let Some(url) = &self.mavlink_out {
            call.extend(["--mavlink-out".to_owned(), url.to_string()]);
        }
        if let Some(system) = self.mavlink_system {
            call.extend(["--mavlink-system".to_owned(), system.to_string()]);
        }
        call
    }

    /// Starts sending, signed with the key of that file; `None` where nothing was asked for.
    pub(crate) fn start(&self, key: Option<&Path>) -> Result<Option<GroundStation>, Failure> {
        let Some(url) = &self.mavlink_out else { return Ok(None) };
        let signing = key.map(|key| link_signing(key, STATION_LINK)).transpose()?;
        let settings = StationSettings { url: url.clone(), system: self.mavlink_system, signing };
        let say = Box::new(|line: &str| message(format_args!("sideslip: {line}")));
        let started = GroundStation::start(settings, say);
        started.map(Some).map_err(|error| Failure::Running(format!("no thread could be started: {error}")))
    }

    /// Ends it, and says what was sent and what was not.
    pub(crate) fn finish(&self, station: GroundStation) -> String {
        let url = self.mavlink_out.as_ref().map(Url::to_string).unwrap_or_default();
        match station.finish(LAST_WORDS) {
            None => format!("{url} holds up the last messages: they are not sent"),
            Some(report) => sentence(&url, report),
        }
    }
}

fn sentence(url: &str, report: StationReport) -> String {
    let StationReport { sent, refused, unsigned, lost, texts_dropped } = report;
    let mut parts = vec![format!("{sent} messages sent to {url}")];
    for (count, what) in [
        (refused, "not sent, for nobody was there to take them"),
        (unsigned, "not sent, for they could not be signed"),
        (lost, "records dropped on the way"),
        (texts_dropped, "texts dropped for their number"),
    ] {
        if count > 0 {
            parts.push(format!("{count} {what}"));
        }
    }
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_sent_is_said() {
        let all = StationReport { sent: 9, refused: 2, unsigned: 3, lost: 4, texts_dropped: 5 };
        let said = sentence("udpout://h:1", all);
        assert_eq!(
            said,
            "9 messages sent to udpout://h:1, 2 not sent, for nobody was there to take them, 3 not sent, for they could not be \
             signed, 4 records dropped on the way, 5 texts dropped for their number"
        );
        assert_eq!(sentence("u", StationReport::default()), "0 messages sent to u");
    }
}
