//! `sideslip simulate`: a model flown on given controls, recorded as a run file.

use super::message;
use super::model_input::read_model;
use super::output_file::refuse_to_overwrite;
use super::run_controls::{ControlHistory, read_controls};
use super::simulated_run::{Format, write_run};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::control::Control;
use sideslip::flight::effect::Effect;
use sideslip::flight::model::LinearModel;
use sideslip::flight::model_file::ModelFile;
use sideslip::flight::run_file::RunInfo;
use sideslip::simulation::flight_model::Asked;
use sideslip::simulation::fly::{Flight, Inputs, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::Instruments;
use sideslip::simulation::turbulence::MEDIUM_HEIGHT_LENGTH_M;
use std::path::{Path, PathBuf};

/// Fly a model on given controls and record it
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  sideslip simulate --model puma --input pedal:doublet:0.02:1.0 --noise --out run.csv\n  \
                  sideslip simulate --model puma-100kn.toml --input pedal:3211:0.02:0.7 --noise flight --seed 1 --out run.csv")]
#[command(group(clap::ArgGroup::new("flown").required(true).args(["controls", "input"])))]
pub(crate) struct Args {
    /// Model file (TOML), or puma, the Level-1 Puma that is built in
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Fly the controls of this run (and its rotor speed), straight lines between its samples
    #[arg(long, value_name = "RUN", conflicts_with_all = ["lead"])]
    controls: Option<PathBuf>,
    /// Fly a test input, control:shape:amplitude:clock[:start]: rad, s; shape step, doublet, 3211 or other digits
    /// (pulse lengths in clocks, signs alternating); start in s, after the lead if left out. Repeatable: inputs add up
    #[arg(long, value_name = "SPEC")]
    input: Vec<String>,
    /// Where the recording goes: a run file (.csv), a log (.mcap) or MAVLink (.tlog), by the name
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Set a key of the run, such as vane_position_m=[13.08,0,0] or accelerometer_position_m=[..] (where the instruments
    /// stand, in the flight too); or, after level1., one of the model's own, such as level1.flight.climb=5.08 (true airspeed
    /// speed, climb, sideslip, density of the trim) or level1.options.flapping=second_order; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// How long, s [default: 10 s after the last input, or the length of the run]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Samples a second [default: 100, or the run's own times]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Instrument noise and bias: none, flight (flight-test quality), or that quality times a factor
    #[arg(long, value_name = "none|flight|FACTOR", default_value = "none", num_args = 0..=1, default_missing_value = "flight", value_parser = noise_factor, allow_negative_numbers = true)]
    noise: f64,
    /// Gusts with this standard deviation, m/s (Dryden, scale 533 m)
    #[arg(long, value_name = "SIGMA", allow_negative_numbers = true)]
    turbulence: Option<f64>,
    /// Seed of noise, biases and gusts
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Seconds in trim before the first input
    #[arg(long, value_name = "S", default_value_t = 2.0, allow_negative_numbers = true)]
    lead: f64,
}

fn noise_factor(text: &str) -> Result<f64, String> {
    match text {
        "none" => Ok(0.0),
        "flight" => Ok(1.0),
        number => match number.parse::<f64>() {
            Ok(factor) if factor.is_finite() && factor >= 0.0 => Ok(factor),
            _ => Err("expected none, flight, or a factor of zero or more".to_owned()),
        },
    }
}

/// Flies and records.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    let format = Format::by_name(&args.out)?;
    if let Some(controls) = &args.controls {
        refuse_to_overwrite("--out", &args.out, std::slice::from_ref(controls))?;
    }
    refuse_to_overwrite("--out", &args.out, std::slice::from_ref(&args.model))?;
    let lead_s = within("--lead", args.lead, 0.0, 1e4)?;
    let rate_hz = args.rate.map(|rate| within("--rate", rate, 0.01, 1e4)).transpose()?;
    let duration_s = args.duration.map(|duration| within("--duration", duration, 0.0, 1e6)).transpose()?;
    let (of_model, of_run): (Vec<String>, Vec<String>) = args.set.iter().cloned().partition(|set| set.starts_with("level1."));
    let read = read_model(&args.model, &Asked { set: of_model, ..Asked::default() })?;
    let in_trim = read.flight();
    let governed = in_trim.level1.as_ref().is_some_and(|trimmed| trimmed.aircraft.options.governed);
    let (file, model) = (&read.file, &in_trim.model);
    let mut effects: Vec<Effect> = file.effects.iter().map(|declared| declared.effect).collect();
    if let Some(sigma) = args.turbulence {
        effects.push(Effect::Turbulence { sigma: within("--turbulence", sigma, 0.0, 100.0)?, length: MEDIUM_HEIGHT_LENGTH_M });
    }
    let times = |start_s, duration_s, rate_hz| {
        uniform_times(start_s, duration_s, rate_hz).map_err(|refused| Failure::Input(refused.to_string()))
    };
    let mut losses = Vec::new();
    let (inputs, times_s, manoeuvre) = match &args.controls {
        Some(path) => {
            let mut run = read_controls(path)?;
            losses.extend(run.losses.drain(..).map(|loss| format!("{}: {loss}", path.display())));
            let times_s = match (rate_hz, duration_s) {
                (None, None) => run.times_s.clone(),
                (None, Some(duration)) => run.times_s.iter().copied().take_while(|t| t - run.start_s() <= duration).collect(),
                (Some(rate), _) => times(run.start_s(), duration_s.unwrap_or(run.end_s() - run.start_s()), rate)?,
            };
            if governed && run.rotor_speed.take().is_some() {
                message(format_args!("note: the rotor speed of {} is left to the model's governor", path.display()));
            }
            (inputs_of_run(path, run, model), times_s, format!("controls of {}", path.display()))
        }
        None => {
            let specs = args.input.iter().map(|text| InputSpec::parse(text)).collect::<Result<Vec<_>, _>>();
            let specs = specs.map_err(|error| Failure::Input(format!("--input: {error}")))?;
            let end_s = specs.iter().map(|spec| spec.end_s(lead_s)).fold(lead_s, f64::max);
            let times_s = times(0.0, duration_s.unwrap_or(end_s + 10.0), rate_hz.unwrap_or(100.0))?;
            (inputs_of_specs(&specs, lead_s, model)?.sampled(&times_s), times_s, args.input.join(" "))
        }
    };
    if times_s.len() < 2 {
        return Err(Failure::Input(format!("expected a flight of two samples or more, found {}", times_s.len())));
    }
    warn_of_still_rotor(&effects, model, &inputs);
    let info = run_info(args, file, &of_run, &manoeuvre)?;
    let of_quality = Instruments::flight_quality(args.noise);
    let of_quality = if in_trim.level1.is_some() { of_quality.with_rotor(args.noise) } else { of_quality };
    let instruments = Instruments {
        accelerometer_position_m: info.geometry().accelerometer_position_m,
        vane_position_m: info.geometry().vane_position_m,
        ..of_quality
    };
    let flight = Flight { effects, inputs, instruments, times_s, seed: args.seed, ..in_trim.clone() };
    let flown = flight.fly().map_err(|refused| Failure::file(&args.model, refused))?;
    write_run(&args.out, format, &info, &flown.samples)?;
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

fn within(option: &str, value: f64, least: f64, most: f64) -> Result<f64, Failure> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(Failure::Input(format!("{option}: expected {least} to {most}, found {value}")))
    }
}

