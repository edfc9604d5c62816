//! Trim: attitude and controls of steady, straight flight.
//!
//! Consumes true airspeed V (m/s), climb rate, sideslip beta, density; produces bank, pitch attitude and the four controls at
//! which all six accelerations vanish. With sin(gamma) = climb/V, the velocity through still air is v = V sin(beta) and u, w of
//!     V sin(gamma) = u sin(theta) - v cos(theta) sin(phi) - w cos(theta) cos(phi)                      (1)
//! On a path steeper than [`STEEP`] a given sideslip may not be compatible with (1); there beta is the angle from heading to
//! ground track, positive to the right. A climb rate above the airspeed is a vertical path at that rate. Numerics: Newton's
//! method with finite differences, steps halved until the accelerations decrease; from a fixed start, and if that fails by
//! continuation from hover. Solved to rounding; a residual above [`TOLERANCE`] is no trim. Refused as well: attitudes and blade
//! pitch beyond the range of the equations ([`MOST_ATTITUDE`], [`MOST_PITCH`]).

use super::aircraft::{Level1, Situation};
use super::internal_states::InternalStates;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::model::Trim;
use crate::simulation::motion::Motion;
use nalgebra::{SMatrix, SVector};

/// Sine of the flight-path angle beyond which sideslip is that of the track.
pub const STEEP: f64 = 0.99;

/// Largest acceleration that counts as none, m/s^2 and rad/s^2.
pub const TOLERANCE: f64 = 1e-10;

/// Largest bank or pitch attitude of a trim, rad.
pub const MOST_ATTITUDE: f64 = 1.0;

/// Largest blade pitch of a trim, rad: beyond it a blade has stalled, which the equations do not know.
pub const MOST_PITCH: f64 = 0.6;

/// The flight that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrimCondition {
    /// True airspeed, m/s.
    pub speed: f64,
    /// Climb rate, m/s.
    pub climb: f64,
    /// Sideslip, rad.
    pub sideslip: f64,
    /// Air density, kg/m^3.
    pub density: f64,
}

/// A Level-1 aircraft in its trim.
#[derive(Clone, Debug, PartialEq)]
pub struct Trimmed {
    /// The aircraft.
    pub aircraft: Level1,
    /// The flight that was asked for.
    pub condition: TrimCondition,
    /// Velocity, attitude and controls.
    pub trim: Trim,
    /// Inner states.
    pub inner: InternalStates,
    /// Speed at which the governor asks for no torque, rad/s.
    pub datum: f64,
    /// Largest acceleration left, m/s^2 or rad/s^2.
    pub residual: f64,
}

/// Why there is no trim.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum TrimError {
    #[error("expected {expected}, found {found}")]
    Condition { expected: &'static str, found: f64 },
    #[error(
        "no trim at {:.2} m/s, climb {:.2} m/s, sideslip {:.3} rad, {:.3} kg/m^3: the steadiest state found still accelerates by {:.1e} m/s^2 or rad/s^2",
        .condition.speed, .condition.climb, .condition.sideslip, .condition.density, .left
    )]
    NotFound { condition: TrimCondition, left: f64 },
    #[error(
        "no trim at {:.2} m/s, climb {:.2} m/s, sideslip {:.3} rad, {:.3} kg/m^3: the inflow of a rotor has no solution there",
        .0.speed, .0.climb, .0.sideslip, .0.density
    )]
    NoInflow(TrimCondition),
    #[error("no trim: a path of {:.2} m/s with climb {:.2} m/s is too steep for a sideslip of {:.3} rad", .0.speed, .0.climb, .0.sideslip)]
    TooSteep(TrimCondition),
    #[error(
        "no trim at {:.2} m/s, climb {:.2} m/s, sideslip {:.3} rad, {:.3} kg/m^3: its rotors take {:.0} N m at their nominal speed, and the engine gives from 0 to {:.0} N m",
        .condition.speed, .condition.climb, .condition.sideslip, .condition.density, .found, .most
    )]
    Torque { condition: TrimCondition, found: f64, most: f64 },
    #[error(
        "no trim at {:.2} m/s, climb {:.2} m/s, sideslip {:.3} rad, {:.3} kg/m^3: it would need {} {:.2} rad, beyond {:.1} rad",
        .condition.speed, .condition.climb, .condition.sideslip, .condition.density, .what, .found, .most
    )]
    Beyond { condition: TrimCondition, what: &'static str, found: f64, most: f64 },
}

/// phi, theta, and the controls by place.
type Unknowns = SVector<f64, 6>;

const UNKNOWNS: [&str; 6] =
    ["a bank of", "a pitch attitude of", "a lon_cyclic of", "a lat_cyclic of", "a collective of", "a pedal of"];

