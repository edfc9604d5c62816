//! The textbook regression: the same sums by outer products, plain recursive least squares, and stepwise by Cholesky.
//!
//!     S <- lambda S + z z',   G_l <- lambda^2 G_l + lambda^l z z_(k-l)'                              (1)
//!     K = P x/(lambda + x'P x),  theta <- theta + K (y - x'theta)',  P <- (P - K x'P)/lambda          (2)
//!     theta = (X'X)^-1 X'y by Cholesky for every subset that stepwise regression tries               (3)
//! The lags are those of ours. (2) keeps six equations of eleven regressors and knows no standard error for coloured
//! residuals, no R2 and no other subset of regressors. (3) comes in two depths: with the white partial F alone, and with
//! standard errors corrected for the colour of the residual, which decide over entry and removal.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Signals, regressors first.
pub(crate) const N: usize = 17;
/// Regressors, the bias at 0.
pub(crate) const P: usize = 11;
const RESPONSES: usize = N - P;
const LAGS: usize = 16;

type Square = SMatrix<f64, N, N>;
type Signals = SVector<f64, N>;

/// (1).
#[derive(Clone)]
pub(crate) struct Sums {
    s: Square,
    lagged: Vec<Square>,
    recent: [Signals; LAGS],
    head: usize,
    weight: f64,
    weight2: f64,
}

impl Sums {
    /// Nothing yet.
    pub(crate) fn new() -> Self {
        Sums {
            s: Square::zeros(),
            lagged: vec![Square::zeros(); LAGS + 1],
            recent: [Signals::zeros(); LAGS],
            head: 0,
            weight: 0.0,
            weight2: 0.0,
        }
    }

    /// One vector.
    pub(crate) fn add(&mut self, z: &Signals, lambda: f64) {
        self.s.ger(1.0, z, z, lambda);
        self.lagged[0].ger(1.0, z, z, lambda * lambda);
        let mut forgotten = 1.0;
        for l in 1..=LAGS {
            forgotten *= lambda;
            let past = &self.recent[(self.head + LAGS - l) % LAGS];
            self.lagged[l].ger(forgotten, z, past, lambda * lambda);
        }
        self.recent[self.head] = *z;
        self.head = (self.head + 1) % LAGS;
        self.weight = lambda * self.weight + 1.0;
        self.weight2 = lambda * lambda * self.weight2 + 1.0;
    }

    /// S and G_l entry by entry against arrays; the largest difference relative to the largest entry.
    pub(crate) fn apart(&self, sums: &[[f64; N]; N], lagged: impl Fn(usize) -> [[f64; N]; N]) -> f64 {
        let mut apart = difference(&self.s, sums);
        for (l, g) in self.lagged.iter().enumerate() {
            apart = apart.max(difference(g, &lagged(l)));
        }
        apart
    }

    fn samples(&self) -> f64 {
        self.weight * self.weight / self.weight2
    }
}

fn difference(ours: &Square, theirs: &[[f64; N]; N]) -> f64 {
    let theirs = Square::from_fn(|i, j| theirs[i][j]);
    (ours - theirs).abs().max() / theirs.abs().max()
}

/// (2): six equations with the same regressors.
#[derive(Clone)]
pub(crate) struct LeastSquares {
    p: SMatrix<f64, P, P>,
    theta: SMatrix<f64, P, RESPONSES>,
}

impl LeastSquares {
    /// Nothing known.
    pub(crate) fn new() -> Self {
        LeastSquares { p: SMatrix::identity() * 1e6, theta: SMatrix::zeros() }
    }

    /// One vector.
    pub(crate) fn add(&mut self, z: &Signals, lambda: f64) {
        let x = z.fixed_rows::<P>(0).into_owned();
        let y = z.fixed_rows::<RESPONSES>(P).into_owned();
        let px = self.p * x;
        let k = px / (lambda + x.dot(&px));
        let residual = y.transpose() - x.transpose() * self.theta;
        self.theta += k * residual;
        self.p = (self.p - k * px.transpose()) / lambda;
    }

    /// Estimate.
    pub(crate) fn theta(&self, regressor: usize, response: usize) -> f64 {
        self.theta[(regressor, response)]
    }
}

/// A fitted subset.
struct Subset {
    terms: Vec<usize>,
    theta: DVector<f64>,
    inverse: DMatrix<f64>,
    squares: f64,
}

/// A fitted equation: terms in the order of entry, estimates, standard errors.
pub(crate) struct Equation {
    /// Places of the terms.
    pub(crate) terms: Vec<usize>,
    /// Estimates.
    pub(crate) theta: Vec<f64>,
    /// Standard errors: corrected for colour, or white.
    pub(crate) std: Vec<f64>,
}

/// Which standard errors decide.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Depth {
    /// White residuals: what most programs do.
    White,
    /// Corrected for the colour of the residual.
    Coloured,
}