/// The run's controls; one that it lacks stays at the model's trim, and it is said.
fn inputs_of_run(path: &Path, run: ControlHistory, model: &LinearModel) -> Inputs {
    let mut inputs = Inputs::at_trim(model);
    for ((control, place), history) in Control::ALL.into_iter().zip(&mut inputs.controls).zip(run.controls) {
        match history {
            Some(history) => *place = history,
            None => {
                let name = control.name(ControlNames::Rotorcraft);
                message(format_args!("note: {} has no `{name}`; it stays at the model's trim", path.display()));
            }
        }
    }
    inputs.rotor_speed = run.rotor_speed.filter(|_| model.trim.rotor_speed.is_some());
    inputs
}

fn inputs_of_specs(specs: &[InputSpec], lead_s: f64, model: &LinearModel) -> Result<Inputs, Failure> {
    let mut inputs = Inputs::at_trim(model);
    for spec in specs {
        let deviation = spec.deviation(lead_s);
        if spec.channel == Channel::RotorSpeed {
            let at_trim = model.trim.rotor_speed.ok_or_else(|| {
                Failure::Input(format!("--input: {spec}: an input of rotor speed needs `rotor_speed` in the model's [trim]"))
            })?;
            inputs.rotor_speed = Some(match inputs.rotor_speed.take() {
                None => deviation.clone().shifted(at_trim),
                Some(earlier) => earlier.plus(1.0, &deviation),
            });
        }
        for (control, history) in Control::ALL.into_iter().zip(&mut inputs.controls) {
            if control.channel() == spec.channel {
                *history = history.plus(1.0, &deviation);
            }
        }
    }
    Ok(inputs)
}

fn warn_of_still_rotor(effects: &[Effect], model: &LinearModel, inputs: &Inputs) {
    let matters = model.rotor_speed.iter().any(|&derivative| derivative != 0.0)
        || effects.iter().any(|effect| matches!(effect, Effect::RotorSpeed { .. }));
    if matters && inputs.rotor_speed.is_none() {
        message(format_args!(
            "note: the rotor speed stays at trim, so its effect does nothing (fly --input rotor_speed:... or a run that has it)"
        ));
    }
}

/// What the recording says of itself, with what `--set` makes of it.
fn run_info(args: &Args, file: &ModelFile, of_run: &[String], manoeuvre: &str) -> Result<RunInfo, Failure> {
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let gamma = file.linear.trim.flight_path_angle();
    let flight_path = match gamma {
        angle if angle > 0.01 => "climb",
        angle if angle < -0.01 => "descent",
        _ => "level",
    };
    let name = args.out.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let text = format!(
        "run = {}\naircraft = {}\nmanoeuvre = {}\nflight_path = \"{flight_path}\"\n\
         accelerometer_position_m = [0.0, 0.0, 0.0]\nvane_position_m = [0.0, 0.0, 0.0]\nsimulated = true\nseed = {}\nnoise = {:?}\n",
        quoted(&name),
        quoted(&file.name),
        quoted(manoeuvre),
        args.seed.min(i64::MAX as u64),
        args.noise,
    );
    let mut info = RunInfo::from_toml(&text).map_err(|place| Failure::Running(place.to_string()))?;
    for assignment in of_run {
        info.set(assignment).map_err(|what| Failure::Input(format!("--set: {what}")))?;
    }
    info.set_controls(file.controls);
    Ok(info)
}
