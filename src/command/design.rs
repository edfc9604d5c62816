//! `sideslip design`: spectra of test inputs, the standard errors to be expected after them, and the best sequence.

use super::message;
use super::model_input::read_model;
use super::output_file::{print, refuse_to_overwrite, write_json, write_whole};
use super::stop::stopped_by_signals;
use serde_json::{Value, json};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::effect::Effect;
use sideslip::flight::model::LinearModel;
use sideslip::flight::model_file::ModelFile;
use sideslip::outputs::chart::{Curve, Panel, svg};
use sideslip::outputs::text::{Digits, TermName, derivative_unit};
use sideslip::simulation::design::dispersion::Uninformed;
use sideslip::simulation::design::information::{Parameter, outputs};
use sideslip::simulation::design::search::{Criterion, Judged, Limits, Problem};
use sideslip::simulation::design::spectrum::{Outline, energy, outline};
use sideslip::simulation::flight_model::Asked;
use sideslip::simulation::instrument::Instruments;
use sideslip::simulation::linear::with_effects;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

const EXAMPLE: &str = "\
Example:
  sideslip design --model puma-100kn.toml --control pedal
  sideslip design --model puma-100kn.toml --control pedal --derivatives N_v,N_p,N_r --limit phi=0.2 --svg pedal.svg

Step, doublet and 3211 at the given clock are compared with the best of all sequences up to --longest clocks. Standard errors
are the Cramer-Rao bounds for the model as it is linear about trim, with white noise of flight-test instruments, an unknown bias
of each channel, and every derivative that is not named exactly known. They rank inputs; real errors are several times larger,
and more so beyond the limits within which the aircraft is linear: u 5, w 4, v 2.5 m/s, q r 0.3, p 0.5 rad/s, theta 0.2,
phi 0.35 rad unless --limit says otherwise. What is found is written as `simulate --input` takes it.";

/// States by the names under which they are limited, with their usual limits: what keeps a linear model true.
const STATES: [(&str, f64); 8] =
    [("u", 5.0), ("w", 4.0), ("q", 0.3), ("theta", 0.2), ("v", 2.5), ("p", 0.5), ("phi", 0.35), ("r", 0.3)];

/// Highest frequency of the spectra, rad/s, and their step.
const SPECTRUM: (f64, f64) = (15.0, 0.05);

/// Compare test inputs by spectrum and expected standard errors, and search the best
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Model file (TOML), or puma
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// The control that moves: lon_cyclic, lat_cyclic, collective, pedal (or elevator, aileron, throttle, rudder)
    #[arg(long, value_name = "CONTROL")]
    control: String,
    /// Derivatives that are to be known, such as N_v,N_p,N_r [default: those of the control's own motion that the model has]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    derivatives: Vec<String>,
    /// Weights of their relative variances in the criterion, in the same order [default: 1 each]
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_negative_numbers = true)]
    weights: Vec<f64>,
    /// Minimise the weighted sum of relative variances, or the determinant of the dispersion
    #[arg(long, value_name = "trace|logdet", default_value = "trace")]
    criterion: String,
    /// Largest deviation of the control, rad
    #[arg(long, value_name = "RAD", default_value_t = 0.02, allow_negative_numbers = true)]
    amplitude: f64,
    /// Clock of doublet and 3211, s
    #[arg(long, value_name = "S", default_value_t = 0.7, allow_negative_numbers = true)]
    clock: f64,
    /// Clocks that the search tries, s
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [0.3, 0.5, 0.7, 1.0])]
    clocks: Vec<f64>,
    /// Longest sequence of the search, clocks
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=14))]
    longest: u32,
    /// Largest deviation of a state from trim, such as phi=0.35 (u v w in m/s, p q r in rad/s, phi theta in rad); repeatable
    #[arg(long, value_name = "STATE=LIMIT")]
    limit: Vec<String>,
    /// Length of the record, s
    #[arg(long, value_name = "S", default_value_t = 20.0, allow_negative_numbers = true)]
    duration: f64,
    /// Samples a second
    #[arg(long, value_name = "HZ", default_value_t = 50.0, allow_negative_numbers = true)]
    rate: f64,
    /// Draw inputs and spectra into this file (SVG)
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write the result as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// An input with its name, spectrum and worth.
struct Candidate {
    name: &'static str,
    judged: Judged,
    errors: Result<Vec<f64>, Uninformed>,
    energies: Vec<f64>,
    outline: Option<Outline>,
}

