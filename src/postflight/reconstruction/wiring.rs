//! Wiring errors of channels that hardly move: increments (`coarse`) do not show them, but they feign errors of instruments.
//!
//! Consumes a run in which errors of instruments were found; tries a sign turned, and the accelerometers across gravity under
//! each other's names: each is put right and the run fitted with nothing at fault. Where the best of them does as well by
//! evidence (E of `select`, (2)) as what was found in the run as recorded, within [`RIVAL`], the run is not fit; where it does
//! better by [`FAR`], no error of an instrument is reported. Wiring and an error of an instrument at once are not tried: of a
//! channel that hardly moves its sign would then be decided by the colour of the noise. Only where a bias is what wiring would
//! make of the channel's mean is that told beside other errors, unless a run in which the channel does move contradicts it by
//! [`FAR`].

use super::fault_selection::{FaultSearch, RIVAL, run_of, select, with_no_fault};
use super::fit::RunWithNoise;
use super::outlier_runs::single_run_evidence;
use super::record::{WiringError, WiringFinding};
use super::run_channels::RunChannels;
use crate::flight::channel::Channel;
use crate::flight::signal::series::Series;
use crate::num::parallel_map::parallel_map;

/// Channels whose signs are turned in practice, and whose errors others answer for.
const SIGNED: [Channel; 6] = [Channel::Phi, Channel::Theta, Channel::Alpha, Channel::Beta, Channel::Ax, Channel::Ay];

/// Mean of an accelerometer, m/s^2, and of an angle, rad, from which wrong wiring makes a bias.
const MISWIRED_MEAN: f64 = 0.05;
const MISWIRED_ANGLE: f64 = 0.01;

/// Evidence by which wiring must be better for no instrument error to be reported; a bias that turns a mean by chance, with its
/// penalty, makes less.
const FAR: f64 = 30.0;

impl WiringError {
    fn put_right(self, record: &RunChannels) -> RunChannels {
        match self {
            WiringError::Turned(channel) => record.turned(channel),
            WiringError::Exchanged => record.exchanged(),
        }
    }
}

/// What is to be said of a run's wiring.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Miswired {
    pub(crate) finding: WiringFinding,
    /// Whether errors of instruments are ruled out beside it.
    pub(crate) alone: bool,
}

/// The wiring error that explains a run, one of those found together, at least as well as errors of instruments do.
pub(crate) fn wiring(found: &FaultSearch, number: usize) -> Option<Miswired> {
    let run = found.runs.get(number)?;
    let evidence = |found: Option<FaultSearch>| single_run_evidence(&found?);
    let there = |channel: &Channel| run.record.series(*channel).is_some();
    let turned = SIGNED.into_iter().filter(there).map(WiringError::Turned);
    let exchanged = [Channel::Ax, Channel::Ay].iter().all(there).then_some(WiringError::Exchanged);
    let all: Vec<WiringError> = turned.chain(exchanged).collect();
    let tried = parallel_map(&all, |wiring| {
        let other = run_of(wiring.put_right(&run.record));
        Some((evidence(with_no_fault(&other))?, *wiring))
    });
    let (theirs, best) = tried.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))?;
    // Errors of instruments can only do better than none.
    if theirs > evidence(with_no_fault(run))? + RIVAL {
        return None;
    }
    let ours = match found.runs.as_slice() {
        [_] => single_run_evidence(found),
        _ => evidence(select(vec![run.clone()])),
    }?;
    if theirs < ours - FAR {
        Some(Miswired { finding: WiringFinding::Better(best), alone: true })
    } else if theirs < ours + RIVAL {
        Some(Miswired { finding: WiringFinding::AsWell(best), alone: false })
    } else {
        None
    }
}

/// What wiring would make so large a bias in a run, of all runs or its own, where none of those that have it speaks against that.
pub(crate) fn miswired(
    found: &FaultSearch,
    number: usize,
    own: bool,
    channel: Channel,
    (bias, std): (f64, f64),
) -> Option<WiringFinding> {
    let wiring = made_by_wiring(found.runs.get(number)?, channel, bias, std)?;
    let those: Vec<&RunWithNoise> =
        if own { found.runs.iter().skip(number).take(1).collect() } else { found.runs.iter().collect() };
    let contradicted = those.into_iter().any(|run| contradicts(run, wiring).unwrap_or(false));
    (!contradicted).then_some(WiringFinding::MakesBias(wiring, channel))
}

