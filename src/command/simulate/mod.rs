//! `sideslip simulate`: a model flown on given controls, recorded as a run file.

use super::options::flight_condition::{FlightCondition, number};
use super::options::instrument_input::read_instruments;
use super::options::mapping_input::{MapOption, read_mapping};
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::PartOptions;
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_run;
use super::recordings::flown_inputs::{
    inputs_of_run, inputs_of_specs, warn_of_stall, warn_of_still_rotor, warn_of_unread_channels,
};
use super::recordings::provenance::Provenance;
use super::recordings::run_controls::read_controls;
use super::recordings::simulated_run::{RunFormat, write_run};
use super::terminal::output_file::{refuse_to_overwrite, refuse_without_folder};
use crate::command::message;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::effect::Effect;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::simulation::flight_model::FlightModel;
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::{HAND_RATE, InputSpec};
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::instrument_file::InstrumentFile;
use sideslip::simulation::pilot::Pilot;
use sideslip::simulation::turbulence::MEDIUM_HEIGHT_LENGTH_M;
use std::fmt::Write as _;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  sideslip simulate --model puma --input pedal:doublet:0.02:1.0 --noise --out run.csv
  sideslip simulate --model puma --speed 51.44 --climb 5.08 --density 1.024 --set hub=exact \
--input pedal:3211:0.02:0.7 --out climb.csv
  sideslip simulate --model puma-100kn.toml --input pedal:3211:0.02:0.7 --noise flight --seed 1 --out run.csv
  sideslip simulate --model puma --input pedal:prbs6:0.02:0.5 --pilot attitude --turbulence 1 --instruments flight-test.toml \
--out run.mcap
  sideslip simulate --model puma --input pedal:3211:0.02:0.7 --noise --rate 250 --out run.ulg

A log of an autopilot has its inertial measurements as fast as they were simulated (ArduPilot 400 Hz, PX4 250 Hz at most), the
other messages at 50 Hz at most; its parameters SIDESLIP_... state the scale of the controls, which replay takes.

--set also takes the keys of the run, such as vane_position_m=[13.08,0,0] or accelerometer_position_m=[..] (where the instruments
stand, in the flight too). A level1 model flies in air of one density; it starts at the altitude where the standard atmosphere has
that density (a linear model at 1000 m). The recording holds the flight condition and options it was flown with: see `inspect`.

An instruments file (TOML) says what differs from flight-test quality; every key may be left out:
  rate_hz = 100                           of every channel without its own rate, Hz
  accelerometer_position_m = [0.4, 0, -0.2]    where they stand, from the centre of mass; also vane_position_m
  [channel.p]                             one table a channel, in its SI unit
  rate_hz = 256                           rows at its own times
  noise = 0.001                           standard deviation of white noise
  bias = 0.002                            constant error; bias_std draws one a run instead
  scale = 1.01                            scale factor
  lag = 0.02                              first-order lag, s
  delay = 0.01                            delay, s
  bits = 12                               PCM word: 2^bits counts over the range, held at its ends; or quantum = 0.001
  range = [-1.0, 1.0]
  dropouts = { rate = 0.1, mean_length = 0.2 }   its own losses: a second of reception, s
  [dropouts]                              of the link, all channels at once: rate, mean_length
  [vibration]                             amplitudes at rotor speed times blades and twice that
  blades = 4                              those of a Level-1 model if left out
  az = [1.0, 0.3]                         of ax ay az p q r
An example stands in replay/instruments/flight-test.toml.";

