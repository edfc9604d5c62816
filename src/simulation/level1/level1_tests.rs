//! The whole Level-1 aircraft: symmetry, momentum, trim, its states, and its flights.

use super::aircraft::Perturbation;
use super::dynamics::Instant;
use super::inflow::InflowGuess;
use super::internal_states::{Flapping, Options};
use super::trim::{TOLERANCE, TrimCondition, TrimError, Trimmed};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::{Effect, EffectKind};
use crate::flight::signal::piecewise_linear::History;
use crate::simulation::flight_model::{FlightModel, FlightRequest};
use crate::simulation::flown_model_tests::one_of_each;
use crate::simulation::fly::{Flight, FlightResult, Inputs, SimulationError, uniform_times};
use crate::simulation::input::InputSpec;
use crate::simulation::instrument::FLIGHT_QUALITY;
use std::f64::consts::PI;

pub(super) const KNOT: f64 = 1852.0 / 3600.0;

pub(super) fn puma(set: &[&str]) -> Trimmed {
    let set = set.iter().map(|&text| text.to_owned()).collect();
    let asked = FlightRequest { speed: Some(100.0 * KNOT), set, ..FlightRequest::default() };
    *FlightModel::puma(&asked).unwrap().level1.unwrap()
}

/// The first instant of a flight from trim.
fn at_trim(trimmed: &Trimmed) -> Instant {
    let start = (&trimmed.situation(), &trimmed.inner, InflowGuess::NONE);
    trimmed.instant(&trimmed.aircraft.equations(), start, &[1.0; 4], |_, _| None)
}

#[test]
fn the_mirror_image_of_the_aircraft_does_the_mirror_image_of_everything() {
    for hub in ["hub=published", "hub=exact"] {
        let trimmed = puma(&[hub, "main_rotor.rotation=anticlockwise"]);
        let mut mirrored = puma(&[hub]).aircraft;
        mirrored.fin.incidence = -mirrored.fin.incidence;
        let mut met = trimmed.situation();
        let aircraft = trimmed.aircraft;
        for (velocity, rates) in
            [([50.0, 4.0, -2.0], [0.1, 0.2, -0.3]), ([3.0, -2.0, 1.0], [0.0, 0.0, 0.4]), ([20.0, 9.0, 9.0], [-0.5, 0.1, 0.0])]
        {
            (met.velocity, met.rates) = (velocity, rates);
            let mut image = met;
            image.velocity[1] = -image.velocity[1];
            image.rates = [-rates[0], rates[1], -rates[2]];
            image.blade[Control::Pedal.index()] = -image.blade[Control::Pedal.index()];
            let (one, other) = (aircraft.respond(&met).accelerations, mirrored.respond(&image).accelerations);
            for (axis, sign) in Axis::ALL.into_iter().zip([1.0, -1.0, 1.0, -1.0, 1.0, -1.0]) {
                let (one, other) = (one[axis.index()], sign * other[axis.index()]);
                assert!((one - other).abs() < 1e-12 * one.abs().max(1.0), "{hub}, {}: {one} {other}", axis.name());
            }
        }
    }
}

#[test]
fn in_axial_flight_thrust_and_power_are_those_of_momentum_theory() {
    for climb in [-8.0, 0.0, 5.0, 15.0] {
        let trimmed = puma(&["main_rotor.shaft_tilt=0", "flight.density=1.1"]);
        let mut aircraft = trimmed.aircraft;
        aircraft.body.cg_forward = 0.0;
        let blade = Control::ALL.map(|control| if control == Control::Collective { 0.25 } else { 0.0 });
        let situation = super::trim::situation([0.0, 0.0, -climb], [0.0; 3], blade, 27.0, 1.1);
        let response = aircraft.respond(&situation);
        let rotor = &aircraft.main_rotor;
        let (area, induced) = (PI * rotor.radius * rotor.radius, response.rotor.induced);
        let momentum = 2.0 * 1.1 * area * induced * (climb + induced);
        assert!((response.thrust - momentum).abs() < 1e-9 * momentum, "climb {climb}: {} {momentum}", response.thrust);
        let delta = rotor.drag_0 + rotor.drag_2 * response.rotor.thrust_coefficient.powi(2);
        let tip = 27.0 * rotor.radius;
        let profile = 0.125 * 1.1 * area * rotor.solidity() * delta * tip.powi(3);
        let power = response.thrust * (climb + induced) + profile;
        assert!((response.rotor.torque * 27.0 - power).abs() < 1e-9 * power, "climb {climb}");
    }
}

