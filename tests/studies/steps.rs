//! The collapse: yaw damping and its partial F against the step of the regression, while R2 still rises.
//!
//! The paper's Fig 18: the Level-1 Puma at 80 kn under a pedal doublet. Terms enter one a step by their partial F for white
//! residuals, down to F = 1, none of them privileged, as the paper's regression did; on the information matrix that the
//! pipeline gathered. Beside it stands what the pipeline's own selection made of the same matrix.

use super::flown::{fly, puma, through};
use super::sheet::{Sheet, draw};
use crate::support::manoeuvre::LEAD_S;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::io::outputs::charts::chart::{Curve, Mark, Marks, Panel};
use sideslip::num::eigen::condition_index;
use sideslip::num::sweep::Swept;
use sideslip::realtime::regression::candidate::{BIAS, REGRESSORS, SIGNALS, STILL, UNMOVED, regressor, response, variable};
use sideslip::realtime::regression::coloured_errors;
use sideslip::realtime::regression::information::Information;
use sideslip::simulation::instrument::InstrumentSet;

/// A partial F below this enters no more; the paper's.
const F_ENTER: f64 = 1.0;

/// Terms that are watched.
const WATCHED: [(Variable, &str); 4] =
    [(Variable::R, "N_r"), (Variable::P, "N_p"), (Variable::V, "N_v"), (Variable::Pedal, "N_pedal")];

/// A watched term at one step.
#[derive(Clone, Copy)]
struct Term {
    value: f64,
    std: f64,
    /// On the standard error for white residuals, (22) of the paper.
    f_white: f64,
    /// On the standard error corrected for coloured residuals.
    f: f64,
}

/// The equation after one step.
struct Step {
    entered: &'static str,
    terms: [Option<Term>; 4],
    r_squared: f64,
    f_total: f64,
    condition: f64,
}

/// The yawing equation step by step.
fn history(information: &Information<SIGNALS>) -> Vec<Step> {
    let y = response(Axis::N);
    let sums = information.sums();
    let scale: [f64; SIGNALS] = std::array::from_fn(|i| sums[i][i].sqrt());
    let scaled = std::array::from_fn(|i| {
        std::array::from_fn(|j| if scale[i] * scale[j] > 0.0 { sums[i][j] / (scale[i] * scale[j]) } else { 0.0 })
    });
    let mut swept = Swept::new(scaled);
    assert!(swept.enter(BIAS, 1e-12));
    let mut order = vec![BIAS];
    let samples = information.effective_samples();
    let about_mean = sums[y][y] - sums[BIAS][y] * sums[BIAS][y] / information.weight();
    let moves =
        |place: usize| variable(place).is_some_and(|variable| information.deviation(place) > UNMOVED * STILL[variable.index()]);
    let mut steps = Vec::new();
    loop {
        let partial_f = |place: usize| {
            let drop = swept.at(place, y) * swept.at(place, y) / swept.at(place, place);
            drop / (swept.at(y, y) - drop) * (samples - (order.len() + 1) as f64)
        };
        let open = (1..REGRESSORS).filter(|&place| moves(place) && !swept.is_inside(place) && swept.at(place, place) > 1e-9);
        let Some(best) = open.max_by(|&a, &b| partial_f(a).total_cmp(&partial_f(b))) else { break };
        if partial_f(best) < F_ENTER || !swept.enter(best, 1e-9) {
            break;
        }
        order.push(best);
        steps.push(step(information, &swept, &scale, &order, about_mean));
    }
    steps
}

