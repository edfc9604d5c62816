//! Simulated flights: the model's own mode and control derivative; linear called linear, saturation found; repeats within noise.

use crate::support::asked::seeds;
use crate::support::puma::puma_100kn;
use sideslip::dynamics::linear::state_matrix;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::effect::Effect;
use sideslip::flight::model::LinearModel;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::tables::manoeuvre_table;
use sideslip::io::outputs::words::manoeuvre_sentences::of_all;
use sideslip::postflight::manoeuvres::record::{Interpretation, Response, RunInterpretation};
use sideslip::postflight::manoeuvres::{Run, interpret};
use sideslip::realtime::modes::naming::eigenmodes;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;

fn flown(mut flight: Flight, input: &str, effects: &[Effect], noise: f64, length_s: f64, seed: u64) -> Vec<Sample> {
    let spec = InputSpec::parse(input).unwrap();
    let place = Channel::CONTROLS.iter().position(|&control| control == spec.channel).unwrap();
    flight.inputs.controls[place] = flight.inputs.controls[place].plus(1.0, &spec.deviation(2.0));
    flight.times_s = uniform_times(0.0, length_s, 50.0).unwrap();
    flight.inputs = flight.inputs.sampled(&flight.times_s);
    flight.instruments = if noise > 0.0 { InstrumentSet::flight_quality(noise) } else { InstrumentSet::perfect() };
    flight.effects = effects.to_vec();
    flight.seed = seed;
    flight.fly().unwrap().samples
}

fn interpretation_of(runs: &[Vec<Sample>]) -> Interpretation {
    let names: Vec<String> = (1..=runs.len()).map(|number| format!("run {number}")).collect();
    let runs: Vec<Run<'_>> =
        runs.iter().zip(&names).map(|(samples, name)| Run { name, samples, controls: ControlNames::Rotorcraft }).collect();
    interpret(&runs)
}

fn calm(model: &LinearModel, input: &str, noise: f64, length_s: f64, seed: u64) -> Vec<Sample> {
    flown(Flight::of(model.clone()), input, &[], noise, length_s, seed)
}

/// Whether any test of proportion, offset or side was significant.
fn found_anything(all: &Interpretation) -> bool {
    all.linearity.iter().filter_map(|one| one.line.as_ref().ok()).any(|line| {
        let tests = [Some(line.curvature), line.offset, line.asymmetry];
        line.nonlinear || tests.iter().flatten().any(|test| test.significant() && test.found.value.abs() > 0.03)
    })
}

#[test]
fn the_models_own_dutch_roll_and_control_derivative() {
    let Some(model) = puma_100kn() else { return };
    let mode = eigenmodes(&state_matrix(&model)).unwrap().dutch_roll.unwrap();
    let (omega, zeta) = (mode.norm(), -mode.re / mode.norm());
    let n_pedal = model.derivative(Axis::N, Variable::Pedal);
    let (mut within, mut told, mut steep) = (0, 0, 0);
    let count = seeds(20);
    for seed in 0..count {
        let all = interpretation_of(&[calm(&model, "pedal:doublet:0.01:0.7", 1.0, 25.0, seed)]);
        let RunInterpretation { manoeuvres, .. } = &all.runs[0];
        assert_eq!(manoeuvres.len(), 1, "seed {seed}");
        let yaw = manoeuvres[0].sensitivities.iter().find(|one| one.channel == Channel::R).unwrap();
        let acceleration = yaw.acceleration.unwrap();
        // The window averages, and yaw damping sets in at once: a little less than the derivative.
        steep += u64::from((0.8..1.1).contains(&(acceleration.value / n_pedal)));
        let Ok(found) = &manoeuvres[0].oscillation else { continue };
        told += 1;
        let scores = [(found.omega.value - omega) / found.omega.std, (found.zeta.value - zeta) / found.zeta.std];
        within += u64::from(scores.iter().all(|score| score.abs() < 3.0));
        if seed == 0 {
            eprintln!("truth {omega:.3} {zeta:.4}, N_pedal {n_pedal:.2}\n{}", manoeuvre_table::text(&all));
        }
    }
    eprintln!(
        "omega {omega:.3} zeta {zeta:.4}: told in {told} of {count}, within 3 standard errors in {within}; N_pedal near in {steep}"
    );
    assert!(told * 100 >= count * 90 && within * 100 >= told * 85 && steep == count);
}

#[test]
fn linear_runs_are_called_linear() {
    let Some(model) = puma_100kn() else { return };
    let (mut called, mut curved) = (0, 0);
    let sets = seeds(50);
    for set in 0..sets {
        let runs: Vec<Vec<Sample>> = ["0.005", "0.01", "0.015", "-0.005", "-0.01"]
            .iter()
            .zip(0..)
            .map(|(size, run)| calm(&model, &format!("pedal:doublet:{size}:0.7"), 1.0, 8.0, 100 * set + run))
            .collect();
        let all = interpretation_of(&runs);
        assert!(all.linearity.iter().any(|one| one.line.is_ok()), "{:?}", all.linearity);
        called += u64::from(found_anything(&all));
        let curves =
            |one: &Interpretation| one.linearity.iter().flat_map(|one| &one.line).any(|line| line.curvature.significant());
        curved += u64::from(curves(&all));
    }
    eprintln!("linear sets: {called} of {sets} called not in proportion, {curved} with a curvature beyond chance however small");
    assert!(called * 25 <= sets, "{called}");
}

