//! `sideslip convert`: a recording of any format that is read, written as a run file (CSV) or a log (MCAP).

mod clock_merge;
mod row_writer;

use super::options::mapping_input::{CONFIG_HELP, MapOption, read_mapping};
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::PartOptions;
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_run;
use super::recordings::provenance::Provenance;
use super::recordings::run_head::{HeadedRecording, head_of, head_with};
use super::terminal::output_file::{refuse_to_overwrite, refuse_without_folder};
use crate::command::message;
use clock_merge::{ClockOptions, SecondRecording};
use row_writer::RowWriter;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::file::log_head::LogHead;
use sideslip::io::outputs::words::control_scale::assumed_scale;
use sideslip::io::telemetry::alignment::aligned_recording::AlignedRecording;
use sideslip::io::telemetry::record::RecordingRow;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "\
Examples:
  sideslip convert flight.tlog from-tlog.csv
  sideslip convert 00000012.BIN flight.mcap --from 30 --to 95
  sideslip convert 'pcm+file://flight.pcm?format=frame.toml' flight.mcap
  sideslip convert day.csv second.csv --manoeuvre 2
  sideslip convert flight.ch10 flight.csv --config measurements.toml
  sideslip convert flight.csv both.csv --merge radar.csv --shared altitude
  sideslip convert flight.csv both.csv --merge radar.csv --clock-offset 12.25 --clock-drift 0

With --merge, rows of a second recording with a clock of its own are put among those of the first, on the first one's clock;
columns that both have keep the values of the first. Offset and drift of the clocks are estimated by cross-correlation of the
shared channel and printed with their standard errors; where the recordings do not determine them nothing is written.

Exit status: 0 done; 1 failed while running; 2 the call or a recording is wrong, or the output exists; 3 done, with data lost
or skipped (said how much); 4 the relation of the clocks is not known.";

/// Convert a recording to a run file (CSV) or a log (MCAP), or merge a second recording into it
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct ConvertArgs {
    /// The recording; its format is recognised by its content. A stream of PCM is pcm+file://PATH?format=FRAME.toml,
    /// IRIG 106 Chapter 10 whose setup does not name the channels ch10+file://PATH?format=FILE.toml
    #[arg(value_name = "IN", value_parser = RecordingSource::parser())]
    input: RecordingSource,
    /// Where it goes: a run file (.csv) or a log (.mcap), by the name
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML)
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    config: Option<PathBuf>,
    #[command(flatten)]
    map: MapOption,
    /// Override a key of the run, such as vane_position_m=[13.08,0,0] or latency_s={tas=0.25} (channels stamped late, s);
    /// repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    parts: PartOptions,
    #[command(flatten)]
    clock: ClockOptions,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Reads, merges where that is asked for, and writes; the output is there whole or not at all.
pub(crate) fn run(args: &ConvertArgs) -> Result<Outcome, Failure> {
    let format = row_writer::RowFormat::by_name(&args.output)?;
    refuse_without_folder("OUT", &args.output)?;
    let read = args.input.files().into_iter().chain(args.clock.files()).collect::<Vec<_>>();
    refuse_to_overwrite("OUT", &args.output, &read)?;
    args.replace.refuse("OUT", &args.output)?;
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let input = chosen_run(&args.input, &args.parts, &args.set, &mapping)?;
    let recording = input.open_with_note(&mapping)?;
    let mut second = match args.clock.second(&args.input, &mapping)? {
        SecondRecording::None => None,
        SecondRecording::Related(second) => Some(second),
        SecondRecording::Unknown => return Ok(Outcome::NotGood),
    };
    let HeadedRecording { mut recording, info, .. } = head_of(&input, recording)?;
    if let Some(note) = assumed_scale(&info) {
        message(format_args!("note: {}: {note}", input.file.display()));
    }
    let own_columns = recording.recording.columns();
    let (mut merge, columns) = match &second {
        None => (None, own_columns.to_vec()),
        Some(second) => {
            let merge = second.merge(own_columns);
            let columns = merge.columns().to_vec();
            (Some(merge), columns)
        }
    };
    let mut writer = {
        let origin = Provenance::of(read).dated(&args.input.file, info.recorded_at()).origin();
        let head = LogHead { origin, ..head_with(&info, &columns) };
        RowWriter::begin(format, &args.output, &info, head, &columns)?
    };
    let (mut written, mut no_time) = (0_u64, 0_u64);
    let mut order = TimeOrder::default();
    let mut each = |row: &RecordingRow| {
        if !row.sample.time_s.is_finite() {
            no_time += 1;
            Ok(())
        } else if input.span.has(row.sample.time_s) {
            written += 1;
            order.put(row.sample.time_s);
            writer.row(row)
        } else {
            // Of the second recording.
            Ok(())
        }
    };
    match (&mut merge, &mut second) {
        (Some(merge), Some(second)) => {
            while let Some(row) = merge.next_row(&mut recording, &mut second.recording)? {
                each(row)?;
            }
        }
        _ => {
            while let Some(row) = recording.next_row()? {
                each(row)?;
            }
        }
    }
    if written == 0 {
        return Err(Failure::file(&args.input.file, "expected rows with a time, found none"));
    }
    writer.end()?;
    message(format_args!("{}: {written} samples", args.output.display()));
    let mut lost = losses(&args.input.file, &recording);
    if no_time > 0 {
        lost.push(format!("{}: {no_time} rows without a time left out", args.input.file.display()));
    }
    lost.extend(order.said(&args.output));
    if let (Some(merge), Some(second)) = (&merge, &second) {
        lost.extend(losses(&second.file, &second.recording));
        let tally = merge.tally();
        let refused: u64 = tally.no_time.iter().chain(&tally.not_growing).sum();
        if refused > 0 {
            lost.push(format!("{refused} rows whose time does not grow are left out"));
        }
    }
    lost.iter().for_each(|loss| message(format_args!("sideslip: {loss}")));
    Ok(if lost.is_empty() { Outcome::Done } else { Outcome::DataLost })
}

/// Whether the rows that are written are in order of time.
#[derive(Debug, Default)]
struct TimeOrder {
    newest_s: Option<f64>,
    not_growing: u64,
}

impl TimeOrder {
    fn put(&mut self, time_s: f64) {
        self.not_growing += u64::from(self.newest_s.is_some_and(|newest_s| time_s <= newest_s));
        self.newest_s = Some(self.newest_s.map_or(time_s, |newest_s| newest_s.max(time_s)));
    }

    /// Rows as they came, where they are not: nothing is put in order unasked.
    fn said(&self, output: &Path) -> Option<String> {
        let (count, output) = (self.not_growing, output.display());
        (count > 0).then(|| {
            format!(
                "{output}: {count} rows whose time does not grow, as in the recording; --set 'latency_s={{}}' puts them in order"
            )
        })
    }
}

/// What of a recording could not be read, in words.
fn losses(file: &Path, aligned: &AlignedRecording) -> Vec<String> {
    let (skipped, name) = (aligned.recording.skipped().rows(), file.display());
    let rows = (skipped > 0).then(|| format!("{name}: {skipped} rows skipped"));
    rows.into_iter().chain(aligned.losses().iter().map(|what| format!("{name}: {what}"))).collect()
}
