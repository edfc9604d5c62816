//! Covariance kept as U D U': symmetric by construction, positive as long as every d is.
//!
//! Consumes rows of a transition matrix, noise input columns and measurement rows; produces the factors
//! U [N x N] (unit upper triangular) and d \[N\] with
//!     P = U diag(d) U'                                                                        (1)
//! | symbol | shape | meaning |
//! | --- | --- | --- |
//! | F | N x N | transition: of the first M states among themselves; the others are constant parameters |
//! | G, q | M x K, K | noise input matrix of the first M states, variances of the independent inputs |
//! | h, r | N, 1 | measurement row, its noise variance |
//!
//! Time update (Thornton 1976; modified weighted Gram-Schmidt), with U split at M as [U11 U12; 0 U22]:
//!     U22, d2 unchanged,  U12 <- F11 U12,
//!     rows of [F11 U11, G] with weights (d1, q) made orthogonal from the last to the first      (2)
//! Measurement update (Bierman 1977, ch. V): f = U'h, v = d f, a_0 = r, a_j = a_(j-1) + f_j v_j,
//!     d_j <- d_j a_(j-1)/a_j,  u_ij <- u_ij - k_i f_j/a_(j-1),  k_i <- k_i + v_j u_ij(old)      (3)
//! Increase of one variance, P_jj <- P_jj + c: rank-one update (Agee and Turner 1972)           (4)
//!
//! Source: G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977; M. S. Grewal and
//! A. P. Andrews, Kalman Filtering, 4th ed. 2015, tables 7.9 to 7.11.
//! Numerics: no subtraction forms a d, so a d stays positive unless it underflows; then [`Breakdown`] is returned and
//! the factors are to be thrown away.

#![expect(clippy::needless_range_loop, reason = "indices are those of the equations")]

pub use super::real::Real;
use super::rows::{BLOCK, add_rows, subtract_row};

/// A variance that is not a positive number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakdown {
    /// Which state, or the number of states for the innovation's own variance.
    pub index: usize,
}

/// A covariance in factored form, (1). `column[j][i]` is u_ij: 1 where i = j, 0 where i > j.
#[derive(Clone, Debug, PartialEq)]
pub struct UdFactor<T, const N: usize> {
    column: [[T; N]; N],
    d: [T; N],
}

/// A measurement row seen through the covariance: what is needed to judge an innovation and then to fuse it.
#[derive(Clone, Debug)]
pub struct Projection<T, const N: usize> {
    first: usize,
    f: [T; N],
    noise_var: T,
    /// h P h' + r.
    pub innovation_var: T,
}

impl<T: Real, const N: usize> UdFactor<T, N> {
    /// Independent states with these variances.
    pub fn from_variances(variances: [T; N]) -> Self {
        let mut column = [[T::ZERO; N]; N];
        for j in 0..N {
            column[j][j] = T::ONE;
        }
        UdFactor { column, d: variances }
    }

    /// P_ij.
    pub fn covariance(&self, i: usize, j: usize) -> T {
        let (low, high) = if i < j { (i, j) } else { (j, i) };
        let mut sum = self.column[high][low] * self.d[high];
        for k in high + 1..N {
            sum += self.column[k][low] * self.column[k][high] * self.d[k];
        }
        sum
    }

    /// P_ii.
    pub fn variance(&self, i: usize) -> T {
        self.covariance(i, i)
    }

    /// Every P_ii.
    pub fn variances(&self) -> [T; N] {
        let mut out = [T::ZERO; N];
        for (k, column) in self.column.iter().enumerate() {
            let d = self.d[k];
            for (out, &u) in out.iter_mut().zip(column) {
                *out += u * u * d;
            }
        }
        out
    }

    /// The first rows of P, as many as `out` has.
    pub fn rows(&self, out: &mut [[T; N]]) {
        out.fill([T::ZERO; N]);
        for (k, column) in self.column.iter().enumerate() {
            for (row, &u) in out.iter_mut().zip(&column[..=k]) {
                add_rows(row, &[*column], &[u * self.d[k]], k + 1);
            }
        }
    }

    /// The diagonal factors d, each positive.
    pub fn diagonal(&self) -> &[T; N] {
        &self.d
    }

