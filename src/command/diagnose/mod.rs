//! `sideslip diagnose`: what a model gets wrong, its cause, the extended model, the gain on runs it never saw.

mod answer;
mod args;
mod json;
mod page;
mod points;
mod rejection;
mod roots;
mod table;
mod verdict;

use super::options::mapping_input::read_mapping;
use super::options::run_parts::is_of_run;
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_runs;
use super::recordings::provenance::Provenance;
use super::recordings::run_condition::condition_of;
use super::recordings::run_input::{RunInput, read_screened, refuse_two_aircraft};
use super::terminal::console::{message_once, print};
use super::terminal::output_file::{refuse_to_overwrite, refuse_without_folder};
use crate::command::{message, message_text};
use answer::{Answer, Flights};
pub(crate) use args::DiagnoseArgs;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::postflight::diagnosis::record::LENGTH_MIN_S;
use sideslip::postflight::identification::test_condition::{TestCondition, test_points};
use sideslip::postflight::recorded_run::{PartedRun, RecordedRun};
use sideslip::simulation::flight_model::FlightModel;
use std::path::{Path, PathBuf};

/// Reads, diagnoses and tells.
pub(crate) fn run(args: &DiagnoseArgs) -> Result<Outcome, Failure> {
    let (fit, holdout) = args.runs.lists()?;
    refuse_wrong_outputs(args, &fit, holdout)?;
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let (of_run, of_model): (Vec<String>, Vec<String>) = args.condition.set.iter().cloned().partition(|set| is_of_run(set));
    let model = args.condition.fly(of_model.clone(), &format!("; or a key of the run ({})", RunInfo::known_keys()))?;
    let [of_fit, of_holdout] = chosen_runs([&fit, holdout], &args.parts, &of_run, &mapping)?;
    let sources: Vec<&RecordingSource> = of_fit.iter().chain(&of_holdout).collect();
    let read =
        |sources: &[RecordingSource]| sources.iter().map(|source| read_screened(source, &mapping)).collect::<Result<Vec<_>, _>>();
    let (fit, holdout) = (read(&of_fit)?, read(&of_holdout)?);
    refuse_two_aircraft(fit.iter().chain(&holdout).zip(sources.iter().copied()))?;
    let controls = fit.first().map_or(ControlNames::Rotorcraft, |one| one.info.geometry().controls);
    let provenance = {
        let besides = [args.condition.model.clone()].into_iter().chain(args.config.clone()).chain(args.map.map.clone());
        let all = Provenance::of(sources.iter().copied().flat_map(RecordingSource::files).chain(besides));
        let runs = fit.iter().chain(&holdout).zip(&sources);
        runs.fold(all, |all, (run, source)| all.dated(&source.file, run.info.recorded_at()))
    };
    // Before the analysis: what was lost may be why it fails.
    let lost: Vec<&String> = fit.iter().chain(&holdout).flat_map(|one| &one.losses).collect();
    lost.iter().for_each(|loss| message_once(format_args!("sideslip: {loss}")));
    let (any_lost, mut losses) = (!lost.is_empty(), Vec::new());
    let mut parted = Vec::new();
    let mut recorded = |runs: Vec<RunInput>, sources: &[RecordingSource]| -> Vec<RecordedRun> {
        let named = runs.into_iter().zip(sources).map(|(one, source)| RecordedRun {
            name: name_of(&one.name, &source.file),
            geometry: *one.info.geometry(),
            samples: one.samples,
            screened: true,
        });
        named.zip(sources).flat_map(|(run, source)| between_gaps(run, &source.file, &mut parted)).collect()
    };
    refuse_twice(fit.iter().chain(&holdout).zip(sources.iter().copied()))?;
    let (fit, holdout) = (recorded(fit, &of_fit), recorded(holdout, &of_holdout));
    losses.extend(parted);
    let conditions: Vec<TestCondition> = fit.iter().map(condition_of).collect();
    let groups = test_points(&conditions);
    let left_to_runs = args.condition.is_left_to_runs(&model);
    if groups.len() > 1 && left_to_runs {
        losses.extend(points::run(args, &of_model, (&fit, &holdout), &groups, (controls, &provenance))?);
    } else {
        let flown = TestCondition::mean(&conditions);
        let model = if left_to_runs && !flown.is_near(&trim_of(&model)) {
            message(format_args!("the model is trimmed where it was flown: {}", points::in_words(&flown, fit.len())));
            args.condition.fly_at(of_model, flown.speed, flown.climb())?
        } else {
            model
        };
        let answer = Answer::of(args, model, (&fit, &holdout), controls, &mut losses)?;
        tell(args, &answer, &Flights { fit: &fit, holdout: &holdout, provenance: &provenance })?;
    }
    for loss in &losses {
        message_once(format_args!("sideslip: {loss}"));
    }
    Ok(if losses.is_empty() && !any_lost { Outcome::Done } else { Outcome::DataLost })
}