/// Every 10 kn from hover to 140 kn, every 500 ft/min from -2000 to 2000, sea level to 3000 m (ISA densities).
#[test]
fn there_is_a_trim_over_the_whole_grid_from_a_cold_start() {
    let mut largest = 0.0f64;
    for hub in ["hub=published", "hub=exact"] {
        let aircraft = puma(&[hub]).aircraft;
        for density in [1.225, 1.112, 1.007, 0.909] {
            for knots in (0..=140).step_by(10) {
                for climb in (-2000..=2000).step_by(500) {
                    let (speed, climb) = (f64::from(knots) * KNOT, f64::from(climb) * 0.3048 / 60.0);
                    let condition = TrimCondition { speed, climb, sideslip: 0.0, density };
                    let trimmed = aircraft.trim(condition).unwrap_or_else(|error| panic!("{error}"));
                    largest = largest.max(trimmed.residual);
                    let trim = &trimmed.trim;
                    let airspeed = speed.max(climb.abs());
                    assert!((trim.airspeed() - airspeed).abs() < 1e-9);
                    assert!((trim.flight_path_angle().sin() * airspeed - climb).abs() < 1e-9, "{condition:?}");
                    let rates = at_trim(&trimmed).response;
                    let [ax, ay, az, ..] = rates.accelerations;
                    assert!(((ax * ax + ay * ay + az * az).sqrt() - 9.80665).abs() < 1e-9);
                }
            }
        }
    }
    eprintln!("largest acceleration left {largest:.1e}");
    assert!(largest < TOLERANCE);
}