impl TrimCondition {
    /// Airspeed flown, m/s: the climb rate where that exceeds the airspeed asked for.
    pub fn airspeed(&self) -> f64 {
        self.speed.max(libm::fabs(self.climb))
    }

    fn check(&self) -> Result<(), TrimError> {
        let ranges = [
            (self.speed, (0.0..=1000.0).contains(&self.speed), "an airspeed from 0 to 1000 m/s"),
            (self.climb, libm::fabs(self.climb) <= 1000.0, "a climb rate from -1000 to 1000 m/s"),
            (self.sideslip, libm::fabs(self.sideslip) <= 1.5, "a sideslip from -1.5 to 1.5 rad"),
            (self.density, (0.1..=1.6).contains(&self.density), "--density from 0.1 to 1.6 kg/m^3"),
        ];
        match ranges.into_iter().find(|(_, good, _)| !good) {
            Some((found, _, expected)) => Err(TrimError::Condition { expected, found }),
            None => Ok(()),
        }
    }

    /// Velocity through the air at that bank and pitch attitude, body axes; `None` where (1) has no solution.
    fn velocity(&self, phi: f64, theta: f64) -> Option<[f64; 3]> {
        let airspeed = self.airspeed();
        if airspeed == 0.0 {
            return Some([0.0; 3]);
        }
        let (sin_phi, cos_phi) = libm::sincos(phi);
        let (sin_theta, cos_theta) = libm::sincos(theta);
        let (sin_beta, cos_beta) = libm::sincos(self.sideslip);
        let sin_gamma = (self.climb / airspeed).clamp(-1.0, 1.0);
        if libm::fabs(sin_gamma) > STEEP {
            let level = airspeed * libm::sqrt(1.0 - sin_gamma * sin_gamma);
            let (ahead, right, down) = (level * cos_beta, level * sin_beta, -airspeed * sin_gamma);
            let along = sin_theta * ahead + cos_theta * down;
            return Some([
                cos_theta * ahead - sin_theta * down,
                sin_phi * along + cos_phi * right,
                cos_phi * along - sin_phi * right,
            ]);
        }
        let (v, in_plane) = (airspeed * sin_beta, airspeed * cos_beta);
        // u = in_plane cos(a), w = in_plane sin(a): in_plane (A cos(a) - B sin(a)) = climb + v cos(theta) sin(phi).
        let (a, b) = (sin_theta, cos_theta * cos_phi);
        let share = (self.climb + v * cos_theta * sin_phi) / (in_plane * libm::sqrt(a * a + b * b));
        if !(libm::fabs(share) <= 1.0) {
            return None;
        }
        let (sin, cos) = libm::sincos(libm::acos(share) - libm::atan2(b, a));
        Some([in_plane * cos, v, in_plane * sin])
    }

    /// On the way from `other` (part 0) to here (part 1).
    fn between(&self, other: &TrimCondition, part: f64) -> TrimCondition {
        let mix = |from: f64, to: f64| from + part * (to - from);
        TrimCondition {
            speed: mix(other.speed, self.speed),
            climb: mix(other.climb, self.climb),
            sideslip: mix(other.sideslip, self.sideslip),
            density: mix(other.density, self.density),
        }
    }
}

impl Level1 {
    /// The trim at that condition, from a cold start.
    ///
    /// # Errors
    /// [`TrimError`] where the condition is none, no trim is found, or one only beyond what equations or engine hold for.
    pub fn trim(&self, condition: TrimCondition) -> Result<Trimmed, TrimError> {
        condition.check()?;
        let cold = Unknowns::from([0.0, 0.0, 0.0, 0.0, 0.2, 0.0]);
        let (mut found, mut left) = self.newton(&condition, cold);
        if !(left < TOLERANCE) {
            (found, left) = self.along_a_path(&condition, cold).unwrap_or((found, left));
        }
        if left == f64::INFINITY {
            let has_velocity = condition.velocity(0.0, 0.0).is_some();
            return Err(if has_velocity { TrimError::NoInflow(condition) } else { TrimError::TooSteep(condition) });
        }
        if !(left < TOLERANCE) {
            return Err(TrimError::NotFound { condition, left });
        }
        for (place, (what, &value)) in UNKNOWNS.into_iter().zip(found.iter()).enumerate() {
            let most = if place < 2 { MOST_ATTITUDE } else { MOST_PITCH };
            if !(libm::fabs(value) <= most) {
                return Err(TrimError::Beyond { condition, what, found: value, most });
            }
        }
        let [phi, theta, controls @ ..] = <[f64; 6]>::from(found);
        let velocity = condition.velocity(phi, theta).ok_or(TrimError::TooSteep(condition))?;
        let [u, v, w] = velocity;
        let rotor_speed = self.main_rotor.speed;
        let trim = Trim { u, v, w, phi, theta, rotor_speed: Some(rotor_speed), controls };
        let response = self.respond(&situation(velocity, [0.0; 3], controls, rotor_speed, condition.density));
        let (found, most) = (response.torque, self.engine.most());
        if self.options.governed && !(found >= 0.0 && found <= most) {
            return Err(TrimError::Torque { condition, found, most });
        }
        let inner = InternalStates {
            flap: response.flap,
            inflow: response.inflow,
            rotor_speed,
            torque: response.torque,
            blade: controls,
            ..InternalStates::default()
        };
        let datum = rotor_speed + response.torque / self.engine.gain(rotor_speed);
        Ok(Trimmed { aircraft: self.clone(), condition, trim, inner, datum, residual: left })
    }

