//! A recording onto the bus, paced by its own time stamps.

use super::args::IngestArgs;
use super::sample_publisher::SamplePublisher;
use crate::command::options::mapping_input::read_mapping;
use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::chosen_runs::chosen_run;
use crate::command::recordings::provenance::Provenance;
use crate::command::recordings::run_head::{HeadedRecording, head_of};
use crate::command::{message, patience, root_path};
use ::replay::{MonotonicClock, Pace, Player};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::Channel;
use sideslip::flight::file::log_head::LogHead;
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::payload::OTHERS;
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::{playing_since, write_head};
use sideslip::io::bus::service::Bus;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Leaves out the columns that a sample on the bus has no place for, and says so.
pub(super) fn fitted(mut head: LogHead) -> LogHead {
    let (mut others, all) = (0, head.unknown_columns());
    head.channels.retain(|(name, _)| {
        let known = Channel::from_name(name).is_some();
        others += usize::from(!known);
        known || others <= OTHERS
    });
    if all > OTHERS {
        message(format_args!("sideslip: {} of {all} columns without meaning here are left out: {OTHERS} fit", all - OTHERS));
    }
    head
}

/// Plays it to its end, or until it is stopped.
pub(super) fn play(args: &IngestArgs, source: &RecordingSource, stop: &Arc<AtomicBool>) -> Result<Outcome, Failure> {
    let file = &source.file;
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let source = &chosen_run(source, &args.parts, &args.set, &mapping)?;
    let mut recording = source.open_with_note(&mapping)?;
    recording.stop_by(Arc::clone(stop));
    let HeadedRecording { mut recording, info, mut head } = head_of(source, recording)?;
    head.origin = Provenance::of(source.files()).dated(file, info.recorded_at()).origin();
    let mut bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take_within(BusRole::Telemetry, patience(args.supervised))?;
    write_head(bus.root(), bus.incarnation(), &fitted(head))?;
    let mut publisher = SamplePublisher::new(&bus, args.lossless || args.speed == Pace::Max)?;
    let mut player = Player::<MonotonicClock>::new(args.speed);
    let played_s = played_before(args, &bus)?;
    let mut missed = 0_u64;
    let mut first_s = None;
    let mut newest_s = 0.0;
    while let Some(row) = recording.next_row()? {
        let time_s = row.sample.time_s;
        if time_s.is_finite() && time_s - *first_s.get_or_insert(time_s) < played_s {
            missed += 1;
            continue;
        }
        if !player.wait_for(time_s, || !stop.load(Ordering::Relaxed))
            || !publisher.sample(&row.sample, &row.others, None, stop)?
        {
            break;
        }
        if time_s.is_finite() {
            newest_s = time_s;
        }
    }
    publisher.end(newest_s, stop)?;
    let recorded = &recording.recording;
    let skipped = recorded.skipped().rows();
    let mut outcome = Outcome::Done;
    if missed > 0 {
        message(format_args!("sideslip: {missed} samples came while no telemetry was running"));
        outcome = Outcome::DataLost;
    }
    let tally = recording.tally().unwrap_or_default();
    let (lost, noted) = (tally.losses(), tally.notes());
    for what in lost.iter().chain(&noted) {
        message(format_args!("sideslip: {}: {what}", file.display()));
    }
    if !lost.is_empty() {
        outcome = Outcome::DataLost;
    }
    if skipped > 0 || recorded.shortfall().is_some() {
        let short = recorded.shortfall().map(|what| format!("; {what}")).unwrap_or_default();
        message(format_args!("sideslip: {}: {skipped} rows skipped{short}", file.display()));
        outcome = Outcome::DataLost;
    }
    Ok(outcome)
}

/// How much of the recording had been due before now, s of its own time: as with a live source, it is gone.
fn played_before(args: &IngestArgs, bus: &Bus) -> Result<f64, Failure> {
    let factor = match args.speed {
        Pace::RealTime => 1.0,
        Pace::Factor(factor) => factor,
        Pace::Max => return Ok(0.0),
    };
    if !args.resume {
        return Ok(0.0);
    }
    let now_ns = monotonic_ns();
    let since_ns = playing_since(bus.root(), now_ns)?;
    Ok(Duration::from_nanos(now_ns.saturating_sub(since_ns)).as_secs_f64() * factor)
}
