//! The analytic rotor loads against numerical integration of the blade element along span and azimuth.
//!
//! A blade element at radius r (over R) and azimuth psi has, over the tip speed,
//!     U_T = r + mu sin(psi)
//!     U_P = mu_z - lambda0 - mu beta cos(psi) + r (p sin(psi) + q cos(psi) - beta' - lambda1c cos(psi))
//! lift U_T^2 theta + U_T U_P, and in the plane of the hub, against the rotation, delta/a0 U_T^2 - U_P (U_T theta + U_P).

use super::flapping::{Flap, FlapDrive};
use super::hub::HubMotion;
use super::rotor::{MainRotor, RotorStates};
use crate::simulation::flight_model::{FlightModel, FlightRequest};

/// Averages over the disc: thrust F0, flap moment by harmonic, torque and in-plane force along the wind of the lift,
/// in-plane force and torque of a unit of profile drag.
#[derive(Default)]
struct Disc {
    thrust: f64,
    moment: [f64; 3],
    torque: f64,
    ahead: f64,
    profile_torque: f64,
    profile_ahead: f64,
}

/// Gauss's five points, exact for the span's polynomials, at equal azimuths, exact for its few harmonics.
fn integrate(drive: &FlapDrive, flap: Flap, flap_rates: Flap) -> Disc {
    const GAUSS: [(f64, f64); 5] = [
        (0.046_910_077_030_668, 0.118_463_442_528_094_5),
        (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
        (0.5, 0.284_444_444_444_444_4),
        (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
        (0.953_089_922_969_332, 0.118_463_442_528_094_5),
    ];
    const AZIMUTHS: usize = 24;
    let mut disc = Disc::default();
    for azimuth in 0..AZIMUTHS {
        let (sin, cos) = (azimuth as f64 * std::f64::consts::TAU / AZIMUTHS as f64).sin_cos();
        let beta = flap.coning + flap.cosine * cos + flap.sine * sin;
        // The multiblade rates turn with the blade: d/dpsi of the harmonics themselves as well.
        let beta_rate = flap_rates.coning + (flap_rates.cosine + flap.sine) * cos + (flap_rates.sine - flap.cosine) * sin;
        for (r, weight) in GAUSS {
            let weight = weight / AZIMUTHS as f64;
            let theta = drive.theta0 + drive.theta1s * sin + drive.theta1c * cos + r * drive.twist;
            let u_t = r + drive.mu * sin;
            let u_p =
                drive.through - drive.mu * beta * cos + r * (drive.p * sin + drive.q * cos - beta_rate - drive.lambda1c * cos);
            let lift = u_t * u_t * theta + u_t * u_p;
            let drag = -u_p * (u_t * theta + u_p);
            disc.thrust += weight * lift;
            for (moment, part) in disc.moment.iter_mut().zip([1.0, 2.0 * cos, 2.0 * sin]) {
                *moment += weight * r * lift * part;
            }
            disc.torque += weight * r * drag;
            disc.profile_torque += weight * r * u_t * u_t;
            // Forward is psi = 180 degrees: flapped-up lift leans inwards, drag stands against the rotation.
            disc.ahead += weight * (lift * beta * cos - drag * sin);
            disc.profile_ahead -= weight * u_t * u_t * sin;
        }
    }
    disc
}

fn rotor() -> MainRotor {
    FlightModel::puma(&FlightRequest::default()).unwrap().level1.unwrap().aircraft.main_rotor
}

const FLIGHTS: [([f64; 2], [f64; 2], [f64; 3]); 5] = [
    ([0.0, -1.0], [0.0, 0.0], [0.25, 0.0, 0.0]),
    ([15.0, 2.0], [0.05, -0.1], [0.2, -0.02, 0.03]),
    ([51.0, -5.0], [0.0, 0.0], [0.24, -0.01, 0.04]),
    ([51.0, -5.0], [0.3, 0.2], [0.24, -0.01, 0.04]),
    ([75.0, -8.0], [-0.2, 0.1], [0.3, -0.08, 0.05]),
];

fn motion([in_plane, axial]: [f64; 2], [p, q]: [f64; 2]) -> HubMotion {
    HubMotion { in_plane, axial, wind: (1.0, 0.0), p, q }
}

#[test]
fn thrust_is_the_integral_of_lift() {
    let rotor = rotor();
    for (air, rates, pitch) in FLIGHTS {
        let point = rotor.ready().point(&motion(air, rates), pitch, (27.0, 1.1), RotorStates::default(), f64::NAN);
        let disc = integrate(&point.drive, point.flap, Flap::default());
        let tip = 27.0 * rotor.radius;
        let k = 0.5 * 1.1 * tip * tip * std::f64::consts::PI * rotor.radius * rotor.radius * rotor.lift_slope * rotor.solidity();
        assert!((k * disc.thrust + point.loads.force[2]).abs() < 1e-9 * k, "{air:?}");
        // With flap rates as states.
        let rates_of_flap = Flap { coning: 0.02, cosine: 0.01, sine: -0.03 };
        let states = RotorStates { flap: Some(point.flap), flap_rates: Some(rates_of_flap), inflow: Some(point.inflow) };
        let moving = rotor.ready().point(&motion(air, rates), pitch, (27.0, 1.1), states, f64::NAN);
        let disc = integrate(&moving.drive, point.flap, rates_of_flap);
        assert!((k * disc.thrust + moving.loads.force[2]).abs() < 1e-9 * k, "{air:?} with flap rates");
    }
}

#[test]
fn flap_balances_the_integrated_moment_harmonic_by_harmonic() {
    let rotor = rotor();
    for (air, rates, pitch) in FLIGHTS {
        let point = rotor.ready().point(&motion(air, rates), pitch, (27.0, 1.1), RotorStates::default(), f64::NAN);
        let (drive, flap) = (&point.drive, point.flap);
        let disc = integrate(drive, flap, Flap::default());
        // beta'' + lambda^2 beta = 2 (p cos - q sin) + gamma/2 integral of r lift.
        let (spring, half) = (drive.lambda_beta2, 0.5 * drive.lock);
        let off = [
            spring * flap.coning - half * disc.moment[0],
            (spring - 1.0) * flap.cosine - 2.0 * drive.p - half * disc.moment[1],
            (spring - 1.0) * flap.sine + 2.0 * drive.q - half * disc.moment[2],
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-13), "{air:?}: {off:?}");
        // The same with any flap and rates: the second derivatives of the states.
        let (flap, moving) = (Flap { coning: 0.1, cosine: -0.05, sine: 0.02 }, Flap { coning: 0.3, cosine: 0.1, sine: -0.2 });
        let disc = integrate(drive, flap, moving);
        let second = drive.accelerations(flap, moving, 0.0, 0.0);
        let off = [
            second.coning + spring * flap.coning - half * disc.moment[0],
            second.cosine + 2.0 * moving.sine + (spring - 1.0) * flap.cosine - 2.0 * drive.p - half * disc.moment[1],
            second.sine - 2.0 * moving.cosine + (spring - 1.0) * flap.sine + 2.0 * drive.q - half * disc.moment[2],
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-13), "{air:?}: {off:?}");
    }
}

