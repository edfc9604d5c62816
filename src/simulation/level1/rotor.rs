//! The main rotor: inflow, flap and loads of a centre-spring rotor, integrated analytically over span and azimuth.
//!
//! Consumes the hub's motion, blade pitch theta0, theta1s, theta1c (rad), rotor speed Omega, air density, and flap and
//! inflow where they are states; produces force and moment at the hub, torque, inflow and flap. With the quantities of `hub`
//! and `flapping` in wind axes and solidity s = N_b c/(pi R):
//!     F0 = theta0 (1/3 + mu^2/2) + mu/2 (theta1s + p/2) + (mu_z - lambda0)/2 + (1 + mu^2) theta_tw/4
//!          - beta0'/3 - mu beta1s'/4 (the last two where flap rates are states)                              (1)
//!     C_T = a0 s F0/2; lambda0 from momentum (`inflow`), or a state                                          (2)
//!     K = rho (Omega R)^2 pi R^2 a0 s/2     T = K F0     delta = delta_0 + delta_2 C_T^2
//!     X_w = T beta1c_w - K delta mu/(2 a0)     Y_w = -T beta1s_w     Z_h = -T                                (3)
//!     Q = K R [-(mu_z - lambda0) F0 + mu X_w/K + delta/(4 a0) (1 + 7/3 mu^2)]                                (4)
//!     L_h = -N_b K_beta beta1s/2     M_h = -N_b K_beta beta1c/2     N_h = Q                                  (5)
//!     dynamic: lambda0' = (C_T - 2 lambda0 sqrt(mu^2 + (lambda0 - mu_z)^2))/(8/(3 pi))                       (6)
//! The thrust is normal to the disc: (3) has no separate induced drag, as in the simulation of the published matrices.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch. 3, in the form inferred from its appendix 4B; (6) with
//! the apparent mass of D. M. Pitt and D. A. Peters, Vertica 5, 1981.

use super::flapping::{Flap, FlapDrive};
use super::hub::{HubLoads, HubMotion};
use super::inflow::{MomentumBalance, harmonic};
use core::f64::consts::PI;

/// Data of the main rotor, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MainRotor {
    /// 1 for a rotor that turns anticlockwise seen from above, -1 clockwise.
    pub direction: f64,
    /// Radius, m.
    pub radius: f64,
    /// Blade chord, m.
    pub chord: f64,
    /// Number of blades.
    pub blades: f64,
    /// Lift slope of the blade section, per rad.
    pub lift_slope: f64,
    /// Profile drag `drag_0 + drag_2 CT^2`.
    pub drag_0: f64,
    /// See `drag_0`.
    pub drag_2: f64,
    /// Linear twist from root to tip, rad.
    pub twist: f64,
    /// Nominal speed, rad/s.
    pub speed: f64,
    /// Flap moment of inertia of a blade, kg m^2.
    pub flap_inertia: f64,
    /// Stiffness of the centre spring, N m/rad.
    pub flap_stiffness: f64,
    /// Forward tilt of the shaft, rad.
    pub shaft_tilt: f64,
    /// Height of the hub above the centre of mass, m.
    pub height: f64,
}

/// Speed dependence of the profile torque in (4).
const PROFILE_TORQUE: f64 = 7.0 / 3.0;

/// Apparent mass of the air through the disc in (6), 8/(3 pi).
const APPARENT_MASS: f64 = 8.0 / (3.0 * PI);

/// Which of the rotor's quantities are states; those that are not follow at once.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(crate) struct RotorStates {
    /// Flap in hub axes, mirrored.
    pub(crate) flap: Option<Flap>,
    /// Flap rates in hub axes a radian of azimuth, where they are states too.
    pub(crate) flap_rates: Option<Flap>,
    /// lambda0.
    pub(crate) inflow: Option<f64>,
}

/// What the rotor does at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RotorPoint {
    pub(crate) loads: HubLoads,
    /// Torque that drives it, N m.
    pub(crate) torque: f64,
    /// Flap in hub axes.
    pub(crate) flap: Flap,
    /// Mean induced velocity, m/s.
    pub(crate) induced: f64,
    /// lambda0, and its rate a radian of azimuth, (6).
    pub(crate) inflow: f64,
    pub(crate) inflow_rate: f64,
    /// C_T.
    pub(crate) thrust_coefficient: f64,
    /// What drives the flap, wind axes.
    pub(crate) drive: FlapDrive,
    /// Cosine and sine of the wind's azimuth.
    pub(crate) wind: (f64, f64),
}

/// A main rotor with constants derived from its data, computed once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadyRotor {
    radius: f64,
    /// 1/R.
    per_radius: f64,
    twist: f64,
    drag_0: f64,
    drag_2: f64,
    /// a0 s/2.
    half: f64,
    /// K over rho Omega^2.
    scale: f64,
    /// 1/(2 a0).
    per_slope: f64,
    /// gamma over rho.
    lock: f64,
    /// K_beta/I_beta.
    stiffness: f64,
    /// -N_b K_beta/2.
    spring: f64,
}

impl MainRotor {
    /// Blade area over disc area.
    pub fn solidity(&self) -> f64 {
        self.blades * self.chord / (PI * self.radius)
    }

    pub(crate) fn ready(&self) -> ReadyRotor {
        let (radius, half) = (self.radius, 0.5 * self.lift_slope * self.solidity());
        let radius2 = radius * radius;
        ReadyRotor {
            radius,
            per_radius: 1.0 / radius,
            twist: self.twist,
            drag_0: self.drag_0,
            drag_2: self.drag_2,
            half,
            scale: radius2 * PI * radius2 * half,
            per_slope: 0.5 / self.lift_slope,
            lock: self.chord * self.lift_slope * radius2 * radius2 / self.flap_inertia,
            stiffness: self.flap_stiffness / self.flap_inertia,
            spring: -0.5 * self.blades * self.flap_stiffness,
        }
    }
}

