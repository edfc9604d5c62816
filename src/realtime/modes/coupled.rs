//! The Dutch roll of the whole aircraft: the lateral subsystem coupled to u, w and q.
//!
//! Consumes the derivatives of all six equations with respect to the six velocities and rates; produces the complex pair of the
//! 8 x 8 matrix that is nearest to the lateral subsystem's Dutch roll: A of (5) of `linear`, states u w q theta v p phi r, which
//! is (1) to (6) of Padfield et al. 1987, linearised. Standard errors as in `lateral`, equations (3) and (4) there, from
//! the covariance within each equation and between the lateral ones; that between the others is neglected, for they share no
//! regressor to which the Dutch roll is sensitive. A derivative that is in no equation counts as zero: it was not significant.
//! Numerics: velocities in tens of m/s, so that the entries of A are of similar size in its adjugate.

use super::lateral::{by_pitch, d_omega_zeta, nearest};
use super::record::OscillatoryMode;
use crate::dynamics::linear::{MOTION_PLACES, kinematic_entries};
use crate::flight::derivative::AXES;
use crate::num::eigen::{eigenvalues_8, sensitivity};
use crate::realtime::regression::record::{LATERAL, LateralDerivatives, MOTION, SixAxisDerivatives};
use nalgebra::Complex;

/// Scale of each state: its unit in those of the computation.
const SCALE: [f64; 8] = [0.1, 0.1, 1.0, 1.0, 0.1, 1.0, 1.0, 1.0];

/// A of (5) of `linear`.
pub fn matrix(six_axis: &SixAxisDerivatives, lateral: &LateralDerivatives) -> [[f64; 8]; 8] {
    let mut a = [[0.0; 8]; 8];
    for (values, row) in six_axis.values.iter().zip(MOTION_PLACES) {
        for (value, column) in values.iter().zip(MOTION_PLACES) {
            a[row][column] = *value;
        }
    }
    for (row, column, value) in kinematic_entries([lateral.u0, six_axis.v0, lateral.w0], lateral.phi0, lateral.theta0) {
        a[row][column] += value;
    }
    a
}

/// The Dutch roll of the whole aircraft, with the standard error of the pitch attitude in trim, rad; `None` where
/// it cannot be computed or no pair is left.
pub fn dutch_roll(
    six_axis: &SixAxisDerivatives,
    lateral: &LateralDerivatives,
    alone: &OscillatoryMode,
    pitch_std: f64,
) -> Option<OscillatoryMode> {
    let a = matrix(six_axis, lateral);
    let scaled: [[f64; 8]; 8] = core::array::from_fn(|i| core::array::from_fn(|j| a[i][j] * SCALE[i] / SCALE[j]));
    let root = nearest(&eigenvalues_8(&scaled)?, Complex::new(alone.real, alone.imag))?;
    let omega = libm::hypot(root.re, root.im);
    let zeta = -root.re / omega;
    let (mut std_omega, mut std_zeta) = (f64::NAN, f64::NAN);
    if let Some(slope) = sensitivity(&scaled, root) {
        let by = |i: usize, j: usize| d_omega_zeta(root, slope[i][j] * (SCALE[i] / SCALE[j]));
        for (part, std) in [&mut std_omega, &mut std_zeta].into_iter().enumerate() {
            let gradient = MOTION_PLACES.map(|row| MOTION_PLACES.map(|column| by(row, column)[part]));
            let u0 = by(1, 2)[part] - by(4, 7)[part];
            let w0 = by(4, 5)[part] - by(0, 2)[part];
            let v0 = by(0, 7)[part] - by(1, 5)[part];
            let slopes = by_pitch([lateral.u0, six_axis.v0, lateral.w0], lateral.phi0, lateral.theta0);
            let pitch = slopes.into_iter().map(|(i, j, entry)| by(i, j)[part] * entry).sum();
            let trim = [(u0, lateral.trim_std[0]), (w0, lateral.trim_std[1]), (v0, six_axis.v0_std), (pitch, pitch_std)];
            *std = libm::sqrt(variance(&gradient, trim, six_axis, lateral));
        }
    }
    Some(OscillatoryMode { real: root.re, imag: root.im, omega, zeta, std_omega, std_zeta })
}