/// The parts of a run between gaps of its rates, which is said; to `left_out` what is too short to be used.
fn between_gaps(run: RecordedRun, file: &Path, left_out: &mut Vec<String>) -> Vec<RecordedRun> {
    let PartedRun { parts, gaps, short } = run.parted(LENGTH_MIN_S);
    let file = file.display();
    if let Some([from_s, to_s]) = gaps.iter().max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0]))) {
        let more = if gaps.len() > 1 { format!(", the longest of {} gaps", gaps.len()) } else { String::new() };
        message(format_args!(
            "sideslip: {file}: no rates from {from_s:.2} s to {to_s:.2} s{more}: diagnosed as {} run(s), each with its own start",
            parts.len()
        ));
    }
    left_out.extend(short.first().map(|[from_s, to_s]| {
        let count = short.len();
        let first = format!("the first from {from_s:.2} s to {to_s:.2} s");
        format!("{file}: {count} part(s) between gaps left out, {first}: expected {LENGTH_MIN_S} s or more with rates")
    }));
    parts
}

/// A run by its name, and by its file where that is called otherwise.
fn name_of(name: &str, file: &Path) -> String {
    match name {
        "" => file.display().to_string(),
        _ if file.file_stem().is_some_and(|stem| stem == name) => name.to_owned(),
        _ => format!("{name} ({})", file.display()),
    }
}

/// A flight that stands in two files is one flight: as a hold-out it would judge itself.
fn refuse_twice<'r>(runs: impl Iterator<Item = (&'r RunInput, &'r RecordingSource)>) -> Result<(), Failure> {
    let mut seen: Vec<(&RunInput, &PathBuf)> = Vec::new();
    for (run, RecordingSource { file, .. }) in runs {
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
    let angles = [("tas", trim.airspeed()), ("alpha", trim.incidence()), ("beta", trim.sideslip()), ("theta", trim.theta)];
    let named = |name: &str| angles.iter().chain([&("phi", trim.phi)]).find(|(there, _)| *there == name).map(|(_, value)| *value);
    TestCondition::of_trim(named, || f64::NAN)
}

fn tell(args: &DiagnoseArgs, answer: &Answer, flights: &Flights<'_>) -> Result<(), Failure> {
    answer.write_extended()?;
    if let Some(path) = args.extended.as_ref().filter(|_| answer.extended.is_none()) {
        message(format_args!("sideslip: {}: not written: the model is not extended", path.display()));
    }
    if let Some(path) = &args.html {
        page::write(path, answer, flights)?;
    }
    let style = if args.json.is_some() { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let text = table::text(answer, style);
    match &args.json {
        None => print(&text),
        Some(path) => {
            message_text(text.trim_end());
            flights.provenance.write_json(path, DocumentSchema::Diagnose, &format!("{:#}\n", json::document(answer)))
        }
    }
}

fn refuse_wrong_outputs(args: &DiagnoseArgs, fit: &[RecordingSource], holdout: &[RecordingSource]) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = {
        let read = fit.iter().chain(holdout).flat_map(RecordingSource::files);
        read.chain([args.condition.model.clone()]).collect()
    };
    let json = args.json.as_ref().filter(|json| json.as_os_str() != "-");
    for (option, output) in [("--json", json), ("--extended", args.extended.as_ref()), ("--html", args.html.as_ref())] {
        if let Some(output) = output {
            refuse_to_overwrite(option, output, &inputs)?;
            refuse_without_folder(option, output)?;
            args.replace.refuse(option, output)?;
        }
    }
    Ok(())
}
