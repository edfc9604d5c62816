//! Derivatives from smoothed states beside those from filtered ones, through the causal filter: what the lag buys.
//!
//! The linear model of the Level-1 Puma at 100 kn, as in `honesty`: instruments of flight-test quality, others four times as
//! noisy, and such as come at rates of their own. All ways see the same samples.

use super::flown::{fly, puma};
use super::honesty::inputs;
use super::score::{Estimate, Score};
use super::sheet::Sheet;
use crate::support::asked::seeds;
use crate::support::manoeuvre::{DURATION_S, LEAD_S, over_seeds};
use sideslip::flight::channel::Channel;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::config::RegressionStates;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::realtime::regression::record::Status;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::InstrumentSet;

const DERIVATIVES: [(&str, Axis, Variable); 6] = [
    ("N_v", Axis::N, Variable::V),
    ("N_p", Axis::N, Variable::P),
    ("N_r", Axis::N, Variable::R),
    ("N_pedal", Axis::N, Variable::Pedal),
    ("L_p", Axis::L, Variable::P),
    ("L_r", Axis::L, Variable::R),
];
const AXES: [(&str, Axis); 2] = [("N", Axis::N), ("L", Axis::L)];

/// Which way, and the corner of the causal filter, Hz; the second has the default.
const WAYS: [(&str, RegressionStates, f64); 4] = [
    ("smoothed", RegressionStates::Smoothed, 2.0),
    ("filtered", RegressionStates::Filtered, 2.0),
    ("filtered, 1 Hz", RegressionStates::Filtered, 1.0),
    ("filtered, 4 Hz", RegressionStates::Filtered, 4.0),
];

/// Instruments, and how many of the ways: all corners for the first.
fn cases() -> [(&'static str, InstrumentSet, usize); 4] {
    let at_rates = |rate_hz: fn(Channel) -> Option<f64>| {
        let mut instruments = InstrumentSet::flight_quality(1.0);
        for instrument in &mut instruments.channels {
            instrument.rate_hz = rate_hz(instrument.channel);
        }
        instruments
    };
    let own_rates = at_rates(|channel| match channel {
        Channel::P | Channel::Q | Channel::R => Some(64.0),
        Channel::Ax | Channel::Ay | Channel::Az => Some(50.0),
        channel if Channel::CONTROLS.contains(&channel) => None,
        _ => Some(32.0),
    });
    let slow_controls = at_rates(|channel| Channel::CONTROLS.contains(&channel).then_some(20.0));
    [
        ("flight-test", InstrumentSet::flight_quality(1.0), 4),
        ("noise x 4", InstrumentSet::flight_quality(4.0), 2),
        ("own rates", own_rates, 2),
        ("controls at 20 Hz", slow_controls, 2),
    ]
}

/// One flight: the last estimates, and when each axis was first called converged, s after the first input.
struct Run {
    last: [Option<Estimate>; DERIVATIVES.len()],
    converged_s: [Option<f64>; AXES.len()],
}

fn run(samples: &[Sample], states: RegressionStates, cutoff_hz: f64) -> Run {
    let mut config = PipelineConfig::default();
    config.estimation.regression_states = states;
    config.estimation.cutoff_hz = cutoff_hz;
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
    let columns = [
        "instruments",
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
    let mut scores = Vec::new();
    for (case, instruments, ways) in cases() {
        let all: Vec<Vec<Run>> = over_seeds(seeds_run, |seed| {
            let samples = fly(&aircraft, &inputs(), &instruments, DURATION_S, seed);
            WAYS[..ways].iter().map(|&(_, states, cutoff_hz)| run(&samples, states, cutoff_hz)).collect()
        });
        for (way, (name, ..)) in WAYS[..ways].iter().enumerate() {
            for (place, (derivative, axis, variable)) in DERIVATIVES.iter().enumerate() {
                let truth = model.derivative(*axis, *variable);
                let score = Score::of(all.iter().map(|runs| runs[way].last[place]), truth);
                let place_of_axis = AXES.iter().position(|(_, other)| other == axis).unwrap();
                let times_s: Vec<_> = all.iter().map(|runs| runs[way].converged_s[place_of_axis]).collect();
                let share = times_s.iter().flatten().count() as f64 / seeds_run as f64;
                let first_s = median(times_s);
                let Score { count, bias, scatter, reported, z_mean, z_spread, within_three, .. } = score;
                let numbers = [count as f64, truth, bias, scatter, reported, z_mean, z_spread, within_three, share, first_s];
                sheet.row(&[case, name, derivative], &numbers);
                eprintln!(
                    "{case}, {name} {derivative:7} {truth:9.5}: bias {bias:+.5}, scatter {scatter:.5}, reported {reported:.5}; z {z_mean:+.2} +- {z_spread:.2}, within 3: {within_three:.2}; axis converged in {share:.2} of the runs, first after {first_s:.2} s"
                );
                scores.push((case, *name, *derivative, truth, score));
            }
        }
    }
    sheet.write();
    for (case, name, derivative, truth, score) in scores {
        let what = format!("{case}, {name}, {derivative}: {score:?}");
        // What is not resolved has no number; the stiffnesses and roll damping always are.
        let always = ["N_v", "L_v", "L_p"].contains(&derivative);
        assert!(score.count as u64 == seeds_run || !always, "{what}");
        if (score.count as u64) < seeds_run {
            continue;
        }
        if case == "flight-test" {
            // Nothing in either way is late behind anything else: the mean of z is chance, 1/sqrt(seeds), and z is of something.
            assert!(score.z_mean.abs() < 4.0 / (seeds_run as f64).sqrt(), "{what}");
            assert!(score.scatter < 0.1 * truth.abs(), "{what}");
            if seeds_run >= 50 {
                assert!(score.z_spread < 1.5, "{what}");
            }
        }
    }
}
