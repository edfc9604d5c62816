//! Rates of the internal states: flap, inflow, rotor speed, engine and actuators, as the options select them.
//!
//! Consumes a trimmed aircraft, the flight state with the pitch demanded by the control path, and the internal states; produces
//! accelerations and rates of the internal states. Order of evaluation: actuators give the blade pitch; pitch, flap and inflow
//! the loads; loads and effects the accelerations; these drive flap and rotor speed.

use super::aircraft::{AircraftResponse, Equations, Situation};
use super::inflow::InflowGuess;
use super::internal_states::{Flapping, InternalStates};
use super::rotor::RotorStates;
use super::trim::Trimmed;
use crate::flight::control::CONTROLS;
use crate::flight::derivative::AXES;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instant {
    pub(crate) response: AircraftResponse,
    /// Rates of the inner states a second.
    pub(crate) rates: InternalStates,
    /// Pitch behind the actuators, rad.
    pub(crate) blade: [f64; CONTROLS],
    /// Speed of the main rotor, rad/s.
    pub(crate) rotor_speed: f64,
}

impl Trimmed {
    /// Response and inner rates. Each control acts `effectiveness` times its deviation from trim; `added` gives from pitch
    /// and rotor speed what effects add to the accelerations; inflow iterations start from `guess`.
    #[inline]
    pub(crate) fn instant(
        &self,
        equations: &Equations<'_>,
        (situation, inner, guess): (&Situation, &InternalStates, InflowGuess),
        effectiveness: &[f64; CONTROLS],
        added: impl FnOnce([f64; CONTROLS], f64) -> Option<[f64; AXES]>,
    ) -> Instant {
        let aircraft = &self.aircraft;
        let (options, mut met) = (aircraft.options, *situation);
        let mut rates = InternalStates::default();
        if options.actuators {
            let ways = situation.blade.into_iter().zip(inner.blade);
            for ((rate, actuator), (asked, position)) in rates.blade.iter_mut().zip(&aircraft.actuators).zip(ways) {
                *rate = actuator.rate_of(asked, position);
            }
            met.blade = inner.blade;
        }
        if options.governed {
            met.rotor_speed = inner.rotor_speed;
        }
        let (blade, omega) = (met.blade, met.rotor_speed);
        for ((pitch, at_trim), factor) in met.blade.iter_mut().zip(self.trim.controls).zip(effectiveness) {
            *pitch = at_trim + factor * (*pitch - at_trim);
        }
        let states = RotorStates {
            flap: (options.flapping != Flapping::QuasiSteady).then_some(inner.flap),
            flap_rates: (options.flapping == Flapping::SecondOrder).then(|| inner.flap_rate.scaled(1.0 / omega)),
            inflow: options.dynamic_inflow.then_some(inner.inflow),
        };
        let delivered = options.governed.then(|| aircraft.engine.delivered(inner.torque));
        let mut response = equations.sum(&met, states, delivered, guess);
        for (acceleration, added) in response.accelerations.iter_mut().zip(added(blade, omega).into_iter().flatten()) {
            *acceleration += added;
        }
        let [_, _, _, dp, dq, dr] = response.accelerations;
        let drive = &response.rotor.drive;
        match options.flapping {
            Flapping::QuasiSteady => {}
            Flapping::FirstOrder => {
                let wind = response.rotor.wind;
                rates.flap = drive.first_order_rates(inner.flap.to_wind(wind)).to_hub(wind).scaled(omega);
            }
            Flapping::SecondOrder => {
                let wind = response.rotor.wind;
                let (flap, rate) = (inner.flap.to_wind(wind), inner.flap_rate.scaled(1.0 / omega).to_wind(wind));
                let omega2 = omega * omega;
                let (p, q) = (equations.place.roll([dp, dr]) / omega2, dq / omega2);
                let (p_w, q_w) = (p * wind.0 + q * wind.1, q * wind.0 - p * wind.1);
                rates.flap = inner.flap_rate;
                rates.flap_rate = drive.accelerations(flap, rate, p_w, q_w).to_hub(wind).scaled(omega2);
            }
        }
        if options.dynamic_inflow {
            rates.inflow = response.rotor.inflow_rate * omega;
        }
        if options.governed {
            let (engine, nominal) = (&aircraft.engine, aircraft.main_rotor.speed);
            rates.rotor_speed = engine.acceleration(inner.torque, response.torque, aircraft.main_rotor.direction * dr);
            rates.torque = inner.torque_rate;
            let speeds = (omega, self.datum, rates.rotor_speed);
            rates.torque_rate = engine.torque_acceleration((inner.torque, inner.torque_rate), engine.gain(nominal), speeds);
        }
        Instant { response, rates, blade, rotor_speed: omega }
    }
}
