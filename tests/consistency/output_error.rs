//! Output error over many seeds: its scatter is that of the Cramer-Rao bound, its intervals cover, and in coloured noise the
//! corrected ones still do where the others do not.

use crate::support::short_period::{Noise, TRUTH, parameters, record, structure};
use crate::support::uniform::Uniform;
use sideslip::postflight::output_error::{FitSettings, RunParameters, fit};

/// Over the seeds: scatter over the mean Cramer-Rao error by parameter, coverage by it, coverage by the corrected error.
fn study(colour: f64, seeds: u64, samples: usize) -> (Vec<f64>, f64, Vec<f64>) {
    let own = RunParameters { initial_state: vec![0.01, 0.0], state_bias: vec![0.0, 0.02], output_bias: vec![0.0, 0.0, 0.1] };
    let noise = Noise { std: [0.002, 0.003, 0.02], colour };
    let (mut squares, mut bounds) = ([0.0; 6], [0.0; 6]);
    let (mut white, mut corrected) = (0, [0; 6]);
    for seed in 0..seeds {
        let times = (0..samples).map(|k| 0.02 * k as f64).collect();
        let flown = record(times, 0.6, &own, &noise, &mut Uniform(100 + 7919 * seed));
        let fitted = fit(&structure(), &parameters(0.1), &[], &[flown], &FitSettings::default()).unwrap();
        assert!(fitted.converged, "seed {seed}");
        for j in 0..6 {
            let error = (fitted.theta[j] - TRUTH[j]).abs();
            squares[j] += error * error;
            bounds[j] += fitted.std_cramer_rao[j] * fitted.std_cramer_rao[j];
            white += u32::from(error < 1.96 * fitted.std_cramer_rao[j]);
            corrected[j] += u32::from(error < 1.96 * fitted.std[j]);
        }
    }
    let ratios = squares.iter().zip(&bounds).map(|(square, bound)| (square / bound).sqrt()).collect();
    let all = seeds as f64;
    (ratios, f64::from(white) / (6.0 * all), corrected.iter().map(|&covered| f64::from(covered) / all).collect())
}

#[test]
fn in_white_noise_scatter_and_coverage_are_those_of_cramer_and_rao() {
    let (ratios, white, corrected) = study(0.0, 300, 600);
    let pooled = corrected.iter().sum::<f64>() / 6.0;
    eprintln!("white: scatter over bound {ratios:.3?}, coverage {white:.4}, corrected {pooled:.4} {corrected:.3?}");
    // Three standard errors of a scatter from 300 seeds are 12 %.
    assert!(ratios.iter().all(|ratio| *ratio < 1.15), "{ratios:?}");
    assert!((0.935..=0.965).contains(&white) && (0.935..=0.965).contains(&pooled), "{white} {pooled}");
}

#[test]
fn in_coloured_noise_the_corrected_intervals_cover() {
    let (ratios, white, corrected) = study(0.9, 300, 1500);
    let pooled = corrected.iter().sum::<f64>() / 6.0;
    eprintln!("coloured: scatter over bound {ratios:.3?}, coverage {white:.4}, corrected {pooled:.4} {corrected:.3?}");
    assert!(white < 0.6, "white intervals are far too narrow: {white}");
    assert!((0.935..=0.965).contains(&pooled), "{pooled}");
    assert!(corrected.iter().all(|one| (0.91..=0.985).contains(one)), "{corrected:?}");
}
