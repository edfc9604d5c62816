//! What the kinematics do beyond their linear part, from what was measured: known inputs of a linear model.
//!
//! Consumes a run with airspeed, flow angles, rates and attitude; produces, for u v w phi theta (and v/V0, w/V0), the rate of
//! change by the full kinematics less its value in trim and less the linear part that the model has itself,
//!     f(x) - f(x0) - sum_j df/dx_j (x_j - x0_j)                                                        (1)
//!     f_u = v r - w q - g sin(theta)     f_v = w p - u r + g cos(theta) sin(phi)
//!     f_w = u q - v p + g cos(theta) cos(phi)
//!     f_phi = p + tan(theta) (q sin(phi) + r cos(phi))     f_theta = q cos(phi) - r sin(phi)           (2)
//! Products of deviations, and whatever a chosen set of states leaves out: pitch in a lateral model, say. Left out, they would
//! be found in the derivatives instead. Source: the paper's (1) to (5).
//! Numerics: deviations are measured, so their noise comes in, but multiplied by another deviation; `velocity` keeps that of
//! the air data small.

use super::columns::{ColumnError, Columns};
use super::datum::Datum;
use super::velocity::{motion, of_air_data};
use crate::flight::unit::STANDARD_GRAVITY as G0;

/// Channels that (2) takes.
pub const CHANNELS: [&str; 8] = ["tas", "alpha", "beta", "p", "q", "r", "phi", "theta"];

/// (1) of a state over time, the linear part over these variables taken off.
///
/// # Errors
/// [`ColumnError`] where one of [`CHANNELS`] is missing or has a gap.
pub fn beyond(run: &Columns, datum: &Datum, state: &str, variables: &[&String]) -> Result<Vec<f64>, ColumnError> {
    let mut trims = [0.0; 8];
    for (channel, trim) in CHANNELS.into_iter().zip(&mut trims) {
        *trim = run.trim(channel)?;
    }
    let motion = motion(run)?;
    let scale = if matches!(state, "alpha" | "beta") { 1.0 / datum.airspeed } else { 1.0 };
    let trim = of_air_data(run, trims);
    let at_trim = scale * full(state, trim);
    let steps = motion.into_iter().map(|now| {
        let linear: f64 = variables.iter().map(|name| datum.known(state, name) * moved(name, now, trim)).sum();
        scale * full(state, now) - at_trim - linear
    });
    Ok(steps.collect())
}

/// (2).
fn full(state: &str, [u, v, w, p, q, r, phi, theta]: [f64; 8]) -> f64 {
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

/// Deviation of a variable that has a known coefficient somewhere.
fn moved(name: &str, now: [f64; 8], trim: [f64; 8]) -> f64 {
    let place = match name {
        "p" => 3,
        "q" => 4,
        "r" => 5,
        "phi" => 6,
        "theta" => 7,
        _ => return 0.0,
    };
    now[place] - trim[place]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::run::RunGeometry;

    /// One row in trim, then one away from it.
    fn run(away: [f64; 8]) -> Columns {
        let trim = [50.0, 0.02, 0.0, 0.0, 0.0, 0.0, 0.01, 0.03];
        let columns = CHANNELS.iter().zip(trim.iter().zip(away)).map(|(name, (at, by))| ((*name).to_owned(), vec![*at, at + by]));
        Columns::new("a".to_owned(), RunGeometry::DEFAULT, vec![0.0, 0.1], columns.collect(), 0.05).unwrap()
    }

    #[test]
    fn what_is_left_is_of_second_order_where_the_linear_part_is_whole() {
        let names: Vec<String> = ["u", "v", "w", "p", "q", "r", "phi", "theta"].map(str::to_owned).into();
        let variables: Vec<&String> = names.iter().collect();
        let datum = Datum { airspeed: 50.0, alpha: 0.02, theta: 0.03, phi: 0.01 };
        for state in ["u", "v", "w", "phi", "theta"] {
            let size = |by: f64| {
                let away = [by, 0.01 * by, 0.012 * by, 0.02 * by, -0.015 * by, 0.01 * by, 0.04 * by, -0.03 * by];
                beyond(&run(away), &datum, state, &variables).unwrap()[1]
            };
            let (one, half) = (size(1.0), size(0.5));
            // The known coefficients have phi0 and theta0 to first order in each other only.
            assert!((one - 4.0 * half).abs() < 0.1 * one.abs().max(half.abs()) + 2e-4, "{state}: {one}, {half}");
        }
    }

    #[test]
    fn the_product_of_sideslip_and_yaw_rate_is_in_u() {
        let datum = Datum { airspeed: 50.0, alpha: 0.02, theta: 0.03, phi: 0.01 };
        let left = beyond(&run([0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0]), &datum, "u", &[]).unwrap()[1];
        assert!((left - 50.0 * f64::sin(0.1) * 0.2).abs() < 1e-12, "{left}");
    }
}
