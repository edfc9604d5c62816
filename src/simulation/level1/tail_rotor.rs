//! The tail rotor: uniform inflow, pitch-flap coupling (delta-3), thrust along body y.
//!
//! Consumes velocity and rates at the hub of the tail rotor, collective theta0T, speed of the main rotor, induced velocity of
//! the main rotor and density; produces force and moment about the centre of mass, and torque. Arm x behind and h above it:
//!     u_T = u - q h     v_T = v - r x + p h     w_T = w + q x - k_lambda v_i                           (1)
//!     mu = sqrt(u_T^2 + w_T^2)/(Omega_T R_T)     mu_z = -v_T/(Omega_T R_T)
//!     theta = [theta0T + k3 G 4/3 (mu_z - lambda)]/[1 - k3 G (1 + mu^2)]                               (2)
//!     C_T = a0 s/2 [theta (1/3 + mu^2/2) + (mu_z - lambda)/2], lambda from momentum (`inflow`)         (3)
//!     Y = rho (Omega_T R_T)^2 pi R_T^2 C_T F     L = h Y     N = -x Y                                  (4)
//!     C_Q = -(mu_z - lambda) C_T + (delta_0 + delta_2 C_T^2) s (1 + 3 mu^2)/8                          (5)
//! k3 is the tangent of the delta-3 angle, G = (gamma/8 lambda_beta^2) of the blade, F the fraction of thrust that fin
//! blockage leaves. (2) is linear in lambda, so (3) is the straight line that `inflow` requires.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch. 3.

use super::inflow::MomentumBalance;
use core::f64::consts::PI;

/// Data of the tail rotor, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TailRotor {
    /// Radius, m.
    pub radius: f64,
    /// Turns a turn of the main rotor.
    pub gearing: f64,
    /// Lift slope, per rad.
    pub lift_slope: f64,
    /// Blade area over disc area.
    pub solidity: f64,
    /// Profile drag `drag_0 + drag_2 CT^2`.
    pub drag_0: f64,
    /// See `drag_0`.
    pub drag_2: f64,
    /// Distance aft of the main hub's foot point, m.
    pub aft: f64,
    /// Height above the centre of mass, m.
    pub height: f64,
    /// k3.
    pub pitch_flap_coupling: f64,
    /// G.
    pub flap_ratio: f64,
    /// F.
    pub blockage: f64,
    /// k_lambda: part of the main rotor's induced velocity that it feels.
    pub downwash: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TailPoint {
    /// Thrust along body y, N.
    pub(crate) side_force: f64,
    /// Torque at its own shaft, N m.
    pub(crate) torque: f64,
    /// lambda.
    pub(crate) inflow: f64,
}

/// A tail rotor with constants derived from its data, computed once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadyTail {
    data: TailRotor,
    /// Its arm behind the centre of mass, m.
    pub(crate) arm: f64,
    /// Tip speed over the main rotor's, m, and 1 over it.
    tip: f64,
    per_tip: f64,
    /// a0 s/2.
    half: f64,
    /// k3 G.
    coupling: f64,
    /// pi R^2.
    area: f64,
}

impl TailRotor {
    /// With its arm behind the centre of mass, m.
    pub(crate) fn ready(&self, arm: f64) -> ReadyTail {
        let tip = self.gearing * self.radius;
        ReadyTail {
            data: *self,
            arm,
            tip,
            per_tip: 1.0 / tip,
            half: 0.5 * self.lift_slope * self.solidity,
            coupling: self.pitch_flap_coupling * self.flap_ratio,
            area: PI * self.radius * self.radius,
        }
    }
}

/// What the tail rotor meets before its inflow is known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TailFlow {
    /// (3): the thrust coefficient is c0 - c1 lambda.
    pub(crate) balance: MomentumBalance,
    /// Omega_T R_T.
    tip: f64,
    density: f64,
}

impl ReadyTail {
    /// (1) to (5); the inflow iteration starts from `guess`.
    #[cfg(test)]
    pub(crate) fn point(&self, velocity: [f64; 3], rates: [f64; 3], pitch: f64, air: (f64, f64, f64), guess: f64) -> TailPoint {
        let flow = self.flow(velocity, rates, pitch, air);
        self.loads(&flow, flow.balance.uniform(guess))
    }

