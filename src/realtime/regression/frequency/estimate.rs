//! Complex least squares in the band: an equation's terms estimated from transforms, with standard errors.
//!
//! Consumes the transforms X \[frequencies x terms\] and y of an equation; produces
//!     theta = D Re(X^* y),   D = \[Re X^* X\]^-1                                                       (1)
//!     cov = S D M D,   M = 1/2 Re(X^* K_- X + X^* K_+ X^conj)                                          (2)
//!     S = |y - X theta|^2/(tr K_- - tr D M)                                                           (3)
//! K_- and K_+ of `transforms` (4): over a short record, the transforms of an error that is white in the band are correlated
//! between neighbouring frequencies. Where the record is long enough to make them independent, (2) and (3)
//! are the usual s2 D with s2 = |y - X theta|^2/(n - p).
//! Source: E. A. Morelli, AIAA 99-4043, 1999, for (1); (2) is ordinary least squares under a known correlation.
//! Numerics: sums scaled to unit diagonal; a pivot below `PIVOT_MIN` refuses the terms.

use super::band::FREQUENCIES;
use super::transforms::{Spectrum, Transforms};
use crate::flight::derivative::Axis;
use crate::num::product::dot;
use crate::num::sweep::Swept;
use crate::realtime::regression::candidate::REGRESSORS;
use nalgebra::Complex;

const PIVOT_MIN: f64 = 1e-6;
/// Place of the response in the sums.
const RESPONSE: usize = REGRESSORS;
const ORDER: usize = REGRESSORS + 1;

/// What all equations share at one time.
#[derive(Clone, Debug)]
pub struct Shared {
    /// Re X^* X by place in z.
    gram: [[f64; REGRESSORS]; REGRESSORS],
    /// M of (2).
    middle: [[f64; REGRESSORS]; REGRESSORS],
    /// tr K_-.
    trace: f64,
}

/// One equation's terms from the band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Estimates by place in z; zero where a term is not in.
    pub theta: [f64; REGRESSORS],
    /// Their standard errors.
    pub std: [f64; REGRESSORS],
}

/// One equation's terms with everything that is told of them.
#[derive(Clone, Debug, PartialEq)]
pub struct InFull {
    /// The terms.
    pub estimate: Estimate,
    /// (2) by place in z; zero where a term is not in.
    pub cov: [[f64; REGRESSORS]; REGRESSORS],
    /// Part of the response's squares over the band that is left.
    pub unexplained: f64,
    /// Intensity S of the error, (3): its variance times the interval of the grid, were it white over all frequencies.
    pub intensity: f64,
}

fn real(a: &Spectrum, b: &Spectrum, count: usize) -> f64 {
    a[..count].iter().zip(b).map(|(a, b)| a.re * b.re + a.im * b.im).sum()
}

impl Shared {
    /// Sums over the band for those terms.
    pub fn new(transforms: &Transforms, wanted: &[bool; REGRESSORS]) -> Self {
        let count = transforms.band().count();
        let zero = [[0.0; REGRESSORS]; REGRESSORS];
        let trace = count as f64 * transforms.kept_difference(0, 0).re;
        let mut shared = Shared { gram: zero, middle: zero, trace };
        for b in (0..REGRESSORS).filter(|&b| wanted[b]) {
            let of_b = transforms.regressor(b);
            let seen = through(transforms, of_b, count);
            for a in (0..=b).filter(|&a| wanted[a]) {
                let of_a = transforms.regressor(a);
                shared.gram[a][b] = real(of_a, of_b, count);
                shared.middle[a][b] = 0.5 * real(of_a, &seen, count);
                shared.gram[b][a] = shared.gram[a][b];
                shared.middle[b][a] = shared.middle[a][b];
            }
        }
        shared
    }

    /// The equation of that axis with those terms; `None` where the band does not tell them apart, or has too little.
    pub fn fit(&self, transforms: &Transforms, axis: Axis, order: &[usize]) -> Option<Estimate> {
        let solved = self.solved(transforms, axis, order)?;
        let mut estimate = Estimate { theta: solved.theta, std: [0.0; REGRESSORS] };
        for &i in order {
            estimate.std[i] = libm::sqrt(self.covariance(&solved, order, i, i).max(0.0));
        }
        let has_numbers = order.iter().all(|&i| estimate.theta[i].is_finite() && estimate.std[i].is_finite());
        has_numbers.then_some(estimate)
    }