#[test]
fn sideslip_is_what_was_asked_and_where_there_is_no_trim_it_is_said() {
    let aircraft = puma(&[]).aircraft;
    let level = TrimCondition { speed: 40.0, climb: 0.0, sideslip: 0.1, density: 1.225 };
    let slipping = aircraft.trim(level).unwrap();
    assert!((slipping.trim.v - 40.0 * 0.1f64.sin()).abs() < 1e-12 && slipping.residual < TOLERANCE);
    for (condition, part) in [
        (TrimCondition { speed: 200.0, ..level }, "no trim"),
        (TrimCondition { density: 0.2, ..level }, "no trim"),
        (TrimCondition { climb: 45.0, ..level }, "no trim"),
        (TrimCondition { climb: 39.5, sideslip: 0.5, ..level }, "too steep"),
        (TrimCondition { speed: f64::NAN, ..level }, "airspeed"),
        (TrimCondition { density: 0.0, ..level }, "density"),
        (TrimCondition { sideslip: 2.0, ..level }, "sideslip"),
    ] {
        let error: TrimError = aircraft.trim(condition).unwrap_err();
        eprintln!("{error}");
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn inner_states_rest_in_trim_whatever_the_options() {
    let plain = puma(&[]);
    let all = ["flapping=second_order", "inflow=dynamic", "rotor_speed=governed", "actuators=first_order"];
    for trimmed in [puma(&all), puma(&["flapping=first_order", "hub=exact"])] {
        let instant = at_trim(&trimmed);
        let rates = instant.rates.to_vector();
        // Torque rates are in N m; everything else of the order of one.
        assert!(rates.iter().enumerate().all(|(place, rate)| rate.abs() < if place > 7 { 1e-5 } else { 1e-9 }), "{rates:?}");
        let there = trimmed.aircraft.respond(&trimmed.situation()).accelerations;
        assert!(instant.response.accelerations.iter().zip(there).all(|(a, b)| (a - b).abs() < 1e-12));
    }
    assert_eq!(plain.aircraft.options, Options { finite_perturbation: true, ..Options::PLAIN });
    assert_eq!(puma(&all).aircraft.options.flapping, Flapping::SecondOrder);
}

/// Eigenvalues that a prototype of our own gives for the same equations, 100 kn level at 1.225 kg/m^3.
#[test]
fn flap_states_have_the_eigenvalues_of_an_independent_program() {
    for (option, wanted) in [
        ("flapping=first_order", &[(-0.084, 0.981), (-1.046, 1.378), (-1.626, 0.0), (-11.10, 7.12), (-24.2, 0.0)][..]),
        (
            "flapping=second_order",
            &[(-0.088, 0.991), (-1.069, 1.372), (-1.619, 0.0), (-15.5, 5.3), (-12.9, 23.3), (-15.0, 49.3)][..],
        ),
    ] {
        let found = puma(&[option]).whole_eigenvalues().unwrap();
        for &(real, imag) in wanted {
            let near = found.iter().map(|mode| (mode.re - real).hypot(mode.im - imag)).fold(f64::INFINITY, f64::min);
            // The last printed digit.
            let digits = if f64::hypot(real, imag) > 10.0 { 0.08 } else { 1.5e-3 };
            assert!(near < digits, "{option}: {real} +- {imag}i is {near} away from {found:?}");
        }
    }
}

/// Five points against two that are closer still: neither truncation nor rounding shows.
#[test]
fn derivatives_do_not_depend_on_the_small_step() {
    for speed in ["flight.speed=0", "flight.speed=10", "flight.speed=51", "flight.speed=72"] {
        let set = vec![speed.to_owned(), "perturbation=small".to_owned()];
        let small = *FlightModel::puma(&FlightRequest { set, ..FlightRequest::default() }).unwrap().level1.unwrap();
        let mut tiny = small.clone();
        tiny.aircraft.options.finite_perturbation = true;
        tiny.aircraft.perturbation = Perturbation { velocity: 1e-3, rate: 1e-4, control: 2e-5 };
        let (small, tiny) = (small.linear(), tiny.linear());
        for (axis, variable) in Axis::ALL.into_iter().flat_map(|axis| Variable::ALL.map(|variable| (axis, variable))) {
            let (a, b) = (small.derivative(axis, variable), tiny.derivative(axis, variable));
            let name = format!("{speed}, {}_{variable:?}", axis.name());
            // At rest forces vary as V|V|, and the differences with the step.
            let allowed = if speed.ends_with("=0") { 3e-5 } else { 1e-7 };
            assert!((a - b).abs() < allowed * a.abs().max(1.0), "{name}: {a} {b}");
        }
    }
}

#[test]
fn larger_perturbations_give_a_larger_n_v() {
    let n_v = |velocity: &str| puma(&[&format!("perturbation.velocity={velocity}")]).linear().derivative(Axis::N, Variable::V);
    let small = puma(&["perturbation=small"]).linear().derivative(Axis::N, Variable::V);
    let (one, five) = (n_v("1"), n_v("5"));
    eprintln!("N_v small {small:.4}, 1 m/s {one:.4}, 5 m/s {five:.4}");
    assert!(small < one && one < five && five > 1.2 * small);
    assert!((n_v("0.01") - small).abs() < 1e-5);
}

pub(super) fn flight(trimmed: &Trimmed, input: &str, duration_s: f64) -> Flight {
    let times_s = uniform_times(0.0, duration_s, 100.0).unwrap();
    let mut flight = Flight::of_level1(trimmed.clone());
    let spec = InputSpec::parse(input).unwrap();
    for (control, history) in Control::ALL.into_iter().zip(&mut flight.inputs.controls) {
        if control.channel() == spec.channel {
            *history = history.plus(1.0, &spec.deviation(1.0));
        }
    }
    flight.inputs = flight.inputs.sampled(&times_s);
    Flight { times_s, ..flight }
}

fn readings(flown: &FlightResult, channel: Channel) -> Vec<f64> {
    flown.samples.iter().filter_map(|sample| sample.get(channel)).collect()
}

#[test]
fn the_trim_is_flown_and_stays_and_a_small_input_moves_it_as_the_linear_model_says() {
    let trimmed = puma(&["perturbation=small"]);
    let still = flight(&trimmed, "pedal:step:0", 10.0).fly().unwrap();
    let first = still.truth[0].motion.to_vector();
    let last = still.truth.last().unwrap().motion.to_vector();
    assert!(first.iter().zip(last).take(8).all(|(a, b)| (a - b).abs() < 1e-8), "{first:?} {last:?}");
    let by_level1 = flight(&trimmed, "pedal:doublet:0.00002:1:1", 8.0).fly().unwrap();
    let mut linear = flight(&trimmed, "pedal:doublet:0.00002:1:1", 8.0);
    (linear.level1, linear.model) = (None, trimmed.linear());
    let by_linear = linear.fly().unwrap();
    for channel in [Channel::P, Channel::R, Channel::Beta, Channel::Q, Channel::Ay] {
        let (a, b) = (readings(&by_level1, channel), readings(&by_linear, channel));
        let size = a.iter().map(|x| (x - a[0]).abs()).fold(0.0, f64::max);
        let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 2e-3 * size, "{channel:?}: {off:e} of {size:e}");
    }
}

#[test]
fn half_the_step_changes_nothing_that_matters() {
    for set in [&[][..], &["flapping=second_order", "inflow=dynamic", "rotor_speed=governed", "actuators=first_order"]] {
        let whole = flight(&puma(set), "pedal:3211:0.03:0.7:1", 8.0);
        let step = if set.is_empty() { 1.0 / 512.0 } else { 5e-4 };
        let half = Flight { max_step_s: Some(step), ..whole.clone() };
        let (whole, half) = (whole.fly().unwrap(), half.fly().unwrap());
        for (whole, half) in whole.truth.iter().zip(&half.truth) {
            let pairs = whole.motion.to_vector().into_iter().zip(half.motion.to_vector());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 2e-6), "{set:?}, {} s", whole.time_s);
        }
    }
}

