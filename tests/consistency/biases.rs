//! Biases of gyros and accelerometers against the ones that were put in, over many flights with the full instrument model:
//! lags, delays, words, vibration, dropouts, and vanes that read 2 % too much and a few milliradians off, of which nobody told.

use super::smoother::{fly, geometry, instruments};
use crate::support::asked::seeds;
use crate::support::manoeuvre::over_seeds;
use crate::support::uniform::Uniform;
use sideslip::flight::channel::Channel;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::fixed_interval::smooth;

const INERTIAL: [Channel; 6] = [Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R];

/// Errors of the six biases in their standard errors. The biases are drawn here, so that they are known.
fn scores(input: &str, seed: u64) -> Option<Vec<f64>> {
    let mut instruments = instruments(1.0);
    let mut uniform = Uniform(1000 + seed);
    let biases = INERTIAL.map(|channel| {
        let one = instruments.channels.iter_mut().find(|one| one.channel == channel).unwrap();
        // The sum of twelve is as good as normal here.
        one.bias = one.bias_std * (0..12).map(|_| uniform.within(0.5)).sum::<f64>();
        one.bias_std = 0.0;
        one.bias
    });
    let flown = fly(input, &instruments, seed)?;
    let whole = smooth(&flown.samples, &EstimationConfig::default(), geometry(&instruments)).unwrap();
    let last = whole.states.last()?;
    let found = [last.accelerometer_bias, last.gyro_bias].concat();
    let std = [last.accelerometer_bias_std, last.gyro_bias_std].concat();
    Some((0..6).map(|i| (found[i] - biases[i]) / std[i]).collect())
}

#[test]
fn biases_are_within_three_standard_errors() {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for input in ["pedal:doublet:0.02:1.0", "pedal:3211:0.02:0.7"] {
        all.extend(over_seeds(seeds(10), |seed| scores(input, seed)).into_iter().flatten());
    }
    if all.is_empty() {
        return;
    }
    let count = all.len() as f64;
    for (i, channel) in INERTIAL.into_iter().enumerate() {
        let mean = all.iter().map(|one| one[i]).sum::<f64>() / count;
        let spread = (all.iter().map(|one| (one[i] - mean) * (one[i] - mean)).sum::<f64>() / count).sqrt();
        let within = all.iter().filter(|one| one[i].abs() < 3.0).count();
        eprintln!("{channel:?}: {within} of {count} within 3 standard errors; mean {mean:+.2}, spread {spread:.2}");
        // Where nothing is wrong 0.3 % are outside. A wrong incidence vane shifts the bias of az by a standard error, after which
        // 3 % are; with 40 flights 4 or more miss the gate, once in 30 were the seeds not fixed.
        assert!(within as f64 >= 0.92 * count, "{channel:?}: {within} of {count}");
    }
    let inside = all.iter().flatten().filter(|score| score.abs() < 3.0).count() as f64 / (6.0 * count);
    eprintln!("all: {:.2} % within 3 standard errors", 100.0 * inside);
    // 0.6 % are outside, as 400 flights measured: of 240 biases six or more miss once in 300, were the seeds not fixed.
    let gate = if count >= 200.0 { 0.99 } else { 0.979 };
    assert!(inside >= gate, "{inside}");
}