#[test]
fn torque_is_the_integral_in_axial_flight_and_the_power_balance_in_any() {
    let rotor = rotor();
    for (air, _, pitch) in FLIGHTS {
        let point = rotor.ready().point(&motion(air, [0.0; 2]), pitch, (27.0, 1.1), RotorStates::default(), f64::NAN);
        // The balance is that of a uniform inflow.
        let drive = FlapDrive { lambda1c: 0.0, ..point.drive };
        let flap = drive.quasi_steady();
        let disc = integrate(&drive, flap, Flap::default());
        let balance = -drive.through * disc.thrust + drive.mu * disc.ahead;
        assert!((disc.torque - balance).abs() < 1e-14, "{air:?}: {} is not {balance}", disc.torque);
        let mu2 = drive.mu * drive.mu;
        assert!((disc.profile_ahead + 0.5 * drive.mu).abs() < 1e-14);
        // The published simulation has 7/3 mu^2 where the balance gives 3 mu^2.
        let profile = drive.mu * disc.profile_ahead + 0.25 * (1.0 + 3.0 * mu2);
        assert!((disc.profile_torque - profile).abs() < 1e-14);
        let tip = 27.0 * rotor.radius;
        let k = 0.5 * 1.1 * tip * tip * std::f64::consts::PI * rotor.radius * rotor.radius * rotor.lift_slope * rotor.solidity();
        // The model's own flap, forced to be that of the uniform inflow, so that both sides have one disc.
        let states = RotorStates { flap: Some(flap), flap_rates: None, inflow: Some(point.inflow) };
        let same = rotor.ready().point(&motion(air, [0.0; 2]), pitch, (27.0, 1.1), states, f64::NAN);
        let delta = rotor.drag_0 + rotor.drag_2 * same.thrust_coefficient * same.thrust_coefficient;
        let drag = delta / rotor.lift_slope;
        let integrated = disc.torque + drag * disc.profile_torque;
        // It differs from the integral by just what it leaves out: the in-plane lift that is not the thrust's tilt, and 2/3 mu^2
        // of the profile drag.
        let (untilted, missing) = (drive.mu * (disc.ahead - disc.thrust * flap.cosine), drag * mu2 / 6.0);
        let found = same.torque / (k * rotor.radius);
        assert!((found + untilted + missing - integrated).abs() < 1e-14, "{air:?}: {found} is not {integrated}");
    }
}
