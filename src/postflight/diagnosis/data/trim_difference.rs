//! Where runs do not begin in the model's trim.
//!
//! Consumes the model's trim and the runs; produces, for each channel that the trim has a number for, the mean over the runs of
//!     d = mean of the first second - trim                                                             (1)
//! and its standard error, from the noise of the channel and its wander within that second, and from the scatter between runs. No
//! run is flown in exactly the model's trim: a difference is a finding of its own, and no cause. Whether a reading is biased
//! instead is for the kinematics to say.

use super::run_data::{ALPHA_OUTPUT, ATTITUDE_OUTPUT, BETA_OUTPUT, OUTPUT_CHANNELS, ROTOR, RunData, TAS_OUTPUT, input_channel};
use crate::flight::channel::Channel;
use crate::flight::control::CONTROLS;
use crate::flight::model::Trim;
use crate::flight::signal::series::Series;
use crate::postflight::diagnosis::record::TrimDifference;

/// Window at a run's start that is its trim, s.
const WINDOW_S: f64 = 1.0;
/// Of every channel of the trim that any run has.
pub fn trim_differences(trim: &Trim, runs: &[RunData]) -> Vec<TrimDifference> {
    let outputs = [
        (ATTITUDE_OUTPUT, trim.phi),
        (ATTITUDE_OUTPUT + 1, trim.theta),
        (TAS_OUTPUT, trim.airspeed()),
        (ALPHA_OUTPUT, trim.incidence()),
        (BETA_OUTPUT, trim.sideslip()),
    ];
    let of_output = outputs.into_iter().filter_map(|(output, at_trim)| {
        let begins = runs.iter().filter_map(|run| begins(run.outputs.get(output)?.as_ref()?, *run.output_noise.get(output)?));
        difference(*OUTPUT_CHANNELS.get(output)?, at_trim, &begins.collect::<Vec<_>>())
    });
    let controls = trim.controls.into_iter().enumerate().take(CONTROLS);
    let inputs = controls.chain(trim.rotor_speed.map(|speed| (ROTOR, speed)));
    let of_input = inputs.filter_map(|(input, at_trim)| {
        let begins = runs.iter().filter_map(|run| begins(run.inputs.get(input)?.as_ref()?, *run.input_noise.get(input)?));
        difference(input_channel(input), at_trim, &begins.collect::<Vec<_>>())
    });
    of_output.chain(of_input).collect()
}

/// A run's beginning: mean over a channel's first second, its standard error, and the noise of a sample.
struct Beginning {
    mean: f64,
    std: f64,
    noise_std: f64,
}

fn begins(series: &Series, noise_std: f64) -> Option<Beginning> {
    let (from_s, _) = series.range_s()?;
    let values: Vec<f64> =
        series.samples().take_while(|(time_s, _)| *time_s <= from_s + WINDOW_S).map(|(_, value)| value).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
    let wander = (variance - noise_std * noise_std).max(0.0);
    let std = libm::sqrt(wander + noise_std * noise_std / count);
    mean.is_finite().then_some(Beginning { mean, std, noise_std })
}

/// (1) over the runs' means and standard errors.
fn difference(channel: Channel, at_trim: f64, begins: &[Beginning]) -> Option<TrimDifference> {
    let count = begins.len() as f64;
    let value = begins.iter().map(|run| run.mean - at_trim).sum::<f64>() / count;
    let within = begins.iter().map(|run| run.std * run.std).sum::<f64>() / (count * count);
    let squares = begins.iter().map(|run| (run.mean - at_trim - value) * (run.mean - at_trim - value)).sum::<f64>();
    let between = if count > 1.0 { squares / (count - 1.0) / count } else { 0.0 };
    let largest = begins.iter().map(|run| libm::fabs(run.mean - at_trim)).fold(0.0, f64::max);
    let noise_std = begins.iter().map(|run| run.noise_std).fold(0.0, f64::max);
    let std = libm::sqrt(within.max(between));
    value.is_finite().then_some(TrimDifference { channel, value, std, largest, noise_std })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(values: impl Iterator<Item = f64>) -> Series {
        Series::of(values.enumerate().map(|(k, value)| (0.02 * k as f64, value)))
    }

    #[test]
    fn a_difference_of_trim_has_the_error_of_noise_of_wander_and_of_the_runs() {
        let still = begins(&line((0..200).map(|k| 0.003 + if k % 2 == 0 { 1e-4 } else { -1e-4 })), 1e-4).unwrap();
        assert!((still.mean - 0.003).abs() < 1e-5 && (still.std - 1e-4 / libm::sqrt(51.0)).abs() < 2e-6);
        let wandering = begins(&line((0..200).map(|k| 0.003 + 0.002 * libm::sin(0.1 * f64::from(k)))), 1e-4).unwrap();
        assert!(wandering.std > 5e-4, "{}", wandering.std);
        let one = difference(Channel::Pedal, 0.001, &[still]).unwrap();
        assert!(one.is_significant() && (one.value - 0.002).abs() < 1e-5 && (one.largest - one.value).abs() < 1e-12);
        let apart =
            difference(Channel::Pedal, 0.0, &[0.004, -0.002].map(|mean| Beginning { mean, std: 1e-5, noise_std: 1e-4 })).unwrap();
        assert!(!apart.is_significant() && (apart.value - 0.001).abs() < 1e-12 && (apart.std - 0.003).abs() < 1e-12);
        assert!((apart.largest - 0.004).abs() < 1e-15);
        assert!(difference(Channel::Pedal, 0.0, &[]).is_none());
    }
}
