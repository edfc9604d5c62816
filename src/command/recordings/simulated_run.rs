//! A simulated flight as a recording, by the name of the file; whole or not at all: a run file in text, a log, MAVLink, a log of
//! an autopilot, a stream of PCM with the format of its frames beside it.

use super::provenance::Provenance;
use crate::command::message;
use crate::command::terminal::output_file::{OutputFile, write_whole};
use sideslip::error::Failure;
use sideslip::flight::channel::{CHANNELS, Channel};
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::file::run_file::{RunFileWriter, RunInfo};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::log::mcap_log::McapLog;
use sideslip::io::telemetry::logs::encode::LogEncodeError;
use sideslip::io::telemetry::logs::encode::sample_dataflash::dataflash_of_samples;
use sideslip::io::telemetry::logs::encode::sample_rates::not_carried;
use sideslip::io::telemetry::logs::encode::sample_ulog::ulog_of_samples;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME, NOT_CARRIED};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::io::telemetry::mavlink::tlog::write_record;
use sideslip::io::telemetry::pcm::sample_stream::stream_of_samples;
use std::path::{Path, PathBuf};

/// The kind of recording that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RunFormat {
    /// A run file in text.
    Csv,
    /// A log, of samples only.
    Mcap,
    /// MAVLink frames behind time stamps.
    Tlog,
    /// A log of ArduPilot.
    Dataflash,
    /// A log of PX4.
    Ulog,
    /// A stream of PCM.
    Pcm,
}

impl RunFormat {
    /// The format that the ending of the name asks for.
    pub(crate) fn by_name(path: &Path) -> Result<Self, Failure> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "csv" => Ok(RunFormat::Csv),
            "mcap" => Ok(RunFormat::Mcap),
            "tlog" => Ok(RunFormat::Tlog),
            "bin" => Ok(RunFormat::Dataflash),
            "ulg" => Ok(RunFormat::Ulog),
            "pcm" => Ok(RunFormat::Pcm),
            _ => Err(Failure::file(path, "expected a name that ends in .csv, .mcap, .tlog, .bin, .ulg or .pcm")),
        }
    }

    /// The files that a run of that name takes.
    pub(crate) fn files(self, path: &Path) -> Vec<PathBuf> {
        let beside = (self == RunFormat::Pcm).then(|| format_beside(path));
        std::iter::once(path.into()).chain(beside).collect()
    }
}

/// Where the format of a stream's frames stands: `run.pcm.toml` beside `run.pcm`.
fn format_beside(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".toml");
    name.into()
}

/// Writes the channels that any sample carries.
pub(crate) fn write_run(
    path: &Path,
    format: RunFormat,
    info: &RunInfo,
    samples: &[Sample],
    provenance: &Provenance,
) -> Result<(), Failure> {
    let present = samples.iter().fold(0, |present, sample| present | sample.present);
    let channels: Vec<Channel> = Channel::ALL.into_iter().filter(|channel| present & (1 << channel.index()) != 0).collect();
    match format {
        RunFormat::Csv => write_whole(path, |file| {
            let mut writer = RunFileWriter::new(file, info, &channels)?;
            samples.iter().try_for_each(|sample| writer.write_row(sample.time_s, |channel| sample.get(channel)))?;
            writer.finish().map(|_| ())
        }),
        RunFormat::Mcap => write_log(path, info, &channels, samples, provenance),
        RunFormat::Tlog => write_tlog(path, info, &channels, samples),
        RunFormat::Dataflash => {
            let log = dataflash_of_samples(samples, info.geometry().controls, &about(info));
            note_left_out("ArduPilot logs", path, info, &not_carried(&channels, &[]));
            note_geometry("ArduPilot logs", path, info.geometry());
            write_bytes(path, log)
        }
        RunFormat::Ulog => {
            let log = ulog_of_samples(samples, info.geometry().controls, &about(info));
            note_left_out("PX4 logs", path, info, &not_carried(&channels, &[Channel::Rho]));
            note_geometry("PX4 logs", path, info.geometry());
            write_bytes(path, log)
        }
        RunFormat::Pcm => write_pcm(path, info, samples),
    }
}

/// What the flight is, in a line for people.
fn about(info: &RunInfo) -> String {
    format!("simulated: {}", info.aircraft().unwrap_or_default())
}

fn write_bytes(path: &Path, bytes: Result<Vec<u8>, LogEncodeError>) -> Result<(), Failure> {
    let bytes = bytes.map_err(|wrong| Failure::file(path, wrong))?;
    write_whole(path, |file| file.write_all(&bytes))
}

