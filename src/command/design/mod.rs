//! `sideslip design`: spectra of test inputs, the standard errors to be expected after them, and the best sequence.

mod result;

use super::options::flight_condition;
use super::options::flight_condition::{FlightCondition, number};
use super::options::replace_option::ReplaceOption;
use super::recordings::provenance::Provenance;
use super::terminal::console::print;
use super::terminal::output_file::{refuse_to_overwrite, refuse_without_folder, same_place, write_whole};
use super::terminal::progress_line::ProgressLine;
use super::terminal::stop::stopped_by_signals;
use crate::command::{message, message_text};
use result::{DesignCandidate, STATES, name_of, panels, to_json, to_table};
use serde_json::json;
use sideslip::dynamics::linear::with_effects;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::effect::Effect;
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::LinearModel;
use sideslip::io::outputs::charts::chart::svg;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::number::Digits;
use sideslip::simulation::input_design::information::{DesignParameter, outputs};
use sideslip::simulation::input_design::search::{Criterion, DesignLimits, DesignProblem, EvaluatedInput, LEAST_AMPLITUDE};
use sideslip::simulation::input_design::spectrum::{energy, outline};
use sideslip::simulation::instrument::InstrumentSet;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

const EXAMPLE: &str = "\
Example:
  sideslip design --model puma-100kn.toml --control pedal
  sideslip design --model puma-100kn.toml --control pedal --derivatives N_v,N_p,N_r --limit phi=0.2 --svg pedal.svg
  sideslip design --model puma --speed 36 --climb -5 --set hub=exact --control lon_cyclic --longest 7

Step, doublet and 3211 at the given clock are compared with the best of all sequences up to --longest clocks. Standard errors
are the Cramer-Rao bounds for the model as it is linear about trim, with white noise of flight-test instruments and an unknown
bias of each channel. Estimated with the derivatives that are named is every other one of their equations (all of N for N_v) that
this flight identifies; --free named takes those as known, and is optimistic. Derivatives of other equations are taken as
known. The bound is that of output error; the regression of `replay` scatters 4 to 10 times more, and its bias may reorder
inputs. They rank inputs; real errors are larger, and more so beyond the limits within which the aircraft is linear: u 5, w 4,
v 2.5 m/s, q r 0.3, p 0.5 rad/s, theta 0.2, phi 0.35 rad unless --limit says otherwise. What is found is written as
`simulate --input` takes it.";

/// Highest frequency of the spectra, rad/s, and their step.
const SPECTRUM: (f64, f64) = (15.0, 0.05);

/// Compare test inputs by spectrum and expected standard errors, and search the best
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct DesignArgs {
    #[command(flatten)]
    condition: FlightCondition,
    /// The control that moves: lon_cyclic, lat_cyclic, collective, pedal (or elevator, aileron, throttle, rudder)
    #[arg(long, value_name = "CONTROL")]
    control: String,
    /// Derivatives of interest, such as N_v,N_p,N_r [default: those of the control's own motion that the model has]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    derivatives: Vec<String>,
    /// What is estimated: all derivatives of the equations of those that are named, or only the named ones
    #[arg(long, value_name = "all|named", default_value = "all", hide_possible_values = true)]
    free: FreeDerivatives,
    /// Weights of their relative variances in the criterion, in the same order [default: 1 each]
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_negative_numbers = true)]
    weights: Vec<f64>,
    /// Minimise the weighted sum of relative variances, or the determinant of the dispersion
    #[arg(long, value_name = "trace|logdet", default_value = "trace")]
    criterion: String,
    /// Largest deviation of the control, rad
    #[arg(long, value_name = "RAD", default_value_t = 0.02, allow_negative_numbers = true, value_parser = number("rad"))]
    amplitude: f64,
    /// Clock of doublet and 3211, s
    #[arg(long, value_name = "S", default_value_t = 0.7, allow_negative_numbers = true, value_parser = number("s"))]
    clock: f64,
    /// Clocks that the search tries, s
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [0.3, 0.5, 0.7, 1.0],
        allow_negative_numbers = true, value_parser = number("s"))]
    clocks: Vec<f64>,
    /// Longest sequence of the search, clocks
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=14))]
    longest: u32,
    /// Largest deviation of a state from trim, such as phi=0.35 (u v w in m/s, p q r in rad/s, phi theta in rad; inf for none);
    /// repeatable
    #[arg(long, value_name = "STATE=LIMIT")]
    limit: Vec<String>,
    /// Length of the record, s
    #[arg(long, value_name = "S", default_value_t = 20.0, allow_negative_numbers = true, value_parser = number("s"))]
    duration: f64,
    /// Samples a second
    #[arg(long, value_name = "HZ", default_value_t = 50.0, allow_negative_numbers = true, value_parser = number("Hz"))]
    rate: f64,
    /// Draw inputs and spectra into this file (SVG)
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write the result as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// What is estimated with the derivatives that are named.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FreeDerivatives {
    All,
    Named,
}

