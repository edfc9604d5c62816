//! Wiring errors of channels that hardly move: increments (`coarse`) do not show them, but they feign errors of instruments.
//!
//! Consumes a run and an error found in it; says where a sign turned or two accelerometers exchanged would make that error: by
//! the means of the channels for a bias; for what goes with the motion by putting ax and ay right, fitting the run anew and
//! comparing the evidence, E of `select` (2).

use super::fit::Run;
use super::odd::evidence_alone;
use super::parameter::{INPUT_CHANNELS, OUTPUT_CHANNELS};
use super::select::RIVAL;
use super::series::Series;
use crate::flight::channel::{Channel, ControlNames};

/// Mean of an accelerometer, m/s^2, and of an angle, rad, from which wrong wiring makes a bias.
const MISWIRED_MEAN: f64 = 0.05;
const MISWIRED_ANGLE: f64 = 0.01;

/// Whether ax and ay are under each other's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exchanged {
    /// As recorded they agree better with the rest.
    No,
    /// One does as well as the other.
    Perhaps,
    /// Exchanged they agree better.
    Yes,
}

/// Fits a run as recorded and with ax and ay exchanged.
pub(super) fn exchanged(run: &Run) -> Exchanged {
    let mut other = run.clone();
    other.record.inputs.swap(0, 1);
    match (evidence_alone(run), evidence_alone(&other)) {
        (Some(one), Some(other)) if other < one - RIVAL => Exchanged::Yes,
        (Some(one), Some(other)) if other < one + RIVAL => Exchanged::Perhaps,
        _ => Exchanged::No,
    }
}

/// What wiring would make so large a bias: a channel with its sign turned has twice its mean, ax and ay exchanged the difference
/// of theirs. Of channels that hardly move besides, which no increments show.
pub(super) fn miswired(run: &Run, channel: Channel, bias: f64, std: f64) -> Option<String> {
    let mean = |channel: Channel| {
        let input = INPUT_CHANNELS.iter().position(|one| *one == channel).and_then(|place| run.record.inputs.get(place));
        let output = OUTPUT_CHANNELS.iter().position(|one| *one == channel).and_then(|place| run.record.outputs.get(place));
        input.or(output)?.as_ref().map(Series::average)
    };
    let made = |would: f64| (bias - would).abs() < 3.0 * std && bias.abs() > 5.0 * std;
    let own = mean(channel)?;
    let name = channel.name(ControlNames::Rotorcraft);
    let (least, other) = match channel {
        Channel::Ax => (MISWIRED_MEAN, Some(Channel::Ay)),
        Channel::Ay => (MISWIRED_MEAN, Some(Channel::Ax)),
        Channel::Phi => (MISWIRED_ANGLE, None),
        _ => return None,
    };
    if own.abs() > least && made(2.0 * own) {
        return Some(format!(
            "{name} reads like one with its sign turned: its bias would be twice its mean, which is not told apart"
        ));
    }
    let apart = own - mean(other?)?;
    (apart.abs() > least && made(apart)).then(|| {
        "ax and ay read like each other, exchanged: the bias would be the difference of their means, which is not told apart"
            .to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::super::record::Record;
    use super::super::select::run_of;
    use super::*;
    use crate::flight::run::RunGeometry;
    use crate::telemetry::record::Sample;

    /// ax 0.5, ay 0.1 m/s^2 and phi 0.03 rad on average, hardly moving.
    #[test]
    fn a_bias_that_wrong_wiring_makes_is_said_to_be_that() {
        let samples: Vec<Sample> = (0..400)
            .map(|k| {
                let mut sample = Sample::new(f64::from(k) / 50.0);
                let ripple = 0.01 * libm::sin(0.3 * f64::from(k));
                for (channel, mean) in [(Channel::Ax, 0.5), (Channel::Ay, 0.1), (Channel::Phi, 0.03), (Channel::Theta, 0.1)] {
                    sample.set(channel, mean + ripple);
                }
                for channel in [Channel::Az, Channel::P, Channel::Q, Channel::R] {
                    sample.set(channel, ripple);
                }
                sample.set(Channel::Tas, 50.0 + ripple);
                sample
            })
            .collect();
        let run = run_of(Record::of(&samples, &RunGeometry::DEFAULT));
        let words = |channel, bias| miswired(&run, channel, bias, 0.02);
        assert!(words(Channel::Ax, 1.0).unwrap().contains("sign turned"));
        assert!(
            words(Channel::Ay, -0.4).unwrap().contains("exchanged") && words(Channel::Ax, 0.4).unwrap().contains("exchanged")
        );
        assert!(miswired(&run, Channel::Phi, 0.06, 0.003).unwrap().contains("phi reads like one"));
        // A bias of another size is one, and so is what is no more than noise.
        assert_eq!((words(Channel::Ax, 0.7), words(Channel::Ay, 0.3), words(Channel::Theta, 0.2)), (None, None, None));
        assert_eq!(miswired(&run, Channel::Ay, 0.2, 0.05), None);
    }
}