    /// Whether the main rotor's induced velocity reaches it.
    #[inline]
    pub(crate) fn in_downwash(&self) -> bool {
        self.data.downwash != 0.0
    }

    /// (1) to (3), for speed of the main rotor, density and induced velocity of the main rotor.
    #[inline]
    pub(crate) fn flow(
        &self,
        [u, v, w]: [f64; 3],
        [p, q, r]: [f64; 3],
        pitch: f64,
        (rotor_speed, density, induced): (f64, f64, f64),
    ) -> TailFlow {
        let ReadyTail { data, arm, coupling, half, .. } = self;
        let (tip, per_tip) = (rotor_speed * self.tip, self.per_tip / rotor_speed);
        let (u_t, v_t) = (u - q * data.height, v - r * arm + p * data.height);
        let w_t = w + q * arm - data.downwash * induced;
        let (mu2, mu_z) = ((u_t * u_t + w_t * w_t) * (per_tip * per_tip), -v_t * per_tip);
        let feathered = 1.0 / (1.0 - coupling * (1.0 + mu2));
        let by_pitch = 1.0 / 3.0 + 0.5 * mu2;
        // C_T = half (by_pitch feathered pitch + flow (mu_z - lambda)).
        let flow = by_pitch * feathered * coupling * (4.0 / 3.0) + 0.5;
        let balance = MomentumBalance { mu2, mu_z, c0: half * (by_pitch * feathered * pitch + flow * mu_z), c1: half * flow };
        TailFlow { balance, tip, density }
    }

    /// (3) to (5) with that inflow.
    #[inline]
    pub(crate) fn loads(&self, flow: &TailFlow, lambda: f64) -> TailPoint {
        let (data, TailFlow { balance: MomentumBalance { mu2, mu_z, c0, c1 }, tip, density }) = (&self.data, *flow);
        let thrust_coefficient = c0 - c1 * lambda;
        let scale = density * tip * tip * self.area;
        let delta = data.drag_0 + data.drag_2 * thrust_coefficient * thrust_coefficient;
        let c_q = -(mu_z - lambda) * thrust_coefficient + 0.125 * delta * data.solidity * (1.0 + 3.0 * mu2);
        TailPoint { side_force: scale * thrust_coefficient * data.blockage, torque: scale * data.radius * c_q, inflow: lambda }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotor() -> TailRotor {
        TailRotor {
            radius: 1.5,
            gearing: 5.0,
            lift_slope: 5.7,
            solidity: 0.2,
            drag_0: 0.01,
            drag_2: 9.0,
            aft: 9.0,
            height: 1.6,
            pitch_flap_coupling: -1.0,
            flap_ratio: 1.0,
            blockage: 1.0,
            downwash: 0.0,
        }
    }

    #[test]
    fn in_hover_thrust_blows_as_momentum_says() {
        // Hover: C_T = 2 lambda^2 and C_T = a0 s/2 [theta/3 - lambda/2], theta = (theta0 + 4/3 lambda)/2.
        let (omega, density, theta0) = (27.0, 1.225, 0.15f64);
        let tip = 5.0 * omega * 1.5;
        let (a, b, c) = (2.0f64, 0.57 * (0.5 - 2.0 / 9.0), -0.57 * theta0 / 6.0);
        let lambda = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
        let wanted = density * tip * tip * PI * 1.5 * 1.5 * 2.0 * lambda * lambda;
        let found = rotor().ready(9.0).point([0.0; 3], [0.0; 3], theta0, (omega, density, 0.0), f64::NAN);
        assert!((found.side_force - wanted).abs() < 1e-9 * wanted);
        assert!(found.torque > 0.0);
    }

    #[test]
    fn the_mirror_image_has_the_opposite_thrust_and_the_same_torque() {
        let given = (27.0, 1.1, 0.0);
        let one = rotor().ready(9.0).point([50.0, 3.0, -1.0], [0.1, 0.2, 0.3], 0.1, given, f64::NAN);
        let other = rotor().ready(9.0).point([50.0, -3.0, -1.0], [-0.1, 0.2, -0.3], -0.1, given, f64::NAN);
        assert!((one.side_force + other.side_force).abs() < 1e-9 && (one.torque - other.torque).abs() < 1e-9);
    }
}
