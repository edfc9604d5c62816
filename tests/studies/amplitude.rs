//! Yaw derivatives against input amplitude and clock: where the nonlinear aircraft leaves its linear model.
//!
//! The paper's Fig 17: a 3211 is flown by the Level-1 Puma, the pipeline estimates, and every estimate is divided by the
//! derivative of small perturbations. Twice: pedal at 100 kn, and lateral cyclic at 80 kn as in the paper.

use super::flown::{fly, puma, through};
use super::score::{Estimate, Score};
use super::sheet::{Sheet, draw};
use crate::support::asked::seeds;
use crate::support::manoeuvre::{LEAD_S, over_seeds};
use sideslip::flight::channel::Channel;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::charts::chart::{Curve, Mark, Marks, Panel};
use sideslip::simulation::flight_model::FlightModel;
use sideslip::simulation::instrument::InstrumentSet;

/// Length of the record from the input on, s.
const RECORD_S: f64 = 12.0;

const CLOCKS_S: [f64; 2] = [0.5, 1.0];

/// Places of N_p and N_r among a case's variables.
const COUPLING: usize = 1;
const DAMPING: usize = 2;

/// One of the paper's two kinds of manoeuvre.
struct Case {
    name: &'static str,
    control: &'static str,
    knots: f64,
    /// Amplitudes, degrees.
    amplitudes_deg: &'static [f64],
    variables: [(Variable, &'static str); 4],
}

const fn variables(control: Variable, name: &'static str) -> [(Variable, &'static str); 4] {
    [(Variable::V, "N_v"), (Variable::P, "N_p"), (Variable::R, "N_r"), (control, name)]
}

/// Estimates of one flight: the four derivatives over those of small perturbations, R2, largest sideslip (rad).
struct Flown {
    ratios: [Option<Estimate>; 4],
    r_squared: f64,
    sideslip: f64,
}

fn one(model: &FlightModel, case: &Case, clock_s: f64, amplitude_deg: f64, instruments: &InstrumentSet, seed: u64) -> Flown {
    let input = format!("{}:3211:{}:{clock_s}", case.control, amplitude_deg.to_radians());
    let samples = fly(&model.flight(), &[input], instruments, LEAD_S + RECORD_S, seed);
    let beta = |sample: &Sample| sample.get(Channel::Beta).map_or(0.0, f64::abs);
    let sideslip = samples.iter().map(beta).fold(0.0, f64::max);
    let mut pipeline = through(&samples);
    let derivatives = pipeline.finish().derivatives.clone().unwrap();
    let equation = &derivatives.equations[Axis::N.index()];
    let ratios = case.variables.map(|(variable, _)| {
        let small = model.linear().derivative(Axis::N, variable);
        equation.term(variable).map(|term| Estimate { value: term.value / small, std: term.std / small.abs(), converged: false })
    });
    Flown { ratios, r_squared: equation.r_squared, sideslip }
}

/// Ratios by clock, amplitude and derivative: without noise, and the score with noise.
struct Study {
    exact: Vec<Vec<Flown>>,
    noisy: Vec<Vec<[Score; 4]>>,
}

fn run(case: &Case, seeds_run: u64) -> Study {
    let model = puma(case.knots);
    let mut study = Study { exact: Vec::new(), noisy: Vec::new() };
    for clock_s in CLOCKS_S {
        let exact = |&amplitude: &f64| one(&model, case, clock_s, amplitude, &InstrumentSet::perfect(), 0);
        study.exact.push(case.amplitudes_deg.iter().map(exact).collect());
        let noisy = |&amplitude: &f64| {
            let flights =
                over_seeds(seeds_run, |seed| one(&model, case, clock_s, amplitude, &InstrumentSet::flight_quality(1.0), seed));
            std::array::from_fn(|place| Score::of(flights.iter().map(|flown| flown.ratios[place]), 1.0))
        };
        study.noisy.push(case.amplitudes_deg.iter().map(noisy).collect());
    }
    write(case, &study, seeds_run);
    study
}

fn write(case: &Case, study: &Study, seeds_run: u64) {
    let columns = [
        "derivative",
        "clock_s",
        "amplitude_deg",
        "largest_sideslip_deg",
        "r2_noise_free",
        "ratio_noise_free",
        "reported_std_noise_free",
        "seeds",
        "estimates",
        "ratio_mean",
        "ratio_scatter",
        "reported_std",
    ];
    let mut sheet = Sheet::new(case.name, &columns);
    for (place, (_, name)) in case.variables.iter().enumerate() {
        for (c, clock_s) in CLOCKS_S.into_iter().enumerate() {
            for (a, &amplitude) in case.amplitudes_deg.iter().enumerate() {
                let (exact, noisy) = (&study.exact[c][a], &study.noisy[c][a][place]);
                let (ratio, std) = exact.ratios[place].map_or((f64::NAN, f64::NAN), |found| (found.value, found.std));
                let numbers = [
                    clock_s,
                    amplitude,
                    exact.sideslip.to_degrees(),
                    exact.r_squared,
                    ratio,
                    std,
                    seeds_run as f64,
                    noisy.count as f64,
                    1.0 + noisy.bias,
                    noisy.scatter,
                    noisy.reported,
                ];
                sheet.row(&[name], &numbers);
                eprintln!(
                    "{name:8} clock {clock_s}, {amplitude:4} deg (beta to {:4.1} deg): {ratio:.3} noise-free, R2 {:.5}; {:.3} +- {:.3} over {} of {seeds_run} seeds, reported {:.3}",
                    exact.sideslip.to_degrees(),
                    exact.r_squared,
                    1.0 + noisy.bias,
                    noisy.scatter,
                    noisy.count,
                    noisy.reported
                );
            }
        }
    }
    sheet.write();
    let panels: Vec<(Panel, Vec<Marks>)> = (0..4).map(|place| panel(case, study, place, seeds_run)).collect();
    draw(case.name, &panels);
}

fn panel(case: &Case, study: &Study, place: usize, seeds_run: u64) -> (Panel, Vec<Marks>) {
    let name = case.variables[place].1;
    let clock = |clock_s: f64| format!("clock {clock_s} s");
    let curves = CLOCKS_S.into_iter().enumerate().map(|(c, clock_s)| {
        let ratio =
            |(a, &amplitude): (usize, &f64)| (amplitude, study.exact[c][a].ratios[place].map_or(f64::NAN, |found| found.value));
        Curve { name: clock(clock_s), points: case.amplitudes_deg.iter().enumerate().map(ratio).collect() }
    });
    let marks = CLOCKS_S.into_iter().enumerate().map(|(c, clock_s)| {
        let mark = |(a, &amplitude): (usize, &f64)| {
            let score = &study.noisy[c][a][place];
            // Beside each other, so that bars can be told apart.
            Mark { point: (amplitude + 0.03 * (c as f64 - 0.5), 1.0 + score.bias), either_way: score.scatter }
        };
        Marks { name: clock(clock_s), marks: case.amplitudes_deg.iter().enumerate().map(mark).collect() }
    });
    let title = format!(
        "{name}, {} 3211 at {} kn: lines noise-free, points mean and scatter of {seeds_run} noisy flights",
        case.control, case.knots
    );
    let panel = Panel {
        title,
        x: "amplitude, deg of blade pitch".into(),
        y: format!("{name} / small perturbation"),
        curves: curves.collect(),
    };
    (panel, marks.collect())
}

/// More seeds than these tell nothing more: noise is the smaller part here.
const MOST_SEEDS: u64 = 16;

/// All amplitudes in the long form, a few otherwise.
fn amplitudes(seeds_run: u64, all: &'static [f64], few: &'static [f64]) -> &'static [f64] {
    if seeds_run > 3 { all } else { few }
}

