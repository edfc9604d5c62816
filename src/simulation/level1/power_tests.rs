//! Power required by the rotors in steady flight, and engine torque at its limits.

use super::inflow::InflowGuess;
use super::internal_states::InternalStates;
use super::level1_tests::{KNOT, flight, puma};
use super::trim::{TrimCondition, TrimError, Trimmed};
use crate::flight::control::Control;
use crate::simulation::flight_model::{FlightModel, FlightRequest};
use crate::simulation::input::InputSpec;
use crate::simulation::integrate::TrueState;
use std::f64::consts::PI;

/// Power of the rotors is what they do to the air, what drags the blades, what drags the rest, and the climb. In the exact
/// geometry the hub's forces act where the hub moves, so in a steady flight it holds to the accelerations that the trim
/// leaves, 1e-10 m/s^2 times mass and speed at most, and rounding.
#[test]
fn in_steady_flight_the_rotors_power_is_induced_profile_parasite_and_climb() {
    for (knots, climb, sideslip) in
        [(0.0, 0.0, 0.0), (20.0, 2.0, 0.0), (60.0, -3.0, 0.05), (100.0, 0.0, 0.0), (100.0, 5.08, -0.1), (140.0, 0.0, 0.0)]
    {
        let density = 1.1;
        let aircraft = puma(&["hub=exact"]).aircraft;
        let trimmed = aircraft.trim(TrimCondition { speed: knots * KNOT, climb, sideslip, density }).unwrap();
        let met = trimmed.situation();
        let response = aircraft.respond(&met);
        let (rotor, tail) = (&aircraft.main_rotor, &aircraft.tail_rotor);
        let omega = rotor.speed;
        let power = |[x, y, z]: [f64; 3]| x * met.velocity[0] + y * met.velocity[1] + z * met.velocity[2];
        // Main rotor: thrust on induced velocity, and profile drag on the blades and their way forward.
        let point = &response.rotor;
        let induced = response.thrust * point.induced;
        let (tip, area, mu2) = (omega * rotor.radius, PI * rotor.radius * rotor.radius, point.drive.mu * point.drive.mu);
        let delta = rotor.drag_0 + rotor.drag_2 * point.thrust_coefficient * point.thrust_coefficient;
        let profile = 0.125 * density * area * tip.powi(3) * rotor.solidity() * delta * (1.0 + 7.0 / 3.0 * mu2);
        // Tail rotor likewise; its thrust stands along y.
        let arm = tail.aft + aircraft.body.cg_forward;
        let pedal = met.blade[Control::Pedal.index()];
        let there = tail.ready(arm).point(met.velocity, met.rates, pedal, (omega, density, point.induced), f64::NAN);
        let tail_tip = tail.gearing * tip / rotor.radius * tail.radius;
        let tail_area = PI * tail.radius * tail.radius;
        let tail_ct = there.side_force / (density * tail_tip * tail_tip * tail_area);
        let tail_mu2 = (met.velocity[0].powi(2) + met.velocity[2].powi(2)) / (tail_tip * tail_tip);
        let tail_delta = tail.drag_0 + tail.drag_2 * tail_ct * tail_ct;
        let tail_profile = 0.125 * density * tail_area * tail_tip.powi(3) * tail.solidity * tail_delta * (1.0 + 3.0 * tail_mu2);
        let tail_induced = there.side_force * there.inflow * tail_tip;
        // What the air takes from fuselage, fin and tailplane.
        let (drag, _) = aircraft.fuselage.loads(met.velocity, (density, point.induced));
        let side = aircraft.fin.side_force(met.velocity, met.rates, density, aircraft.fin.aft + aircraft.body.cg_forward);
        let down = aircraft.tailplane.normal_force(
            met.velocity,
            0.0,
            (density, point.induced),
            aircraft.tailplane.aft + aircraft.body.cg_forward,
        );
        let parasite = -power(drag) - power([0.0, side, down]);
        let climbing = aircraft.body.mass * 9.80665 * climb;
        let spent = induced + profile + tail_induced + tail_profile + parasite + climbing;
        let given = response.torque * omega;
        let left = trimmed.residual * aircraft.body.mass * trimmed.trim.airspeed();
        assert!(
            (given - spent).abs() < left + 1e-12 * (given.abs() + induced + parasite.abs() + climbing.abs()),
            "{knots} kn, climb {climb}: {given} W is not {spent} W"
        );
        assert!(given > 2e5 && induced > 0.0 && profile > 1e5 && tail_profile > 0.0);
    }
}

#[test]
fn in_an_autorotation_the_rotor_runs_away_from_its_engine() {
    let trimmed = puma(&["rotor_speed=governed"]);
    let mut flown = flight(&trimmed, "collective:step:-0.1:0:1", 4.0);
    // Lever down and stick back: the air comes up through the disc.
    let stick = &mut flown.inputs.controls[Control::LonCyclic.index()];
    *stick = stick.plus(1.0, &InputSpec::parse("lon_cyclic:step:0.06:0:1").unwrap().deviation(1.0));
    let flown = flown.fly().unwrap();
    let torques: Vec<f64> = flown.truth.iter().map(|state| state.rotor.unwrap().torque).collect();
    let fastest = flown.truth.iter().map(|state| state.rotor_speed.unwrap()).fold(0.0, f64::max);
    let least = torques.iter().copied().fold(f64::INFINITY, f64::min);
    eprintln!("rotor up to {fastest:.2} rad/s, datum {:.2}, torque down to {least:.3} N m", trimmed.datum);
    // A brake of 63 kN m a rad/s would have held it within a few tenths of the datum.
    assert!(least >= 0.0 && least < 1e-2 * torques[0] && fastest > trimmed.datum + 1.0);
}

