//! The nonlinear part of kinematics and instruments, computed from measurements.
//!
//! Consumes a run with airspeed, flow angles, rates and attitude; produces, for u v w phi theta (and v/V0, w/V0), the rate of
//! change by the full kinematics less its value in trim and less the linear part that the model has itself, as a known input:
//!     f(x) - f(x0) - sum_j df/dx_j (x_j - x0_j)                                                        (1)
//!     f_u = v r - w q - g sin(theta)     f_v = w p - u r + g cos(theta) sin(phi)
//!     f_w = u q - v p + g cos(theta) cos(phi)
//!     f_phi = p + tan(theta) (q sin(phi) + r cos(phi))     f_theta = q cos(phi) - r sin(phi)           (2)
//! and the same of the outputs, subtracted from the measurements: air data with the velocity at the vane, specific force with
//! the accelerometers' arm, by (1) to (4) and (7) of `sensors`.                                             (3)
//! The remainder holds products of deviations and the states that a chosen set omits (pitch in a lateral model); omitted, it
//! would bias the derivatives. SI, body axes, one value a row.
//! Source: Padfield et al. 1987, (1) to (5).
//! Numerics: noise of the measured deviations enters multiplied by another deviation; `velocity` keeps that of the air data
//! small.
//! Returns [`ColumnError`] where a channel is missing.

use super::columns::{ColumnError, Columns};
use super::reference_trim::ReferenceTrim;
use super::velocity::{CHANNELS, motion, of_air_data};
use crate::dynamics::sensors::{AirData, velocity_at_arm};
use crate::flight::run::RunGeometry;
use crate::flight::unit::STANDARD_GRAVITY as G0;

/// Measured motion of a run.
#[derive(Clone, Debug)]
pub(crate) struct NonlinearRemainder {
    /// u v w p q r phi theta at every row.
    motion: Vec<[f64; 8]>,
    trim: [f64; 8],
}

impl NonlinearRemainder {
    ///
    /// # Errors
    /// [`ColumnError`] where one of [`CHANNELS`] is missing or has a gap.
    pub(crate) fn of(run: &Columns) -> Result<Self, ColumnError> {
        let mut trims = [0.0; 8];
        for (channel, trim) in CHANNELS.into_iter().zip(&mut trims) {
            *trim = run.trim(channel)?;
        }
        Ok(NonlinearRemainder { motion: motion(run)?, trim: of_air_data(run, trims) })
    }

    /// (1) of a state over time, with the linear part over these variables subtracted.
    pub(crate) fn of_state(&self, reference_trim: &ReferenceTrim, state: &str, variables: &[&String]) -> Vec<f64> {
        let scale = if matches!(state, "alpha" | "beta") { 1.0 / reference_trim.airspeed } else { 1.0 };
        let at_trim = scale * kinematic_rate(state, self.trim);
        let known: Vec<f64> = variables.iter().map(|name| reference_trim.known(state, name)).collect();
        let steps = self.motion.iter().map(|now| {
            let linear: f64 = variables.iter().zip(&known).map(|(name, known)| known * deviation(name, now, &self.trim)).sum();
            scale * kinematic_rate(state, *now) - at_trim - linear
        });
        steps.collect()
    }

    /// (3) of an output over time, less its value in trim and the linear part over these variables; `None` of a linear output.
    pub(crate) fn of_output(
        &self,
        reference_trim: &ReferenceTrim,
        output: &str,
        variables: &[&String],
        geometry: &RunGeometry,
    ) -> Option<Vec<f64>> {
        if let Some(axis) = ["ax", "ay", "az"].iter().position(|name| *name == output) {
            let arm = geometry.accelerometer_position_m;
            let at_trim = centripetal(axis, &self.trim, arm);
            return Some(self.motion.iter().map(|now| centripetal(axis, now, arm) - at_trim).collect());
        }
        let slopes = reference_trim.flow_slopes(output)?;
        let vane = if output == "tas" { [0.0; 3] } else { geometry.vane_position_m };
        let at_trim = air_data(output, velocity_at(&self.trim, vane));
        let part = |now: &[f64; 8]| {
            // Linear part in the velocities that are variables of the model.
            let mut own = self.trim;
            for name in variables {
                if let Some(place) = place(name)
                    && let (Some(own), Some(now)) = (own.get_mut(place), now.get(place))
                {
                    *own = *now;
                }
            }
            let (own, trim) = (velocity_at(&own, vane), velocity_at(&self.trim, vane));
            let linear: f64 = slopes.iter().zip(own.iter().zip(trim)).map(|(slope, (own, trim))| slope * (own - trim)).sum();
            air_data(output, velocity_at(now, vane)) - at_trim - linear
        };
        Some(self.motion.iter().map(part).collect())
    }
}

fn velocity_at(&[u, v, w, p, q, r, ..]: &[f64; 8], arm: [f64; 3]) -> [f64; 3] {
    velocity_at_arm([u, v, w], [p, q, r], arm)
}