fn step(
    information: &Information<SIGNALS>,
    swept: &Swept<SIGNALS>,
    scale: &[f64; SIGNALS],
    order: &[usize],
    about_mean: f64,
) -> Step {
    let y = response(Axis::N);
    let mut dispersion = [[0.0; REGRESSORS]; REGRESSORS];
    let mut residual = [0.0; SIGNALS];
    residual[y] = 1.0;
    for &i in order {
        residual[i] = -swept.at(i, y) * scale[y] / scale[i];
        for &j in order {
            dispersion[i][j] = -swept.at(i, j) / (scale[i] * scale[j]);
        }
    }
    let covariances = coloured_errors::residual_covariance(information, &residual, &residual, order.len());
    let white = coloured_errors::white_covariance(information, &dispersion, covariances[0]);
    let corrected = coloured_errors::equation_covariance(information, order, &dispersion, &residual);
    let terms = WATCHED.map(|(variable, _)| {
        let place = regressor(variable);
        order.contains(&place).then(|| {
            let value = -residual[place];
            let f = |variance: f64| value * value / variance;
            Term { value, std: corrected[place][place].sqrt(), f_white: f(white[place][place]), f: f(corrected[place][place]) }
        })
    });
    let r_squared = 1.0 - swept.at(y, y) * scale[y] * scale[y] / about_mean;
    let (p, m) = (order.len() as f64, information.effective_samples());
    let entered = order.last().and_then(|&place| variable(place)).map_or("0", |variable| variable.name(Default::default()));
    Step {
        entered,
        terms,
        r_squared,
        f_total: r_squared / (p - 1.0) * (m - p) / (1.0 - r_squared),
        condition: condition_index(information.sums(), order),
    }
}

/// What the pipeline itself says of a watched term.
type Own = [Option<(f64, f64)>; 4];

fn write(name: &'static str, title: &str, steps: &[Step], own: &Own, truth: [f64; 4]) {
    let mut columns = vec!["entered".to_owned(), "step".into(), "R2".into(), "F_total".into(), "condition_index".into()];
    for (_, term) in WATCHED {
        columns.extend(["", "_std", "_F_white", "_F_corrected"].map(|end| format!("{term}{end}")));
    }
    let mut sheet = Sheet::new(name, &columns.iter().map(String::as_str).collect::<Vec<_>>());
    for (count, step) in steps.iter().enumerate() {
        let mut numbers = vec![(count + 1) as f64, step.r_squared, step.f_total, step.condition];
        for term in step.terms {
            numbers.extend(term.map_or([f64::NAN; 4], |term| [term.value, term.std, term.f_white, term.f]));
        }
        eprintln!(
            "step {:2} + {:10} R2 {:.6} F {:9.0} index {:6.1}; {}",
            count + 1,
            step.entered,
            step.r_squared,
            step.f_total,
            step.condition,
            WATCHED
                .iter()
                .zip(step.terms)
                .filter_map(|((_, name), term)| {
                    term.map(|term| format!("{name} {:+.4} +- {:.4} F {:.0}/{:.0}", term.value, term.std, term.f_white, term.f))
                })
                .collect::<Vec<_>>()
                .join(", ")
        );
        sheet.row(&[step.entered], &numbers);
    }
    sheet.write();
    let steps_of = |of: &dyn Fn(&Step) -> f64| -> Vec<(f64, f64)> {
        steps.iter().enumerate().map(|(count, step)| ((count + 1) as f64, of(step))).collect()
    };
    let of_term = |place: usize, of: fn(&Term) -> f64| steps_of(&|step: &Step| step.terms[place].as_ref().map_or(f64::NAN, of));
    let curve = |name: &str, points: Vec<(f64, f64)>| Curve { name: name.into(), points };
    let terms = steps.iter().map(|step| step.entered).collect::<Vec<_>>().join(" ");
    let x = format!("step; entered: {terms}");
    let last = steps.len() as f64;
    let damping = |place: usize| {
        let name = WATCHED[place].1;
        let panel = Panel {
            title: format!("{title}: {name} by step, its standard error, and the pipeline's own (last)"),
            x: x.clone(),
            y: format!("{name}, 1/s"),
            curves: vec![
                curve(name, of_term(place, |term| term.value)),
                curve("small perturbation", steps_of(&|_| truth[place])),
            ],
        };
        let estimates = steps.iter().enumerate().filter_map(|(count, step)| {
            step.terms[place].map(|term| Mark { point: ((count + 1) as f64, term.value), either_way: term.std })
        });
        let own = own[place].map(|(value, std)| Mark { point: (last + 0.3, value), either_way: std });
        let marks = vec![
            Marks { name: name.into(), marks: estimates.collect() },
            Marks { name: "pipeline's own".into(), marks: own.into_iter().collect() },
        ];
        (panel, marks)
    };
    let ratios = Panel {
        title: "Partial F ratios (white residuals, as in the paper)".into(),
        x: x.clone(),
        y: "log10 F".into(),
        curves: WATCHED
            .iter()
            .enumerate()
            .map(|(place, (_, name))| curve(name, of_term(place, |term| term.f_white.log10())))
            .collect(),
    };
    let fit = Panel {
        title: "Fit error still falls".into(),
        x: x.clone(),
        y: "log10 (1 - R2)".into(),
        curves: vec![curve("1 - R2", steps_of(&|step| (1.0 - step.r_squared).log10()))],
    };
    draw(name, &[damping(0), damping(1), (ratios, Vec::new()), (fit, Vec::new())]);
}

