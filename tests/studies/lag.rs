//! Derivatives from smoothed states, half a second late, beside those from filtered ones: what the lag buys.
//!
//! The linear model of the Level-1 Puma at 100 kn, flight-test quality, as in `honesty`; both ways see the same samples.

use crate::flown::{fly, puma};
use crate::honesty::inputs;
use crate::manoeuvre::{DURATION_S, LEAD_S, over_seeds, seeds};
use crate::score::{Estimate, Score};
use crate::sheet::Sheet;
use sideslip::estimation::config::RegressionStates;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::pipeline::{Config, Pipeline};
use sideslip::regression::record::Status;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::Instruments;
use sideslip::telemetry::record::Sample;

const DERIVATIVES: [(&str, Axis, Variable); 6] = [
    ("N_v", Axis::N, Variable::V),
    ("N_p", Axis::N, Variable::P),
    ("N_r", Axis::N, Variable::R),
    ("N_pedal", Axis::N, Variable::Pedal),
    ("L_p", Axis::L, Variable::P),
    ("L_r", Axis::L, Variable::R),
];
const AXES: [(&str, Axis); 2] = [("N", Axis::N), ("L", Axis::L)];

const WAYS: [(&str, RegressionStates); 2] = [("smoothed", RegressionStates::Smoothed), ("filtered", RegressionStates::Filtered)];

/// One flight: the last estimates, and when each axis was first called converged, s after the first input.
struct Run {
    last: [Option<Estimate>; DERIVATIVES.len()],
    converged_s: [Option<f64>; AXES.len()],
}

fn run(samples: &[Sample], states: RegressionStates) -> Run {
    let mut config = Config::default();
    config.estimation.regression_states = states;
    let mut pipeline = Box::new(Pipeline::new(&config, RunGeometry::default()).unwrap());
    let mut run = Run { last: [None; DERIVATIVES.len()], converged_s: [None; AXES.len()] };
    for sample in samples {
        let Some(derivatives) = &pipeline.step(sample).derivatives else { continue };
        let equation = |axis: Axis| &derivatives.equations[axis.index()];
        let is_converged = |axis| equation(axis).status == Status::Converged;
        run.last = DERIVATIVES.map(|(_, axis, variable)| {
            let term = equation(axis).term(variable)?;
            Some(Estimate { value: term.value, std: term.std, converged: is_converged(axis) })
        });
        for ((_, axis), first_s) in AXES.iter().zip(&mut run.converged_s) {
            if first_s.is_none() && is_converged(*axis) {
                *first_s = Some(sample.time_s - LEAD_S);
            }
        }
    }
    run
}

/// Middle of those that came; the longest wait of all where half never came.
fn median(mut times_s: Vec<Option<f64>>) -> f64 {
    times_s.sort_by(|a, b| a.unwrap_or(f64::INFINITY).total_cmp(&b.unwrap_or(f64::INFINITY)));
    times_s[times_s.len() / 2].unwrap_or(f64::INFINITY)
}

#[test]
fn filtered_states_beside_smoothed_ones() {
    let model = puma(100.0).linear().clone();
    let seeds_run = seeds(8);
    let aircraft = Flight::of(model.clone());
    let instruments = Instruments::flight_quality(1.0);
    let all: Vec<[Run; 2]> = over_seeds(seeds_run, |seed| {
        let samples = fly(&aircraft, &inputs(), &instruments, DURATION_S, seed);
        WAYS.map(|(_, states)| run(&samples, states))
    });
    let columns = [
        "states",
        "derivative",
        "estimates",
        "truth",
        "bias",
        "scatter",
        "reported_std",
        "z_mean",
        "z_spread",
        "within_3",
        "axis_converged_share",
        "axis_first_converged_median_s",
    ];
    let mut sheet = Sheet::new("lag", &columns);
    let mut scores = [[None; DERIVATIVES.len()]; 2];
    for (way, (name, _)) in WAYS.iter().enumerate() {
        for (place, (derivative, axis, variable)) in DERIVATIVES.iter().enumerate() {
            let truth = model.derivative(*axis, *variable);
            let score = Score::of(all.iter().map(|runs| runs[way].last[place]), truth);
            let place_of_axis = AXES.iter().position(|(_, other)| other == axis).unwrap();
            let times_s: Vec<_> = all.iter().map(|runs| runs[way].converged_s[place_of_axis]).collect();
            let share = times_s.iter().flatten().count() as f64 / seeds_run as f64;
            let first_s = median(times_s);
            let Score { count, bias, scatter, reported, z_mean, z_spread, within_three, .. } = score;
            let numbers = [count as f64, truth, bias, scatter, reported, z_mean, z_spread, within_three, share, first_s];
            sheet.row(&[name, derivative], &numbers);
            eprintln!(
                "{name} {derivative:7} {truth:9.5}: bias {bias:+.5}, scatter {scatter:.5}, reported {reported:.5}; z {z_mean:+.2} +- {z_spread:.2}, within 3: {within_three:.2}; axis converged in {share:.2} of the runs, first after {first_s:.2} s"
            );
            scores[way][place] = Some((score, share, first_s));
        }
    }
    sheet.write();
    let [smoothed, filtered] = scores;
    for (place, (name, ..)) in DERIVATIVES.iter().enumerate() {
        let ((smoothed, ..), (filtered, ..)) = (smoothed[place].unwrap(), filtered[place].unwrap());
        assert_eq!((smoothed.count as u64, filtered.count as u64), (seeds_run, seeds_run), "{name}");
        // What the lag buys: filtered accelerations come late behind the controls, and no standard error knows that.
        assert!(smoothed.bias.abs() < 0.3 * filtered.bias.abs(), "{name}: {smoothed:?} {filtered:?}");
        assert!(smoothed.scatter < filtered.scatter, "{name}: {smoothed:?} {filtered:?}");
        if seeds_run >= 50 {
            assert!(smoothed.z_mean.abs() < 0.75 && smoothed.z_spread < 1.5, "{name}: {smoothed:?}");
        }
    }
}