#[test]
fn every_effect_is_at_work_on_a_level1_aircraft() {
    let trimmed = puma(&["flight.climb=3"]);
    let plain = flight(&trimmed, "pedal:3211:0.02:0.7:1", 8.0);
    let with = |effect: Effect| {
        let mut flight = plain.clone();
        let speeds = vec![(0.0, 27.0), (2.0, 27.0), (4.0, 27.4), (6.0, 26.9)];
        flight.inputs.rotor_speed = Some(History::through(speeds).unwrap());
        flight.effects = vec![effect];
        flight.fly()
    };
    let bare = with(Effect::None).unwrap();
    for effect in one_of_each() {
        if matches!(effect, Effect::None | Effect::Unknown { .. }) {
            continue;
        }
        let flown = with(effect).unwrap();
        let largest = |channel| {
            let (a, b) = (readings(&flown, channel), readings(&bare, channel));
            a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let changed = FLIGHT_QUALITY.iter().map(|instrument| largest(instrument.channel)).fold(0.0, f64::max);
        assert!(changed > 1e-3, "{effect:?} changes nothing: {changed:e}");
    }
    assert_eq!(with(Effect::Unknown { axis: Axis::L }), Err(SimulationError::NotFlown(EffectKind::Unknown)));
}

#[test]
fn a_derivative_added_and_an_effectiveness_are_what_they_are_on_a_linear_model() {
    let trimmed = puma(&[]);
    let mut half_input = flight(&trimmed, "pedal:doublet:0.02:1:1", 6.0);
    let pedal = &mut half_input.inputs.controls[Control::Pedal.index()];
    let at_trim = trimmed.trim.controls[Control::Pedal.index()];
    *pedal = History::through(pedal.points().iter().map(|&(t, x)| (t, at_trim + 0.5 * (x - at_trim))).collect()).unwrap();
    let mut half_effect = flight(&trimmed, "pedal:doublet:0.02:1:1", 6.0);
    half_effect.effects = vec![Effect::ControlEffectiveness { control: Control::Pedal, factor: 0.5 }];
    let (a, b) = (readings(&half_input.fly().unwrap(), Channel::R), readings(&half_effect.fly().unwrap(), Channel::R));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12));
    // At the first instant in a given motion the yaw acceleration differs by delta times the deviation, and nothing else does.
    let mut plain = flight(&trimmed, "pedal:step:0", 0.1);
    let mut start = Flight::trim_motion(&plain.model);
    start.rates[0] = 0.2;
    plain.start = Some(start);
    let extended =
        Flight { effects: vec![Effect::Derivative { axis: Axis::N, variable: Variable::P, delta: -0.15 }], ..plain.clone() };
    let (a, b) = (plain.fly().unwrap().truth[0], extended.fly().unwrap().truth[0]);
    assert!((b.angular_acceleration[2] - a.angular_acceleration[2] + 0.03).abs() < 1e-12);
    let same = a.specific_force.iter().zip(b.specific_force).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(same, "{:?} {:?}", a.specific_force, b.specific_force);
}

