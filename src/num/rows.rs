//! Sums of multiples of rows, block by block, so that the sums stay in registers and are vectorised.
//!
//! Consumes rows [K x N] and their weights \[K\]; produces
//!     s_i <- s_i + sum_k w_k r_ki          r_ki <- r_ki - w_k s_i                                    (1)
//! Numerics: each entry is summed in the order of k, so blocks change no bit. A zero weight is skipped.

use super::real::Real;

/// Entries that are worked on together.
pub(crate) const BLOCK: usize = 8;

/// sum <- sum + sum_k weights_k rows_k, at least for the first `count` entries.
pub(crate) fn add_rows<T: Real, const N: usize>(sum: &mut [T; N], rows: &[[T; N]], weights: &[T], count: usize) {
    let (blocks, rest) = sum.as_chunks_mut::<BLOCK>();
    let whole = blocks.len();
    for (b, block) in blocks.iter_mut().take(count.div_ceil(BLOCK)).enumerate() {
        // A copy, so that it stays in registers.
        let mut register = *block;
        for (row, &weight) in rows.iter().zip(weights) {
            if weight != T::ZERO {
                let row = &row.as_chunks::<BLOCK>().0[b];
                for (sum, &entry) in register.iter_mut().zip(row) {
                    *sum += weight * entry;
                }
            }
        }
        *block = register;
    }
    for (sum, i) in rest.iter_mut().zip(whole * BLOCK..count) {
        for (row, &weight) in rows.iter().zip(weights) {
            *sum += weight * row[i];
        }
    }
}

/// rows_k <- rows_k - weights_k row, at least for the first `count` entries.
pub(crate) fn subtract_row<T: Real, const N: usize>(rows: &mut [[T; N]], weights: &[T], row: &[T; N], count: usize) {
    let (blocks, rest) = row.as_chunks::<BLOCK>();
    for (b, &block) in blocks.iter().take(count.div_ceil(BLOCK)).enumerate() {
        for (row, &weight) in rows.iter_mut().zip(weights) {
            if weight != T::ZERO {
                for (entry, entry_of_row) in row.as_chunks_mut::<BLOCK>().0[b].iter_mut().zip(block) {
                    *entry -= weight * entry_of_row;
                }
            }
        }
    }
    for (i, &entry) in (blocks.len() * BLOCK..count).zip(rest) {
        for (row, &weight) in rows.iter_mut().zip(weights) {
            row[i] -= weight * entry;
        }
    }
}

/// c' M c of a symmetric M, from its lower triangle and the whole of its blocks on the diagonal.
pub(crate) fn quadratic_form<const N: usize>(lower: &[[f64; N]; N], c: &[f64; N]) -> f64 {
    let doubled = c.map(|entry| 2.0 * entry);
    let (blocks, rest) = c.as_chunks::<BLOCK>();
    let mut form = 0.0;
    for (b, entries) in blocks.iter().enumerate() {
        let mut register = [0.0; BLOCK];
        let (own, below) = (b * BLOCK, (b + 1) * BLOCK);
        let rows = lower[own..below].iter().zip(entries).chain(lower[below..].iter().zip(&doubled[below..]));
        for (row, &weight) in rows {
            for (sum, &entry) in register.iter_mut().zip(&row.as_chunks::<BLOCK>().0[b]) {
                *sum += weight * entry;
            }
        }
        form += register.iter().zip(entries).map(|(sum, entry)| sum * entry).sum::<f64>();
    }
    let first = blocks.len() * BLOCK;
    for (i, &entry) in rest.iter().enumerate() {
        let row = &lower[first + i][first..];
        form += entry * (row[i] * entry + row.iter().zip(&doubled[first..]).take(i).map(|(m, c)| m * c).sum::<f64>());
    }
    form
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_form_is_the_plain_double_sum_whatever_stands_above_the_blocks() {
        const N: usize = 19;
        let c: [f64; N] = core::array::from_fn(|i| libm::cos(5.0 * i as f64));
        let whole = |i: usize, j: usize| libm::sin((i * j + i + j) as f64);
        let above = |i: usize, j: usize| j > i && (j / BLOCK > i / BLOCK || i >= N / BLOCK * BLOCK);
        let lower = core::array::from_fn(|i| core::array::from_fn(|j| if above(i, j) { f64::NAN } else { whole(i, j) }));
        let plain: f64 = (0..N).map(|i| (0..N).map(|j| c[i] * whole(i, j) * c[j]).sum::<f64>()).sum();
        assert!((quadratic_form(&lower, &c) - plain).abs() < 1e-13 * plain.abs().max(1.0));
    }

    #[test]
    fn blocks_and_rest_are_the_plain_sums_bit_by_bit() {
        const N: usize = 19;
        let entry = |k: usize, i: usize| libm::sin((7 * k + 3 * i) as f64);
        let rows: [[f64; N]; 5] = core::array::from_fn(|k| core::array::from_fn(|i| entry(k, i)));
        let weights = [0.3, 0.0, -2.0, 1e9, 0.7];
        for count in [0, 1, 8, 9, 16, 17, 19] {
            let mut sum: [f64; N] = core::array::from_fn(|i| entry(9, i));
            let before = sum;
            add_rows(&mut sum, &rows, &weights, count);
            let mut left = rows;
            subtract_row(&mut left, &weights, &before, count);
            for i in 0..count {
                let mut plain = before[i];
                for k in 0..5 {
                    plain += weights[k] * rows[k][i];
                    assert_eq!(left[k][i].to_bits(), (rows[k][i] - weights[k] * before[i]).to_bits());
                }
                assert_eq!(sum[i].to_bits(), plain.to_bits());
            }
        }
    }
}
