//! The best subset of each size, exactly, by branch and bound.
//!
//! Consumes a [`Design`] and up to 20 candidates; produces for every number of terms the subset with the smallest sum of
//! squared residuals. [`CandidateRole::Kept`] terms are in every subset.
//! With [X y] = Q R, R upper triangular [n+1 x n+1], the sum of squares of the first j columns is
//!     SSE_j = R_yy^2 + sum of R_iy^2 over i = j+1 .. n                                              (1)
//! so one triangle evaluates n subsets. Dropping column i and restoring the triangle by plane rotations evaluates those that
//! follow; dropped in order from i on, every subset is visited once. SSE never rises with a further term, so a branch whose
//! triangle fits no better than the best known subset of its smallest size is cut.                        (2)
//! Columns are ordered by the SSE that their removal costs, largest first, which makes (2) cut early.
//! Source: G. M. Furnival and R. W. Wilson, Technometrics 16(4), 1974; the form with triangles after C. Gatu and
//! E. J. Kontoghiorghes, J. Comput. Graph. Stat. 15(1), 2006.
//! Numerics: R by Cholesky of the scaled sums; candidates that are combinations of others (pivot below `PIVOT_MIN`) are
//! in no subset.

use super::design::{CandidateRole, Design};
use super::fit::{PIVOT_MIN, Working};

/// Largest number of candidates.
pub const CANDIDATES_MAX: usize = 20;

/// The best subset of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Subset {
    /// Places of its terms, in their order among the candidates.
    pub places: Vec<usize>,
    /// R2 about the mean: Padfield et al. 1987, (20).
    pub r_squared: f64,
    /// Predicted squared error, fit (5), over var(y).
    pub pse: f64,
}

/// Result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct BestSubsets {
    /// By number of terms, from the kept ones alone to all.
    pub subsets: Vec<Subset>,
    /// Places of candidates that are constant or linear combinations of others, in no subset.
    pub dependent: Vec<usize>,
    /// Triangles evaluated, at most 2^(n-1) for n candidates.
    pub triangles: usize,
}

/// Too many candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected at most {CANDIDATES_MAX} candidates that have to earn their place, found {found} in all")]
pub struct TooMany {
    /// Number of candidates.
    pub found: usize,
}

impl BestSubsets {
    /// The subset with the smallest predicted squared error.
    pub fn smallest_pse(&self) -> Option<&Subset> {
        self.subsets.iter().min_by(|a, b| a.pse.total_cmp(&b.pse))
    }
}

/// Searches all subsets.
///
/// # Errors
/// [`TooMany`] above [`CANDIDATES_MAX`].
pub fn best_subsets(design: &Design) -> Result<BestSubsets, TooMany> {
    let mut working = Working::new(design);
    let role = |place: usize| design.candidates()[place].role;
    let kept = (0..design.names().len()).filter(|&place| role(place) == CandidateRole::Kept);
    let others = (0..design.names().len()).filter(|&place| role(place) != CandidateRole::Kept);
    let (mut fixed, mut open, mut dependent) = (Vec::new(), Vec::new(), Vec::new());
    for (place, is_fixed) in kept.map(|place| (place, true)).chain(others.map(|place| (place, false))) {
        let list = match (working.enter(place), is_fixed) {
            (false, _) => &mut dependent,
            (true, true) => &mut fixed,
            (true, false) => &mut open,
        };
        list.push(place);
    }
    if open.len() > CANDIDATES_MAX || fixed.len() + open.len() >= WIDTH {
        return Err(TooMany { found: fixed.len() + open.len() });
    }
    // Ordered by the SSE that their removal from the whole costs; as given where near dependencies make a reordered triangle
    // singular.
    let as_they_came: Vec<usize> = fixed.iter().chain(&open).copied().collect();
    open.sort_by(|&a, &b| working.loss(b).total_cmp(&working.loss(a)));
    let by_loss: Vec<usize> = fixed.iter().chain(&open).copied().collect();
    let mut search = Search { best: vec![(f64::INFINITY, 0); fixed.len() + open.len() + 1], fixed: fixed.len(), triangles: 0 };
    let (order, triangle) = match Triangle::of(design, &by_loss) {
        Some(triangle) => (by_loss, Some(triangle)),
        None => (as_they_came.clone(), Triangle::of(design, &as_they_came)),
    };
    if let Some(triangle) = triangle {
        search.branch(&triangle, fixed.len());
    }
    let m = design.samples();
    let subset = |(size, &(squares, members)): (usize, &(f64, u64))| {
        let mut places: Vec<usize> =
            order.iter().enumerate().filter(|(bit, _)| members >> bit & 1 == 1).map(|(_, &place)| place).collect();
        places.sort_unstable();
        Subset { places, r_squared: 1.0 - squares, pse: squares + design.parameters(size) / m }
    };
    let found = search.best.iter().enumerate().skip(fixed.len()).filter(|(_, (squares, _))| squares.is_finite());
    Ok(BestSubsets { subsets: found.map(subset).collect(), dependent, triangles: search.triangles })
}

