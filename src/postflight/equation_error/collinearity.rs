//! Collinearity: terms that these data do not separate, and the input that would.
//!
//! Consumes a [`Design`] and places of candidates; produces, from columns about their means scaled to unit length, with singular
//! values s_k and right singular vectors V,
//!     eta_k = s_max/s_k                                                condition indexes             (1)
//!     pi_kj = (V_jk^2/s_k^2)/sum_k V_jk^2/s_k^2                        variance proportions          (2)
//! and a group of terms for every eta_k >= 30 with two or more pi_kj >= 0.5: the estimates of a group are nearly exchangeable.
//! Nearly equal indexes share a dependency, so their proportions are added.
//! Columns are about the mean because the bias is always included and its own standard error is not of interest: the indexes are
//! those that inflate the standard errors of the slopes, whatever the trim.
//! Source: D. A. Belsley, E. Kuh and R. E. Welsch, Regression Diagnostics, 1980, ch. 3.

use super::design::Design;
use super::expression::Expression;
use super::separation::input_that_splits;
use crate::num::symmetric::diagonalise;

/// Least condition index of a dependency.
pub const STRONG: f64 = 30.0;

/// Least variance proportion of a term that takes part in it.
pub const SHARE: f64 = 0.5;

/// Ratio of indexes that compete for their dependencies.
const NEAR: f64 = 3.0;

/// Condition indexes and variance proportions of some terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Collinearity {
    /// Places of the terms among the candidates.
    pub places: Vec<usize>,
    /// (1), smallest first; infinite where terms are dependent.
    pub indexes: Vec<f64>,
    /// (2): `[k][j]` for index k and term j.
    pub proportions: Vec<Vec<f64>>,
}

/// Collinear terms.
#[derive(Clone, Debug, PartialEq)]
pub struct CollinearGroup {
    /// Condition index of the dependency.
    pub index: f64,
    /// Names of the terms, and their proportions of variance in it.
    pub terms: Vec<(String, f64)>,
    /// The input that would separate them, a sentence.
    pub split_by: String,
}

/// Largest condition index; 1 for fewer than two terms.
pub(super) fn largest_index(design: &Design, places: &[usize]) -> f64 {
    Collinearity::of(design, places).and_then(|found| found.indexes.last().copied()).unwrap_or(1.0)
}

impl Collinearity {
    /// (1) and (2) of the candidates at those places; `None` where there is none, or one of them does not vary.
    pub fn of(design: &Design, places: &[usize]) -> Option<Collinearity> {
        let order = places.len();
        if order == 0 || places.iter().any(|&place| !design.scale.get(place).is_some_and(|scale| *scale > 0.0)) {
            return None;
        }
        let mut a: Vec<f64> = places.iter().flat_map(|&i| places.iter().map(move |&j| design.correlation(i, j))).collect();
        let mut v = vec![0.0; order * order];
        if !diagonalise(&mut a, &mut v, order) {
            return None;
        }
        let mut values: Vec<(f64, usize)> = (0..order).map(|k| (a[k * order + k].max(0.0), k)).collect();
        values.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let largest = values.first().map_or(0.0, |(value, _)| *value);
        let indexes =
            values.iter().map(|(value, _)| if *value > 0.0 { libm::sqrt(largest / value) } else { f64::INFINITY }).collect();
        // Eigenvalues within rounding of zero, of either sign, count as the smallest positive one.
        let part = |j: usize, (value, k): (f64, usize)| v[j * order + k] * v[j * order + k] / value.max(f64::MIN_POSITIVE);
        let totals: Vec<f64> = (0..order).map(|j| values.iter().map(|&value| part(j, value)).sum()).collect();
        let proportions =
            values.iter().map(|&value| totals.iter().enumerate().map(|(j, total)| part(j, value) / total).collect()).collect();
        Some(Collinearity { places: places.to_vec(), indexes, proportions })
    }

    /// Groups of collinear terms, the largest index first.
    pub fn groups(&self, design: &Design) -> Vec<CollinearGroup> {
        let mut groups = Vec::new();
        let mut k = self.indexes.len();
        while k > 0 && self.indexes[k - 1] >= STRONG {
            let worst = self.indexes[k - 1];
            let near =
                (0..k).rev().take_while(|&other| self.indexes[other] >= STRONG && self.indexes[other] * NEAR >= worst).count();
            let share = |j: usize| -> f64 { self.proportions[k - near..k].iter().map(|row| row[j]).sum() };
            let inside: Vec<(usize, f64)> = self
                .places
                .iter()
                .enumerate()
                .map(|(j, &place)| (place, share(j)))
                .filter(|(_, share)| *share >= SHARE)
                .collect();
            if inside.len() >= 2 {
                let terms = inside.iter().map(|&(place, share)| (design.names()[place].clone(), share)).collect();
                let expressions: Vec<&Expression> = inside.iter().map(|&(place, _)| &design.candidates()[place].term).collect();
                groups.push(CollinearGroup { index: worst, terms, split_by: input_that_splits(&expressions) });
            }
            k -= near.max(1);
        }
        groups
    }
}
