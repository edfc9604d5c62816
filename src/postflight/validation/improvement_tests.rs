//! Improvement against closed forms: pooled ratios, intervals of white and coloured errors, what is compared.

use super::free_run::{FreeRunPrediction, PredictedChannel};
use super::improvement::*;
use crate::flight::channel::Channel;
use crate::flight::effect::Effect;
use crate::num::random::NormalNoise;

/// A channel with these errors before and after, at 50 Hz; z = sin t.
fn pair(channel: Channel, errors: [&dyn Fn(f64) -> f64; 2], seconds: f64) -> [FreeRunPrediction; 2] {
    let times_s: Vec<f64> = (0..=(50.0 * seconds) as usize).map(|place| 0.02 * place as f64).collect();
    errors.map(|error| {
        let measured: Vec<f64> = times_s.iter().map(|&time_s| libm::sin(time_s)).collect();
        let predicted = times_s.iter().zip(&measured).map(|(&time_s, z)| z - error(time_s)).collect();
        let one = PredictedChannel {
            channel,
            times_s: times_s.clone(),
            measured,
            predicted,
            offset: 0.0,
            at_trim: 0.0,
            noise_std: 0.1,
        };
        FreeRunPrediction {
            channels: vec![one],
            not_predicted: Vec::new(),
            effects: Vec::new(),
            diverged_at_s: None,
            range_s: [0.0, seconds],
        }
    })
}

#[test]
fn figures_are_those_of_the_closed_form() {
    // Over whole turns: rms of sin is 1/sqrt 2; an error 0.2 sin t leaves 1 - 0.04 of the variance, y = 0.8 sin t.
    let turns = 8.0 * core::f64::consts::PI;
    let [before, after] = pair(Channel::R, [&|t| 0.2 * libm::sin(t), &|t| 0.02 * libm::sin(t)], turns);
    let gain = improvement(&[(&before, &after)]);
    let [one] = gain.channels.as_slice() else { panic!("{gain:?}") };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 2e-3, "{a} is not {b}");
    close(one.rms[0].value, 0.2 * core::f64::consts::FRAC_1_SQRT_2);
    close(one.theil[0].value, 0.2 / 1.8);
    close(one.vaf[0].value, 0.96);
    close(one.vaf[1].value, 1.0 - 0.0004);
    close(one.ratio.value, 0.1);
    // The errors go together, so every draw has the same ratio.
    close(one.ratio.interval[1] - one.ratio.interval[0], 0.0);
    assert_eq!((one.ratio.verdict(), one.samples), (ImprovementVerdict::Gain, before.channels[0].times_s.len()));
    let pooled = gain.pooled.unwrap();
    close(pooled.rms[0].value, 2.0 * core::f64::consts::FRAC_1_SQRT_2);
    assert_eq!(pooled.channels, [Channel::R]);
    assert!(gain.airspeed.is_none() && gain.altitude.is_none());
}

/// Errors that are the other's half a block later: no gain, however many samples there are.
#[test]
fn the_same_error_at_another_time_is_no_gain() {
    let wave = |t: f64| libm::sin(0.7 * t) + libm::sin(1.9 * t + 1.0);
    let [before, after] = pair(Channel::Tas, [&wave, &|t| wave(t + 5.0)], 40.0);
    let gain = improvement(&[(&before, &after)]);
    let ratio = gain.airspeed.unwrap().ratio;
    assert_eq!(ratio.verdict(), ImprovementVerdict::NoGain, "{ratio:?}");
    assert!(ratio.interval[1] - ratio.interval[0] > 0.05, "{ratio:?}");
    assert!(gain.pooled.is_none());
}

/// The interval of an rms of independent errors is that of chi-square: about 1 +- 1.96 / sqrt(2 N).
#[test]
fn the_interval_of_white_errors_is_as_wide_as_it_should_be() {
    let mut noise = NormalNoise::new(5, 0);
    let draws: Vec<f64> = (0..=5000).map(|_| noise.draw()).collect();
    let error = |t: f64| draws[libm::round(t * 50.0) as usize];
    let [before, after] = pair(Channel::P, [&error, &error], 100.0);
    let gain = improvement(&[(&before, &after)]);
    let rms = gain.channels[0].rms[0];
    let wanted = 2.0 * 1.96 * rms.value / libm::sqrt(2.0 * 5001.0);
    let found = rms.interval[1] - rms.interval[0];
    assert!((found / wanted - 1.0).abs() < 0.35, "{found} is not {wanted}");
    assert_eq!(gain.channels[0].ratio.verdict(), ImprovementVerdict::NoGain);
    assert!((gain.channels[0].ratio.value - 1.0).abs() < 1e-15);
}

#[test]
fn both_are_taken_up_to_where_one_diverged_and_a_bias_is_absolute() {
    let [mut before, mut after] = pair(Channel::Phi, [&|_| 0.3, &|_| 0.1], 20.0);
    before.diverged_at_s = Some(10.0);
    after.effects.push(Effect::SensorBias { channel: Channel::Phi, value: 0.2 });
    (before.channels[0].offset, after.channels[0].offset) = (0.3, 0.1);
    let with = improvement(&[(&before, &after)]);
    assert!(with.channels[0].absolute && (with.channels[0].ratio.value - 1.0 / 3.0).abs() < 1e-9);
    assert_eq!(with.channels[0].samples, 501);
    after.effects.clear();
    let without = improvement(&[(&before, &after)]);
    assert!(without.channels[0].rms[0].value < 1e-9 && !without.channels[0].absolute);
}

/// An error that is d at the outset and nothing with the change that is right: E after is E before without d.
#[test]
fn the_expected_ratio_is_that_of_a_change_that_is_right() {
    let (left, wrong) = (|t: f64| libm::sin(40.0 * t), |t: f64| 0.5 * libm::sin(0.7 * t));
    let [before, after] = pair(Channel::R, [&|t| left(t) + wrong(t), &left], 60.0);
    let pooled = improvement(&[(&before, &after)]).pooled.unwrap();
    assert!((pooled.expected_ratio() - pooled.ratio.value).abs() < 0.01, "{} {:?}", pooled.expected_ratio(), pooled.ratio);
    assert!(!pooled.is_not_seen());
    let [before, after] = pair(Channel::R, [&left, &|t| left(t) + 1e-3 * wrong(t)], 60.0);
    let untold = improvement(&[(&before, &after)]).pooled.unwrap();
    assert!(untold.is_not_seen() || untold.ratio.verdict() != ImprovementVerdict::NoGain, "{:?}", untold.ratio);
}
