//! The information matrix with lagged products: sufficient statistics of the past, at a cost independent of the record's length.
//!
//! Consumes vectors z_k \[N\] (bias, regressors, responses) on a uniform grid; produces
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
//! Numerics: plain sums; vectors are deviations from trim, so that the bias does not swamp them. G_l is kept with the lag as
//! its last index, so that an update, a form over all lags and a weighted sum over lags each run along memory; and it is kept
//! over f_n^2, where f_k is the product of lambda up to k, as the sum of (z_k/f_k) (z_(k-l)/f_(k-l))': to forget is then to
//! change f alone, until it is so small that the sums are brought back to it.

/// Lags that are kept: 16 steps of the grid, twice the support that the default smoothing colours.
pub const LAGS: usize = 16;

/// Covariances of two residuals at lags 0 .. LAGS: `[l]` is (first at k, second at k - l).
pub type LagCovariance = [f64; LAGS + 1];

/// f below which the sums are rescaled to f = 1, far above underflow of f^2.
const SMALL: f64 = 1e-60;

/// One number a lag, from lag 1; two cache lines that no other entry shares.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Lagged([f64; LAGS]);

/// Sums of products (1) and lagged products (2).
#[derive(Clone, Debug)]
pub struct Information<const N: usize> {
    sums: [[f64; N]; N],
    /// G_0.
    squared: [[f64; N]; N],
    /// f_n: lagged products are kept over its square, recent vectors over it.
    scale: f64,
    /// Entry `[i][j][l - 1]` is that of G_l over f_n^2.
    lagged: [[Lagged; N]; N],
    weight: f64,
    weight2: f64,
    weight3: f64,
    /// Sums of z_i^4.
    fourth: [f64; N],
    /// Entry `[i][l - 1]` is z_i of l instants ago over the f of then; zero where it was skipped.
    recent: [Lagged; N],
}

impl<const N: usize> Default for Information<N> {
    fn default() -> Self {
        Information::EMPTY
    }
}

impl<const N: usize> Information<N> {
    /// No vector yet.
    pub const EMPTY: Information<N> = Information {
        sums: [[0.0; N]; N],
        squared: [[0.0; N]; N],
        scale: 1.0,
        lagged: [[Lagged([0.0; LAGS]); N]; N],
        weight: 0.0,
        weight2: 0.0,
        weight3: 0.0,
        fourth: [0.0; N],
        recent: [Lagged([0.0; LAGS]); N],
    };

    /// One vector, with everything before it forgotten by `lambda`.
    pub fn add(&mut self, z: &[f64; N], lambda: f64) {
        let forget = lambda * lambda;
        accumulate(&mut self.sums, z, lambda);
        accumulate(&mut self.squared, z, forget);
        self.weight = lambda * self.weight + 1.0;
        self.weight2 = forget * self.weight2 + 1.0;
        self.weight3 = forget * lambda * self.weight3 + 1.0;
        for (sum, &zi) in self.fourth.iter_mut().zip(z) {
            *sum = lambda * *sum + (zi * zi) * (zi * zi);
        }
        self.scale *= lambda;
        if self.scale < SMALL {
            self.rescale();
        }
        let scaled = z.map(|zi| zi / self.scale);
        // The lags of one past vector stay in registers while every entry with it is updated.
        for (j, &Lagged(before)) in self.recent.iter().enumerate() {
            for (row, &zi) in self.lagged.iter_mut().zip(&scaled) {
                for (product, before) in row[j].0.iter_mut().zip(&before) {
                    *product += zi * before;
                }
            }
        }
        self.remember(&scaled);
    }

    /// Rescales all sums to f = 1.
    #[cold]
    fn rescale(&mut self) {
        let (scale, scale2) = (self.scale, self.scale * self.scale);
        self.lagged.as_flattened_mut().iter_mut().for_each(|products| products.0 = products.0.map(|product| scale2 * product));
        self.recent.iter_mut().for_each(|past| past.0 = past.0.map(|past| scale * past));
        self.scale = 1.0;
    }

    /// One instant of the grid without a vector: nothing is added and nothing forgotten.
    pub fn skip(&mut self) {
        self.remember(&[0.0; N]);
    }

    fn remember(&mut self, z: &[f64; N]) {
        for (before, &zi) in self.recent.iter_mut().zip(z) {
            before.0.copy_within(..LAGS - 1, 1);
            before.0[0] = zi;
        }
    }

    /// S of (1).
    pub fn sums(&self) -> &[[f64; N]; N] {
        &self.sums
    }

    /// G_0 of (2).
    pub fn squared(&self) -> &[[f64; N]; N] {
        &self.squared
    }

    /// G_l of (2), copied out; entry `[i][j]` is the sum of z_i at k times z_j at k - l.
    pub fn lagged(&self, lag: usize) -> [[f64; N]; N] {
        match lag.checked_sub(1) {
            None => self.squared,
            Some(l) => core::array::from_fn(|i| core::array::from_fn(|j| self.scale2() * self.lagged[i][j].0[l])),
        }
    }

    /// Entry i, j of G_l for every lag.
    pub fn over_lags(&self, i: usize, j: usize) -> [f64; LAGS + 1] {
        let mut products = [self.squared[i][j]; LAGS + 1];
        products[1..].copy_from_slice(&self.lagged[i][j].0.map(|product| self.scale2() * product));
        products
    }

    /// Adds `factor` times entry i, j of G_l to `sums`, for every lag.
    pub fn add_over_lags(&self, sums: &mut [f64; LAGS + 1], factor: f64, i: usize, j: usize) {
        let [now, later @ ..] = sums;
        *now += factor * self.squared[i][j];
        let factor = factor * self.scale2();
        for (sum, product) in later.iter_mut().zip(&self.lagged[i][j].0) {
            *sum += factor * product;
        }
    }

