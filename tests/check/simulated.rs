//! Healthy instruments, rough air, and runs that are not fit.

use super::flown::{checked, flight};
use crate::support::asked::seeds;
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::flight::run::RunGeometry;
use sideslip::io::outputs::words::instrument_words::{not_observable, verdict_reason};
use sideslip::postflight::reconstruction::verdict::{Fitness, check};
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::simulation::instrument_file::InstrumentFile;

/// Ten flights (500 by SIDESLIP_SEEDS) with healthy instruments: none was named in 500.
#[test]
fn healthy_instruments_are_left_alone() {
    let flight = flight();
    let count = seeds(10);
    let verdicts = over_seeds(count, |seed| checked(&flight, &[], 20_000 + seed));
    let false_findings: Vec<String> =
        verdicts.iter().flat_map(|verdict| &verdict.corrections).map(|one| format!("{:?}", one.effect.effect)).collect();
    eprintln!("{} false findings in {count} flights: {false_findings:?}", false_findings.len());
    assert!(verdicts.iter().all(|verdict| verdict.fitness != Fitness::NotFit));
    assert!(false_findings.len() as u64 <= count / 50, "{false_findings:?}");
}

/// Gusts move vanes and accelerometers alike: nothing may be named, and it is said that nothing can be.
#[test]
fn rough_air_is_said_and_blamed_on_no_instrument() {
    let flight = flight();
    for sigma in [0.3, 0.5, 1.0] {
        let gusts = [Effect::Turbulence { sigma, length: 150.0 }];
        for verdict in over_seeds(seeds(2), |seed| checked(&flight, &gusts, seed)) {
            assert!(verdict.corrections.is_empty() && verdict.fitness == Fitness::Fit, "{sigma} m/s: {verdict:?}");
            let rough = verdict.not_observable.iter().map(not_observable).any(|what| what.contains("air is too rough"));
            assert!(rough || sigma < 0.9, "{sigma} m/s: {verdict:?}");
        }
    }
}

/// Instruments of the flight-test file, whose alpha and beta read 2 % too much, airspeed lags 0.3 s and attitude is 15 ms late,
/// on a shaking airframe with drop-outs: what is named is one of these
/// (nothing is: none of them is large enough for this flight).
#[test]
fn instruments_of_the_flight_test_file() {
    let mut flight = flight();
    let text = include_str!("../../replay/instruments/flight-test.toml");
    flight.instruments = InstrumentFile::parse(text, |_| true).unwrap().applied_to(flight.instruments, 1.0);
    let count = seeds(4);
    let verdicts = over_seeds(count, |seed| checked(&flight, &[], 30_000 + seed));
    let mut named = Vec::new();
    for (one, verdict) in verdicts.iter().flat_map(|verdict| verdict.corrections.iter().map(move |one| (one, verdict))) {
        eprintln!("{:?} or {:?}: {}", one.effect, one.alternatives, verdict.fitness.words());
        let theirs = |effect: &Effect| match *effect {
            Effect::SensorLag { channel, .. } | Effect::SensorDelay { channel, .. } => {
                matches!(channel, Channel::Tas | Channel::Phi | Channel::Theta)
            }
            Effect::SensorScale { channel, .. } | Effect::SensorBias { channel, .. } => {
                matches!(channel, Channel::Alpha | Channel::Beta)
            }
            _ => false,
        };
        named.push(
            std::iter::once(&one.effect)
                .chain(one.alternatives.iter().map(|other| &other.effect))
                .any(|declared| theirs(&declared.effect)),
        );
    }
    let wrong = named.iter().filter(|theirs| !**theirs).count();
    eprintln!("{} findings in {count} flights, {wrong} of them not in the file", named.len());
    assert!(wrong as u64 <= count / 10, "{wrong} of {}", named.len());
}

/// What a run lacks is the reason why it is not fit.
#[test]
fn runs_that_are_not_fit_say_why() {
    let flight = flight();
    let flown = flight.fly().unwrap();
    let run = |samples| RecordedRun { name: "cut".to_owned(), samples, geometry: RunGeometry::default(), screened: false };
    let verdict = |samples| check(&[run(samples)]).remove(0);
    let short = verdict(flown.samples[..150].to_vec());
    assert!(short.fitness == Fitness::NotFit && verdict_reason(&short.reason).contains("too short"), "{short:?}");
    let slow = verdict(flown.samples.iter().step_by(10).copied().collect());
    assert!(slow.fitness == Fitness::NotFit && verdict_reason(&slow.reason).contains("5.0 Hz"), "{slow:?}");
    let mut blind = flown.samples.clone();
    blind.iter_mut().for_each(|sample| sample.clear(Channel::Q));
    let blind = verdict(blind);
    assert!(blind.fitness == Fitness::NotFit && verdict_reason(&blind.reason).contains("no angular rate q"), "{blind:?}");
    let still = verdict(flown.samples[..80].to_vec());
    assert!(still.fitness == Fitness::NotFit);
}
