//! The Dutch roll of the whole aircraft: what is left of the lateral subsystem's once it is coupled to u, w and q.
//!
//! Consumes the derivatives of all six equations with respect to the six velocities and rates; produces the complex pair of the
//! 8 x 8 matrix that is nearest to the lateral subsystem's Dutch roll. States u w q theta v p phi r, about the trim:
//!     u' = X.x - w0 q + v0 r - g cos(theta0) theta
//!     w' = Z.x + u0 q - v0 p - g sin(theta0) cos(phi0) theta - g cos(theta0) sin(phi0) phi
//!     v' = Y.x + w0 p - u0 r - g sin(theta0) sin(phi0) theta + g cos(theta0) cos(phi0) phi              (1)
//!     q' = M.x,  p' = L.x,  r' = N.x
//!     theta' = cos(phi0) q - sin(phi0) r,  phi' = p + tan(theta0) (sin(phi0) q + cos(phi0) r)
//! which is (1) to (6) of the paper linearised. Standard errors as in `lateral`, equations (3) and (4) there, from the covariance
//! within each equation and between the lateral ones; that between the others is left out, for they share no regressor that
//! the Dutch roll leans on heavily. A derivative that is in no equation counts as zero: selection found it to bring nothing.
//! Numerics: velocities count in tens of m/s, so that the entries of A are of one size when its adjugate is formed.

use super::lateral::{d_omega_zeta, nearest};
use super::record::Oscillation;
use crate::flight::derivative::AXES;
use crate::flight::unit::STANDARD_GRAVITY as G0;
use crate::num::eigen::{eigenvalues_8, sensitivity};
use crate::realtime::regression::record::{LATERAL, LateralDerivatives, MOTION, SixAxisDerivatives};
use nalgebra::Complex;

/// Row of each axis, in the order of `Axis::ALL`: X Y Z L M N.
const ROWS: [usize; AXES] = [0, 4, 1, 5, 2, 7];
/// Column of each variable of the motion: u v w p q r.
const COLUMNS: [usize; MOTION] = [0, 4, 1, 5, 2, 7];
/// One of each state in its own unit is so many of the unit that the computation uses.
const SCALE: [f64; 8] = [0.1, 0.1, 1.0, 1.0, 0.1, 1.0, 1.0, 1.0];

/// (1).
pub fn matrix(six_axis: &SixAxisDerivatives, lateral: &LateralDerivatives) -> [[f64; 8]; 8] {
    let (sin_phi, cos_phi) = libm::sincos(lateral.phi0);
    let (sin_theta, cos_theta) = libm::sincos(lateral.theta0);
    let tan_theta = sin_theta / cos_theta;
    let mut a = [[0.0; 8]; 8];
    for (values, row) in six_axis.values.iter().zip(ROWS) {
        for (value, column) in values.iter().zip(COLUMNS) {
            a[row][column] = *value;
        }
    }
    a[0][2] -= lateral.w0;
    a[0][7] += six_axis.v0;
    a[1][5] -= six_axis.v0;
    a[0][3] = -G0 * cos_theta;
    a[1][2] += lateral.u0;
    a[1][3] = -G0 * sin_theta * cos_phi;
    a[1][6] = -G0 * cos_theta * sin_phi;
    a[4][5] += lateral.w0;
    a[4][7] -= lateral.u0;
    a[4][3] = -G0 * sin_theta * sin_phi;
    a[4][6] = G0 * cos_theta * cos_phi;
    a[3][2] = cos_phi;
    a[3][7] = -sin_phi;
    a[6][5] = 1.0;
    a[6][2] = sin_phi * tan_theta;
    a[6][7] = cos_phi * tan_theta;
    a
}

/// The Dutch roll of the whole aircraft; `None` where it cannot be computed or no pair is left.
pub fn dutch_roll(six_axis: &SixAxisDerivatives, lateral: &LateralDerivatives, alone: &Oscillation) -> Option<Oscillation> {
    let a = matrix(six_axis, lateral);
    let scaled: [[f64; 8]; 8] = core::array::from_fn(|i| core::array::from_fn(|j| a[i][j] * SCALE[i] / SCALE[j]));
    let root = nearest(&eigenvalues_8(&scaled)?, Complex::new(alone.real, alone.imag))?;
    let omega = libm::hypot(root.re, root.im);
    let zeta = -root.re / omega;
    let (mut std_omega, mut std_zeta) = (f64::NAN, f64::NAN);
    if let Some(slope) = sensitivity(&scaled, root) {
        let by = |i: usize, j: usize| d_omega_zeta(root, slope[i][j] * (SCALE[i] / SCALE[j]));
        for (part, std) in [&mut std_omega, &mut std_zeta].into_iter().enumerate() {
            let gradient = ROWS.map(|row| COLUMNS.map(|column| by(row, column)[part]));
            let u0 = by(1, 2)[part] - by(4, 7)[part];
            let w0 = by(4, 5)[part] - by(0, 2)[part];
            let v0 = by(0, 7)[part] - by(1, 5)[part];
            let trim = [(u0, lateral.trim_std[0]), (w0, lateral.trim_std[1]), (v0, six_axis.v0_std)];
            *std = libm::sqrt(variance(&gradient, trim, six_axis, lateral));
        }
    }
    Some(Oscillation { real: root.re, imag: root.im, omega, zeta, std_omega, std_zeta })
}

/// g' Sigma g.
fn variance(
    gradient: &[[f64; MOTION]; AXES],
    trim: [(f64, f64); 3],
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
            // Within one equation it is in the sum already.
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
        let pair = dutch_roll(&six_axis, &lateral, &alone).unwrap();
        let expected = eigenmodes(&theirs).unwrap().dutch_roll.unwrap();
        assert!((pair.real - expected.re).abs() < 1e-10 && (pair.imag - expected.im).abs() < 1e-10, "{pair:?} {expected:?}");
    }

    #[test]
    fn standard_errors_are_those_of_a_slow_way() {
        // Central differences of omega and zeta in every derivative and in the trim, then g' Sigma g over all pairs.
        let (six_axis, lateral, _) = puma();
        let alone = lateral::modes(0.0, Status::Converged, &lateral).unwrap().dutch_roll.unwrap();
        let pair = dutch_roll(&six_axis, &lateral, &alone).unwrap();
        let slope = |change: &dyn Fn(&mut SixAxisDerivatives, &mut LateralDerivatives, f64)| {
            let at = |step: f64| {
                let (mut six_axis, mut lateral) = (six_axis.clone(), lateral);
                change(&mut six_axis, &mut lateral, step);
                let pair = dutch_roll(&six_axis, &lateral, &alone).unwrap();
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
            sum += (trim[0][k] * 0.2).powi(2) + (trim[1][k] * 0.1).powi(2) + (trim[2][k] * 0.15).powi(2);
            assert!((found / sum.sqrt() - 1.0).abs() < 1e-5, "{found} {}", sum.sqrt());
        }
    }
}