pub(crate) fn run(args: &DesignArgs) -> Result<Outcome, Failure> {
    for (option, file) in [("--json", &args.json), ("--svg", &args.svg)] {
        if let Some(file) = file {
            refuse_without_folder(option, file)?;
            refuse_to_overwrite(option, file, std::slice::from_ref(&args.condition.model))?;
            args.replace.refuse(option, file)?;
        }
    }
    if let (Some(json), Some(svg)) = (&args.json, &args.svg)
        && same_place(json, svg)
    {
        return Err(Failure::file(svg, "--svg: expected another file than --json's, found the same"));
    }
    let flight = args.condition.read()?;
    let file = &flight.file;
    let model = &changed(file)?;
    let control = Control::from_name(&args.control).ok_or_else(|| {
        let names = "lon_cyclic lat_cyclic collective pedal; fixed wing: elevator aileron throttle rudder";
        Failure::Input(format!("--control: expected the name of a control ({names}), found `{}`", args.control))
    })?;
    let parameters = parameters(args, model, control)?;
    let free = if args.free == FreeDerivatives::All { others(&parameters, control) } else { Vec::new() };
    let criterion = criterion(args, parameters.len())?;
    let limits = limits(args)?;
    let read = outputs(model, &InstrumentSet::flight_quality(1.0));
    let problem = DesignProblem {
        model,
        parameters: &parameters,
        free: &free,
        outputs: &read,
        control,
        criterion: &criterion,
        limits: &limits,
        known: None,
    };
    let omegas: Vec<f64> = (1..).map(|k| SPECTRUM.1 * f64::from(k)).take_while(|omega| *omega <= SPECTRUM.0).collect();
    let candidate = |name: &'static str, judged: EvaluatedInput| {
        let deviation = judged.spec.deviation(limits.lead_s);
        let energies: Vec<f64> = omegas.iter().map(|&omega| energy(&deviation, omega)).collect();
        let outline = outline(&omegas, &energies);
        let errors = problem.wanted(&judged.information).and_then(|information| information.standard_errors());
        DesignCandidate { name, errors, judged, energies, outline }
    };
    let mut candidates = Vec::new();
    for (name, pattern) in [("step", [].as_slice()), ("doublet", &[1, 1]), ("3211", &[3, 2, 1, 1])] {
        let judged = problem.judge(pattern, args.clock);
        let end_s = judged.spec.end_s(limits.lead_s);
        match (end_s <= limits.duration_s, judged.fits) {
            (true, true) => candidates.push(candidate(name, judged)),
            (false, _) => {
                let (end, whole) = (Digits(end_s, 4), limits.duration_s);
                message(format_args!("note: {name} left out: it lasts to {end} s, the record to {whole} s"));
            }
            (true, false) => message(format_args!("note: {name} left out: {}", no_room(&problem, &judged))),
        }
    }
    let SearchedInputs { best, cut_short } = searched(&problem)?;
    match best {
        Some(best) => candidates.push(candidate("best found", best)),
        None => message(format_args!("note: no sequence of this control alone gives all of these derivatives")),
    }
    let names: Vec<String> = parameters.iter().map(|parameter| name_of(*parameter, file.controls)).collect();
    let mut table = flight_condition::in_words(&flight).map_or_else(String::new, |words| format!("{words}\n\n"));
    table.push_str(&to_table(&candidates, &names, &parameters, model));
    if !free.is_empty() {
        let besides: Vec<String> = free.iter().map(|parameter| name_of(*parameter, file.controls)).collect();
        let _ = writeln!(table, "  unknown besides: {}", besides.join(" "));
    }
    if let Some(path) = &args.svg {
        let picture = svg(&panels(&candidates, &omegas, &limits)).map_err(|error| Failure::Running(error.to_string()))?;
        write_whole(path, |file| file.write_all(picture.as_bytes()))?;
    }
    match &args.json {
        None => print(&table)?,
        Some(path) => {
            message_text(table.trim_end());
            let mut result = to_json(&candidates, &names, &parameters, model, &omegas);
            if let Some(result) = result.as_object_mut() {
                let besides: Vec<String> = free.iter().map(|parameter| name_of(*parameter, file.controls)).collect();
                result.extend([("level1".to_owned(), flight_condition::to_json(&flight)), ("free".to_owned(), json!(besides))]);
            }
            let mut text = serde_json::to_string_pretty(&result).map_err(|error| Failure::Running(error.to_string()))?;
            text.push('\n');
            Provenance::of([args.condition.model.clone()]).write_json(path, DocumentSchema::Design, &text)?;
        }
    }
    match cut_short {
        None => Ok(Outcome::Done),
        Some((tried, all)) => {
            message(format_args!(
                "sideslip: stopped by a signal after {tried} of {all} sequences: `best found` is the best of these"
            ));
            Ok(Outcome::DataLost)
        }
    }
}