/// g' Sigma g.
fn variance(
    gradient: &[[f64; MOTION]; AXES],
    trim: [(f64, f64); 4],
    six_axis: &SixAxisDerivatives,
    lateral: &LateralDerivatives,
) -> f64 {
    let mut sum = 0.0;
    for (slopes, cov) in gradient.iter().zip(&six_axis.cov) {
        for (row, gi) in cov.iter().zip(slopes) {
            for (entry, gj) in row.iter().zip(slopes) {
                sum += gi * entry * gj;
            }
        }
    }
    let flat: [f64; LATERAL] = LateralDerivatives::NAMES.map(|(axis, variable)| gradient[axis.index()][variable.index()]);
    for (i, row) in lateral.cov.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            // Covariances within one equation are in the sum already.
            if i / 3 != j / 3 {
                sum += flat[i] * entry * flat[j];
            }
        }
    }
    for (slope, std) in trim {
        sum += slope * slope * std * std;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::naming::eigenmodes;
    use super::*;
    use crate::dynamics::linear::state_matrix;
    use crate::flight::file::model_file::ModelFile;
    use crate::realtime::modes::lateral;
    use crate::realtime::regression::record::Status;

    fn puma() -> (SixAxisDerivatives, LateralDerivatives, ModelFile) {
        let mut file = ModelFile::parse(include_str!("../../../replay/models/puma-like.toml")).unwrap();
        // In sideslip, where the coupling is stronger.
        file.linear.trim.v = 4.0;
        let mut six_axis = SixAxisDerivatives::of(&file.linear);
        let mut lateral = LateralDerivatives::of(&file.linear);
        for (axis, (values, cov)) in six_axis.values.iter().zip(&mut six_axis.cov).enumerate() {
            for (i, value) in values.iter().enumerate() {
                cov[i][i] = (0.01 * value.abs() + 1e-4 * (axis + i) as f64).powi(2);
            }
            cov[0][4] = 0.3 * (cov[0][0] * cov[4][4]).sqrt();
            cov[4][0] = cov[0][4];
        }
        for (i, (axis, variable)) in LateralDerivatives::NAMES.into_iter().enumerate() {
            lateral.cov[i][i] = six_axis.cov[axis.index()][variable.index()][variable.index()];
        }
        let between = 0.4 * (lateral.cov[3][3] * lateral.cov[6][6]).sqrt();
        (lateral.cov[3][6], lateral.cov[6][3]) = (between, between);
        lateral.trim_std = [0.2, 0.1];
        six_axis.v0_std = 0.15;
        (six_axis, lateral, file)
    }

    #[test]
    fn its_matrix_and_root_are_those_of_the_simulation() {
        let (six_axis, lateral, file) = puma();
        let (ours, theirs) = (matrix(&six_axis, &lateral), state_matrix(&file.linear));
        for i in 0..8 {
            for j in 0..8 {
                assert!((ours[i][j] - theirs[(i, j)]).abs() < 1e-12, "{i} {j}");
            }
        }
        let alone = lateral::modes(0.0, Status::Converged, &lateral).unwrap().dutch_roll.unwrap();
        let pair = dutch_roll(&six_axis, &lateral, &alone, 0.0).unwrap();
        let expected = eigenmodes(&theirs).unwrap().dutch_roll.unwrap();
        assert!((pair.real - expected.re).abs() < 1e-10 && (pair.imag - expected.im).abs() < 1e-10, "{pair:?} {expected:?}");
    }

    #[test]
    fn standard_errors_are_those_of_a_slow_way() {
        // Central differences of omega and zeta in every derivative and in the trim, then g' Sigma g over all pairs.
        let (six_axis, lateral, _) = puma();
        let alone = lateral::modes(0.0, Status::Converged, &lateral).unwrap().dutch_roll.unwrap();
        let pair = dutch_roll(&six_axis, &lateral, &alone, 0.05).unwrap();
        let slope = |change: &dyn Fn(&mut SixAxisDerivatives, &mut LateralDerivatives, f64)| {
            let at = |step: f64| {
                let (mut six_axis, mut lateral) = (six_axis.clone(), lateral);
                change(&mut six_axis, &mut lateral, step);
                let pair = dutch_roll(&six_axis, &lateral, &alone, 0.05).unwrap();
                [pair.omega, pair.zeta]
            };
            let (up, down) = (at(1e-6), at(-1e-6));
            [0, 1].map(|k| (up[k] - down[k]) / 2e-6)
        };
        let mut slopes = [[[0.0; 2]; MOTION]; AXES];
        for (a, row) in slopes.iter_mut().enumerate() {
            for (i, entry) in row.iter_mut().enumerate() {
                *entry = slope(&|six_axis, _, step| six_axis.values[a][i] += step);
            }
        }
        let trim = [
            slope(&|_, lateral, step| lateral.u0 += step),
            slope(&|_, lateral, step| lateral.w0 += step),
            slope(&|six_axis, _, step| six_axis.v0 += step),
            slope(&|_, lateral, step| lateral.theta0 += step),
        ];
        let place = |axis: usize, variable: usize| {
            LateralDerivatives::NAMES.iter().position(|(a, v)| (a.index(), v.index()) == (axis, variable))
        };
        for (k, found) in [pair.std_omega, pair.std_zeta].into_iter().enumerate() {
            let mut sum = 0.0;
            for (a, i, b, j) in (0..AXES.pow(2) * MOTION.pow(2)).map(|n| (n % 6, n / 6 % 6, n / 36 % 6, n / 216)) {
                let cov = match (place(a, i), place(b, j)) {
                    _ if a == b => six_axis.cov[a][i][j],
                    (Some(row), Some(column)) => lateral.cov[row][column],
                    _ => 0.0,
                };
                sum += slopes[a][i][k] * cov * slopes[b][j][k];
            }
            sum += (trim[0][k] * 0.2).powi(2)
                + (trim[1][k] * 0.1).powi(2)
                + (trim[2][k] * 0.15).powi(2)
                + (trim[3][k] * 0.05).powi(2);
            assert!((found / sum.sqrt() - 1.0).abs() < 1e-5, "{found} {}", sum.sqrt());
        }
    }
}