/// Fly a model on given controls and record it
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
#[command(group(clap::ArgGroup::new("flown").required(true).args(["controls", "input"])))]
pub(crate) struct SimulateArgs {
    #[command(flatten)]
    condition: FlightCondition,
    /// Fly the controls of this run (and its rotor speed), straight lines between its samples
    #[arg(long, value_name = "RUN", conflicts_with_all = ["lead"], value_parser = RecordingSource::parser())]
    controls: Option<RecordingSource>,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) of --controls carries which channel (TOML, as in
    /// `convert --help`)
    #[arg(long, value_name = "FILE", requires = "controls")]
    config: Option<PathBuf>,
    #[command(flatten)]
    map: MapOption,
    #[command(flatten)]
    parts: PartOptions,
    /// Fly a test input, control:shape:amplitude:clock[:start]: rad, s; shape step, doublet, 3211 or other digits
    /// (pulse lengths in clocks, signs alternating), prbs3 to prbs8 (7 to 255 clocks, pseudo-random); start in s, after the
    /// lead if left out. Repeatable: inputs add up
    #[arg(long, value_name = "SPEC")]
    input: Vec<String>,
    /// Where the recording goes, by the name: a run file (.csv), a log (.mcap), MAVLink (.tlog), a log of ArduPilot (.bin) or of
    /// PX4 (.ulg), a stream of PCM (.pcm, the format of its frames beside it in .pcm.toml)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// How long, s [default: 10 s after the last input, or the length of the run]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = number("s"))]
    duration: Option<f64>,
    /// Samples a second [default: 100, or the run's own times]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = number("Hz"))]
    rate: Option<f64>,
    /// Maximum rate of a control movement, rad of blade pitch per second
    #[arg(long, value_name = "RAD/S", default_value_t = HAND_RATE, conflicts_with = "controls",
        allow_negative_numbers = true, value_parser = number("rad/s"))]
    hand_rate: f64,
    /// Who flies besides: a pilot who slowly holds bank and pitch attitude (attitude), heading too (heading), by gains far below
    /// a test input, so that a long flight of an unstable aircraft stays near its trim; the recorded controls include his inputs
    #[arg(long, value_name = "none|attitude|heading", default_value = "none")]
    pilot: PilotMode,
    /// Instruments by a file (TOML): rates, errors, PCM words, dropouts, vibration; see below
    #[arg(long, value_name = "FILE")]
    instruments: Option<PathBuf>,
    /// Instrument noise and bias: none, flight (flight-test quality), or that quality times a factor; with --instruments the
    /// factor of all random errors [default: none, or flight with --instruments]
    #[arg(long, value_name = "none|flight|FACTOR", num_args = 0..=1, default_missing_value = "flight", value_parser = noise_factor, allow_negative_numbers = true)]
    noise: Option<f64>,
    /// Gusts with this standard deviation, m/s (Dryden, scale 533 m)
    #[arg(long, value_name = "SIGMA", allow_negative_numbers = true, value_parser = number("m/s"))]
    turbulence: Option<f64>,
    /// Seed of noise, biases and gusts
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = seed)]
    seed: u64,
    /// Seconds in trim before the first input
    #[arg(long, value_name = "S", default_value_t = 2.0, allow_negative_numbers = true, value_parser = number("s"))]
    lead: f64,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Who flies besides the test input.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum PilotMode {
    None,
    Attitude,
    Heading,
}

impl PilotMode {
    fn pilot(self) -> Option<Pilot> {
        match self {
            PilotMode::None => None,
            PilotMode::Attitude => Some(Pilot::ATTITUDE),
            PilotMode::Heading => Some(Pilot::ATTITUDE_AND_HEADING),
        }
    }
}

/// The call and everything that it reads.
fn provenance(args: &SimulateArgs) -> Provenance {
    let controls = args.controls.iter().flat_map(RecordingSource::files);
    let besides = args.instruments.iter().chain(&args.config).chain(&args.map.map).cloned();
    Provenance::of(controls.chain([args.condition.model.clone()]).chain(besides))
}

fn noise_factor(text: &str) -> Result<f64, String> {
    match text {
        "none" => Ok(0.0),
        "flight" => Ok(1.0),
        number => match number.parse::<f64>() {
            Ok(factor) if (0.0..=1000.0).contains(&factor) => Ok(factor),
            _ => Err("expected none, flight, or a factor from 0 to 1000".to_owned()),
        },
    }
}

fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}

/// Stamps of a simulated recording are not late, unless an effect `sensor_delay` makes them so.
fn refuse_latencies(of_run: &[String]) -> Result<(), Failure> {
    match of_run.iter().find(|set| key_of(set) == "latency_s") {
        Some(set) => Err(Failure::Input(format!("--set: expected latency_s with a command that reads runs, found `{set}`"))),
        None => Ok(()),
    }
}

