//! The engine with its governor, and the speed of the rotor.
//!
//! Consumes rotor speed (rad/s), engine torque and its rate, torque of both rotors (N m, at the main rotor), yaw acceleration;
//! produces
//!     dOmega/dt = (Q_e - Q_R)/I + sigma dr/dt                                                          (1)
//!     tau_1 tau_3 d2Q_e/dt2 = -(tau_1 + tau_3) dQ_e/dt - Q_e + Q_c                                     (2)
//!     Q_c = -K (Omega - Omega_i + tau_2 dOmega/dt), limited to 0 ... Q_max                             (3)
//! with K = Q_full/(droop Omega_nominal): at full torque the speed has fallen by the droop. Fuel flow limits Q_c from below and,
//! where the model file gives Q_max, from above; (2) is two first-order lags in series, so Q_e stays within the same limits. A
//! freewheel separates engine and rotor: no negative torque enters (1), and a rotor driven by the air may exceed the engine's
//! speed. The governor datum Omega_i is such that the rotor has its nominal speed in trim. Source: G. D. Padfield, Helicopter
//! Flight Dynamics, 2nd ed. 2007, ch. 3, with constant time constants.

/// Data of engine and governor, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engine {
    /// Q_full, N m at the main rotor.
    pub full_torque: f64,
    /// Part of the nominal speed that is lost at full torque.
    pub droop: f64,
    /// tau_1, s.
    pub lag_fuel: f64,
    /// tau_3, s.
    pub lag_engine: f64,
    /// tau_2, s.
    pub lead: f64,
    /// I, rotors and transmission at the main rotor, kg m^2.
    pub inertia: f64,
    /// Most torque, N m at the main rotor; `None` has no limit.
    pub torque_limit: Option<f64>,
}

impl Engine {
    /// K, N m a rad/s.
    pub(crate) fn gain(&self, nominal_speed: f64) -> f64 {
        self.full_torque / (self.droop * nominal_speed)
    }

    /// What passes the freewheel of an engine torque.
    pub(crate) fn delivered(&self, torque: f64) -> f64 {
        torque.clamp(0.0, self.most())
    }

    /// Most torque, N m.
    pub(crate) fn most(&self) -> f64 {
        self.torque_limit.unwrap_or(f64::INFINITY)
    }

    /// (1).
    pub(crate) fn acceleration(&self, engine_torque: f64, rotor_torque: f64, yaw: f64) -> f64 {
        (self.delivered(engine_torque) - rotor_torque) / self.inertia + yaw
    }

    /// (2), (3): second derivative of the torque, speeds as (speed, datum, rate).
    pub(crate) fn torque_acceleration(
        &self,
        (torque, rate): (f64, f64),
        gain: f64,
        (speed, datum, acceleration): (f64, f64, f64),
    ) -> f64 {
        let called = self.delivered(-gain * (speed - datum + self.lead * acceleration));
        (called - torque - (self.lag_fuel + self.lag_engine) * rate) / (self.lag_fuel * self.lag_engine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENGINE: Engine =
        Engine { full_torque: 8e4, droop: 0.05, lag_fuel: 0.1, lag_engine: 0.4, lead: 0.3, inertia: 6500.0, torque_limit: None };

    #[test]
    fn at_full_torque_the_speed_has_drooped() {
        let engine = ENGINE;
        // Steady: Q = -K (Omega - Omega_i), so 5 % of 27 rad/s below the datum is full torque.
        let called = engine.torque_acceleration((8e4, 0.0), engine.gain(27.0), (27.0 * 0.95, 27.0, 0.0));
        assert!(called.abs() < 1e-6, "{called}");
        assert!((engine.acceleration(7e4, 6.35e4, 0.2) - 1.2).abs() < 1e-12);
    }

    #[test]
    fn a_freewheel_pulls_one_way_and_a_limit_holds() {
        let engine = Engine { torque_limit: Some(5e4), ..ENGINE };
        // A torque below zero neither brakes the rotor nor is called for; the air's 3.25 kN m alone speeds it up by 0.5 rad/s^2.
        assert!((engine.acceleration(-1e4, -3250.0, 0.0) - 0.5).abs() < 1e-12);
        assert!((engine.acceleration(9e4, 5e4, 0.0)).abs() < 1e-12);
        // Three tenths fast, or 20 % slow: steady at no torque and at the limit.
        for (speed, steady) in [(27.0 * 1.3, 0.0), (27.0 * 0.8, 5e4)] {
            assert!(engine.torque_acceleration((steady, 0.0), engine.gain(27.0), (speed, 27.0, 0.0)).abs() < 1e-9);
        }
    }
}