/// Whether a run is explained far better by errors of instruments than by that wiring, whatever errors are reported besides.
fn contradicts(run: &RunWithNoise, wiring: WiringError) -> Option<bool> {
    let evidence = |run: RunWithNoise| single_run_evidence(&select(vec![run])?);
    Some(evidence(run_of(wiring.put_right(&run.record)))? > evidence(run.clone())? + FAR)
}

/// A channel with its sign turned has twice its mean, ax and ay exchanged the difference of theirs: of channels that hardly move
/// besides, which no increments show.
fn made_by_wiring(run: &RunWithNoise, channel: Channel, bias: f64, std: f64) -> Option<WiringError> {
    let mean = |channel: Channel| run.record.series(channel).map(Series::average);
    let made = |would: f64| (bias - would).abs() < 3.0 * std && bias.abs() > 5.0 * std;
    let own = mean(channel)?;
    let (least, other) = match channel {
        Channel::Ax => (MISWIRED_MEAN, Some(Channel::Ay)),
        Channel::Ay => (MISWIRED_MEAN, Some(Channel::Ax)),
        Channel::Phi => (MISWIRED_ANGLE, None),
        _ => return None,
    };
    if own.abs() > least && made(2.0 * own) {
        return Some(WiringError::Turned(channel));
    }
    let apart = own - mean(other?)?;
    (apart.abs() > least && made(apart)).then_some(WiringError::Exchanged)
}

#[cfg(test)]
mod tests {
    use super::super::reconstruction_tests::flown;
    use super::*;
    use crate::flight::run::RunGeometry;
    use crate::flight::sample::Sample;
    use crate::io::outputs::words::instrument_words::wiring_finding;

    #[test]
    fn a_sign_that_is_turned_and_accelerometers_that_are_exchanged_are_known_by_the_whole_fit() {
        let record = flown();
        let wiring = |record: RunChannels| wiring(&select(vec![run_of(record)]).unwrap(), 0);
        assert_eq!(wiring(record.clone()), None);
        for (wrong, words) in [
            (record.exchanged(), "ax and ay under each other's names"),
            (record.turned(Channel::Ay), "ay with its sign reversed"),
            (record.turned(Channel::Theta), "theta with its sign reversed"),
        ] {
            let said = wiring(wrong).unwrap();
            assert!(said.alone && wiring_finding(said.finding).contains(words), "{said:?}");
        }
    }

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
        let run = run_of(RunChannels::of(&samples, &RunGeometry::DEFAULT));
        let words =
            |channel, bias| Some(wiring_finding(WiringFinding::MakesBias(made_by_wiring(&run, channel, bias, 0.02)?, channel)));
        assert!(words(Channel::Ax, 1.0).unwrap().contains("sign reversed"));
        assert!(
            words(Channel::Ay, -0.4).unwrap().contains("exchanged") && words(Channel::Ax, 0.4).unwrap().contains("exchanged")
        );
        let phi = WiringFinding::MakesBias(made_by_wiring(&run, Channel::Phi, 0.06, 0.003).unwrap(), Channel::Phi);
        assert!(wiring_finding(phi).contains("phi reads like one"));
        // A bias of another size is one, and so is what is no more than noise.
        assert_eq!((words(Channel::Ax, 0.7), words(Channel::Ay, 0.3), words(Channel::Theta, 0.2)), (None, None, None));
        assert_eq!(made_by_wiring(&run, Channel::Ay, 0.2, 0.05), None);
    }

    /// Whatever the bias is: ay moves as it should, so that it is neither turned nor ax.
    #[test]
    fn where_a_channel_moves_its_wiring_is_known_beside_a_bias() {
        let mut biased = flown();
        let ay = biased.inputs[1].take().unwrap();
        biased.inputs[1] = Some(Series::of(ay.samples().map(|(time_s, value)| (time_s, value + 0.6))));
        for (record, wiring, wrong) in [
            (biased.clone(), WiringError::Turned(Channel::Ay), true),
            (biased.clone(), WiringError::Exchanged, true),
            (biased.turned(Channel::Ay), WiringError::Turned(Channel::Ay), false),
            (biased.exchanged(), WiringError::Exchanged, false),
        ] {
            assert_eq!(contradicts(&run_of(record), wiring), Some(wrong), "{wiring:?}");
        }
    }
}
