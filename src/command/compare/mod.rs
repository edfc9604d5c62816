//! `sideslip compare`: flight against simulation on the same controls.

mod comparison;
mod json;
mod overlay_chart;
mod table;

use super::options::fitted_runs::refuse_twice;
use super::options::flight_condition::{FlightCondition, read_model};
use super::options::mapping_input::{CONFIG_HELP, MapOption, read_mapping};
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::{PartOptions, is_of_run};
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_runs;
use super::recordings::provenance::Provenance;
use super::recordings::run_input::{RunInput, read_run, refuse_two_aircraft};
use super::recordings::run_names::tell_apart;
use super::terminal::console::{message_once, print};
use super::terminal::output_file::{refuse_to_overwrite, refuse_without_folder, write_json, write_whole};
use crate::command::message_text;
use comparison::{ComparedRun, Comparison, outlasts_trim};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::control::{CONTROLS, Control};
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::postflight::validation::free_run::{FreeRunPrediction, ValidationRun, predict};
use sideslip::postflight::validation::improvement::improvement;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use std::path::PathBuf;

const EXAMPLE: &str = "\
Example:
  sideslip compare flight.csv --model replay/models/puma-like.toml --svg flight.svg
  sideslip compare monday/*.csv --model puma --speed 51.4 --out pictures --json -
  sideslip compare holdout.csv --model model.toml --beside extended.toml

The model starts in its own trim and flies each run's measured controls (and rotor speed) as they move about the run's own
trim, the mean over the trim window; nothing is fitted. Its effects are flown too, those on instruments in what is read; gusts
are not. Errors are of deviations from trim; of a channel that a model gives a bias, of absolute values. TIC is Theil's
inequality coefficient, 0 perfect to 1; VAF the variance accounted for, 1 perfect, negative where the mean predicts
better. Pooled: root of the mean over channels of the squared rms over noise, airspeed and altitude apart. In brackets 95 % of
the moving-block bootstrap. Of a run on which a model diverges before its trim window ends there is no score.

Exit status: 0 done, a model that diverges is a result; 1 failed while running; 2 the call, a recording or a model is wrong; 3
done, rows were skipped. With --json the table goes to standard error.";

/// Fly a model on the measured controls of runs: pictures of both, rms, Theil's coefficient, VAF
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct CompareArgs {
    /// Recordings, a run each; their format is recognised by their content; a stream of PCM is
    /// pcm+file://PATH?format=FRAME.toml, Chapter 10 whose setup does not name the channels ch10+file://PATH?format=FILE.toml
    #[arg(required = true, value_name = "RUN", value_parser = RecordingSource::parser())]
    files: Vec<RecordingSource>,
    #[command(flatten)]
    condition: FlightCondition,
    /// Another model beside it, such as the extended one: its errors, and the improvement by it
    #[arg(long, value_name = "FILE")]
    beside: Option<PathBuf>,
    /// Length of the window at a run's start whose mean is its trim, s
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    trim_window: f64,
    /// Take a control as constant where runs have no column of it; repeatable
    #[arg(long, value_name = "CONTROL")]
    still: Vec<String>,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML)
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    config: Option<PathBuf>,
    #[command(flatten)]
    map: MapOption,
    #[command(flatten)]
    parts: PartOptions,
    /// Write the answer as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw every run, measured and simulated, into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Draw each run into a file of its own in this folder, with compare.json beside
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Reads runs and models, flies and tells.
pub(crate) fn run(args: &CompareArgs) -> Result<Outcome, Failure> {
    refuse_wrong_outputs(args)?;
    if !(args.trim_window > 0.0 && args.trim_window.is_finite()) {
        return Err(Failure::Input(format!("--trim-window: expected more than 0 s, found {}", args.trim_window)));
    }
    let still = still(&args.still)?;
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let (of_run, of_model): (Vec<String>, Vec<String>) = args.condition.set.iter().cloned().partition(|set| is_of_run(set));
    let model = args.condition.fly(of_model, &format!("; or a key of the run ({})", RunInfo::known_keys()))?;
    let beside = args.beside.as_ref().map(|path| read_model(path, &FlightRequest::default(), "")).transpose()?;
    let [sources] = chosen_runs([&args.files], &args.parts, &of_run, &mapping)?;
    refuse_twice(&sources.iter().collect::<Vec<_>>())?;
    let mut read = sources.iter().map(|source| read_run(source, &mapping)).collect::<Result<Vec<_>, _>>()?;
    tell_apart(read.iter_mut().map(|one| &mut one.name), &sources.iter().collect::<Vec<_>>());
    refuse_two_aircraft(read.iter().zip(&sources))?;
    refuse_standing(args, &file_names(read.iter().map(|one| one.name.as_str())))?;
    let losses: Vec<String> = read.iter().flat_map(|one| one.losses.clone()).collect();
    let mut runs = Vec::new();
    for (one, RecordingSource { file, .. }) in read.into_iter().zip(&sources) {
        let RunInput { name, info, samples, .. } = one;
        let run = ValidationRun { trim_window_s: args.trim_window, still, ..ValidationRun::of(&samples, info.geometry()) };
        let fly = |model: &FlightModel| predict(model, &model.file.own_effects(), &run).map_err(|why| Failure::file(file, why));
        let (model, beside) = (fly(&model)?, beside.as_ref().map(fly).transpose()?);
        if model.channels.is_empty() {
            return Err(Failure::file(file, "expected a channel that the model predicts, such as p, r or ay, found none"));
        }
        let lasts = |prediction: &FreeRunPrediction| outlasts_trim(prediction, args.trim_window);
        let scored = lasts(&model) && beside.as_ref().is_none_or(lasts);
        let compared = ComparedRun { name, model, beside, info, samples, scored };
        let figures = compared.figures();
        runs.push((compared, figures));
    }
    let scored = runs.iter().filter(|(one, _)| one.scored);
    let pairs: Vec<(&FreeRunPrediction, &FreeRunPrediction)> = scored.map(|(one, _)| one.pair()).collect();
    let all = match (pairs.is_empty(), runs.first()) {
        (true, Some((one, _))) => one.figures(),
        _ => improvement(&pairs),
    };
    tell(args, &sources, &Comparison { all, runs, beside: beside.is_some() })?;
    for loss in &losses {
        message_once(format_args!("sideslip: {loss}"));
    }
    Ok(if losses.is_empty() { Outcome::Done } else { Outcome::DataLost })
}

/// Tables, pictures and the document, each where it was asked for.
fn tell(args: &CompareArgs, sources: &[RecordingSource], answer: &Comparison) -> Result<(), Failure> {
    let drawn = |error: sideslip::io::outputs::charts::chart::ChartError| Failure::Running(error.to_string());
    let style = if args.json.is_some() { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let text = table::text(answer, style);
    let document =
        provenance(args, sources, answer).in_front_of(&format!("{:#}\n", json::document(answer)), Some(DocumentSchema::Compare));
    if let Some(path) = &args.svg {
        let all: Vec<&ComparedRun> = answer.runs.iter().map(|(one, _)| one).collect();
        let text = overlay_chart::svg(&all).map_err(drawn)?;
        write_whole(path, |file| file.write_all(text.as_bytes()))?;
    }
    if let Some(folder) = &args.out {
        std::fs::create_dir_all(folder).map_err(|error| Failure::io(folder, &error))?;
        let files = file_names(answer.runs.iter().map(|(one, _)| one.name.as_str()));
        for (file, (one, _)) in files.iter().zip(&answer.runs) {
            let text = overlay_chart::svg(&[one]).map_err(drawn)?;
            let file = folder.join(file);
            write_whole(&file, |file| file.write_all(text.as_bytes()))?;
        }
        write_whole(&folder.join(NUMBERS), |file| file.write_all(document.as_bytes()))?;
    }
    match &args.json {
        None => print(&text),
        Some(path) => {
            message_text(text.trim_end());
            write_json(path, &document)
        }
    }
}

/// The call and everything that it reads.
fn provenance(args: &CompareArgs, sources: &[RecordingSource], answer: &Comparison) -> Provenance {
    let files = sources.iter().flat_map(RecordingSource::files).chain([args.condition.model.clone()]);
    let besides = args.beside.iter().chain(&args.config).chain(&args.map.map).cloned();
    let runs = answer.runs.iter().map(|(one, _)| &one.info).zip(sources);
    runs.fold(Provenance::of(files.chain(besides)), |all, (info, source)| all.dated(&source.file, info.recorded_at()))
}

/// What `--out` writes beside the pictures.
const NUMBERS: &str = "compare.json";

/// The picture of each run by its name; numbered where two runs have one name.
fn file_names<'n>(runs: impl Iterator<Item = &'n str>) -> Vec<String> {
    let plain = |name: &str| -> String { name.chars().map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' }).collect() };
    let names: Vec<String> = runs.map(plain).collect();
    let numbered = |(place, own): (usize, &String)| {
        let twice = names.iter().filter(|name| *name == own).count() > 1 || own.is_empty();
        if twice { format!("{own}-{}.svg", place + 1) } else { format!("{own}.svg") }
    };
    names.iter().enumerate().map(numbered).collect()
}

/// Refuses, before anything is flown, to write over files of the user in the folder of the pictures.
fn refuse_standing(args: &CompareArgs, pictures: &[String]) -> Result<(), Failure> {
    let Some(folder) = &args.out else { return Ok(()) };
    let names = pictures.iter().map(String::as_str).chain([NUMBERS]);
    args.replace.refuse_in("--out", folder, names)
}

fn refuse_wrong_outputs(args: &CompareArgs) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = {
        let read = args.files.iter().flat_map(RecordingSource::files);
        read.chain([args.condition.model.clone()]).chain(args.beside.clone()).collect()
    };
    let json = args.json.as_ref().filter(|json| json.as_os_str() != "-");
    for (option, output) in [("--json", json), ("--svg", args.svg.as_ref())] {
        if let Some(output) = output {
            refuse_to_overwrite(option, output, &inputs)?;
            refuse_without_folder(option, output)?;
            args.replace.refuse(option, output)?;
        }
    }
    if let Some(folder) = args.out.as_ref().filter(|folder| folder.exists() && !folder.is_dir()) {
        return Err(Failure::file(folder, "--out: expected a folder, found a file"));
    }
    Ok(())
}

fn still(names: &[String]) -> Result<[bool; CONTROLS], Failure> {
    let mut still = [false; CONTROLS];
    for name in names {
        let what = || Failure::Input(format!("--still: expected a control, such as pedal or throttle, found `{name}`"));
        let control = Control::from_name(name).ok_or_else(what)?;
        still[control.index()] = true;
    }
    Ok(still)
}
