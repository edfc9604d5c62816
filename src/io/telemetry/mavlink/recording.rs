//! A tlog or a raw stream of frames as a recording: counts of its senders, and the samples of the vehicle row by row.
//!
//! Consumes a file in two passes: the first counts senders and determines the vehicle and its channels, the second reads the
//! samples. Produces [`RecordingRow`]s in order of time. Each boot is a segment placed after the one before, counted in the
//! column `boot`. Refused: a file in which no sender transmits motion.

use super::mapping::MavlinkConfig;
use super::message::{MessageBody, MessageKind, MessageReading};
use super::packet::{FrameTally, Framing, Packet};
use super::senders::{Sender, Senders};
use super::stream::{UnusedMessages, VehicleStream, admits};
use super::tlog::PacketReader;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::file::run_file::{RecordingColumn, RunInfo};
use crate::flight::file::time_stamp::TimeStamp;
use crate::flight::sample::Sample;
use crate::io::telemetry::record::{RecordingError, RecordingRow, SkippedByReason};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// What the first reading of the file showed.
#[derive(Clone, Debug)]
pub struct Traffic {
    /// Who sent what.
    pub senders: Senders,
    /// Frames and damage.
    pub tally: FrameTally,
    /// Who is the vehicle.
    pub vehicle: Sender,
    /// How often the vehicle booted, at least once.
    pub boots: u32,
}

/// A file of MAVLink that is being read.
#[derive(Debug)]
pub struct MavlinkRecording {
    path: PathBuf,
    framing: Framing,
    reader: PacketReader<File>,
    stream: VehicleStream,
    traffic: Traffic,
    info: RunInfo,
    columns: Vec<RecordingColumn>,
    row: RecordingRow,
    rows: u64,
    skipped: SkippedByReason,
    ended: bool,
}

/// What one sender could bring.
#[derive(Default)]
struct SenderCandidate {
    channels: u32,
    stream: Option<Box<VehicleStream>>,
}

/// A host's clock that was never set is before it: 2000-01-01, us since 1970.
const YEAR_2000_US: u64 = 946_684_800_000_000;

impl MavlinkRecording {
    /// Reads the file once to see who is in it; `path` is named in messages only.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or nobody (or not the one that the configuration names) sends motion.
    pub fn new(path: &Path, mut file: File, framing: Framing, config: MavlinkConfig) -> Result<Self, RecordingError> {
        let io = |source| RecordingError::Io { path: path.into(), source };
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        let mut reader = PacketReader::new(&mut file, framing);
        let mut senders = Senders::default();
        let mut candidates: BTreeMap<Sender, SenderCandidate> = BTreeMap::new();
        let mut sticks = BTreeMap::new();
        let mut first_us = None;
        while let Some(packet) = reader.next_packet().map_err(io)? {
            if let Some(gone) = senders.count(&packet) {
                candidates.remove(&gone);
            }
            let sender = Sender::of(&packet);
            first_us = first_us.or(packet.stamp_us);
            if senders.of(sender).is_some() && admits(&config, sender) {
                candidates.entry(sender).or_default().take(&packet, sender, &config);
            }
            if let Some(reading @ MessageReading { body: MessageBody::Sticks { target, .. }, .. }) = MessageReading::of(&packet) {
                *sticks.entry(target).or_insert(0) |= config.channels(&reading);
            }
        }
        let tally = reader.tally();
        let vehicle = senders.vehicle(|sender| admits(&config, sender)).ok_or_else(|| {
            let (messages, who) = (senders.total(), senders.iter().map(|(sender, _)| sender.to_string()));
            let who: Vec<String> = who.take(8).collect();
            whole(format!(
                "expected messages of motion (inertial or attitude) of a vehicle, found none in {messages} messages of {}",
                if who.is_empty() { "nobody".to_owned() } else { who.join(", ") }
            ))
        })?;
        let found = candidates.remove(&vehicle).unwrap_or_default();
        let boots = found.stream.map_or(1, |stream| stream.clock().boots().max(1));
        let directed = [0, vehicle.system].iter().filter_map(|target| sticks.get(target)).fold(0, |all, one| all | one);
        let fixed_wing = senders.of(vehicle).is_some_and(|tally| tally.fixed_wing);
        let told = if fixed_wing { ControlNames::FixedWing } else { ControlNames::Rotorcraft };
        let controls = config.names.unwrap_or(told);
        let columns = columns(found.channels | directed, controls, boots).map_err(whole)?;
        let others = columns.iter().filter(|column| column.name == "boot").count();
        let mut info =
            RunInfo::from_toml(&format!("source = \"{}\"\n", vehicle.as_source())).map_err(|place| whole(place.to_string()))?;
        info.set_controls(controls);
        let came = Channel::CONTROLS.map(|channel| (found.channels | directed) & (1 << channel.index()) != 0);
        let assumed = config.assumed_scale();
        info.set_assumed_scale(core::array::from_fn(|place| came[place] && assumed[place]));
        if let Some(at) = first_us.filter(|us| *us >= YEAR_2000_US).and_then(|us| TimeStamp::of_unix_us(us).iso()) {
            info.add_text("recorded_at", &at);
        }
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        Ok(MavlinkRecording {
            path: path.into(),
            framing,
            reader: PacketReader::new(file, framing),
            stream: VehicleStream::new(config, Some(vehicle)),
            traffic: Traffic { senders, tally, vehicle, boots },
            info,
            columns,
            row: RecordingRow { number: 0, sample: Sample::new(0.0), others: vec![None; others] },
            rows: 0,
            skipped: SkippedByReason::default(),
            ended: false,
        })
    }

