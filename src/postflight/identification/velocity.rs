//! Velocity over time: integrated accelerometers for its fast part, air data for its slow part (complementary).
//!
//! Consumes a run with air data, rates, attitude and specific force; produces u v w [m/s, body] at the centre of mass at every
//! row. With the accelerometers at x y z, the integrals
//!     U = int (ax - g sin(theta) + r v - q w) dt - (z q - y r)
//!     V = int (ay + g cos(theta) sin(phi) + p w - r u) dt - (x r - z p)                                (1)
//!     W = int (az + g cos(theta) cos(phi) + q u - p v) dt - (y p - x q)
//! are the velocity but for the initial value and slow errors of bias and attitude, which the air data correct:
//!     u = U + sum_k c_k T_k(t),  c by least squares of (u measured - U), T_k Chebyshev's, one more every 8 s   (2)
//! Air data alone are noisy (0.3 m/s, which times a yaw rate acts like a gust); through (2) only their slow part enters, without
//! a vane's scale or a lag of the pneumatic lines at the frequencies of the motion.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2006, ch. 10 (flight path reconstruction); (2) is ours.
//! Returns the air data's velocity where the accelerometers were not recorded, [`ColumnError`] where another channel is missing.

use super::columns::{ColumnError, Columns};
use crate::dynamics::sensors::{cross, flow_angles_at_foot, velocity_of_air_data};
use crate::flight::unit::STANDARD_GRAVITY as G0;
use nalgebra::{DMatrix, DVector};

/// Channels of the motion: air data, rates, attitude.
pub(crate) const CHANNELS: [&str; 8] = ["tas", "alpha", "beta", "p", "q", "r", "phi", "theta"];

/// The accelerometers' channels.
const FORCES: [&str; 3] = ["ax", "ay", "az"];

/// Record length for one more term of (2), s; least and largest number of terms.
const TERM_S: f64 = 8.0;
const TERMS: (usize, usize) = (3, 16);

/// u v w p q r phi theta at every row.
///
/// # Errors
/// [`ColumnError`] where one of [`CHANNELS`] is missing or has a gap.
pub(crate) fn motion(run: &Columns) -> Result<Vec<[f64; 8]>, ColumnError> {
    let mut whole = Vec::with_capacity(CHANNELS.len());
    for channel in CHANNELS {
        let trim = run.trim(channel)?;
        let mut values = run.lines(channel)?;
        values.iter_mut().for_each(|value| *value += trim);
        whole.push(values);
    }
    let row = |k: usize| -> [f64; 8] {
        core::array::from_fn(|i| whole.get(i).and_then(|values| values.get(k)).copied().unwrap_or(f64::NAN))
    };
    let mut motion: Vec<[f64; 8]> = (0..run.times_s.len()).map(|k| of_air_data(run, row(k))).collect();
    let forces = FORCES.map(|channel| Some((run.trim(channel).ok()?, run.lines(channel).ok()?)));
    let [Some(ax), Some(ay), Some(az)] = forces else { return Ok(motion) };
    let force = |k: usize| [&ax, &ay, &az].map(|(trim, values)| trim + values.get(k).copied().unwrap_or(f64::NAN));
    let integrated = integrals(run, &motion, force);
    for axis in 0..3 {
        let slow: Vec<f64> = motion.iter().zip(&integrated).map(|(now, own)| now[axis] - own[axis]).collect();
        let Some(slow) = slow_part(&run.times_s, &slow) else { continue };
        for ((now, own), slow) in motion.iter_mut().zip(&integrated).zip(slow) {
            now[axis] = own[axis] + slow;
        }
    }
    Ok(motion)
}

/// u v w p q r phi theta at the centre of mass, velocity by the air data.
pub(crate) fn of_air_data(run: &Columns, [tas, alpha, beta, p, q, r, phi, theta]: [f64; 8]) -> [f64; 8] {
    let [alpha, beta] = flow_angles_at_foot([alpha, beta], [p, q, r], run.geometry.vane_position_m, tas);
    let [u, v, w] = velocity_of_air_data(tas, alpha, beta);
    [u, v, w, p, q, r, phi, theta]
}

