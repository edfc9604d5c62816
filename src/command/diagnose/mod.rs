//! `sideslip diagnose`: what a model gets wrong, its cause, the extended model, the gain on runs it never saw.

mod json;
mod page;
mod points;
mod roots;
mod table;
mod verdict;

use super::options::flight_condition::FlightCondition;
use super::options::mapping_input::read_mapping;
use super::recordings::run_condition::condition_of;
use super::recordings::run_input::{RunInput, read_screened, refuse_two_aircraft};
use super::terminal::output_file::{print, refuse_to_overwrite, refuse_without_folder, same_place, write_json, write_whole};
use crate::command::message;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::set_aside::{no_diagnosis, reason};
use sideslip::postflight::diagnosis::data::run::RecordedRun;
use sideslip::postflight::diagnosis::diagnose::{Diagnosis, diagnose};
use sideslip::postflight::diagnosis::search::next_cause::SearchSettings;
use sideslip::postflight::identification::test_condition::{TestCondition, test_points};
use sideslip::simulation::flight_model::FlightModel;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "\
Example:
  sideslip diagnose --model puma-100kn.toml --fit 3211.csv lateral.csv doublet.csv --holdout other.csv --extended better.toml
  sideslip diagnose --model puma --speed 51.4 --density 1.024 --fit monday/*.csv --json -

Every effect that a model file can have is a hypothesis, for every axis, control and channel: derivatives, nonlinear terms, the
way of each control to its blade, rotor speed, gusts, the instruments. All are weighed together along the runs with the model's
own tolerance free to answer, the best are fitted with their numbers free, and after each that is taken the search goes on until
what remains is noise. Causes that the data do not tell apart are told together. Where no hypothesis explains what is there, it
says so: on which axis, and in which band. The gain is that of free runs on runs which were not fitted; without a gain no model is
extended. Runs should begin in the trim of the model. A Level-1 model whose airspeed and climb are left open is trimmed where the
runs were flown; runs of several test points are diagnosed at their own each, and all over the flight path.

Exit status: 0 done, whatever was found; 1 failed while running; 2 the call, a recording or a model is wrong; 3 done, rows were
skipped or a run was set aside. With --json - the table goes to standard error.";

/// Say what a model gets wrong, name the cause, extend the model, and measure the gain on runs kept back
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    condition: FlightCondition,
    /// Recordings to find causes in, a run each
    #[arg(long, value_name = "RUN", num_args = 1.., required = true)]
    fit: Vec<PathBuf>,
    /// Recordings that the gain is measured on; they are not looked at before
    #[arg(long, value_name = "RUN", num_args = 1..)]
    holdout: Vec<PathBuf>,
    /// Most causes that are looked for
    #[arg(long, value_name = "N", default_value_t = 3)]
    causes: usize,
    /// Which message gives which channel, for recordings of MAVLink (TOML)
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Write the answer as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the extended model to this file, where there is one
    #[arg(long, value_name = "FILE")]
    extended: Option<PathBuf>,
    /// Write a page for a sceptic to this file: the answer, every run beside both models, what the residuals go with, the gain
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// Everything that is told.
struct Answer {
    model: FlightModel,
    diagnosis: Diagnosis,
    extension: Vec<DeclaredEffect>,
    controls: ControlNames,
    extended: Option<PathBuf>,
}

/// The runs, for pictures.
struct Flights<'r> {
    fit: &'r [RecordedRun],
    holdout: &'r [RecordedRun],
}

/// Reads, diagnoses and tells.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    refuse_wrong_outputs(args)?;
    let mapping = read_mapping(args.config.as_deref())?;
    let (of_run, of_model): (Vec<String>, Vec<String>) =
        args.condition.set.iter().cloned().partition(|set| RunInfo::is_known(set.split('=').next().unwrap_or_default().trim()));
    let model = args.condition.fly(of_model.clone(), &format!("; or a key of the run ({})", RunInfo::known_keys()))?;
    let read = |files: &[PathBuf]| files.iter().map(|file| read_screened(file, &of_run, &mapping)).collect::<Result<Vec<_>, _>>();
    let (fit, holdout) = (read(&args.fit)?, read(&args.holdout)?);
    refuse_two_aircraft(fit.iter().chain(&holdout).zip(args.fit.iter().chain(&args.holdout)))?;
    let controls = fit.first().map_or(ControlNames::Rotorcraft, |one| one.info.geometry().controls);
    let mut losses: Vec<String> = fit.iter().chain(&holdout).flat_map(|one| one.losses.clone()).collect();
    let recorded = |runs: Vec<RunInput>, files: &[PathBuf]| -> Vec<RecordedRun> {
        let named = runs.into_iter().zip(files).map(|(one, file)| RecordedRun {
            name: name_of(&one.name, file),
            geometry: *one.info.geometry(),
            samples: one.samples,
        });
        named.collect()
    };
    refuse_twice(fit.iter().chain(&holdout).zip(args.fit.iter().chain(&args.holdout)))?;
    let (fit, holdout) = (recorded(fit, &args.fit), recorded(holdout, &args.holdout));
    let conditions: Vec<TestCondition> = fit.iter().map(condition_of).collect();
    let groups = test_points(&conditions);
    let left_to_runs = args.condition.is_left_to_runs(&model);
    if groups.len() > 1 && left_to_runs {
        losses.extend(points::run(args, &of_model, (&fit, &holdout), &groups, controls)?);
    } else {
        let flown = TestCondition::mean(&conditions);
        let model = if left_to_runs && !flown.is_near(&trim_of(&model)) {
            message(format_args!("the model is trimmed where it was flown: {}", points::in_words(&flown, fit.len())));
            args.condition.fly_at(of_model, flown.speed, flown.climb())?
        } else {
            model
        };
        let answer = answered(args, model, (&fit, &holdout), controls, &mut losses)?;
        tell(args, &answer, &Flights { fit: &fit, holdout: &holdout })?;
    }
    for loss in &losses {
        message(format_args!("sideslip: {loss}"));
    }
    Ok(if losses.is_empty() { Outcome::Done } else { Outcome::DataLost })
}

/// A run by its name, and by its file where that is called otherwise.
fn name_of(name: &str, file: &Path) -> String {
    match name {
        "" => file.display().to_string(),
        _ if file.file_stem().is_some_and(|stem| stem == name) => name.to_owned(),
        _ => format!("{name} ({})", file.display()),
    }
}

/// A flight that stands in two files is one flight: kept back it would judge itself.
fn refuse_twice<'r>(runs: impl Iterator<Item = (&'r RunInput, &'r PathBuf)>) -> Result<(), Failure> {
    let mut seen: Vec<(&RunInput, &PathBuf)> = Vec::new();
    for (run, file) in runs {
        if let Some((_, first)) = seen.iter().find(|(other, _)| !run.samples.is_empty() && other.samples == run.samples) {
            let first = first.display();
            return Err(Failure::file(file, format!("expected each flight once, found the samples of `{first}` again")));
        }
        seen.push((run, file));
    }
    Ok(())
}

/// The test point that a model is trimmed at.
fn trim_of(model: &FlightModel) -> TestCondition {
    let trim = model.linear().trim;
    let speed = trim.airspeed();
    let angles = [
        ("tas", speed),
        ("alpha", libm::atan2(trim.w, trim.u)),
        ("beta", libm::asin(trim.v / speed.max(1.0))),
        ("theta", trim.theta),
    ];
    let named = |name: &str| angles.iter().chain([&("phi", trim.phi)]).find(|(there, _)| *there == name).map(|(_, value)| *value);
    TestCondition::of_trim(named, || f64::NAN)
}

/// Diagnoses a model by the runs of one test point.
fn answered(
    args: &Args,
    model: FlightModel,
    (fit, holdout): (&[RecordedRun], &[RecordedRun]),
    controls: ControlNames,
    losses: &mut Vec<String>,
) -> Result<Answer, Failure> {
    let settings = SearchSettings { causes: args.causes, ..SearchSettings::default() };
    let diagnosis = diagnose(&model, fit, holdout, &settings).map_err(|wrong| Failure::Input(no_diagnosis(&wrong)))?;
    losses.extend(diagnosis.set_aside.iter().map(|(name, why)| format!("{name}: set aside: {}", reason(why))));
    let extension = diagnosis.extension();
    let extended = args.extended.clone().filter(|_| !extension.is_empty());
    Ok(Answer { model, diagnosis, extension, controls, extended })
}

/// The extended model to its file.
fn write_extended(answer: &Answer) -> Result<(), Failure> {
    let Some(path) = &answer.extended else { return Ok(()) };
    let all: Vec<DeclaredEffect> = answer.model.file.effects.iter().chain(&answer.extension).copied().collect();
    let text = answer.model.with_effects(&all).map_err(|wrong| Failure::Running(wrong.to_string()))?;
    write_whole(path, |file| file.write_all(text.as_bytes()))
}

fn write_page(path: &Path, answer: &Answer, flights: &Flights<'_>) -> Result<(), Failure> {
    let text = page::text(answer, flights)?;
    write_whole(path, |file| file.write_all(text.as_bytes()))
}

fn tell(args: &Args, answer: &Answer, flights: &Flights<'_>) -> Result<(), Failure> {
    write_extended(answer)?;
    if let Some(path) = args.extended.as_ref().filter(|_| answer.extended.is_none()) {
        message(format_args!("sideslip: {}: not written, for there is nothing to extend", path.display()));
    }
    if let Some(path) = &args.html {
        write_page(path, answer, flights)?;
    }
    let style = if args.json.is_some() { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let text = table::text(answer, style);
    match &args.json {
        None => print(&text),
        Some(path) => {
            message(format_args!("{}", text.trim_end()));
            write_json(path, &format!("{:#}\n", json::document(answer)))
        }
    }
}

fn refuse_wrong_outputs(args: &Args) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = args.fit.iter().chain(&args.holdout).chain([&args.condition.model]).cloned().collect();
    let json = args.json.as_ref().filter(|json| json.as_os_str() != "-");
    for (option, output) in [("--json", json), ("--extended", args.extended.as_ref()), ("--html", args.html.as_ref())] {
        if let Some(output) = output {
            refuse_to_overwrite(option, output, &inputs)?;
            refuse_without_folder(option, output)?;
        }
    }
    let runs: Vec<&PathBuf> = args.fit.iter().chain(&args.holdout).collect();
    for (place, file) in runs.iter().enumerate() {
        if runs.iter().take(place).any(|other| same_place(other, file)) {
            return Err(Failure::file(
                file,
                "expected each run once, to be fitted or to be kept back, found the same file twice",
            ));
        }
    }
    Ok(())
}