    /// The format in a word.
    pub fn format(&self) -> &'static str {
        match self.framing {
            Framing::Stamped => "MAVLink tlog",
            Framing::Bare => "MAVLink stream",
        }
    }

    /// Who sent what, and how it came.
    pub fn traffic(&self) -> &Traffic {
        &self.traffic
    }

    /// What the run says of itself.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The time, the vehicle's channels in the order of their places, and `boot` where there are several.
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// No row is skipped: what is damaged is no row yet.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// What of the file could not be read or used, in words; complete after the last row.
    pub fn shortfall(&self) -> Option<String> {
        passed_over(self.traffic.tally, self.stream.unused())
    }

    /// The next sample of the vehicle; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or no message of the vehicle makes a sample.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        loop {
            if let Some(timed) = self.stream.next_sample() {
                self.rows += 1;
                self.row.number = self.rows;
                self.row.sample = timed.sample;
                self.row.others.iter_mut().for_each(|boot| *boot = Some(f64::from(timed.boot)));
                return Ok(Some(&self.row));
            }
            if self.ended {
                break;
            }
            match self.reader.next_packet().map_err(|source| RecordingError::Io { path: self.path.clone(), source })? {
                Some(packet) => self.stream.packet(&packet, packet.stamp_us),
                None => {
                    self.stream.flush();
                    self.ended = true;
                }
            }
        }
        if self.rows == 0 {
            let what = format!("expected samples of sender {}, found none whose time is known", self.traffic.vehicle);
            return Err(RecordingError::Whole { path: self.path.clone(), what });
        }
        Ok(None)
    }
}

impl SenderCandidate {
    fn take(&mut self, packet: &Packet, sender: Sender, config: &MavlinkConfig) {
        let Some(reading) = MessageReading::of(packet) else { return };
        if reading.kind != MessageKind::ManualControl {
            self.channels |= config.channels(&reading);
        }
        // The stream is run for its clock only; its samples are let go.
        let stream = self.stream.get_or_insert_with(|| Box::new(VehicleStream::new(config.clone(), Some(sender))));
        stream.packet(packet, packet.stamp_us);
        while stream.next_sample().is_some() {}
    }
}

/// What was damaged or not used, in words; `None` where there was nothing.
pub fn passed_over(tally: FrameTally, unused: UnusedMessages) -> Option<String> {
    let FrameTally { bad_checksum, garbage_bytes, first_damage_at, .. } = tally;
    let UnusedMessages { late, in_doubt, no_clock, overrun } = unused;
    let mut parts = Vec::new();
    if bad_checksum > 0 {
        parts.push(format!("{bad_checksum} frames with a wrong checksum"));
    }
    if garbage_bytes > 0 {
        parts.push(format!("{garbage_bytes} bytes that belong to no frame"));
    }
    if let Some((damage, at)) = parts.first_mut().zip(first_damage_at) {
        *damage = format!("{damage} (the first damage is at byte {at})");
    }
    for (count, what) in [
        (late, "messages of the vehicle too late for their place"),
        (in_doubt, "whose time contradicts the others"),
        (no_clock, "before its clock was known"),
        (overrun, "that nobody took in time"),
    ] {
        if count > 0 {
            parts.push(format!("{count} {what}"));
        }
    }
    (!parts.is_empty()).then(|| format!("passed over: {}", parts.join(", ")))
}

fn columns(channels: u32, controls: ControlNames, boots: u32) -> Result<Vec<RecordingColumn>, String> {
    let mut columns = vec![RecordingColumn::new("time", None)?];
    for channel in Channel::ALL.into_iter().filter(|channel| channels & (1 << channel.index()) != 0) {
        columns.push(RecordingColumn::new(channel.name(controls), None)?);
    }
    if boots > 1 {
        columns.push(RecordingColumn::new("boot", None)?);
    }
    Ok(columns)
}