pub(crate) fn run(args: &SimulateArgs) -> Result<Outcome, Failure> {
    let format = RunFormat::by_name(&args.out)?;
    refuse_without_folder("--out", &args.out)?;
    let inputs: Vec<PathBuf> = {
        let read = args.controls.iter().flat_map(RecordingSource::files);
        read.chain([args.condition.model.clone()]).chain(args.instruments.clone()).collect()
    };
    for written in format.files(&args.out) {
        refuse_to_overwrite("--out", &written, &inputs)?;
        args.replace.refuse("--out", &written)?;
    }
    let lead_s = within("--lead", args.lead, 0.0, 1e4)?;
    let hand_rate = within("--hand-rate", args.hand_rate, 1e-4, 1e4)?;
    let duration_s = args.duration.map(|duration| within("--duration", duration, 0.0, 1e6)).transpose()?;
    let (of_run, of_model): (Vec<String>, Vec<String>) =
        args.condition.set.iter().cloned().partition(|set| RunInfo::is_known(key_of(set)));
    refuse_latencies(&of_run)?;
    let keys_of_run = format!("; or a key of the run ({})", RunInfo::known_keys());
    let read = args.condition.fly(of_model, &keys_of_run)?;
    let in_trim = read.flight();
    let (file, model) = (&read.file, &in_trim.model);
    let mut effects = file.own_effects();
    if let Some(sigma) = args.turbulence {
        effects.push(Effect::Turbulence { sigma: within("--turbulence", sigma, 0.0, 100.0)?, length: MEDIUM_HEIGHT_LENGTH_M });
    }
    let described = args.instruments.as_deref().map(|path| read_instruments(path, &in_trim)).transpose()?;
    let rate_hz = args.rate.map(|rate| within("--rate", rate, 0.01, 1e4)).transpose()?;
    let rate_hz = rate_hz.or(described.as_ref().and_then(|described| described.rate_hz));
    let instruments = instruments(args, in_trim.level1.is_some(), described.as_ref());
    let times = |start_s, duration_s, rate_hz| {
        uniform_times(start_s, duration_s, rate_hz).map_err(|refused| Failure::Input(refused.to_string()))
    };
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let mut losses = Vec::new();
    let (inputs, times_s, manoeuvre) = match &args.controls {
        Some(source) => {
            let (path, mut run) =
                (source.file.as_path(), read_controls(&chosen_run(source, &args.parts, &[], &mapping)?, &mapping)?);
            losses.extend(run.losses.drain(..).map(|loss| format!("{}: {loss}", path.display())));
            let times_s = match (rate_hz, duration_s) {
                (None, None) => run.times_s.clone(),
                (None, Some(duration)) => run.times_s.iter().copied().take_while(|t| t - run.start_s() <= duration).collect(),
                (Some(rate), _) => times(run.start_s(), duration_s.unwrap_or(run.end_s() - run.start_s()), rate)?,
            };
            for (key, then, now) in run.differing(&read.flown()) {
                message(format_args!("note: {} was flown with {key} {then}; now it is {now}", path.display()));
            }
            if in_trim.is_governed() && run.rotor_speed.take().is_some() {
                message(format_args!("note: the rotor speed of {} is left to the model's governor", path.display()));
            }
            (inputs_of_run(path, run, model), times_s, format!("controls of {}", path.display()))
        }
        None => {
            let specs = args.input.iter().map(|text| InputSpec::parse(text)).collect::<Result<Vec<_>, _>>();
            let specs = specs.map_err(|error| Failure::Input(format!("--input: {error}")))?;
            let end_s = specs.iter().map(|spec| spec.end_s(lead_s)).fold(lead_s, f64::max);
            let times_s = times(0.0, duration_s.unwrap_or(end_s + 10.0), rate_hz.unwrap_or(100.0))?;
            let inputs = inputs_of_specs(&specs, lead_s, hand_rate, model)?.sampled_by(&instruments, &times_s);
            (inputs.map_err(|refused| Failure::Input(refused.to_string()))?, times_s, args.input.join(" "))
        }
    };
    if times_s.len() < 2 {
        return Err(Failure::Input(format!("expected a flight of two samples or more, found {}", times_s.len())));
    }
    warn_of_still_rotor(&effects, model, &inputs);
    warn_of_unread_channels(&effects, &instruments);
    if in_trim.level1.is_some() {
        warn_of_stall(&inputs);
    }
    let info = run_info(args, &read, &of_run, &manoeuvre, &instruments)?;
    let instruments = InstrumentSet {
        accelerometer_position_m: info.geometry().accelerometer_position_m,
        vane_position_m: info.geometry().vane_position_m,
        blades: info.geometry().blades.map(f64::from).or(instruments.blades),
        ..instruments
    };
    let pilot = args.pilot.pilot();
    let flight = Flight { effects, inputs, pilot, instruments, times_s, seed: args.seed, ..in_trim.clone() };
    let flown = flight.fly().map_err(|refused| Failure::file(&args.condition.model, refused))?;
    write_run(&args.out, format, &info, &flown.samples, &provenance(args))?;
    let last_s = flown.samples.last().map_or(0.0, |sample| sample.time_s);
    message(format_args!("{}: {} samples, to {last_s} s", args.out.display(), flown.samples.len()));
    if let Some(time_s) = flown.diverged_at_s {
        let (lost, all) = (flight.times_s.len() - flown.truth.len(), flight.times_s.len());
        losses.push(format!("the motion diverged at {time_s:.3} s and is cut there: {lost} of {all} samples lost"));
    }
    for loss in &losses {
        message(format_args!("sideslip: {loss}"));
    }
    Ok(if losses.is_empty() { Outcome::Done } else { Outcome::DataLost })
}

