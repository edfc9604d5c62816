//! Curves of free runs: what was measured and what was predicted, as deviations from trim, and the controls that were moved.

use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::effect::Effect;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::charts::chart::Curve;
use sideslip::postflight::validation::free_run::{FreeRunPrediction, PredictedChannel};

/// The controls that a run has, from their first value, of at most so many points each.
pub(crate) fn controls(samples: &[Sample], names: ControlNames, most: usize) -> Vec<Curve> {
    let one = |channel: Channel| {
        let points: Vec<(f64, f64)> = samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?))).collect();
        let first = points.first()?.1;
        let deviations = points.iter().map(|&(time_s, value)| (time_s, value - first));
        Some(curve(channel.name(names), deviations, points.len(), most))
    };
    Channel::CONTROLS.into_iter().filter_map(one).collect()
}

/// A channel as measured, then as each of the named predictions has it.
pub(crate) fn overlay(measured: &PredictedChannel, predictions: &[(&str, &FreeRunPrediction)], most: usize) -> Vec<Curve> {
    let at_trim = measured.at_trim + measured.offset;
    let deviations = measured.times_s.iter().zip(&measured.measured).map(|(&time_s, z)| (time_s, z - at_trim));
    let mut curves = vec![curve("measured", deviations, measured.times_s.len(), most)];
    for (name, prediction) in predictions {
        let own = prediction.channels.iter().find(|one| one.channel == measured.channel);
        curves.extend(own.map(|own| simulated(name, own, prediction, most)));
    }
    curves
}

/// What was predicted as a deviation from trim; where a bias is at stake, from what was measured in trim.
fn simulated(name: &str, predicted: &PredictedChannel, of: &FreeRunPrediction, most: usize) -> Curve {
    let biased = of.effects.iter().any(|one| matches!(one, Effect::SensorBias { channel, .. } if *channel == predicted.channel));
    let at_trim = predicted.at_trim + if biased { predicted.offset } else { 0.0 };
    let points = predicted.times_s.iter().zip(&predicted.predicted).map(|(&time_s, y)| (time_s, y - at_trim));
    curve(name, points, predicted.times_s.len(), most)
}

/// At most so many points, each the mean of the samples that it stands for: vibration is not taken for motion.
fn curve(name: &str, points: impl Iterator<Item = (f64, f64)>, count: usize, most: usize) -> Curve {
    let points: Vec<(f64, f64)> = points.collect();
    let mean = |some: &[(f64, f64)]| {
        let (x, y) = some.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0, y + point.1));
        (x / some.len() as f64, y / some.len() as f64)
    };
    Curve { name: name.to_owned(), points: points.chunks_exact(count.div_ceil(most).max(1)).map(mean).collect() }
}
