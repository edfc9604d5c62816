//! `sideslip identify`: derivatives and modes from whole runs, after the flight.

mod chosen_states;
mod equation;
mod frequency_domain;
mod json;
mod model_output;
mod page;
mod refusals;
mod run_columns;
mod run_pipeline;
mod table;
mod test_point_result;
mod test_point_text;
mod trimmed_models;
mod unit;

use super::options::fitted_runs::FittedRuns;
use super::options::flight_condition::number;
use super::options::mapping_input::{CONFIG_HELP, MapOption, read_mapping};
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::PartOptions;
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_runs;
use super::recordings::provenance::Provenance;
use super::recordings::run_names::tell_apart;
use super::recordings::run_result::RunResult;
use super::terminal::console::{message_once, print};
use super::terminal::output_file::{refuse_to_overwrite, write_whole};
use super::terminal::progress_line::watched;
use super::terminal::stop::stopped_by_signals;
use crate::command::{message, message_text};
use equation::Equation;
use frequency_domain::{Domain, FrequencyDomainResult};
use refusals::{is_converged, not_identified, refuse_slow_rates, refuse_twice};
use run_columns::read_columns;
use run_pipeline::through_pipeline;
use sideslip::error::{Failure, Outcome};
use sideslip::io::outputs::json::derivatives_json::derivatives_json;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::number::Fixed;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::telemetry::recording_config::RecordingConfig as Mapping;
use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::identify::{FitMethod, IdentificationRequest, InstrumentTreatment, identify};
use sideslip::postflight::identification::model_variables::ModelVariables;
use sideslip::postflight::identification::nondimensional::nondimensional;
use sideslip::postflight::identification::test_condition::{TestCondition, test_points};
use sideslip::postflight::identification::usual_variables::UsualVariables;
use sideslip::postflight::output_error::FitSettings;
use sideslip::realtime::pipeline::PipelineConfig;
use sideslip::realtime::regression::frequency::band::Band;
use std::path::PathBuf;
use test_point_result::{TestPointResult, test_point};
use trimmed_models::TrimmedModels;