    /// Entry of (2) for z_i of `lag_i` instants ago and z_j of `lag_j` instants ago, as if the signals were stationary; zero
    /// where they are more than [`LAGS`] apart.
    pub fn shifted(&self, i: usize, lag_i: usize, j: usize, lag_j: usize) -> f64 {
        let (newer, older, apart) = if lag_j >= lag_i { (i, j, lag_j - lag_i) } else { (j, i, lag_i - lag_j) };
        match apart {
            0 => self.squared[i][j],
            1..=LAGS => self.scale2() * self.lagged[newer][older].0[apart - 1],
            _ => 0.0,
        }
    }

    /// a' G_l b for every lag, over the places where a and b are not zero.
    pub fn forms(&self, a: &[f64; N], b: &[f64; N]) -> [f64; LAGS + 1] {
        let mut now = 0.0;
        let mut later = [0.0; LAGS];
        for (i, &ai) in a.iter().enumerate() {
            if ai == 0.0 {
                continue;
            }
            for (j, &bj) in b.iter().enumerate() {
                if bj == 0.0 {
                    continue;
                }
                let both = ai * bj;
                now += both * self.squared[i][j];
                for (sum, product) in later.iter_mut().zip(&self.lagged[i][j].0) {
                    *sum += both * product;
                }
            }
        }
        let mut forms = [now; LAGS + 1];
        forms[1..].copy_from_slice(&later.map(|form| self.scale2() * form));
        forms
    }

    /// Entry i, j of the weighted sum of G_l over the lags.
    pub fn weighted(&self, weights: &[f64; LAGS + 1], i: usize, j: usize) -> f64 {
        // Four sums side by side: one alone would wait for each addition.
        let mut sums = [0.0; 4];
        let (products, _) = self.lagged[i][j].0.as_chunks::<4>();
        let (of_lags, _) = weights[1..].as_chunks::<4>();
        for (products, weights) in products.iter().zip(of_lags) {
            for ((sum, product), weight) in sums.iter_mut().zip(products).zip(weights) {
                *sum += product * weight;
            }
        }
        weights[0] * self.squared[i][j] + self.scale2() * ((sums[0] + sums[2]) + (sums[1] + sums[3]))
    }

    /// f_n^2.
    fn scale2(&self) -> f64 {
        self.scale * self.scale
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

    /// Number of vectors that carry as much information: weight^2/weight2.
    pub fn effective_samples(&self) -> f64 {
        if self.weight2 > 0.0 { self.weight * self.weight / self.weight2 } else { 0.0 }
    }

    /// Vectors in which entry `i` moves: of n equal squares n, of one that exceeds all others 1,
    ///     (sum z_i^2)^2 / sum z_i^4.
    pub fn moving_samples(&self, i: usize) -> f64 {
        if self.fourth[i] > 0.0 { self.sums[i][i] * self.sums[i][i] / self.fourth[i] } else { 0.0 }
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

/// matrix <- forget matrix + z z'.
fn accumulate<const N: usize>(matrix: &mut [[f64; N]; N], z: &[f64; N], forget: f64) {
    for (row, &zi) in matrix.iter_mut().zip(z) {
        for (entry, &zj) in row.iter_mut().zip(z) {
            *entry = forget * *entry + zi * zj;
        }
    }
}

// `weighted` takes the lags four at a time.
const _: () = assert!(LAGS.is_multiple_of(4));

#[cfg(test)]
mod tests {
    use super::{Information, LAGS};

    #[test]
    fn strong_forgetting_goes_on_past_what_a_number_can_hold() {
        let row = |k: usize| [1.0, libm::sin(0.7 * k as f64), libm::cos(1.9 * k as f64)];
        let (lambda, count) = (0.25_f64, 700_usize);
        let mut information = Information::<3>::EMPTY;
        (0..count).for_each(|k| information.add(&row(k), lambda));
        // (2) term by term; what is older than 60 vectors weighs less than the rounding of the newest.
        for lag in 0..=LAGS {
            for (i, row_found) in information.lagged(lag).iter().enumerate() {
                for (j, found) in row_found.iter().enumerate() {
                    let terms = (0..60).map(|age| {
                        let k = count - 1 - age;
                        libm::pow(lambda, (2 * age + lag) as f64) * row(k)[i] * row(k - lag)[j]
                    });
                    let known: f64 = terms.sum();
                    let size = libm::pow(lambda, lag as f64);
                    assert!((found - known).abs() < 1e-12 * size, "lag {lag}, {i} {j}: {found} for {known}");
                }
            }
        }
    }

    #[test]
    fn everything_forgotten_is_a_new_beginning() {
        let (mut information, mut new) = (Information::<2>::EMPTY, Information::<2>::EMPTY);
        [[1.0, 3.0], [1.0, -2.0]].iter().for_each(|z| information.add(z, 0.9));
        information.add(&[1.0, 5.0], 0.0);
        information.add(&[1.0, 7.0], 0.9);
        [[1.0, 5.0], [1.0, 7.0]].iter().for_each(|z| new.add(z, 0.9));
        for (found, known) in [0, 1]
            .map(|lag| (information.lagged(lag), new.lagged(lag)))
            .iter()
            .flat_map(|(a, b)| a.as_flattened().iter().zip(b.as_flattened()))
        {
            assert!((found - known).abs() < 1e-13, "{found} for {known}");
        }
    }
}