/// Compares and searches.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    for (option, file) in [("--json", &args.json), ("--svg", &args.svg)] {
        if let Some(file) = file {
            refuse_to_overwrite(option, file, std::slice::from_ref(&args.model))?;
        }
    }
    let file = read_model(&args.model, &Asked::default())?.file;
    let model = &changed(&file)?;
    let control = Control::from_name(&args.control)
        .ok_or_else(|| Failure::Input(format!("--control: expected the name of a control, found `{}`", args.control)))?;
    let parameters = parameters(args, model, control)?;
    let criterion = criterion(args, parameters.len())?;
    let limits = limits(args)?;
    let read = outputs(model, &Instruments::flight_quality(1.0));
    let problem =
        Problem { model, parameters: &parameters, outputs: &read, control, criterion: &criterion, limits: &limits, known: None };
    let omegas: Vec<f64> = (1..).map(|k| SPECTRUM.1 * f64::from(k)).take_while(|omega| *omega <= SPECTRUM.0).collect();
    let candidate = |name: &'static str, judged: Judged| {
        let deviation = judged.spec.deviation(limits.lead_s);
        let energies: Vec<f64> = omegas.iter().map(|&omega| energy(&deviation, omega)).collect();
        let outline = outline(&omegas, &energies);
        Candidate { name, errors: judged.information.standard_errors(), judged, energies, outline }
    };
    let mut candidates = vec![
        candidate("step", problem.judge(&[], args.clock)),
        candidate("doublet", problem.judge(&[1, 1], args.clock)),
        candidate("3211", problem.judge(&[3, 2, 1, 1], args.clock)),
    ];
    let stop = stopped_by_signals()?;
    let mut tried = 0_u64;
    let best = problem.search(|_| {
        tried += 1;
        !stop.load(Ordering::Relaxed)
    });
    if stop.load(Ordering::Relaxed) {
        return Err(Failure::Running(format!("stopped by a signal after {tried} sequences")));
    }
    message(format_args!("{tried} sequences tried"));
    match best {
        Some(best) => candidates.push(candidate("best found", best)),
        None => message(format_args!("note: no sequence of this control alone gives all of these derivatives")),
    }
    let names: Vec<String> = parameters.iter().map(|parameter| name_of(*parameter, file.controls)).collect();
    let table = to_table(&candidates, &names, &parameters, model);
    if let Some(path) = &args.svg {
        let picture = svg(&panels(&candidates, &omegas, &limits)).map_err(|error| Failure::Running(error.to_string()))?;
        write_whole(path, |file| file.write_all(picture.as_bytes()))?;
    }
    match &args.json {
        None => print(&table)?,
        Some(path) => {
            message(format_args!("{}", table.trim_end()));
            let result = to_json(&candidates, &names, &parameters, model, &omegas);
            let mut text = serde_json::to_string_pretty(&result).map_err(|error| Failure::Running(error.to_string()))?;
            text.push('\n');
            write_json(path, &text)?;
        }
    }
    Ok(Outcome::Done)
}

