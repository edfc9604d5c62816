//! Wilson's interval of a proportion.

/// Of `hits` in `count`, at 95 %: (p + z^2/2n -+ z sqrt(p(1-p)/n + z^2/4n^2))/(1 + z^2/n), z = 1.96.
pub(crate) fn wilson(hits: usize, count: usize) -> [f64; 2] {
    const Z: f64 = 1.959_963_985;
    if count == 0 {
        return [0.0, 1.0];
    }
    let (n, p) = (count as f64, hits as f64 / count as f64);
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    [(middle - half) / scale, (middle + half) / scale].map(|bound| bound.clamp(0.0, 1.0))
}

/// The proportion, its counts and its interval in words.
pub(crate) fn proportion(hits: usize, count: usize) -> String {
    let [low, high] = wilson(hits, count);
    format!("{hits} of {count}, {:.3} ({low:.3} to {high:.3})", hits as f64 / count.max(1) as f64)
}

/// Newcombe 1998, table I: 81 of 263 gives 0.2553 to 0.3662; 0 of 20 gives 0 to 0.1611.
#[test]
fn the_published_intervals() {
    for (hits, count, [low, high]) in [(81, 263, [0.2553, 0.3662]), (0, 20, [0.0, 0.1611])] {
        let found = wilson(hits, count);
        assert!((found[0] - low).abs() < 1e-4 && (found[1] - high).abs() < 1e-4, "{found:?}");
    }
}
