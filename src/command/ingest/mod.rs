//! `sideslip ingest`: telemetry into shared memory, from a recording or a link.

mod args;
mod chapter10_link_source;
mod link_source;
mod notice_words;
mod pcm_link_source;
mod recording_source;
mod row_publisher;
mod sample_publisher;
mod silence_monitor;
mod vehicle_file;

use super::options::telemetry_source::TelemetrySource;
use super::terminal::stop::{stopped_by_signals, supervised};
pub(crate) use args::IngestArgs;
use sideslip::error::{Failure, Outcome};

/// Publishes the source to its end, or until it is stopped.
pub(crate) fn run(args: &IngestArgs) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    supervised(args.supervised, &stop)?;
    if args.map.map.is_some() && !matches!(args.source, TelemetrySource::Recording(_)) {
        return Err(Failure::Input("--map: expected with a recording (file://PATH), found a link".into()));
    }
    if args.parts.any() && !matches!(args.source, TelemetrySource::Recording(_)) {
        return Err(Failure::Input("--from, --to, --manoeuvre: expected with a recording (file://PATH), found a link".into()));
    }
    match &args.source {
        TelemetrySource::Recording(_) | TelemetrySource::PcmLink { .. } | TelemetrySource::Chapter10Link { .. }
            if args.signing_key.is_some() =>
        {
            Err(Failure::Input(
                "--signing-key: expected with a link of MAVLink; PCM has no signatures, those of a recording are not verified"
                    .into(),
            ))
        }
        TelemetrySource::Recording(source) => recording_source::play(args, source, &stop),
        TelemetrySource::PcmLink { url, format } => pcm_link_source::listen(args, url, format, &stop),
        TelemetrySource::Chapter10Link { url, format } => chapter10_link_source::listen(args, url, format.as_deref(), &stop),
        TelemetrySource::Link(url) => link_source::listen(args, url, &stop),
    }
}