/// (3) of air data.
fn air_data(output: &str, velocity: [f64; 3]) -> f64 {
    let instrument = match output {
        "tas" => AirData::Airspeed,
        "alpha" => AirData::Incidence,
        _ => AirData::Sideslip,
    };
    instrument.value(velocity)
}

/// w x (w x r) along an axis.
fn centripetal(axis: usize, &[_, _, _, p, q, r, ..]: &[f64; 8], [x, y, z]: [f64; 3]) -> f64 {
    let along = p * x + q * y + r * z;
    let square = p * p + q * q + r * r;
    match axis {
        0 => p * along - square * x,
        1 => q * along - square * y,
        _ => r * along - square * z,
    }
}

/// Place of a variable of the model in the motion.
fn place(name: &str) -> Option<usize> {
    Some(match name {
        "u" => 0,
        "v" | "beta" => 1,
        "w" | "alpha" => 2,
        "p" => 3,
        "q" => 4,
        "r" => 5,
        "phi" => 6,
        "theta" => 7,
        _ => return None,
    })
}

/// (2).
fn kinematic_rate(state: &str, [u, v, w, p, q, r, phi, theta]: [f64; 8]) -> f64 {
    let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (libm::sincos(phi), libm::sincos(theta));
    match state {
        "u" => v * r - w * q - G0 * sin_theta,
        "v" | "beta" => w * p - u * r + G0 * cos_theta * sin_phi,
        "w" | "alpha" => u * q - v * p + G0 * cos_theta * cos_phi,
        "phi" => p + sin_theta / cos_theta * (q * sin_phi + r * cos_phi),
        "theta" => q * cos_phi - r * sin_phi,
        _ => 0.0,
    }
}

/// Deviation from trim of a variable with a known coefficient: a rate or an attitude.
fn deviation(name: &str, now: &[f64; 8], trim: &[f64; 8]) -> f64 {
    let at = |motion: &[f64; 8]| place(name).filter(|place| *place >= 3).and_then(|place| motion.get(place).copied());
    at(now).zip(at(trim)).map_or(0.0, |(now, trim)| now - trim)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row in trim, then one away from it.
    fn run(away: [f64; 8]) -> Columns {
        let trim = [50.0, 0.02, 0.1, 0.0, 0.0, 0.0, 0.12, 0.03];
        let columns = CHANNELS.iter().zip(trim.iter().zip(away)).map(|(name, (at, by))| ((*name).to_owned(), vec![*at, at + by]));
        Columns::new("a".to_owned(), RunGeometry::DEFAULT, vec![0.0, 0.1], columns.collect(), 0.05).unwrap()
    }

    #[test]
    fn the_remainder_is_of_second_order_where_the_linear_part_is_complete() {
        let names: Vec<String> = ["u", "v", "w", "p", "q", "r", "phi", "theta"].map(str::to_owned).into();
        let variables: Vec<&String> = names.iter().collect();
        let reference_trim = ReferenceTrim { airspeed: 50.0, alpha: 0.02, beta: 0.1, theta: 0.03, phi: 0.12 };
        for state in ["u", "v", "w", "phi", "theta"] {
            let size = |by: f64| {
                let away = [by, 0.01 * by, 0.012 * by, 0.02 * by, -0.015 * by, 0.01 * by, 0.04 * by, -0.03 * by];
                NonlinearRemainder::of(&run(away)).unwrap().of_state(&reference_trim, state, &variables)[1]
            };
            let (one, half) = (size(0.2), size(0.1));
            assert!((one - 4.0 * half).abs() < 0.1 * one.abs().max(half.abs()) + 1e-9, "{state}: {one}, {half}");
        }
        let geometry = RunGeometry { vane_position_m: [6.0, 0.5, 1.0], ..RunGeometry::DEFAULT };
        for output in ["tas", "alpha", "beta"] {
            let size = |by: f64| {
                let away = [by, 0.01 * by, 0.012 * by, 0.02 * by, -0.015 * by, 0.01 * by, 0.04 * by, -0.03 * by];
                NonlinearRemainder::of(&run(away)).unwrap().of_output(&reference_trim, output, &variables, &geometry).unwrap()[1]
            };
            let (one, half) = (size(0.2), size(0.1));
            assert!((one - 4.0 * half).abs() < 0.1 * one.abs().max(half.abs()) + 1e-9, "{output}: {one}, {half}");
        }
    }

    #[test]
    fn the_product_of_sideslip_and_yaw_rate_is_in_u() {
        let reference_trim = ReferenceTrim { airspeed: 50.0, alpha: 0.02, beta: 0.1, theta: 0.03, phi: 0.12 };
        let left =
            NonlinearRemainder::of(&run([0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0])).unwrap().of_state(&reference_trim, "u", &[])
                [1];
        // The whole product, for the model has neither.
        assert!((left - 50.0 * f64::sin(0.2) * 0.2).abs() < 1e-12, "{left}");
    }
}