const EXAMPLE: &str = "\
Example:
  sideslip identify flight.csv
  sideslip identify rud1.csv ail1.csv --states p,r --inputs aileron,rudder,beta
  sideslip identify coefficients.csv --response Cm --candidates 'alpha;qhat;elevator;alpha*elevator'
  sideslip identify flight.csv --domain frequency --band 0.1:1.2
  sideslip identify gusty.csv --doubt-instruments --method filter-error
  sideslip identify day.csv --manoeuvre day:1,2,4 --holdout other.csv
  sideslip identify monday/*.csv --holdout tuesday.csv --set 'vane_position_m=[13.1,0,0]' --out result

Every run goes through the pipeline of `replay` (smoothed states, stepwise regression); then output error finds one linear
model over all runs: each has its own trim, initial state and biases, and the kinematics that a linear model leaves out are
taken from the measurements. Standard errors are corrected for the colour of the residuals. The effect of what is neither state
nor input is absorbed by the derivatives of what is. Without --states it takes all eight of a helicopter whose planes are coupled;
else the plane of motion that the controls excited, or both, without derivatives from one to the other; a note says which runs
decided it. Runs of --holdout are predicted, not fitted.
Output error takes all noise as the outputs'; where gusts or noisy recorded controls move the aircraft, --method filter-error has
smaller errors; in strong gusts its standard errors are still too small. A note says where the residuals show gusts; the scores
of the fit are those of a free run.

Exit status: 0 done; 1 failed while running; 2 the call or a recording is wrong; 3 done, with rows skipped; 4 nothing
could be identified, or the search has not converged and no model is written. With --json - the
table goes to standard error.";

/// What `--out` writes beside the models.
const REPORT: &str = "report.html";
const NUMBERS: &str = "derivatives.json";

/// Identify a linear model from runs: derivatives with standard errors, modes, prediction of hold-out runs
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct IdentifyArgs {
    #[command(flatten)]
    runs: FittedRuns,
    /// States of the model, such as v,p,phi,r or p,r
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    states: Vec<String>,
    /// Inputs of the model: controls, or any measured channel
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    inputs: Vec<String>,
    /// Outputs of output error [default: the channels that measure the states]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    outputs: Vec<String>,
    /// Instead of a model: one equation by stepwise regression for this column or term, such as Cm
    #[arg(long, value_name = "TERM", conflicts_with_all = ["states", "inputs", "outputs", "out"])]
    response: Option<String>,
    /// Terms offered to --response: columns, products, powers, x*|x|, spline(x,knot)
    #[arg(long, value_name = "TERMS", value_delimiter = ';', requires = "response")]
    candidates: Vec<String>,
    /// Estimate errors of the instruments too: scale factors of the vanes, airspeed and incidence of the trim, and the delay of
    /// each output; standard errors then include them
    #[arg(long, conflicts_with = "response")]
    doubt_instruments: bool,
    /// How the parameters are estimated: by output-error; or by filter-error, where gusts and the noise of recorded controls
    /// disturb the states
    #[arg(long, value_name = "METHOD", value_parser = method, default_value = "output-error", conflicts_with = "response")]
    method: FitMethod,
    /// Override a key of every run, such as vane_position_m=[13.08,0,0] or latency_s={tas=0.25} (channels stamped late, s);
    /// RUN:KEY=VALUE of that recording alone; repeatable
    #[arg(long, value_name = "[RUN:]KEY=VALUE")]
    set: Vec<String>,
    /// Length of the window at a run's start whose mean is its trim, s
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    trim_window: f64,
    /// Show the derivatives of this model beside: a model file (of several the one trimmed nearest to a test point), or puma,
    /// which is trimmed at each test point's speed, climb and density; repeatable
    #[arg(long, value_name = "FILE", conflicts_with = "response")]
    model: Vec<PathBuf>,
    /// Air density of the model's trim, kg/m^3 [default: the runs' own, or that of the standard atmosphere at their altitude]
    #[arg(long, value_name = "KG/M3", requires = "model", value_parser = number("kg/m^3"))]
    density: Option<f64>,
    /// Recordings with steady-heading sideslips, not fitted: N_v and L_v from what the controls hold; one or more
    #[arg(long, value_name = "RUN", num_args = 1.., conflicts_with = "response", value_parser = RecordingSource::parser())]
    sideslips: Vec<RecordingSource>,
    /// What the equations of each run are fitted to; output error is of signals over time in either. The frequency domain brings
    /// measured frequency responses with coherence besides
    #[arg(long, value_enum, default_value_t = Domain::Time, conflicts_with = "response")]
    domain: Domain,
    /// The band of --domain frequency, Hz [default: 0.1:1.5]
    #[arg(long, value_name = "LOW:HIGH", value_parser = frequency_domain::band, conflicts_with = "response")]
    band: Option<Band>,
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
    /// Write report.html, derivatives.json and model.toml to this directory; of several test points model-RUN.toml each, after
    /// its first run
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

fn method(text: &str) -> Result<FitMethod, String> {
    match text {
        "output-error" => Ok(FitMethod::OutputError),
        "filter-error" => Ok(FitMethod::FilterError),
        _ => Err("expected output-error or filter-error".to_owned()),
    }
}

/// Reads the runs, identifies, and reports the result.
pub(crate) fn run(args: &IdentifyArgs) -> Result<Outcome, Failure> {
    if !(args.trim_window > 0.0 && args.trim_window.is_finite()) {
        let found = args.trim_window;
        return Err(Failure::Input(format!("--trim-window: expected seconds, more than zero, found {found}")));
    }
    let (fitted, holdout) = args.runs.lists()?;
    let files = || fitted.iter().chain(holdout).chain(&args.sideslips).flat_map(RecordingSource::files);
    if let Some(json) = args.json.as_ref().filter(|json| json.as_os_str() != "-") {
        refuse_to_overwrite("--json", json, &files().collect::<Vec<_>>())?;
    }
    args.replace.refuse_each([("--json", args.json.as_deref())])?;
    refuse_standing(args, [REPORT, NUMBERS])?;
    let band = frequency_domain::asked(args.domain, args.band)?;
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let [sources, held_out, steady] = chosen_runs([&fitted, holdout, &args.sideslips], &args.parts, &args.set, &mapping)?;
    let read_all = |sources: &[RecordingSource]| {
        sources.iter().map(|source| read_columns(source, &mapping, args.trim_window)).collect::<Result<Vec<_>, _>>()
    };
    let (mut runs, losses): (Vec<_>, Vec<_>) = read_all(&sources)?.into_iter().unzip();
    let (mut holdout, of_holdout): (Vec<_>, Vec<_>) = read_all(&held_out)?.into_iter().unzip();
    let every: Vec<&RecordingSource> = sources.iter().chain(&held_out).collect();
    tell_apart(runs.iter_mut().chain(&mut holdout).map(|run| &mut run.run), &every);
    // Before the analysis: what was lost may be why it fails.
    let mut lost = say_losses(losses.iter().chain(&of_holdout));
    let named = every.iter().map(|source| &source.file);
    let all: Vec<(&PathBuf, &Columns)> = named.zip(runs.iter().chain(&holdout)).collect();
    refuse_twice(&all)?;

    let provenance = provenance(args, files(), &all);
    let to_standard_output = args.json.as_ref().is_some_and(|json| json.as_os_str() == "-");
    let style = if to_standard_output { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    if let Some(response) = &args.response {
        let equation = Equation::select(&runs, &holdout, args.trim_window, response, &args.candidates)?;
        say(&equation.text(style), to_standard_output)?;
        if let Some(json) = &args.json {
            provenance.write_json(json, DocumentSchema::Regression, &format!("{:#}\n", equation.document()))?;
        }
        return Ok(if lost { Outcome::DataLost } else { Outcome::Done });
    }
    let usual = UsualVariables::of(&runs);
    let choice = choice(args, usual.variables.clone());
    let by_itself = args.states.is_empty();
    let only = if by_itself { usual.only(&choice) } else { None };
    let chosen = match (by_itself, args.outputs.is_empty()) {
        (true, _) => Some(chosen_states::note(&usual, &choice, &runs)),
        (false, true) => chosen_states::unused_accelerometers(&choice, &runs),
        (false, false) => None,
    };
    refuse_slow_rates(&all, &choice)?;
    let instruments = if args.doubt_instruments { InstrumentTreatment::Estimated } else { InstrumentTreatment::Trusted };
    let in_band = band.map(|band| FrequencyDomainResult::of(&runs, &choice, band));
    let wanted = IdentificationRequest { choice, only, instruments, method: args.method };
    let (sideslips, losses): (Vec<_>, Vec<_>) = read_all(&steady)?.into_iter().unzip();
    lost |= say_losses(losses.iter());
    let conditions: Vec<TestCondition> = runs.iter().map(TestCondition::of).collect();
    let groups = test_points(&conditions);
    let models = model_output::model_names(&groups, &runs);
    refuse_standing(args, models.iter().map(String::as_str))?;
    if groups.len() > 1 || !args.model.is_empty() || !sideslips.is_empty() {
        let (points, stopped) = watched("output error", |work| {
            let settings = FitSettings { watch: Some(work), ..FitSettings::default() };
            by_test_point(args, (&runs, &holdout, &sideslips), &groups, &wanted, &settings)
        })?;
        let mut points = points?;
        lost |= stopped && say_stopped();
        let by_run = PipelineResults::of(args, &sources, &runs, &mapping, band)?;
        for point in &mut points {
            point.identified.linear.notes.splice(..0, chosen.clone());
            point.identified.linear.notes.extend(by_run.instrument_doubts());
        }
        let mut document =
            test_point_text::document(&points, &by_run.json()?).map_err(|error| Failure::Running(error.to_string()))?;
        let besides = by_run.frequency_part(in_band.as_ref(), &mut document, style);
        say(&format!("{}{besides}", test_point_text::text(&points, style)), to_standard_output)?;
        if let Some(json) = &args.json {
            provenance.write_json(json, DocumentSchema::Identify, &format!("{document:#}\n"))?;
        }
        let mut good = true;
        for (name, point) in models.iter().zip(&points) {
            let model = args.out.as_ref().map(|folder| folder.join(name));
            good &= is_converged(&point.identified, model.as_deref(), stopped);
        }
        if let Some(folder) = &args.out {
            std::fs::create_dir_all(folder).map_err(|error| Failure::io(folder, &error))?;
            provenance.write_json(&folder.join(NUMBERS), DocumentSchema::Identify, &format!("{document:#}\n"))?;
            let page = page::of_test_points(&points, in_band.as_ref()).map_err(|error| Failure::Running(error.to_string()))?;
            write_whole(&folder.join(REPORT), |file| file.write_all(provenance.at_the_foot_of(&page).as_bytes()))?;
            for (name, (group, point)) in models.iter().zip(groups.iter().zip(&points)) {
                if let Some(model) = model_output::model(&point.identified, &of_group(group, &runs)) {
                    write_whole(&folder.join(name), |file| file.write_all(model.as_bytes()))?;
                }
            }
        }
        return Ok(outcome(good, lost));
    }
    let (identified, stopped) = watched("output error", |work| {
        identify(&runs, &holdout, wanted, &FitSettings { watch: Some(work), ..FitSettings::default() })
    })?;
    let mut identified = identified.map_err(not_identified)?;
    lost |= stopped && say_stopped();
    identified.linear.notes.splice(..0, chosen);
    let formed = nondimensional(&identified, &runs);

    let by_run = PipelineResults::of(args, &sources, &runs, &mapping, band)?;
    identified.linear.notes.extend(by_run.instrument_doubts());
    let mut document =
        json::document(&identified, formed.as_ref(), &by_run.json()?).map_err(|error| Failure::Running(error.to_string()))?;
    let besides = by_run.frequency_part(in_band.as_ref(), &mut document, style);

    say(&format!("{}{besides}", table::text(&identified, style)), to_standard_output)?;
    if let Some(json) = &args.json {
        provenance.write_json(json, DocumentSchema::Identify, &format!("{document:#}\n"))?;
    }
    let model = args.out.as_ref().map(|folder| folder.join("model.toml"));
    let good = is_converged(&identified, model.as_deref(), stopped);
    if let Some(folder) = &args.out {
        std::fs::create_dir_all(folder).map_err(|error| Failure::io(folder, &error))?;
        provenance.write_json(&folder.join(NUMBERS), DocumentSchema::Identify, &format!("{document:#}\n"))?;
        let page = page::of_model(&identified, formed.as_ref(), in_band.as_ref())
            .map_err(|error| Failure::Running(error.to_string()))?;
        write_whole(&folder.join(REPORT), |file| file.write_all(provenance.at_the_foot_of(&page).as_bytes()))?;
        if let Some(model) = model_output::model(&identified, &runs) {
            write_whole(&folder.join("model.toml"), |file| file.write_all(model.as_bytes()))?;
        }
    }
    Ok(outcome(good, lost))
}

/// Refuses, before the fit, to write over files of the user in the folder of the results.
fn refuse_standing<'n>(args: &IdentifyArgs, names: impl IntoIterator<Item = &'n str>) -> Result<(), Failure> {
    let Some(folder) = &args.out else { return Ok(()) };
    args.replace.refuse_in("--out", folder, names)
}

/// A search that has not converged gives no answer, whatever was lost.
fn outcome(converged: bool, lost: bool) -> Outcome {
    match (converged, lost) {
        (false, _) => Outcome::NotGood,
        (true, true) => Outcome::DataLost,
        (true, false) => Outcome::Done,
    }
}

/// The call and everything that it reads.
fn provenance(args: &IdentifyArgs, files: impl Iterator<Item = PathBuf>, read: &[(&PathBuf, &Columns)]) -> Provenance {
    let besides = args.model.iter().chain(&args.config).chain(&args.map.map).cloned();
    let all = Provenance::of(files.chain(besides));
    read.iter().fold(all, |all, (file, run)| all.dated(file, run.recorded_at.as_deref()))
}

/// Each run by itself through the pipeline of `replay`.
struct PipelineResults {
    runs: Vec<RunResult>,
    in_band: bool,
}

impl PipelineResults {
    fn of(
        args: &IdentifyArgs,
        sources: &[RecordingSource],
        columns: &[Columns],
        mapping: &Mapping,
        band: Option<Band>,
    ) -> Result<Self, Failure> {
        let mut config = PipelineConfig::default();
        config.estimation.trim_window_s = args.trim_window;
        if let Some(band) = band {
            frequency_domain::whole_record(&mut config, band);
        }
        let stop = stopped_by_signals()?;
        let through = |source: &RecordingSource| through_pipeline(source, &config, mapping, &stop);
        let mut runs = sources.iter().map(through).collect::<Result<Vec<_>, _>>()?;
        runs.iter_mut().zip(columns).for_each(|(run, columns)| run.name.clone_from(&columns.run));
        Ok(PipelineResults { runs, in_band: band.is_some() })
    }

    /// Runs of which the pipeline withholds derivatives because of an instrument, a sentence each.
    fn instrument_doubts(&self) -> impl Iterator<Item = String> {
        self.runs.iter().filter_map(|run| {
            let doubt = run.instrument_doubt()?;
            let name = &run.name;
            Some(format!("run {name}: {doubt}; what is fitted here rests on its readings: see `sideslip check`"))
        })
    }

    fn json(&self) -> Result<String, Failure> {
        let estimates = |run| if self.in_band { RunResult::estimates_in_band(run) } else { RunResult::estimates(run) };
        let estimates: Vec<_> = self.runs.iter().map(estimates).collect();
        derivatives_json(&estimates).map_err(|error| Failure::Running(error.to_string()))
    }

    /// What the frequency domain says besides: into the document, and for a person.
    fn frequency_part(&self, in_band: Option<&FrequencyDomainResult>, document: &mut serde_json::Value, style: Style) -> String {
        let Some(in_band) = in_band else { return String::new() };
        in_band.put(document);
        format!("\n{}", in_band.text(&self.runs, style))
    }
}

fn of_group(group: &[usize], runs: &[Columns]) -> Vec<Columns> {
    group.iter().filter_map(|&place| runs.get(place).cloned()).collect()
}

/// Each test point identified, beside the model trimmed there.
fn by_test_point(
    args: &IdentifyArgs,
    (runs, holdout, sideslips): (&[Columns], &[Columns], &[Columns]),
    groups: &[Vec<usize>],
    wanted: &IdentificationRequest,
    settings: &FitSettings,
) -> Result<Vec<TestPointResult>, Failure> {
    let models = TrimmedModels::new(&args.model, args.density);
    let of = |group: &[usize]| of_group(group, runs);
    let conditions: Vec<TestCondition> =
        groups.iter().map(|group| TestCondition::mean(&of(group).iter().map(TestCondition::of).collect::<Vec<_>>())).collect();
    let at = |run: &Columns, place: usize| conditions.get(place).is_some_and(|one| one.is_near(&TestCondition::of(run)));
    for (option, others) in [("--holdout", holdout), ("--sideslips", sideslips)] {
        if let Some(run) = others.iter().find(|run| !(0..conditions.len()).any(|place| at(run, place))) {
            let TestCondition { speed, path, .. } = TestCondition::of(run);
            return Err(Failure::Input(format!(
                "{option}: `{}` was flown at {} m/s on a path of {} degrees; expected a run of a test point that is fitted",
                run.run,
                Fixed(speed, 1),
                Fixed(path.to_degrees(), 1)
            )));
        }
    }
    let one = |(place, group): (usize, &Vec<usize>)| {
        let condition = conditions.get(place).copied().unwrap_or_else(|| TestCondition::mean(&[]));
        let kept: Vec<Columns> = holdout.iter().filter(|run| at(run, place)).cloned().collect();
        let held: Vec<&Columns> = sideslips.iter().filter(|run| at(run, place)).collect();
        test_point((&of(group), &kept, &held), wanted, models.at(&condition)?, settings)
    };
    groups.iter().enumerate().map(one).collect()
}

/// The table, where the JSON leaves room for it.
fn say(text: &str, json_on_standard_output: bool) -> Result<(), Failure> {
    if json_on_standard_output {
        message_text(text.trim_end());
        return Ok(());
    }
    print(text)
}

/// Says that a signal ended the fit.
fn say_stopped() -> bool {
    message(format_args!("sideslip: stopped by a signal: the numbers are those of the search until then"));
    true
}

/// Whether there are any.
fn say_losses<'l>(losses: impl Iterator<Item = &'l Vec<String>>) -> bool {
    let losses: Vec<&String> = losses.flatten().collect();
    losses.iter().for_each(|loss| message_once(format_args!("sideslip: {loss}")));
    !losses.is_empty()
}

/// What was asked for, and the usual where nothing was.
fn choice(args: &IdentifyArgs, usual: ModelVariables) -> ModelVariables {
    if args.states.is_empty() {
        let or = |asked: &[String], usual: Vec<String>| if asked.is_empty() { usual } else { asked.to_vec() };
        return ModelVariables {
            states: usual.states,
            inputs: or(&args.inputs, usual.inputs),
            outputs: or(&args.outputs, usual.outputs),
        };
    }
    let measured = args.states.iter().map(|state| match state.as_str() {
        "v" => "beta".to_owned(),
        "w" => "alpha".to_owned(),
        "u" => "tas".to_owned(),
        own => own.to_owned(),
    });
    let outputs = if args.outputs.is_empty() { measured.collect() } else { args.outputs.clone() };
    let inputs = if args.inputs.is_empty() { usual.inputs } else { args.inputs.clone() };
    ModelVariables { states: args.states.clone(), inputs, outputs }
}