fn solve(sums: &Sums, terms: Vec<usize>, response: usize) -> Option<Subset> {
    let n = terms.len();
    let xx = DMatrix::from_fn(n, n, |i, j| sums.s[(terms[i], terms[j])]);
    let xy = DVector::from_fn(n, |i, _| sums.s[(terms[i], response)]);
    let cholesky = xx.cholesky()?;
    let theta = cholesky.solve(&xy);
    let squares = sums.s[(response, response)] - theta.dot(&xy);
    Some(Subset { terms, theta, inverse: cholesky.inverse(), squares })
}

/// Theta and sum of squares only, for a trial.
fn trial(sums: &Sums, terms: &[usize], response: usize) -> Option<f64> {
    let n = terms.len();
    let xx = DMatrix::from_fn(n, n, |i, j| sums.s[(terms[i], terms[j])]);
    let xy = DVector::from_fn(n, |i, _| sums.s[(terms[i], response)]);
    let theta = xx.cholesky()?.solve(&xy);
    Some(sums.s[(response, response)] - theta.dot(&xy))
}

impl Subset {
    fn white_var(&self, samples: f64) -> f64 {
        self.squares / (samples - self.terms.len() as f64)
    }

    /// Covariance of the estimates corrected for colour, with tapered lags.
    fn coloured(&self, sums: &Sums, response: usize) -> DMatrix<f64> {
        let n = self.terms.len();
        let mut e = Signals::zeros();
        e[response] = 1.0;
        for (&term, theta) in self.terms.iter().zip(self.theta.iter()) {
            e[term] = -theta;
        }
        let samples = sums.samples();
        let scale = samples / (samples - n as f64) / sums.weight2;
        let mut middle = DMatrix::zeros(n, n);
        for (l, g) in sums.lagged.iter().enumerate() {
            let r = scale * e.dot(&(g * e)) * (1.0 - l as f64 / (LAGS + 1) as f64);
            let picked = DMatrix::from_fn(n, n, |i, j| g[(self.terms[i], self.terms[j])]);
            if l == 0 {
                middle += picked * r;
            } else {
                middle += (&picked + picked.transpose()) * r;
            }
        }
        &self.inverse * middle * &self.inverse
    }

    fn variances(&self, sums: &Sums, response: usize, depth: Depth) -> Vec<f64> {
        match depth {
            Depth::White => self.inverse.diagonal().iter().map(|d| d * self.white_var(sums.samples())).collect(),
            Depth::Coloured => self.coloured(sums, response).diagonal().iter().copied().collect(),
        }
    }
}

/// The candidate whose entry lowers the sum of squares most, with its white partial F.
fn best(sums: &Sums, current: &Subset, response: usize, open: &[usize]) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for &candidate in open {
        let mut terms = current.terms.clone();
        terms.push(candidate);
        let Some(squares) = trial(sums, &terms, response) else { continue };
        let f = (current.squares - squares) / squares * (sums.samples() - terms.len() as f64);
        if best.is_none_or(|(_, largest)| f > largest) {
            best = Some((candidate, f));
        }
    }
    best
}

/// (3): primary terms first, then those that earn their place.
pub(crate) fn stepwise(
    sums: &Sums,
    response: usize,
    primary: &[usize],
    optional: &[usize],
    f_enter: f64,
    f_remove: f64,
    depth: Depth,
) -> Option<Equation> {
    let mut current = solve(sums, vec![0], response)?;
    let mut open = primary.to_vec();
    while let Some((term, _)) = best(sums, &current, response, &open) {
        open.retain(|&other| other != term);
        current.terms.push(term);
        current = solve(sums, current.terms, response)?;
    }
    let mut open = optional.to_vec();
    while let Some((term, f)) = best(sums, &current, response, &open) {
        if f < f_enter {
            break;
        }
        open.retain(|&other| other != term);
        let mut terms = current.terms.clone();
        terms.push(term);
        let wider = solve(sums, terms, response)?;
        let var = wider.variances(sums, response, depth);
        let last = wider.terms.len() - 1;
        if wider.theta[last] * wider.theta[last] / var[last] <= f_enter {
            continue;
        }
        current = wider;
        loop {
            let var = current.variances(sums, response, depth);
            let weakest = (1..current.terms.len())
                .filter(|&i| !primary.contains(&current.terms[i]))
                .map(|i| (i, current.theta[i] * current.theta[i] / var[i]))
                .filter(|(_, f)| *f < f_remove)
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((weakest, _)) = weakest else { break };
            current.terms.remove(weakest);
            current = solve(sums, current.terms, response)?;
        }
    }
    let std = current.variances(sums, response, depth).into_iter().map(f64::sqrt).collect();
    Some(Equation { terms: current.terms, theta: current.theta.iter().copied().collect(), std })
}