fn key_of(assignment: &str) -> &str {
    assignment.split('=').next().unwrap_or_default().trim()
}

fn within(option: &str, value: f64, least: f64, most: f64) -> Result<f64, Failure> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(Failure::Input(format!("{option}: expected {least} to {most}, found {value}")))
    }
}

/// Factor of all random errors.
fn noise_of(args: &SimulateArgs) -> f64 {
    args.noise.unwrap_or(if args.instruments.is_some() { 1.0 } else { 0.0 })
}

fn instruments(args: &SimulateArgs, with_rotor: bool, described: Option<&InstrumentFile>) -> InstrumentSet {
    let factor = noise_of(args);
    let of_quality = InstrumentSet::flight_quality(factor);
    let mut instruments = if with_rotor { of_quality.with_rotor(factor) } else { of_quality };
    if let Some(described) = described {
        instruments = described.applied_to(instruments, factor);
        instruments.accelerometer_position_m = described.accelerometer_position_m.unwrap_or_default();
        instruments.vane_position_m = described.vane_position_m.unwrap_or_default();
    }
    instruments
}

/// What the recording says of itself, with what `--set` makes of it.
fn run_info(
    args: &SimulateArgs,
    read: &FlightModel,
    of_run: &[String],
    manoeuvre: &str,
    instruments: &InstrumentSet,
) -> Result<RunInfo, Failure> {
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let file = &read.file;
    let gamma = file.linear.trim.flight_path_angle();
    let flight_path = match gamma {
        angle if angle > 0.01 => "climb",
        angle if angle < -0.01 => "descent",
        _ => "level",
    };
    let name = args.out.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut text = format!(
        "run = {}\naircraft = {}\nmanoeuvre = {}\nflight_path = \"{flight_path}\"\n\
         accelerometer_position_m = {:?}\nvane_position_m = {:?}\nsimulated = true\nseed = {}\nnoise = {:?}\n",
        quoted(&name),
        quoted(&file.name),
        quoted(manoeuvre),
        instruments.accelerometer_position_m,
        instruments.vane_position_m,
        args.seed.min(i64::MAX as u64),
        noise_of(args),
    );
    let shaken = instruments.channels.iter().any(|channel| channel.vibration.is_some());
    if let Some(blades) = instruments.blades.or(read.blades().filter(|_| shaken)) {
        let _ = writeln!(text, "blades = {blades}");
    }
    if let Some(path) = &args.instruments {
        let _ = writeln!(text, "instruments = {}", quoted(&path.file_name().unwrap_or_default().to_string_lossy()));
    }
    if let Some(sigma) = args.turbulence {
        let _ = writeln!(text, "turbulence = {sigma:?}");
    }
    if libm::fabs(args.hand_rate - HAND_RATE) > 0.0 {
        let _ = writeln!(text, "hand_rate = {:?}", args.hand_rate);
    }
    if args.pilot.pilot().is_some() {
        let _ =
            writeln!(text, "pilot = {}", quoted(if matches!(args.pilot, PilotMode::Heading) { "heading" } else { "attitude" }));
    }
    let flown = read.flown();
    if !flown.is_empty() {
        let model = args.condition.model.file_name().unwrap_or_default().to_string_lossy();
        let of_model = [("level1".to_owned(), toml::Value::Table(flown))];
        let _ = write!(text, "model = {}\n{}", quoted(&model), toml::Table::from_iter(of_model));
    }
    if !file.effects.is_empty() {
        text.push('\n');
        file.effects.iter().for_each(|effect| text.push_str(&effect.to_toml(file.controls)));
    }
    let mut info = RunInfo::from_toml(&text).map_err(|place| Failure::Running(place.to_string()))?;
    for assignment in of_run {
        info.set(assignment).map_err(|what| Failure::Input(format!("--set: {what}")))?;
    }
    info.set_controls(file.controls);
    Ok(info)
}
