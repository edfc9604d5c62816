//! The information matrix: everything the regression keeps of the past, at a cost independent of the record's length.
//!
//! Consumes vectors z_k [N] (bias, regressors, responses) on a uniform grid; produces
//!     S   = sum_k lambda^(n-k) z_k z_k'                                                           (1)
//!     G_l = sum_k lambda^((n-k)+(n-(k-l))) z_k z_(k-l)',  l = 0 .. LAGS                             (2)
//! S gives least squares for any subset of regressors and any response. G_l gives, for any vector of coefficients e over z
//! (such as e = response - X theta), the autocovariance of the residual v_k = e'z_k afterwards, without a second pass:
//!     R_l = e' G_l e / sum_k lambda^(2(n-k))                                                       (3)
//! lambda < 1 forgets; a vector that is skipped ages nothing and leaves a hole in the lagged products: lags count instants
//! of the grid, the exponents of lambda count only the vectors that were added.
//! Source: E. A. Morelli and V. Klein, Accuracy of aerodynamic model parameters estimated from flight test data,
//! J. Guidance 20(1), 1997; recursive form after J. A. Grauer and E. A. Morelli, NTRS 20160007740, with the residuals'
//! autocovariance taken from (2) instead of from stored residuals.
//! Numerics: plain sums; vectors are deviations from trim, so that the bias does not swamp them.

/// Lags that are kept: 16 steps of the grid, twice the support that the default smoothing colours.
pub const LAGS: usize = 16;

/// Sums of products (1) and lagged products (2).
#[derive(Clone, Debug)]
pub struct Information<const N: usize> {
    sums: [[f64; N]; N],
    lagged: [[[f64; N]; N]; LAGS + 1],
    weight: f64,
    weight2: f64,
    weight3: f64,
    recent: [[f64; N]; LAGS],
    used: [bool; LAGS],
    head: usize,
}

impl<const N: usize> Default for Information<N> {
    fn default() -> Self {
        Information {
            sums: [[0.0; N]; N],
            lagged: [[[0.0; N]; N]; LAGS + 1],
            weight: 0.0,
            weight2: 0.0,
            weight3: 0.0,
            recent: [[0.0; N]; LAGS],
            used: [false; LAGS],
            head: 0,
        }
    }
}

impl<const N: usize> Information<N> {
    /// One vector, with everything before it forgotten by `lambda`.
    pub fn add(&mut self, z: &[f64; N], lambda: f64) {
        accumulate(&mut self.sums, z, z, lambda, 1.0);
        accumulate(&mut self.lagged[0], z, z, lambda * lambda, 1.0);
        self.weight = lambda * self.weight + 1.0;
        self.weight2 = lambda * lambda * self.weight2 + 1.0;
        self.weight3 = lambda * lambda * lambda * self.weight3 + 1.0;
        let mut forgotten = lambda;
        for lag in 1..=LAGS {
            let place = (self.head + LAGS - lag) % LAGS;
            let used = self.used[place];
            let past = self.recent[place];
            accumulate(&mut self.lagged[lag], z, &past, lambda * lambda, if used { forgotten } else { 0.0 });
            if used {
                forgotten *= lambda;
            }
        }
        self.remember(z, true);
    }

    /// One instant of the grid without a vector: nothing is added and nothing forgotten.
    pub fn skip(&mut self) {
        self.remember(&[0.0; N], false);
    }

    fn remember(&mut self, z: &[f64; N], used: bool) {
        self.recent[self.head] = *z;
        self.used[self.head] = used;
        self.head = (self.head + 1) % LAGS;
    }

    /// S of (1).
    pub fn sums(&self) -> &[[f64; N]; N] {
        &self.sums
    }

    /// G_l of (2); entry `[i][j]` is the sum of z_i at k times z_j at k - l.
    pub fn lagged(&self, lag: usize) -> &[[f64; N]; N] {
        &self.lagged[lag]
    }

    /// Sum of the weights lambda^(n-k): the number of vectors where nothing is forgotten.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Sum of the squared weights.
    pub fn weight2(&self) -> f64 {
        self.weight2
    }

    /// Sum of the cubed weights.
    pub fn weight3(&self) -> f64 {
        self.weight3
    }

    /// a' G_l b, over the places where a and b are not zero.
    pub fn form(&self, lag: usize, a: &[f64; N], b: &[f64; N]) -> f64 {
        let mut sum = 0.0;
        for (row, &ai) in self.lagged[lag].iter().zip(a) {
            if ai == 0.0 {
                continue;
            }
            let mut inner = 0.0;
            for (entry, &bj) in row.iter().zip(b) {
                inner += entry * bj;
            }
            sum += ai * inner;
        }
        sum
    }

    /// Number of vectors that carry as much information: weight^2/weight2.
    pub fn effective_samples(&self) -> f64 {
        if self.weight2 > 0.0 { self.weight * self.weight / self.weight2 } else { 0.0 }
    }

    /// Standard deviation of entry `i` about its mean.
    pub fn deviation(&self, i: usize) -> f64 {
        if !(self.weight > 0.0) {
            return 0.0;
        }
        let mean = self.sums[0][i] / self.weight;
        libm::sqrt((self.sums[i][i] / self.weight - mean * mean).max(0.0))
    }
}

/// matrix <- forget matrix + scale a b'.
fn accumulate<const N: usize>(matrix: &mut [[f64; N]; N], a: &[f64; N], b: &[f64; N], forget: f64, scale: f64) {
    for (row, &ai) in matrix.iter_mut().zip(a) {
        let ai = scale * ai;
        for (entry, &bj) in row.iter_mut().zip(b) {
            *entry = forget * *entry + ai * bj;
        }
    }
}