    /// Time update, (2): `top` is F11 [M x M]; K noise inputs act on the first M states.
    ///
    /// # Errors
    /// [`Breakdown`] where a predicted variance is not positive.
    pub fn propagate<const M: usize, const K: usize>(
        &mut self,
        top: &[[T; M]; M],
        noise_input: &[[T; K]; M],
        noise_var: &[T; K],
    ) -> Result<(), Breakdown> {
        // Rows of F11 [U11 U12]; what F11 has not costs nothing.
        let mut old = [[T::ZERO; N]; M];
        for (j, column) in self.column.iter().enumerate() {
            for (row, &u) in old.iter_mut().zip(&column[..=j]) {
                row[j] = u;
            }
        }
        // The rows that are made orthogonal, [F11 U11, G], entry by entry, so that the rows lie side by side.
        let mut moved = [[T::ZERO; M]; M];
        let mut noise = [[T::ZERO; M]; K];
        for i in 0..M {
            let mut new = [T::ZERO; N];
            add_rows(&mut new, &old, &top[i], N);
            for (entry, &new) in moved.iter_mut().zip(&new) {
                entry[i] = new;
            }
            for (column, &new) in self.column.iter_mut().zip(&new).skip(M) {
                column[i] = new;
            }
            for (entry, &input) in noise.iter_mut().zip(&noise_input[i]) {
                entry[i] = input;
            }
        }
        let mut weights = [T::ZERO; M];
        weights.copy_from_slice(&self.d[..M]);
        for j in (0..M).rev() {
            let (mut pivot, mut weighted) = ([T::ZERO; M], [T::ZERO; M]);
            let (mut noise_pivot, mut noise_weighted) = ([T::ZERO; K], [T::ZERO; K]);
            let mut norm = T::ZERO;
            for k in 0..M {
                pivot[k] = moved[k][j];
                weighted[k] = pivot[k] * weights[k];
                norm += weighted[k] * pivot[k];
            }
            for k in 0..K {
                noise_pivot[k] = noise[k][j];
                noise_weighted[k] = noise_pivot[k] * noise_var[k];
                norm += noise_weighted[k] * noise_pivot[k];
            }
            if !(norm > T::ZERO && norm.finite()) {
                return Err(Breakdown { index: j });
            }
            self.d[j] = norm;
            let mut u = [T::ZERO; M];
            add_rows(&mut u, &moved, &weighted, j);
            add_rows(&mut u, &noise, &noise_weighted, j);
            let scale = T::ONE / norm;
            for u in &mut u {
                *u = *u * scale;
            }
            self.column[j][..j].copy_from_slice(&u[..j]);
            subtract_row(&mut moved, &pivot, &u, j);
            subtract_row(&mut noise, &noise_pivot, &u, j);
        }
        Ok(())
    }

    /// The measurement row `h` with noise variance `noise_var`, seen through the covariance.
    ///
    /// # Errors
    /// [`Breakdown`] where the innovation variance is not positive.
    pub fn project(&self, h: &[T; N], noise_var: T) -> Result<Projection<T, N>, Breakdown> {
        let mut touched = [0; N];
        let mut count = 0;
        for (i, &entry) in h.iter().enumerate() {
            if entry != T::ZERO {
                touched[count] = i;
                count += 1;
            }
        }
        let touched = &touched[..count];
        let first = touched.first().copied().unwrap_or(N);
        let mut f = [T::ZERO; N];
        let mut innovation_var = noise_var;
        for j in first..N {
            let column = &self.column[j];
            for &i in touched {
                f[j] += column[i] * h[i];
            }
            innovation_var += f[j] * f[j] * self.d[j];
        }
        if !(noise_var > T::ZERO && innovation_var.finite()) {
            return Err(Breakdown { index: N });
        }
        Ok(Projection { first, f, noise_var, innovation_var })
    }

    /// Measurement update, (3); returns the gain K = P h'/innovation_var \[N\].
    ///
    /// # Errors
    /// [`Breakdown`] where an updated variance is not positive.
    pub fn fuse(&mut self, projection: &Projection<T, N>) -> Result<[T; N], Breakdown> {
        let Projection { first, f, noise_var, .. } = projection;
        let mut v = [T::ZERO; N];
        let mut lambda = [T::ZERO; N];
        let mut a = *noise_var;
        let mut one_over_a = T::ONE / a;
        for j in *first..N {
            v[j] = self.d[j] * f[j];
            lambda[j] = f[j] * one_over_a;
            let before = a;
            a += f[j] * v[j];
            one_over_a = T::ONE / a;
            self.d[j] = self.d[j] * (before * one_over_a);
            if !(self.d[j] > T::ZERO) {
                return Err(Breakdown { index: j });
            }
        }
        // Rows above `first` couple states that the measurement does not touch itself: they move too. A row's own diagonal,
        // 1, brings v into the gain; below it all is nothing and stays so.
        let mut gain = [T::ZERO; N];
        let (blocks, rest) = gain.as_chunks_mut::<BLOCK>();
        let whole = blocks.len();
        for (b, block) in blocks.iter_mut().enumerate() {
            let mut register = *block;
            for j in (*first).max(b * BLOCK)..N {
                let column = &mut self.column[j].as_chunks_mut::<BLOCK>().0[b];
                for (entry, gain) in column.iter_mut().zip(&mut register) {
                    let old = *entry;
                    *entry = old - *gain * lambda[j];
                    *gain += v[j] * old;
                }
            }
            *block = register;
        }
        for (gain, i) in rest.iter_mut().zip(whole * BLOCK..) {
            for j in (*first).max(i)..N {
                let old = self.column[j][i];
                self.column[j][i] = old - *gain * lambda[j];
                *gain += v[j] * old;
            }
        }
        for entry in &mut gain {
            *entry = *entry * one_over_a;
        }
        Ok(gain)
    }