/// What the rotor meets before its inflow is known, wind axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RotorFlow {
    mu: f64,
    mu_z: f64,
    theta0: f64,
    theta1s: f64,
    theta1c: f64,
    /// Hub rates over Omega.
    p: f64,
    q: f64,
    lock: f64,
    lambda_beta2: f64,
    /// (1) without the flow through the disc.
    still: f64,
    wind: (f64, f64),
    rotor_speed: f64,
    density: f64,
    states: RotorStates,
}

impl ReadyRotor {
    /// Loads (1) to (5) for pitch theta0, theta1s, theta1c in hub axes; the inflow iteration starts from `guess`.
    #[cfg(test)]
    pub(crate) fn point(
        &self,
        motion: &HubMotion,
        pitch: [f64; 3],
        speed_and_density: (f64, f64),
        states: RotorStates,
        guess: f64,
    ) -> RotorPoint {
        let flow = self.flow(motion, pitch, speed_and_density, states);
        self.loads(&flow, states.inflow.unwrap_or_else(|| self.balance(&flow).uniform(guess)))
    }

    /// What it meets with pitch theta0, theta1s, theta1c in hub axes.
    #[inline]
    pub(crate) fn flow(
        &self,
        motion: &HubMotion,
        pitch: [f64; 3],
        (rotor_speed, density): (f64, f64),
        states: RotorStates,
    ) -> RotorFlow {
        let per_omega = 1.0 / rotor_speed;
        let per_tip = per_omega * self.per_radius;
        let (mu, mu_z) = (motion.in_plane * per_tip, motion.axial * per_tip);
        let (cos_w, sin_w) = motion.wind;
        let [theta0, theta1s, theta1c] = pitch;
        let p = (motion.p * cos_w + motion.q * sin_w) * per_omega;
        let q = (motion.q * cos_w - motion.p * sin_w) * per_omega;
        let (theta1s, theta1c) = (theta1s * cos_w + theta1c * sin_w, theta1c * cos_w - theta1s * sin_w);
        let mu2 = mu * mu;
        let flapping = states.flap_rates.map_or(0.0, |rates| {
            let rates = rates.to_wind(motion.wind);
            rates.coning * (1.0 / 3.0) + 0.25 * mu * rates.sine
        });
        let still =
            theta0 * (1.0 / 3.0 + 0.5 * mu2) + 0.5 * mu * (theta1s + 0.5 * p) + 0.25 * (1.0 + mu2) * self.twist - flapping;
        let (lock, lambda_beta2) = (density * self.lock, 1.0 + self.stiffness * (per_omega * per_omega));
        let wind = motion.wind;
        RotorFlow { mu, mu_z, theta0, theta1s, theta1c, p, q, lock, lambda_beta2, still, wind, rotor_speed, density, states }
    }

    /// (2).
    #[inline]
    pub(crate) fn balance(&self, flow: &RotorFlow) -> MomentumBalance {
        let (half, mu_z) = (self.half, flow.mu_z);
        MomentumBalance { mu2: flow.mu * flow.mu, mu_z, c0: half * (flow.still + 0.5 * mu_z), c1: 0.5 * half }
    }

    /// Mean induced velocity, m/s, of that inflow.
    #[inline]
    pub(crate) fn induced(&self, flow: &RotorFlow, lambda0: f64) -> f64 {
        lambda0 * flow.rotor_speed * self.radius
    }

    /// Loads (1) to (5) with that inflow.
    #[inline]
    pub(crate) fn loads(&self, flow: &RotorFlow, lambda0: f64) -> RotorPoint {
        let RotorFlow { mu, mu_z, theta0, theta1s, theta1c, p, q, lock, lambda_beta2, still, wind, .. } = *flow;
        let (mu2, through) = (mu * mu, mu_z - lambda0);
        let f0 = still + 0.5 * through;
        let thrust_coefficient = self.half * f0;
        let speed = libm::sqrt(mu2 + through * through);
        let inflow_rate = (thrust_coefficient - 2.0 * lambda0 * speed) * (1.0 / APPARENT_MASS);

        let lambda1c = harmonic(mu, mu_z, lambda0, speed);
        let drive = FlapDrive { mu, theta0, twist: self.twist, theta1s, theta1c, through, lambda1c, p, q, lock, lambda_beta2 };
        let flap_w = flow.states.flap.map_or_else(|| drive.quasi_steady(), |flap| flap.to_wind(wind));
        let flap = flow.states.flap.unwrap_or_else(|| flap_w.to_hub(wind));

        let k = flow.density * (flow.rotor_speed * flow.rotor_speed) * self.scale;
        let thrust = k * f0;
        let delta = self.drag_0 + self.drag_2 * thrust_coefficient * thrust_coefficient;
        let x_w = thrust * flap_w.cosine - k * delta * mu * self.per_slope;
        let y_w = -thrust * flap_w.sine;
        let profile = 0.5 * delta * self.per_slope * (1.0 + PROFILE_TORQUE * mu2);
        let torque = self.radius * (k * (profile - through * f0) + mu * x_w);
        let (spring, (cos_w, sin_w)) = (self.spring, wind);
        let loads = HubLoads {
            force: [x_w * cos_w - y_w * sin_w, x_w * sin_w + y_w * cos_w, -thrust],
            moment: [spring * flap.sine, spring * flap.cosine, torque],
        };
        RotorPoint {
            loads,
            torque,
            flap,
            induced: self.induced(flow, lambda0),
            inflow: lambda0,
            inflow_rate,
            thrust_coefficient,
            drive,
            wind,
        }
    }
}