fn study(name: &'static str, title: &str, input: &str, instruments: &InstrumentSet, seed: u64) -> (Vec<Step>, [f64; 4]) {
    let model = puma(80.0);
    let truth = WATCHED.map(|(variable, _)| model.linear().derivative(Axis::N, variable));
    let samples = fly(&model.flight(), &[input.to_owned()], instruments, LEAD_S + 12.0, seed);
    let mut pipeline = through(&samples);
    let derivatives = pipeline.finish().derivatives.clone().unwrap();
    let equation = &derivatives.equations[Axis::N.index()];
    let own: Own = WATCHED.map(|(variable, _)| equation.term(variable).map(|term| (term.value, term.std)));
    eprintln!("{name}: truth {truth:?}; pipeline's own {own:?}, R2 {:.6}, {} terms", equation.r_squared, equation.terms.len());
    let steps = history(pipeline.regression().information());
    write(name, title, &steps, &own, truth);
    (steps, truth)
}

/// Steps at which a watched term is in, with that term.
fn watched(steps: &[Step], place: usize) -> Vec<(usize, Term)> {
    steps.iter().enumerate().filter_map(|(count, step)| step.terms[place].map(|term| (count, term))).collect()
}

/// What the paper says of its Fig 18, and what it did not have: standard errors for coloured residuals.
fn collapses(steps: &[Step], truth: [f64; 4], fall: f64) {
    assert!(steps.windows(2).all(|pair| pair[0].r_squared < pair[1].r_squared), "R2 rises at every step");
    let damping = watched(steps, 0);
    let (peak, best) = damping.iter().copied().max_by(|(_, a), (_, b)| a.f_white.total_cmp(&b.f_white)).unwrap();
    let (last, end) = damping.last().copied().unwrap();
    eprintln!("F of N_r peaks at step {}: {:.0}, is {:.0} at the last", peak + 1, best.f_white, end.f_white);
    assert!(peak < last && end.f_white < best.f_white / fall, "F of N_r has a peak and falls while R2 rises");
    // The corrected standard error falls into the same hole, so the peak is no matter of coloured residuals.
    let corrected = damping.iter().map(|(_, term)| term.f).fold(0.0, f64::max);
    assert!(end.f < corrected / fall, "so does the F corrected for colour");
    if fall > 5.0 {
        assert!((end.value - truth[0]).abs() > 2.0 * (best.value - truth[0]).abs(), "N_r is nearer to its value at the peak");
    }
}

#[test]
fn fig_18() {
    for (name, title, input, factor, fall) in [
        ("fig18-noise-free", "Noise-free doublet", "pedal:doublet:0.0175:1", 0.0, 10.0),
        ("fig18-noise", "Doublet, flight noise", "pedal:doublet:0.0175:1", 1.0, 2.0),
        ("fig18-3211", "3211, flight noise", "pedal:3211:0.0175:0.7", 1.0, 2.0),
    ] {
        let (steps, truth) = study(name, title, input, &InstrumentSet::flight_quality(factor), 1);
        collapses(&steps, truth, fall);
    }
}