/// What the search came to; where a signal ended it, after how many sequences of how many.
struct SearchedInputs {
    best: Option<EvaluatedInput>,
    cut_short: Option<(u64, u64)>,
}

/// The best sequence, and how far the search is while it lasts.
fn searched(problem: &DesignProblem<'_>) -> Result<SearchedInputs, Failure> {
    let stop = stopped_by_signals()?;
    let (all, mut tried, mut fitting, mut progress) = (problem.sequences() as u64, 0_u64, 0_u64, ProgressLine::new());
    let (mut least, mut leader, mut widest) = (f64::INFINITY, String::new(), None::<EvaluatedInput>);
    let best = problem.search(|judged| {
        tried += 1;
        fitting += u64::from(judged.fits);
        if judged.cost < least {
            (least, leader) = (judged.cost, format!(", best so far {}", judged.spec));
        }
        if widest.is_none() {
            widest = Some(judged.clone());
        }
        progress.show_part(tried, all, || format!("{tried} of {all} sequences{leader}"));
        !stop.load(Ordering::Relaxed)
    });
    drop(progress);
    let cut_short = stop.load(Ordering::Relaxed).then_some((tried, all));
    match widest {
        _ if cut_short.is_some() => Ok(SearchedInputs { best, cut_short }),
        None => Err(Failure::Input("--clocks: no sequence fits into the record; lengthen --duration".to_owned())),
        Some(judged) if fitting == 0 => Err(Failure::Input(format!("--limit: no input fits: {}", no_room(problem, &judged)))),
        Some(_) => {
            message(format_args!(
                "{tried} sequences tried{}",
                if fitting < tried { format!(", {fitting} fit") } else { String::new() }
            ));
            Ok(SearchedInputs { best, cut_short })
        }
    }
}

fn no_room(problem: &DesignProblem<'_>, judged: &EvaluatedInput) -> String {
    let place = problem.tightest(&judged.information);
    let (state, limit) = (STATES.get(place).map_or("", |(name, _)| name), problem.limits.excursion.get(place).copied());
    format!("even with {LEAST_AMPLITUDE} rad it takes {state} beyond the limit of {}", limit.unwrap_or_default())
}

/// Every other derivative of their equations, of states and of the control that moves: what this flight could tell.
fn others(named: &[DesignParameter], control: Control) -> Vec<DesignParameter> {
    let variables = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R, control.variable()];
    let concerned = Axis::ALL.into_iter().filter(|axis| named.iter().any(|parameter| parameter.axis == *axis));
    let all = concerned.flat_map(|axis| variables.map(|variable| DesignParameter { axis, variable }));
    all.filter(|parameter| !named.contains(parameter)).collect()
}

/// The model with its effects in it; what no linear model can hold is left out, and it is said.
fn changed(file: &ModelFile) -> Result<LinearModel, Failure> {
    let effects = file.own_effects();
    for effect in &effects {
        if !matches!(
            effect,
            Effect::Derivative { .. }
                | Effect::Nonlinear { .. }
                | Effect::ControlEffectiveness { .. }
                | Effect::FlightPath { .. }
        ) {
            message(format_args!("note: the effect `{}` is left out of the design", effect.kind().name()));
        }
    }
    with_effects(&file.linear, &effects)
        .map_err(|_| Failure::Input("the model's effects add more nonlinear terms than a model may have".to_owned()))
}

