//! Which eigenvalues of a linearised aircraft are its Dutch roll, roll and spiral.
//!
//! Consumes A [8 x 8] in the order of `linear::STATES`; produces every eigenvalue (1/s), three of them named. Those of the
//! lateral subsystem (v p phi r) serve as a guide: the Dutch roll is the oscillation, the roll mode the fastest and the
//! spiral the slowest real mode of it, and each name goes to the nearest eigenvalue of the whole matrix.
//! Returns no name where the subsystem has no such mode (two oscillations, or none).

use crate::num::eigen::{eigenvalues_4, eigenvalues_8};
use nalgebra::{Complex, SMatrix};

/// Eigenvalues with names, 1/s.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenmodes {
    /// The Dutch roll, imaginary part positive.
    pub dutch_roll: Option<Complex<f64>>,
    /// The roll mode.
    pub roll: Option<f64>,
    /// The spiral mode.
    pub spiral: Option<f64>,
    /// The others; of a pair the one with positive imaginary part.
    pub others: Vec<Complex<f64>>,
}

/// Eigenvalues of A with names; `None` where they cannot be computed.
pub fn eigenmodes(a: &SMatrix<f64, 8, 8>) -> Option<Eigenmodes> {
    const LATERAL: [usize; 4] = [4, 5, 6, 7];
    let entries = core::array::from_fn(|row| core::array::from_fn(|column| a[(row, column)]));
    let whole = upper_half(&eigenvalues_8(&entries)?);
    let lateral = LATERAL.map(|row| LATERAL.map(|column| a[(row, column)]));
    let guides = upper_half(&eigenvalues_4(&lateral)?);
    let (oscillations, reals): (Vec<_>, Vec<_>) = guides.into_iter().partition(|mode| mode.im > 0.0);
    let mut others = whole;
    let mut take = |guide: Option<Complex<f64>>, oscillates: bool| -> Option<Complex<f64>> {
        let guide = guide?;
        let candidates = others.iter().enumerate().filter(|(_, mode)| (mode.im > 0.0) == oscillates);
        let nearest = candidates.min_by(|(_, a), (_, b)| (*a - guide).norm_sqr().total_cmp(&(*b - guide).norm_sqr()));
        let place = nearest.map(|(place, _)| place)?;
        Some(others.remove(place))
    };
    let dutch_roll = take(if oscillations.len() == 1 { oscillations.first().copied() } else { None }, true);
    let by_speed = |a: &&Complex<f64>, b: &&Complex<f64>| a.re.abs().total_cmp(&b.re.abs());
    let two = reals.len() == 2;
    let roll = take(reals.iter().max_by(by_speed).copied().filter(|_| two), false);
    let spiral = take(reals.iter().min_by(by_speed).copied().filter(|_| two), false);
    Some(Eigenmodes { dutch_roll, roll: roll.map(|mode| mode.re), spiral: spiral.map(|mode| mode.re), others })
}

/// Reals and the upper one of each pair.
fn upper_half(modes: &[Complex<f64>]) -> Vec<Complex<f64>> {
    modes.iter().copied().filter(|mode| mode.im >= 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uncoupled_aircraft_has_its_modes_by_name() {
        // Longitudinal: diagonal -1, -2, -3, -4. Lateral: blocks with eigenvalues -0.1 +- 1.5i, -2 and -0.05.
        let mut a = SMatrix::<f64, 8, 8>::zeros();
        for (place, value) in [-1.0, -2.0, -3.0, -4.0].into_iter().enumerate() {
            a[(place, place)] = value;
        }
        a[(4, 4)] = -0.1;
        a[(7, 7)] = -0.1;
        a[(4, 7)] = -1.5;
        a[(7, 4)] = 1.5;
        a[(5, 5)] = -2.0;
        a[(6, 6)] = -0.05;
        let modes = eigenmodes(&a).unwrap();
        assert!((modes.dutch_roll.unwrap() - Complex::new(-0.1, 1.5)).norm_sqr() < 1e-24);
        assert!((modes.roll.unwrap() + 2.0).abs() < 1e-12 && (modes.spiral.unwrap() + 0.05).abs() < 1e-12);
        assert_eq!(modes.others.len(), 4);
        a[(0, 0)] = f64::NAN;
        assert_eq!(eigenmodes(&a), None);
    }
}