#[test]
fn linear_runs_in_gusts_are_called_linear() {
    let Some(model) = puma_100kn() else { return };
    let sets = seeds(25);
    let gusts = [Effect::Turbulence { sigma: 0.5, length: 150.0 }];
    let mut called = 0;
    for set in 0..sets {
        let sizes = ["0.005", "0.01", "0.015", "0.01"].iter().zip(0..);
        let run = |(size, run): (&&str, u64)| {
            flown(Flight::of(model.clone()), &format!("pedal:doublet:{size}:0.7"), &gusts, 1.0, 8.0, 9000 + 100 * set + run)
        };
        called += u64::from(found_anything(&interpretation_of(&sizes.map(|one| run((one.0, one.1))).collect::<Vec<_>>())));
    }
    eprintln!("linear sets in gusts of 0.5 m/s: {called} of {sets} called not in proportion");
    assert!(called * 10 <= sets, "{called}");
}

#[test]
fn a_saturating_response_is_found() {
    let model = FlightModel::puma(&FlightRequest { speed: Some(51.44), ..FlightRequest::default() }).unwrap();
    let limit = [Effect::RateLimit { control: Control::Pedal, rate: 0.03 }];
    let set = |effects: &[Effect], seed: u64| -> Interpretation {
        let sizes = ["0.01", "0.02", "0.03"].iter().zip(0..);
        let runs =
            sizes.map(|(size, run)| flown(model.flight(), &format!("pedal:doublet:{size}:0.7"), effects, 1.0, 8.0, seed + run));
        interpretation_of(&runs.collect::<Vec<_>>())
    };
    for seed in [0, 10, 20] {
        let saturated = set(&limit, seed);
        if seed == 0 {
            eprintln!("{}", manoeuvre_table::text(&saturated));
        }
        let first = saturated.linearity.iter().find(|one| one.response == Response::Initial).unwrap();
        let line = first.line.as_ref().unwrap();
        assert!(line.nonlinear && line.growth.value < 0.95, "{line:?}");
        let sentences = of_all(&saturated);
        assert!(sentences.iter().any(|said| said.contains("grows less than the input")), "{sentences:?}");
        let plain = set(&[], seed);
        let first = plain.linearity.iter().find(|one| one.response == Response::Initial).unwrap();
        eprintln!("seed {seed}: limited {:?}, plain {:?}", line.growth, first.line.as_ref().unwrap().growth);
    }
}

#[test]
fn repeats_scatter_as_noise_or_as_gusts() {
    let Some(model) = puma_100kn() else { return };
    let input = |run: u64| if run == 9 { "pedal:doublet:-0.01:0.7" } else { "pedal:doublet:0.01:0.7" };
    let set = |effects: &[Effect]| -> Interpretation {
        let runs = (0..3).map(|run| flown(Flight::of(model.clone()), input(run), effects, 1.0, 10.0, 50 + run));
        interpretation_of(&runs.collect::<Vec<_>>())
    };
    let (calm, gusty) = (set(&[]), set(&[Effect::Turbulence { sigma: 1.0, length: 150.0 }]));
    eprintln!("{}\n{}", manoeuvre_table::text(&calm), manoeuvre_table::text(&gusty));
    for (all, gusts) in [(&calm, false), (&gusty, true)] {
        assert_eq!(all.points.len(), 1, "left and right are one test point: {:?}", all.points);
        let scatter = all.points[0].scatter.as_ref().unwrap();
        let yaw = scatter.iter().find(|one| one.channel == Channel::R).unwrap();
        assert_eq!(yaw.scatter.value > 2.0 * yaw.noise, gusts, "{yaw:?}");
    }
    // Left and right are one test point; what differs is the aircraft's own (bank and gravity), a little more than noise.
    let sides = interpretation_of(&[0, 9].map(|run| flown(Flight::of(model.clone()), input(run), &[], 1.0, 10.0, 70 + run)));
    assert_eq!(sides.points.len(), 1, "{:?}", sides.points);
    assert!(sides.points[0].scatter.as_ref().unwrap().iter().any(|one| one.channel == Channel::R && one.scatter.value < 0.15));
    let one = interpretation_of(&[flown(Flight::of(model.clone()), input(0), &[], 1.0, 10.0, 50)]);
    assert!(one.points[0].scatter.is_err() && of_all(&one).iter().any(|said| said.contains("0 of 1 test points")));
}