/// As named, or those that the control's own motion shows and the model has.
fn parameters(args: &DesignArgs, model: &LinearModel, control: Control) -> Result<Vec<DesignParameter>, Failure> {
    if args.derivatives.is_empty() {
        let lateral = matches!(control, Control::LatCyclic | Control::Pedal);
        let (axes, variables) = match lateral {
            true => ([Axis::N, Axis::L, Axis::Y], [Variable::V, Variable::P, Variable::R]),
            false => ([Axis::M, Axis::Z, Axis::X], [Variable::U, Variable::W, Variable::Q]),
        };
        let all = axes.into_iter().flat_map(|axis| {
            variables.into_iter().chain([control.variable()]).map(move |variable| DesignParameter { axis, variable })
        });
        let had: Vec<DesignParameter> =
            all.filter(|&DesignParameter { axis, variable }| model.derivative(axis, variable) != 0.0).collect();
        return match had.is_empty() {
            true => Err(Failure::Input(format!("--control: the model has no derivative of the motion by `{}`", args.control))),
            false => Ok(had),
        };
    }
    let parse = |text: &String| {
        let text = text.trim();
        let wrong = || Failure::Input(format!("--derivatives: expected names such as N_v or L_pedal, found `{text}`"));
        let (axis, variable) = text.split_once('_').ok_or_else(wrong)?;
        let parameter = DesignParameter {
            axis: Axis::from_name(axis).ok_or_else(wrong)?,
            variable: Variable::from_name(variable).ok_or_else(wrong)?,
        };
        if model.derivative(parameter.axis, parameter.variable) == 0.0 {
            let what = format!("--derivatives: expected derivatives of the model that are not zero, found `{text}`");
            return Err(Failure::Input(what));
        }
        Ok(parameter)
    };
    let named: Vec<DesignParameter> = args.derivatives.iter().map(parse).collect::<Result<_, _>>()?;
    for (place, parameter) in named.iter().enumerate() {
        if named.iter().take(place).any(|before| before == parameter) {
            let twice = name_of(*parameter, ControlNames::Rotorcraft);
            return Err(Failure::Input(format!("--derivatives: expected each once, found {twice} twice")));
        }
    }
    Ok(named)
}

fn criterion(args: &DesignArgs, count: usize) -> Result<Criterion, Failure> {
    let weights = if args.weights.is_empty() { vec![1.0; count] } else { args.weights.clone() };
    let expected = format!("--weights: expected {count} numbers of zero or more, one a derivative and not all zero");
    if weights.len() != count {
        return Err(Failure::Input(format!("{expected}, found {}", weights.len())));
    }
    if let Some(wrong) = weights.iter().find(|weight| !(weight.is_finite() && **weight >= 0.0)) {
        return Err(Failure::Input(format!("{expected}, found {wrong}")));
    }
    if !weights.iter().any(|weight| *weight > 0.0) {
        return Err(Failure::Input(format!("{expected}, found zeros only")));
    }
    match args.criterion.as_str() {
        "trace" => Ok(Criterion::Trace(weights)),
        "logdet" => Ok(Criterion::LogDeterminant),
        other => Err(Failure::Input(format!("--criterion: expected trace or logdet, found `{other}`"))),
    }
}

fn limits(args: &DesignArgs) -> Result<DesignLimits, Failure> {
    let within = |option: &str, value: f64, least: f64, most: f64| match (least..=most).contains(&value) {
        true => Ok(value),
        false => Err(Failure::Input(format!("{option}: expected {least} to {most}, found {value}"))),
    };
    let mut excursion = STATES.map(|(_, usual)| usual);
    for text in &args.limit {
        let names = STATES.map(|(state, _)| state).join(" ");
        let wrong = || {
            let expected = format!("STATE=LIMIT such as phi=0.35, with a state of {names} and a limit above zero in SI units");
            Failure::Input(format!("--limit: expected {expected}, found `{text}`"))
        };
        let (name, limit) = text.split_once('=').ok_or_else(wrong)?;
        let place = STATES.iter().position(|(state, _)| *state == name).ok_or_else(wrong)?;
        let limit = limit.parse::<f64>().ok().filter(|limit| *limit > 0.0).ok_or_else(wrong)?;
        excursion.iter_mut().skip(place).take(1).for_each(|entry| *entry = limit);
    }
    for (place, clock) in args.clocks.iter().enumerate() {
        if args.clocks.iter().take(place).any(|before| before.total_cmp(clock).is_eq()) {
            return Err(Failure::Input(format!("--clocks: expected each once, found {clock} twice")));
        }
    }
    let clocks_s = args.clocks.iter().map(|&clock| within("--clocks", clock, 0.05, 10.0)).collect::<Result<Vec<_>, _>>()?;
    within("--clock", args.clock, 0.05, 10.0)?;
    Ok(DesignLimits {
        amplitude: within("--amplitude", args.amplitude, 1e-5, 1.0)?,
        excursion,
        clocks_s,
        longest: args.longest,
        lead_s: 1.0,
        duration_s: within("--duration", args.duration, 2.0, 600.0)?,
        rate_hz: within("--rate", args.rate, 1.0, 256.0)?,
    })
}