    /// Increases the variance of one state by `increase` >= 0, (4).
    ///
    /// # Errors
    /// [`Breakdown`] where a variance is not positive afterwards.
    pub fn inflate(&mut self, state: usize, increase: T) -> Result<(), Breakdown> {
        let mut c = increase;
        let mut a = [T::ZERO; N];
        a[state] = T::ONE;
        for j in (0..=state).rev() {
            if !(c > T::ZERO) {
                break;
            }
            let old = self.d[j];
            let new = old + c * a[j] * a[j];
            if !(new > T::ZERO && new.finite()) {
                return Err(Breakdown { index: j });
            }
            let b = c * a[j] / new;
            self.d[j] = new;
            for i in 0..j {
                a[i] -= a[j] * self.column[j][i];
                self.column[j][i] += b * a[i];
            }
            c = c * (old / new);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix5, SMatrix, Vector5};

    type Factor = UdFactor<f64, 5>;

    fn dense(factor: &Factor) -> Matrix5<f64> {
        Matrix5::from_fn(|i, j| factor.covariance(i, j))
    }

    fn pseudo(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// The textbook covariance beside the factored one through many random updates of every kind.
    #[test]
    fn agrees_with_the_textbook_covariance() {
        let mut seed = 1;
        let mut factor = Factor::from_variances([4.0, 1.0, 0.25, 0.01, 0.04]);
        let mut p = dense(&factor);
        for _ in 0..300 {
            let mut f = Matrix5::identity();
            let mut top = [[0.0; 3]; 3];
            let mut g = [[0.0; 2]; 3];
            for i in 0..3 {
                for j in 0..3 {
                    f[(i, j)] += 0.1 * pseudo(&mut seed);
                    top[i][j] = f[(i, j)];
                }
                for entry in &mut g[i] {
                    *entry = pseudo(&mut seed);
                }
            }
            let q = [0.1, 0.02];
            let gm = SMatrix::<f64, 5, 2>::from_fn(|i, j| if i < 3 { g[i][j] } else { 0.0 });
            factor.propagate(&top, &g, &q).unwrap();
            factor.inflate(4, 1e-3).unwrap();
            factor.inflate(3, 2e-3).unwrap();
            p = f * p * f.transpose() + gm * SMatrix::<f64, 2, 2>::from_diagonal(&q.into()) * gm.transpose();
            p[(4, 4)] += 1e-3;
            p[(3, 3)] += 2e-3;
            assert!((dense(&factor) - p).abs().max() < 1e-12 * p.abs().max());

            // A row that begins with zeros as well as a full one.
            for first in [0, 2] {
                let h: [f64; 5] = core::array::from_fn(|i| if i < first { 0.0 } else { pseudo(&mut seed) });
                let hv = Vector5::from(h);
                let s = (hv.transpose() * p * hv)[0] + 0.3;
                let projection = factor.project(&h, 0.3).unwrap();
                assert!((projection.innovation_var - s).abs() < 1e-12 * s);
                let k = factor.fuse(&projection).unwrap();
                let gain = p * hv / s;
                assert!((Vector5::from(k) - gain).abs().max() < 1e-11);
                p -= gain * (hv.transpose() * p);
                p = (p + p.transpose()) * 0.5;
                assert!((dense(&factor) - p).abs().max() < 1e-11 * p.abs().max());
            }
        }
    }

    #[test]
    fn refuses_a_variance_that_is_not_positive() {
        let factor = Factor::from_variances([1.0; 5]);
        assert_eq!(factor.project(&[1.0; 5], 0.0).unwrap_err(), Breakdown { index: 5 });
        assert_eq!(factor.project(&[f64::NAN; 5], 1.0).unwrap_err(), Breakdown { index: 5 });
        let mut zero = Factor::from_variances([0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(zero.propagate(&[[1.0]], &[[0.0]], &[1.0]), Err(Breakdown { index: 0 }));
    }
}