    /// Conditions from hover to the one that is asked for, in steps that shrink where one fails.
    fn along_a_path(&self, condition: &TrimCondition, cold: Unknowns) -> Option<(Unknowns, f64)> {
        const SHORTEST: f64 = 1e-3;
        let hover = TrimCondition { speed: 0.0, climb: 0.0, sideslip: 0.0, density: condition.density };
        let (mut state, left) = self.newton(&hover, cold);
        if !(left < TOLERANCE) {
            return None;
        }
        let (mut part, mut step) = (0.0, 0.25);
        loop {
            let next = f64::min(part + step, 1.0);
            let (tried, left) = self.newton(&condition.between(&hover, next), state);
            if left < TOLERANCE {
                if next >= 1.0 {
                    return Some((tried, left));
                }
                (state, part, step) = (tried, next, 1.5 * step);
            } else if step > SHORTEST {
                step *= 0.5;
            } else {
                return None;
            }
        }
    }

    /// Newton's method from that state; gives the state with the smallest accelerations, and the largest of those.
    fn newton(&self, condition: &TrimCondition, start: Unknowns) -> (Unknowns, f64) {
        const ITERATIONS: usize = 60;
        const DIFFERENCE: f64 = 1e-6;
        const LONGEST: f64 = 0.2;
        let Some(mut residual) = self.accelerations(condition, &start) else { return (start, f64::INFINITY) };
        let mut state = start;
        for _ in 0..ITERATIONS {
            let mut jacobian = SMatrix::<f64, 6, 6>::zeros();
            for column in 0..6 {
                let moved = |by: f64| {
                    let mut state = state;
                    state[column] += by;
                    self.accelerations(condition, &state)
                };
                let (Some(up), Some(down)) = (moved(DIFFERENCE), moved(-DIFFERENCE)) else { return (state, residual.amax()) };
                jacobian.set_column(column, &((up - down) / (2.0 * DIFFERENCE)));
            }
            let Some(mut step) = jacobian.lu().solve(&residual) else { break };
            let longest = step.amax();
            if !longest.is_finite() {
                break;
            }
            if longest > LONGEST {
                step *= LONGEST / longest;
            }
            let mut better = None;
            let mut share = 1.0;
            while share > 1e-4 {
                let tried = state - step * share;
                match self.accelerations(condition, &tried) {
                    Some(accelerations) if accelerations.norm() < residual.norm() => {
                        better = Some((tried, accelerations));
                        break;
                    }
                    _ => share *= 0.5,
                }
            }
            // Where no step makes it better it is as steady as rounding lets it be, or stuck: the residual decides.
            let Some(next) = better else { break };
            (state, residual) = next;
        }
        (state, residual.amax())
    }

    /// The six accelerations that a trim makes vanish; `None` where the condition has no such attitude.
    fn accelerations(&self, condition: &TrimCondition, state: &Unknowns) -> Option<SVector<f64, 6>> {
        let [phi, theta, controls @ ..] = <[f64; 6]>::from(*state);
        let velocity = condition.velocity(phi, theta)?;
        let response = self.respond(&situation(velocity, [0.0; 3], controls, self.main_rotor.speed, condition.density));
        let [ax, ay, az, dp, dq, dr] = response.accelerations;
        let motion = Motion { velocity, rates: [0.0; 3], attitude: [phi, theta, 0.0], altitude: 0.0 };
        let change = motion.rate_of_change([ax, ay, az], [dp, dq, dr]);
        let ([x, y, z], [l, m, n]) = (change.velocity, change.rates);
        let all = [x, y, z, l, m, n];
        all.iter().all(|value| value.is_finite()).then(|| SVector::from(all))
    }
}

/// A situation out of its parts.
pub(crate) const fn situation(
    velocity: [f64; 3],
    rates: [f64; 3],
    blade: [f64; CONTROLS],
    rotor_speed: f64,
    density: f64,
) -> Situation {
    Situation { velocity, rates, blade, rotor_speed, density }
}

const _: () = assert!(Control::LonCyclic.index() == 0 && Control::Pedal.index() == 3, "UNKNOWNS names controls by place");