    /// The same with the covariance and how much of the response is left: what is said of a record after the flight.
    pub fn fit_in_full(&self, transforms: &Transforms, axis: Axis, order: &[usize]) -> Option<InFull> {
        let estimate = self.fit(transforms, axis, order)?;
        let solved = self.solved(transforms, axis, order)?;
        let mut cov = [[0.0; REGRESSORS]; REGRESSORS];
        for &i in order {
            for &j in order {
                cov[i][j] = self.covariance(&solved, order, i, j);
            }
        }
        Some(InFull { estimate, cov, unexplained: solved.unexplained, intensity: solved.intensity })
    }

    /// Re X^* X by place in z.
    pub fn gram(&self) -> &[[f64; REGRESSORS]; REGRESSORS] {
        &self.gram
    }

    /// Entry of (2).
    fn covariance(&self, solved: &Solved, order: &[usize], i: usize, j: usize) -> f64 {
        let through: f64 = order.iter().map(|&k| solved.dispersion[i][k] * dot(&self.middle[k], &solved.dispersion[j])).sum();
        solved.intensity * through
    }

    /// (1) and (3).
    fn solved(&self, transforms: &Transforms, axis: Axis, order: &[usize]) -> Option<Solved> {
        let count = transforms.band().count();
        let response = transforms.response(axis);
        let mut scale = [0.0; ORDER];
        for &place in order {
            scale[place] = 1.0 / libm::sqrt(self.gram[place][place]);
        }
        scale[RESPONSE] = 1.0 / libm::sqrt(real(&response, &response, count));
        let mut sums = [[0.0; ORDER]; ORDER];
        sums[RESPONSE][RESPONSE] = 1.0;
        for &i in order {
            for &j in order {
                sums[i][j] = self.gram[i][j] * scale[i] * scale[j];
            }
            sums[i][RESPONSE] = real(transforms.regressor(i), &response, count) * scale[i] * scale[RESPONSE];
            sums[RESPONSE][i] = sums[i][RESPONSE];
        }
        let mut swept = Swept::new(sums);
        for &place in order {
            if !swept.enter(place, PIVOT_MIN) {
                return None;
            }
        }
        let zero = [[0.0; REGRESSORS]; REGRESSORS];
        let unexplained = swept.at(RESPONSE, RESPONSE);
        let mut solved = Solved { theta: [0.0; REGRESSORS], dispersion: zero, intensity: 0.0, unexplained };
        for &i in order {
            for &j in order {
                solved.dispersion[i][j] = -swept.at(i, j) * scale[i] * scale[j];
            }
            solved.theta[i] = swept.at(i, RESPONSE) * scale[i] / scale[RESPONSE];
        }
        let squares = unexplained / (scale[RESPONSE] * scale[RESPONSE]);
        let taken: f64 = order.iter().map(|&i| dot(&solved.dispersion[i], &self.middle[i])).sum();
        solved.intensity = squares / (self.trace - taken);
        (self.trace - taken > 0.0 && solved.intensity.is_finite()).then_some(solved)
    }
}

/// An equation as (1) and (3) leave it.
struct Solved {
    theta: [f64; REGRESSORS],
    dispersion: [[f64; REGRESSORS]; REGRESSORS],
    intensity: f64,
    unexplained: f64,
}

/// K_- X + K_+ X^conj.
fn through(transforms: &Transforms, x: &Spectrum, count: usize) -> Spectrum {
    let mut seen = [Complex::new(0.0, 0.0); FREQUENCIES];
    for (i, seen) in seen[..count].iter_mut().enumerate() {
        for (j, x) in x[..count].iter().enumerate() {
            *seen += transforms.kept_difference(i, j) * x + transforms.kept_sum(i, j) * x.conj();
        }
    }
    seen
}