/// (1), by the trapezoidal rule.
fn integrals(run: &Columns, motion: &[[f64; 8]], force: impl Fn(usize) -> [f64; 3]) -> Vec<[f64; 3]> {
    let mut sums = [0.0; 3];
    let mut before: Option<(f64, [f64; 3])> = None;
    let mut all = Vec::with_capacity(motion.len());
    for (k, (time_s, &[u, v, w, p, q, r, phi, theta])) in run.times_s.iter().zip(motion).enumerate() {
        let [ax, ay, az] = force(k);
        let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (libm::sincos(phi), libm::sincos(theta));
        let rate = [
            ax - G0 * sin_theta + r * v - q * w,
            ay + G0 * cos_theta * sin_phi + p * w - r * u,
            az + G0 * cos_theta * cos_phi + q * u - p * v,
        ];
        if let Some((before_s, old)) = before {
            for ((sum, old), rate) in sums.iter_mut().zip(old).zip(rate) {
                *sum += 0.5 * (time_s - before_s) * (old + rate);
            }
        }
        before = Some((*time_s, rate));
        let by_arm = cross([p, q, r], run.geometry.accelerometer_position_m);
        all.push(core::array::from_fn(|axis| sums[axis] - by_arm[axis]));
    }
    all
}

/// The polynomial of (2) at every row; `None` where the least squares are singular.
fn slow_part(times_s: &[f64], values: &[f64]) -> Option<Vec<f64>> {
    let (first_s, last_s) = (times_s.first()?, times_s.last()?);
    let span_s = last_s - first_s;
    let terms = (TERMS.0 + (span_s / TERM_S) as usize).min(TERMS.1);
    if values.len() <= 2 * terms || values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let basis = |time_s: f64| {
        let x = (2.0 * (time_s - first_s) / span_s - 1.0).clamp(-1.0, 1.0);
        let angle = libm::acos(x);
        (0..terms).map(move |k| libm::cos(k as f64 * angle))
    };
    let (mut m, mut b) = (DMatrix::<f64>::zeros(terms, terms), DVector::<f64>::zeros(terms));
    for (time_s, value) in times_s.iter().zip(values) {
        let row = DVector::from_iterator(terms, basis(*time_s));
        m.ger(1.0, &row, &row, 1.0);
        b.axpy(*value, &row, 1.0);
    }
    let c = m.cholesky()?.solve(&b);
    Some(times_s.iter().map(|time_s| basis(*time_s).zip(c.iter()).map(|(basis, c)| basis * c).sum()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::run::RunGeometry;

    /// Level flight on a sinusoidal airspeed that the accelerometer sees and the air data see with steps of 0.5 m/s.
    fn run(with_force: bool) -> (Columns, Vec<f64>) {
        let times: Vec<f64> = (0..2000).map(|k| 0.01 * f64::from(k)).collect();
        let true_u: Vec<f64> = times.iter().map(|t| 50.0 + 2.0 * f64::sin(1.5 * t) + 0.1 * t).collect();
        let read = true_u.iter().enumerate().map(|(k, u)| u + if k % 2 == 0 { 0.5 } else { -0.5 }).collect();
        let zero = || vec![0.0; times.len()];
        let mut columns = vec![("tas".to_owned(), read)];
        columns.extend(["alpha", "beta", "p", "q", "r", "phi", "theta"].map(|name| (name.to_owned(), zero())));
        if with_force {
            // A bias of 0.03 m/s^2.
            columns.push(("ax".to_owned(), times.iter().map(|t| 3.0 * f64::cos(1.5 * t) + 0.13).collect()));
            columns.push(("ay".to_owned(), zero()));
            columns.push(("az".to_owned(), vec![-G0; times.len()]));
        }
        (Columns::new("a".to_owned(), RunGeometry::DEFAULT, times, columns, 1.0).unwrap(), true_u)
    }

    #[test]
    fn the_accelerometers_take_the_noise_out_of_the_airspeed() {
        let (with, truth) = run(true);
        let found = motion(&with).unwrap();
        let worst = found.iter().zip(&truth).map(|(now, u)| (now[0] - u).abs()).fold(0.0, f64::max);
        assert!(worst < 0.05, "{worst}");
        assert!(found.iter().all(|now| now[1].abs() < 1e-6 && now[2].abs() < 1e-6));
        let (without, truth) = run(false);
        assert!((motion(&without).unwrap()[3][0] - truth[3]).abs() > 0.4);
    }
}