fn write_pcm(path: &Path, info: &RunInfo, samples: &[Sample]) -> Result<(), Failure> {
    let stream = stream_of_samples(samples, info.geometry().controls, info.document());
    let stream = stream.map_err(|wrong| Failure::file(path, wrong))?;
    let format = format_beside(path);
    write_whole(path, |file| file.write_all(&stream.line))?;
    write_whole(&format, |file| file.write_all(stream.format.as_bytes())).inspect_err(|_| {
        // A stream without its format is no recording.
        let _ = std::fs::remove_file(path);
    })?;
    message(format_args!("its frames: {}; read as 'pcm+file://{}?format={0}'", format.display(), path.display()));
    if let Some(start_s) = samples.first().map(|sample| sample.time_s).filter(|start_s| libm::fabs(*start_s) > 0.0) {
        message(format_args!("note: a stream of PCM begins at 0 s; this flight began at {start_s} s"));
    }
    Ok(())
}

fn note_left_out(what: &str, path: &Path, info: &RunInfo, channels: &[Channel]) {
    let names: Vec<&str> = channels.iter().map(|channel| channel.name(info.geometry().controls)).collect();
    if !names.is_empty() {
        message(format_args!("note: {what} carry no {}; left out of {}", names.join(", "), path.display()));
    }
}

/// Where the instruments stand is a key of the run, which that format has no place for.
fn note_geometry(what: &str, path: &Path, geometry: &RunGeometry) {
    let RunGeometry { accelerometer_position_m, vane_position_m, blades, controls: _ } = *geometry;
    let position =
        |key: &str, [x, y, z]: [f64; 3]| [x, y, z].iter().any(|m| *m != 0.0).then(|| format!("--set {key}=[{x},{y},{z}]"));
    let lost = [
        position("accelerometer_position_m", accelerometer_position_m),
        position("vane_position_m", vane_position_m),
        blades.map(|blades| format!("--set blades={blades}")),
    ];
    let lost: Vec<String> = lost.into_iter().flatten().collect();
    if !lost.is_empty() {
        message(format_args!(
            "note: {what} do not say how the aircraft is instrumented; commands that read {} need {}",
            path.display(),
            lost.join(" ")
        ));
    }
}

fn write_log(
    path: &Path,
    info: &RunInfo,
    channels: &[Channel],
    samples: &[Sample],
    provenance: &Provenance,
) -> Result<(), Failure> {
    let controls = info.geometry().controls;
    let named = channels.iter().map(|channel| (channel.name(controls).to_owned(), channel.si_unit().to_owned()));
    let origin = provenance.origin();
    let head = LogHead { run_toml: info.to_toml(), channels: named.collect(), controls, origin };
    let output = OutputFile::beside(path)?;
    let created = McapLog::create(output.place(), head, Box::new(|_| ()));
    let mut log = created.map_err(|error| Failure::Running(error.to_string()))?.one_file();
    for sample in samples {
        log.sample(sample, &[]);
    }
    close_whole(log, &output)?;
    output.keep()
}

/// Closes a log of one file that is to be whole or not at all: a fault is a failure, in which the file has its last name.
pub(crate) fn close_whole(log: McapLog, output: &OutputFile) -> Result<(), Failure> {
    let summary = log.close();
    let Some(fault) = summary.faults.first() else { return Ok(()) };
    let [place, target] = [output.place(), output.target()].map(|path| path.display().to_string());
    Err(Failure::Running(fault.replace(&place, &target)))
}

/// When the first sample of every simulated tlog was received, us since 1970 (2026-01-01 UTC): no clock is read, so that
/// the same flight gives the same bytes.
const TLOG_START_US: u64 = 1_767_225_600_000_000;

/// Each frame is stamped with the time of its sample. What MAVLink does not carry is left out, and it is said.
fn write_tlog(path: &Path, info: &RunInfo, channels: &[Channel], samples: &[Sample]) -> Result<(), Failure> {
    let controls = info.geometry().controls;
    let mut encoder = Encoder::new(ME, MavlinkConfig::default(), controls);
    let mut records = Vec::new();
    let refused = |time_s: f64, what: &dyn std::fmt::Display| Failure::file(path, format_args!("at {time_s} s: {what}"));
    for sample in samples {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the encoder refuses what is no time")]
        let stamp_us = TLOG_START_US.saturating_add(libm::round(sample.time_s * 1e6) as u64);
        let mut written = Ok(());
        let frames = encoder.sample(sample, |frame| {
            if written.is_ok() {
                written = write_record(&mut records, stamp_us, frame);
            }
        });
        frames.map_err(|wrong| refused(sample.time_s, &wrong))?;
        written.map_err(|error| Failure::io(path, &error))?;
    }
    let left_out: Vec<Channel> = NOT_CARRIED.into_iter().filter(|channel| channels.contains(channel)).collect();
    note_left_out("messages of MAVLink", path, info, &left_out);
    note_geometry("messages of MAVLink", path, info.geometry());
    write_whole(path, |file| file.write_all(&records))
}

const _: () = assert!(CHANNELS <= 32, "a sample's presence has 32 bits");