/// Ratio without noise of the derivative at that place, by clock and amplitude.
fn ratio(study: &Study, clock: usize, amplitude: usize, place: usize) -> f64 {
    study.exact[clock][amplitude].ratios[place].map_or(f64::NAN, |found| found.value)
}

#[test]
fn fig_17_pedal() {
    let seeds_run = seeds(3).min(MOST_SEEDS);
    let all = &[0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0];
    let amplitudes_deg = amplitudes(seeds_run, all, &[0.2, 0.5, 3.0]);
    let variables = variables(Variable::Pedal, "N_pedal");
    let study = run(&Case { name: "fig17-pedal", control: "pedal", knots: 100.0, amplitudes_deg, variables }, seeds_run);
    judge(&study, amplitudes_deg);
}

#[test]
fn fig_17_lateral_cyclic() {
    let seeds_run = seeds(3).min(MOST_SEEDS);
    let all = &[0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5];
    let amplitudes_deg = amplitudes(seeds_run, all, &[0.2, 0.5, 1.5]);
    let variables = variables(Variable::LatCyclic, "N_lat_cyclic");
    let study = run(&Case { name: "fig17-lat-cyclic", control: "lat_cyclic", knots: 80.0, amplitudes_deg, variables }, seeds_run);
    judge(&study, amplitudes_deg);
}

/// What the paper says of its Fig 17: small inputs give the small perturbations' derivatives, damping and coupling depart from
/// them as amplitude and clock grow.
fn judge(study: &Study, amplitudes_deg: &[f64]) {
    let last = amplitudes_deg.len() - 1;
    let of = |wanted: f64| amplitudes_deg.iter().position(|amplitude| amplitude.total_cmp(&wanted).is_eq()).unwrap();
    // Smaller ones still leave longitudinal motion too still to be offered, and its part goes into what is.
    let (small, half_degree) = (of(0.2), of(0.5));
    let mut reported = 0;
    for place in 0..4 {
        let found = ratio(study, 0, small, place);
        reported += usize::from(found.is_finite());
        assert!(found.is_nan() || (found - 1.0).abs() < 0.15, "derivative {place} of a small input: {found} of its value");
    }
    // One that is as uncertain as it is large has no number.
    assert!(reported >= 3, "{reported} of 4 derivatives of a small input are reported");
    let departure = |clock: usize, amplitude: usize| (ratio(study, clock, amplitude, DAMPING) - 1.0).abs();
    // Where the errors that cover the curvature are as large as the damping, it is not reported and its ratio no number.
    let departs = departure(0, last);
    assert!(departs.is_nan() || departs > 2.0 * departure(0, small), "damping departs with amplitude");
    assert!(departure(1, half_degree) > departure(0, half_degree), "and with the clock");
    let coupling = (ratio(study, 1, half_degree, COUPLING) - 1.0).abs();
    eprintln!("at half a degree coupling departs by {coupling}, damping by {}", departure(1, half_degree));
    assert!(coupling.is_nan() || coupling > departure(1, half_degree), "coupling departs further than damping");
}