/// Columns of a triangle at most: all candidates, those kept, and the response.
const WIDTH: usize = 64;

/// R of (1): columns of some candidates and the response.
#[derive(Clone)]
struct Triangle {
    /// Column after column, each as long as its place + 1.
    columns: Vec<f64>,
    bits: Vec<u8>,
}

impl Triangle {
    /// By Cholesky of the scaled sums; `None` where they are not positive.
    fn of(design: &Design, order: &[usize]) -> Option<Triangle> {
        let n = order.len();
        if n + 1 > WIDTH {
            return None;
        }
        let all: Vec<usize> = order.iter().copied().chain([design.names().len()]).collect();
        let mut columns: Vec<f64> = Vec::with_capacity((n + 1) * (n + 2) / 2);
        for (j, &b) in all.iter().enumerate() {
            let start = j * (j + 1) / 2;
            for (i, &a) in all.iter().enumerate().take(j + 1) {
                let of_i = i * (i + 1) / 2;
                let done: f64 = (0..i).map(|k| columns[of_i + k] * columns[start + k]).sum();
                let rest = design.correlation(a, b) - done;
                if i < j {
                    columns.push(rest / columns[of_i + i]);
                } else if j == n {
                    // The response may be a linear combination of the candidates: its pivot is then zero.
                    columns.push(libm::sqrt(rest.max(0.0)));
                } else if rest > 0.1 * PIVOT_MIN {
                    columns.push(libm::sqrt(rest));
                } else {
                    return None;
                }
            }
        }
        Some(Triangle { columns, bits: (0..n).map(|bit| bit as u8).collect() })
    }

    fn len(&self) -> usize {
        self.bits.len()
    }

    /// The triangle without column i.
    fn without(&self, i: usize) -> Triangle {
        let n = self.len();
        let mut columns = Vec::with_capacity(n * (n + 1) / 2);
        columns.extend_from_slice(&self.columns[..i * (i + 1) / 2]);
        // Columns after i have one subdiagonal entry: rotations of rows (k, k+1) annihilate them and apply to the columns after.
        let mut turns = [(1.0, 0.0); WIDTH];
        for j in i + 1..=n {
            let start = j * (j + 1) / 2;
            let own = &self.columns[start..=start + j];
            columns.extend_from_slice(&own[..i]);
            let mut carried = own[i];
            for k in i..j - 1 {
                let (cosine, sine) = turns[k];
                columns.push(cosine * carried + sine * own[k + 1]);
                carried = cosine * own[k + 1] - sine * carried;
            }
            let length = libm::sqrt(carried * carried + own[j] * own[j]);
            turns[j - 1] = if length > 0.0 { (carried / length, own[j] / length) } else { (1.0, 0.0) };
            columns.push(length);
        }
        let bits = self.bits.iter().enumerate().filter(|(place, _)| *place != i).map(|(_, &bit)| bit).collect();
        Triangle { columns, bits }
    }

    fn response(&self) -> &[f64] {
        let n = self.len();
        &self.columns[n * (n + 1) / 2..]
    }
}

struct Search {
    /// Smallest sum of squares and its members' bits, by number of terms.
    best: Vec<(f64, u64)>,
    fixed: usize,
    triangles: usize,
}

impl Search {
    /// All subsets that have the first `first` columns and lack some of the others.
    fn branch(&mut self, triangle: &Triangle, first: usize) {
        self.triangles += 1;
        let n = triangle.len();
        // (1), from all columns down to the first ones.
        let response = triangle.response();
        let mut squares = response[n] * response[n];
        let whole = squares;
        let mut members = triangle.bits.iter().fold(0_u64, |set, bit| set | 1 << bit);
        for j in (first..=n).rev() {
            if squares < self.best[j].0 {
                self.best[j] = (squares, members);
            }
            if j > 0 {
                squares += response[j - 1] * response[j - 1];
                members &= !(1 << triangle.bits[j - 1]);
            }
        }
        for i in first..n.saturating_sub(1) {
            // (2): subsets of the branch have at least the first i columns, and one of them at least.
            if whole >= self.best[i.max(1).max(self.fixed)].0 {
                return;
            }
            self.branch(&triangle.without(i), i);
        }
    }
}
