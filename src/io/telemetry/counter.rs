//! Counters of few bits that begin again at zero: which whole number a reading means.

/// The number nearest to `near` whose remainder by `modulus` is `low`; half of it away, the earlier one.
pub(super) fn nearest(near: i64, low: i64, modulus: i64) -> i64 {
    let ahead = low.wrapping_sub(near).rem_euclid(modulus);
    let step = if ahead >= modulus / 2 { ahead - modulus } else { ahead };
    near.saturating_add(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_number_of_those_bits_is_before_or_after() {
        for (near, low, wanted) in [(0, 0, 0), (5, 250, -6), (250, 3, 259), (600, 40, 552), (256, 128, 128), (-3, 254, -2)] {
            assert_eq!(nearest(near, low, 256), wanted, "{near} {low}");
        }
        assert_eq!(nearest(1 << 40, 7, 1 << 32), (1 << 40) + 7);
    }
}
