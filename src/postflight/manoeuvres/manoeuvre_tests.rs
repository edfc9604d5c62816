//! The damped sine beside its closed form, and its standard errors beside the scatter over many draws of noise.

use super::damped_sine::{Bins, fit};
use crate::num::random::NormalNoise;

fn swing(omega: f64, zeta: f64, noise: f64, seed: u64, colour: f64) -> Vec<Bins> {
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let mut draw = NormalNoise::new(seed, 7);
    let channel = |size: f64, phase: f64, drift: f64, draw: &mut NormalNoise| {
        let mut state = 0.0;
        let bins = (0..300).map(|i| {
            let t = f64::from(i) * 0.04;
            state = colour * state + (1.0 - colour * colour).sqrt() * noise * draw.draw();
            Some((t, size * (-zeta * omega * t).exp() * (damped * t + phase).sin() + 0.02 + drift * t + state * size))
        });
        bins.collect::<Bins>()
    };
    vec![channel(0.1, 0.3, 1e-3, &mut draw), channel(0.05, 1.9, -2e-3, &mut draw), channel(0.04, -1.0, 0.0, &mut draw)]
}

#[test]
fn without_noise_the_closed_form_comes_back() {
    for (omega, zeta) in [(1.8, 0.09), (2.5, 0.5), (4.0, 0.6), (1.0, -0.02), (6.0, 0.02)] {
        let found = fit(&swing(omega, zeta, 1e-9, 1, 0.0), 0.6, 9.0).unwrap();
        assert!((found.omega.value - omega).abs() < 1e-5, "{omega} {zeta}: {found:?}");
        assert!((found.zeta.value - zeta).abs() < 1e-5, "{omega} {zeta}: {found:?}");
        assert!(found.explained > 0.999_99);
        assert!((found.channels[0].size() - 0.1).abs() < 1e-5 && (found.channels[1].coefficients[3] + 2e-3).abs() < 1e-6);
    }
}

#[test]
fn standard_errors_hold_the_truth_in_white_and_in_coloured_noise() {
    const SEEDS: u64 = 50;
    for (omega, zeta, noise, colour) in
        [(1.8, 0.09, 0.1, 0.0), (2.5, 0.35, 0.05, 0.0), (1.8, 0.09, 0.1, 0.8), (2.0, 0.1, 0.05, 0.95)]
    {
        let (mut within, mut squares) = (0_u64, [0.0; 2]);
        for seed in 0..SEEDS {
            let found = fit(&swing(omega, zeta, noise, seed, colour), 0.6, 9.0).unwrap();
            let scores = [(found.omega.value - omega) / found.omega.std, (found.zeta.value - zeta) / found.zeta.std];
            within += u64::from(scores.iter().all(|score| score.abs() < 3.0));
            for (square, score) in squares.iter_mut().zip(scores) {
                *square += score * score / SEEDS as f64;
            }
        }
        let spread = squares.map(f64::sqrt);
        eprintln!("omega {omega} zeta {zeta} noise {noise} colour {colour}: {within} of {SEEDS} within, spread {spread:.2?}");
        // Noise correlated over most of a period is recognised only in part: 192 of 200 were measured there.
        assert!(within * 100 >= SEEDS * if colour > 0.9 { 94 } else { 97 }, "{within}");
    }
}

#[test]
fn a_wild_reading_changes_little_and_a_missing_one_nothing() {
    let mut channels = swing(1.8, 0.09, 0.01, 3, 0.0);
    let clean = fit(&channels, 0.6, 9.0).unwrap();
    for (place, bin) in channels[0].iter_mut().enumerate() {
        match (place % 37, &mut *bin) {
            (5, Some((_, x))) => *x += 0.2,
            (20..=24, bin) => *bin = None,
            _ => {}
        }
    }
    let wild = fit(&channels, 0.6, 9.0).unwrap();
    assert!((wild.zeta.value - clean.zeta.value).abs() < 4.0 * clean.zeta.std, "{wild:?}");
    assert!(fit(&[vec![Some((0.0, 0.0)); 50]], 0.6, 9.0).is_none());
    assert!(fit(&[], 0.6, 9.0).is_none());
}