#[test]
fn the_governor_brings_the_rotor_back_and_takes_no_orders() {
    let trimmed = puma(&["rotor_speed=governed"]);
    let flown = flight(&trimmed, "collective:step:0.01:0:1", 12.0);
    let speeds = readings(&flown.fly().unwrap(), Channel::RotorSpeed);
    let (last, before) = (speeds[speeds.len() - 1], speeds[speeds.len() - 100]);
    // More torque, less speed: 5 % at full torque, 85 kN m, is 0.016 rad/s a kN m. A centiradian of collective takes 2 to 5.
    assert!((0.03..0.08).contains(&(27.0 - last)) && (last - before).abs() < 0.01, "{before}, {last}");
    let mut ordered = flown.clone();
    ordered.inputs.rotor_speed = Some(History::constant(27.0));
    assert_eq!(ordered.fly(), Err(SimulationError::Governed));
    let mut held = Flight::of_level1(puma(&[]));
    (held.inputs, held.times_s) = (Inputs::at_trim(&held.model), vec![0.0, 1.0]);
    held.inputs.rotor_speed = Some(History::constant(27.0));
    assert!(held.fly().is_ok());
}

/// The speed that a governor made, given to a rotor that reacts: the same motion.
#[test]
fn a_rotor_of_given_speed_that_reacts_is_one_that_its_engine_turns() {
    let governed = puma(&["rotor_speed=governed"]);
    let truth = flight(&governed, "pedal:3211:0.012:0.7:1", 8.0).fly().unwrap();
    let points = truth.truth.iter().map(|state| (state.time_s, state.rotor_speed.unwrap())).collect();
    let mut given = flight(&puma(&[]), "pedal:3211:0.012:0.7:1", 8.0);
    given.inputs.rotor_speed = Some(History::through(points).unwrap());
    let worst = |effects: Vec<Effect>| {
        let flown = Flight { effects, ..given.clone() }.fly().unwrap();
        let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        off(&readings(&truth, Channel::R), &readings(&flown, Channel::R))
    };
    let (reacting, held) = (worst(vec![Effect::RotorReaction { reaction: governed.aircraft.reaction() }]), worst(Vec::new()));
    assert!(reacting < 0.1 * held, "{reacting} of {held} rad/s");
    given.effects = vec![Effect::RotorReaction { reaction: 0.1 }];
    given.level1 = Some(Box::new(governed));
    given.inputs.rotor_speed = None;
    assert_eq!(given.fly(), Err(SimulationError::Reacts));
}

#[test]
fn the_rotor_is_measured_where_there_is_one() {
    let trimmed = puma(&["rotor_speed=governed", "flapping=second_order"]);
    let mut flown = flight(&trimmed, "collective:step:0.01:0:1", 6.0);
    flown.instruments = flown.instruments.with_rotor(0.0);
    let recorded = flown.fly().unwrap();
    let (torque, coning) = (readings(&recorded, Channel::Torque), readings(&recorded, Channel::Flap0));
    assert!((torque[0] - trimmed.inner.torque).abs() < 1e-6 && (coning[0] - trimmed.inner.flap.coning).abs() < 1e-12);
    assert!(torque[torque.len() - 1] > torque[0] + 1000.0 && coning[coning.len() - 1] > coning[0] + 1e-3);
    assert_eq!(readings(&recorded, Channel::Flap1s).len(), 601);
    let mut linear = flown.clone();
    linear.level1 = None;
    assert_eq!(linear.fly(), Err(SimulationError::NoChannel(Channel::Torque)));
}

#[test]
fn actuators_lag_and_hold_their_rate() {
    let trimmed = puma(&["actuators=first_order", "actuators.pedal.rate=0.1"]);
    let flown = flight(&trimmed, "pedal:step:0.05:0:1", 3.0).fly().unwrap();
    let blade: Vec<f64> = flown.truth.iter().map(|state| state.blade[Control::Pedal.index()]).collect();
    let fastest = blade.windows(2).map(|pair| (pair[1] - pair[0]).abs() * 100.0).fold(0.0, f64::max);
    assert!((fastest - 0.1).abs() < 1e-9, "{fastest}");
    assert!((blade[blade.len() - 1] - trimmed.trim.controls[Control::Pedal.index()] - 0.05).abs() < 1e-6);
}

#[test]
fn a_fast_actuator_has_its_own_eigenvalue_whatever_its_rate() {
    let trimmed = puma(&["actuators=first_order", "actuators.pedal.tau=1e-4"]);
    let fastest = trimmed.whole_eigenvalues().unwrap().into_iter().map(|mode| mode.re).fold(0.0, f64::min);
    assert!((fastest + 1e4).abs() < 1.0, "{fastest}");
}