/// The model with its effects in it; what no linear model can hold is left out, and it is said.
fn changed(file: &ModelFile) -> Result<LinearModel, Failure> {
    let effects: Vec<Effect> = file.effects.iter().map(|declared| declared.effect).collect();
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

fn name_of(Parameter { axis, variable }: Parameter, controls: ControlNames) -> String {
    TermName { axis, variable: Some(variable), controls }.to_string()
}

/// As named, or those that the control's own motion shows and the model has.
fn parameters(args: &Args, model: &LinearModel, control: Control) -> Result<Vec<Parameter>, Failure> {
    if args.derivatives.is_empty() {
        let lateral = matches!(control, Control::LatCyclic | Control::Pedal);
        let (axes, variables) = match lateral {
            true => ([Axis::N, Axis::L, Axis::Y], [Variable::V, Variable::P, Variable::R]),
            false => ([Axis::M, Axis::Z, Axis::X], [Variable::U, Variable::W, Variable::Q]),
        };
        let all = axes
            .into_iter()
            .flat_map(|axis| variables.into_iter().chain([control.variable()]).map(move |variable| Parameter { axis, variable }));
        return Ok(all.filter(|&Parameter { axis, variable }| model.derivative(axis, variable) != 0.0).collect());
    }
    let parse = |text: &String| {
        let wrong = || Failure::Input(format!("--derivatives: expected names such as N_v or L_pedal, found `{text}`"));
        let (axis, variable) = text.split_once('_').ok_or_else(wrong)?;
        let parameter = Parameter {
            axis: Axis::from_name(axis).ok_or_else(wrong)?,
            variable: Variable::from_name(variable).ok_or_else(wrong)?,
        };
        if model.derivative(parameter.axis, parameter.variable) == 0.0 {
            let what = format!("--derivatives: expected derivatives of the model that are not zero, found `{text}`");
            return Err(Failure::Input(what));
        }
        Ok(parameter)
    };
    let named: Vec<Parameter> = args.derivatives.iter().map(parse).collect::<Result<_, _>>()?;
    for (place, parameter) in named.iter().enumerate() {
        if named.iter().take(place).any(|before| before == parameter) {
            let twice = name_of(*parameter, ControlNames::Rotorcraft);
            return Err(Failure::Input(format!("--derivatives: expected each once, found {twice} twice")));
        }
    }
    Ok(named)
}

fn criterion(args: &Args, count: usize) -> Result<Criterion, Failure> {
    let weights = if args.weights.is_empty() { vec![1.0; count] } else { args.weights.clone() };
    let usable = weights.iter().all(|weight| weight.is_finite() && *weight >= 0.0);
    if weights.len() != count || !usable {
        let found = weights.len();
        return Err(Failure::Input(format!("--weights: expected {count} numbers of zero or more, found {found}")));
    }
    match args.criterion.as_str() {
        "trace" => Ok(Criterion::Trace(weights)),
        "logdet" => Ok(Criterion::LogDeterminant),
        other => Err(Failure::Input(format!("--criterion: expected trace or logdet, found `{other}`"))),
    }
}

fn limits(args: &Args) -> Result<Limits, Failure> {
    let within = |option: &str, value: f64, least: f64, most: f64| match (least..=most).contains(&value) {
        true => Ok(value),
        false => Err(Failure::Input(format!("{option}: expected {least} to {most}, found {value}"))),
    };
    let mut excursion = STATES.map(|(_, usual)| usual);
    for text in &args.limit {
        let wrong = || Failure::Input(format!("--limit: expected STATE=LIMIT such as phi=0.35, found `{text}`"));
        let (name, limit) = text.split_once('=').ok_or_else(wrong)?;
        let place = STATES.iter().position(|(state, _)| *state == name).ok_or_else(wrong)?;
        let limit = limit.parse::<f64>().ok().filter(|limit| *limit > 0.0).ok_or_else(wrong)?;
        excursion.iter_mut().skip(place).take(1).for_each(|entry| *entry = limit);
    }
    let clocks_s = args.clocks.iter().map(|&clock| within("--clocks", clock, 0.05, 10.0)).collect::<Result<Vec<_>, _>>()?;
    within("--clock", args.clock, 0.05, 10.0)?;
    Ok(Limits {
        amplitude: within("--amplitude", args.amplitude, 1e-5, 1.0)?,
        excursion,
        clocks_s,
        longest: args.longest,
        lead_s: 1.0,
        duration_s: within("--duration", args.duration, 2.0, 600.0)?,
        rate_hz: within("--rate", args.rate, 1.0, 256.0)?,
    })
}

fn to_table(candidates: &[Candidate], names: &[String], parameters: &[Parameter], model: &LinearModel) -> String {
    let mut text = String::from("Inputs\n");
    for candidate in candidates {
        let _ = write!(text, "  {:<10} {}", candidate.name, candidate.judged.spec);
        if let Some(Outline { peak, half_power: [from, to], nodes }) = &candidate.outline {
            let _ = write!(
                text,
                "   most energy at {} rad/s, half that density {} to {}",
                Digits(*peak, 3),
                Digits(*from, 3),
                Digits(*to, 3)
            );
            if !nodes.is_empty() {
                let nodes: Vec<String> = nodes.iter().take(4).map(|node| Digits(*node, 3).to_string()).collect();
                let _ = write!(text, ", nodes at {}", nodes.join(", "));
            }
        }
        text.push('\n');
    }
    text.push_str("\nStandard errors at best\n");
    let _ = write!(text, "  {:<14} {:>10} {:<12}", "", "value", "unit");
    candidates.iter().for_each(|candidate| {
        let _ = write!(text, " {:>10}", candidate.name);
    });
    text.push('\n');
    for (place, (name, parameter)) in names.iter().zip(parameters).enumerate() {
        let value = model.derivative(parameter.axis, parameter.variable);
        let unit = derivative_unit(parameter.axis, Some(parameter.variable));
        let _ = write!(text, "  {name:<14} {:>10} {unit:<12}", Digits(value, 4).to_string());
        for candidate in candidates {
            let error = candidate.errors.as_ref().ok().and_then(|errors| errors.get(place));
            let _ = write!(text, " {:>10}", error.map_or("-".to_owned(), |error| Digits(*error, 2).to_string()));
        }
        text.push('\n');
    }
    let _ = write!(text, "  {:<14} {:>10} {:<12}", "criterion", "", "");
    for candidate in candidates {
        let _ = write!(text, " {:>10}", Digits(candidate.judged.cost, 3).to_string());
    }
    text.push('\n');
    for candidate in candidates {
        if let Err(Uninformed(parameter)) = &candidate.errors {
            let name = name_of(*parameter, ControlNames::Rotorcraft);
            let _ = writeln!(text, "  {}: nothing in it tells {name} from the others", candidate.name);
        }
    }
    text
}

fn to_json(candidates: &[Candidate], names: &[String], parameters: &[Parameter], model: &LinearModel, omegas: &[f64]) -> Value {
    let one = |candidate: &Candidate| {
        let errors = |errors: &Vec<f64>| {
            let rows = names.iter().zip(parameters).zip(errors);
            rows.map(|((name, parameter), std)| {
                json!({"name": name, "value": model.derivative(parameter.axis, parameter.variable), "std": std})
            })
            .collect::<Vec<Value>>()
        };
        json!({
            "name": candidate.name,
            "input": candidate.judged.spec.to_string(),
            "criterion": candidate.judged.cost.is_finite().then_some(candidate.judged.cost),
            "parameters": candidate.errors.as_ref().ok().map(errors),
            "spectrum": candidate.energies,
            "nodes": candidate.outline.as_ref().map(|outline| outline.nodes.clone()),
            "excursion": STATES.iter().zip(candidate.judged.information.excursion)
                .map(|((state, _), most)| ((*state).to_owned(), json!(most))).collect::<serde_json::Map<_, _>>(),
        })
    };
    json!({"omega": omegas, "candidates": candidates.iter().map(one).collect::<Vec<Value>>()})
}

fn panels(candidates: &[Candidate], omegas: &[f64], limits: &Limits) -> [Panel; 2] {
    let title = |candidate: &Candidate| format!("{}: {}", candidate.name, candidate.judged.spec);
    let input = |candidate: &Candidate| {
        let deviation = candidate.judged.spec.deviation(limits.lead_s);
        let mut points = vec![(0.0, 0.0)];
        points.extend(deviation.points().iter().copied());
        points.push((limits.duration_s, deviation.at(limits.duration_s)));
        Curve { name: title(candidate), points }
    };
    // A step's spectrum is that of its transient: it would hide the others. Last, so that the others keep their colours.
    let (returning, steps): (Vec<_>, Vec<_>) = candidates.iter().partition(|one| !one.judged.spec.pattern.is_empty());
    let spectrum = |candidate: &Candidate| Curve {
        name: candidate.name.to_owned(),
        points: omegas.iter().copied().zip(candidate.energies.iter().copied()).collect(),
    };
    [
        Panel {
            title: "Inputs".into(),
            x: "time, s".into(),
            y: "deviation, rad".into(),
            curves: returning.iter().chain(&steps).copied().map(input).collect(),
        },
        Panel {
            title: "Energy spectra".into(),
            x: "frequency, rad/s".into(),
            y: "energy, (rad s)^2".into(),
            curves: returning.iter().copied().map(spectrum).collect(),
        },
    ]
}