#[test]
fn a_torque_limit_is_kept_and_the_rotor_droops() {
    let free = puma(&["rotor_speed=governed"]);
    let mut limited = free.clone();
    let limit = 1.1 * free.inner.torque;
    limited.aircraft.engine.torque_limit = Some(limit);
    let fly = |trimmed: &Trimmed| flight(trimmed, "collective:step:0.03:0:1", 4.0).fly().unwrap().truth;
    let most = |truth: &[TrueState]| truth.iter().map(|state| state.rotor.unwrap().torque).fold(0.0, f64::max);
    let slowest = |truth: &[TrueState]| truth.iter().map(|state| state.rotor_speed.unwrap()).fold(f64::INFINITY, f64::min);
    let (limited, free) = (fly(&limited), fly(&free));
    eprintln!(
        "limit {limit:.0} N m: {:.1}, {:.0} without; {:.2} and {:.2} rad/s",
        most(&limited),
        most(&free),
        slowest(&limited),
        slowest(&free)
    );
    assert!(most(&limited) <= limit * (1.0 + 1e-12) && most(&limited) > 0.99 * limit && most(&free) > 1.05 * limit);
    assert!(slowest(&limited) < slowest(&free) - 0.1);
}

#[test]
fn a_trim_beyond_the_governed_engine_is_refused_and_a_limit_is_set_by_hand() {
    let with = |set: &[&str]| {
        FlightModel::puma(&FlightRequest { set: set.iter().map(|&text| text.to_owned()).collect(), ..FlightRequest::default() })
    };
    assert!(with(&["engine.torque_limit=20000"]).is_ok());
    let error = with(&["engine.torque_limit=15000", "rotor_speed=governed"]).unwrap_err().to_string();
    assert!(error.contains("the engine gives from 0 to 15000 N m"), "{error}");
    assert_eq!(
        with(&["engine.torque_limit=5e5", "rotor_speed=governed"]).unwrap().level1.unwrap().aircraft.engine.torque_limit,
        Some(5e5)
    );
    assert!(with(&["engine.torque_limit=-1"]).unwrap_err().to_string().contains("more than zero"));
    // Falling fast the air drives the rotor, and an engine behind a freewheel cannot hold it at its nominal speed.
    let falling =
        puma(&["rotor_speed=governed"]).aircraft.trim(TrimCondition { speed: 40.0, climb: -12.0, sideslip: 0.0, density: 1.225 });
    assert!(matches!(falling, Err(TrimError::Torque { found, .. }) if found < 0.0), "{falling:?}");
}

/// With the shaft upright and no product of inertia: what passes the shaft is inside fuselage and rotor, so no engine torque
/// changes their angular momentum I_zz r - sigma I (Omega - sigma r); the fuselage alone loses the torque that is missing.
#[test]
fn what_passes_the_shaft_turns_the_fuselage_and_the_freewheel_lets_it_go() {
    for (set, sigma) in [("main_rotor.rotation=clockwise", -1.0), ("main_rotor.rotation=anticlockwise", 1.0)] {
        for hub in ["hub=published", "hub=exact"] {
            let trimmed = puma(&["rotor_speed=governed", "body.ixz=0", "main_rotor.shaft_tilt=0", hub, set]);
            let aircraft = &trimmed.aircraft;
            assert!((aircraft.main_rotor.direction - sigma).abs() < 1e-15);
            let (equations, met) = (aircraft.equations(), trimmed.situation());
            let plain = aircraft.respond(&met);
            let at = |torque: f64| {
                let inner = InternalStates { torque, ..trimmed.inner };
                let instant = trimmed.instant(&equations, (&met, &inner, InflowGuess::NONE), &[1.0; 4], |_, _| None);
                (instant.response.accelerations[5], instant.rates.rotor_speed)
            };
            let (izz, inertia) = (aircraft.body.izz, aircraft.engine.inertia);
            let momentum = |(dr, domega): (f64, f64)| izz * dr - sigma * inertia * (domega - sigma * dr);
            let (steady, free, full) = (at(trimmed.inner.torque), at(0.0), at(1.5 * trimmed.inner.torque));
            // In trim, engine and air hold each other: nothing changes.
            assert!(steady.0.abs() < 1e-10 && steady.1.abs() < 1e-10 && (steady.0 - plain.accelerations[5]).abs() < 1e-14);
            for other in [free, full] {
                assert!((momentum(other) - momentum(steady)).abs() < 1e-6, "{hub}: {other:?} is not {steady:?}");
            }
            // Of the rotor's own torque the shaft passes nothing, only what it gives on to the tail rotor.
            let (own, tail) = (plain.rotor.torque, plain.torque - plain.rotor.torque);
            let passes = own + sigma * izz * (free.0 - plain.accelerations[5]);
            assert!((passes + tail).abs() < 1e-6 && tail > 500.0 && own > 1e4, "{hub}: {passes} N m, tail rotor {tail} N m");
            // An engine torque below zero passes no freewheel.
            assert!((at(-1e4).0 - free.0).abs() < 1e-15);
        }
    }
}
