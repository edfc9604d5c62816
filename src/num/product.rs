//! Products of vectors and of matrices that lie row by row in slices, their terms summed in order.
//!
//! Consumes A \[rows x inner\] and B \[inner x columns\] (or B' \[columns x inner\]); produces
//!     a . b = sum_l a_l b_l                                                                           (1)
//!     (A B)_ij = sum_l A_il B_lj,     (A B')_ij = sum_l A_il B_jl                                     (2)
//! Numerics: every entry is the sum over l from zero upward, so that both forms of (2) round alike.

/// (1).
#[inline]
pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(a, b)| a * b).sum()
}

/// `out += left right`, with `right` \[inner x columns\].
#[cfg(feature = "std")]
#[inline]
pub(crate) fn add_product(left: &[f64], right: &[f64], inner: usize, columns: usize, out: &mut [f64]) {
    if inner == 0 || columns == 0 {
        return;
    }
    for (row, out) in left.chunks_exact(inner).zip(out.chunks_exact_mut(columns)) {
        for (&factor, line) in row.iter().zip(right.chunks_exact(columns)) {
            for (out, value) in out.iter_mut().zip(line) {
                *out += factor * value;
            }
        }
    }
}

/// `out = left right`, with `right` \[inner x columns\].
#[cfg(feature = "std")]
#[inline]
pub(crate) fn set_product(left: &[f64], right: &[f64], inner: usize, columns: usize, out: &mut [f64]) {
    out.fill(0.0);
    add_product(left, right, inner, columns, out);
}

/// `out = left right'`, n x n each.
#[cfg(feature = "std")]
#[inline]
pub(crate) fn set_product_by_transpose(left: &[f64], right: &[f64], n: usize, out: &mut [f64]) {
    for (row, out) in left.chunks_exact(n.max(1)).zip(out.chunks_exact_mut(n.max(1))) {
        for (line, out) in right.chunks_exact(n.max(1)).zip(out) {
            *out = row.iter().zip(line).fold(0.0, |sum, (a, b)| sum + a * b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "values are exact in binary")]
    fn products_are_those_written_out() {
        let (left, right) = ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [1.0, 0.5, -1.0, 2.0, 0.0, 4.0]);
        let mut out = [9.0; 4];
        set_product(&left, &right, 3, 2, &mut out);
        assert_eq!(out, [-1.0, 16.5, -1.0, 36.0]);
        add_product(&left, &right, 3, 2, &mut out);
        assert_eq!(out, [-2.0, 33.0, -2.0, 72.0]);
        set_product_by_transpose(&left[..4], &right[..4], 2, &mut out);
        assert_eq!(out, [2.0, 3.0, 5.0, 5.0]);
        assert_eq!(dot(&left, &right), 1.0 + 1.0 - 3.0 + 8.0 + 24.0);
        // No columns, nothing inside.
        set_product(&[], &[], 0, 0, &mut []);
        set_product(&[], &[], 0, 2, &mut out);
        assert_eq!(out, [0.0; 4]);
    }
}
