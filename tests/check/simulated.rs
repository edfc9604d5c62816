//! Simulated flights of the built-in Puma at 100 kn with instruments of flight-test quality, one error at a time.

use crate::manoeuvre::{LEAD_S, over_seeds, seeds};
use sideslip::estimation::compatibility::verdict::{Candidate, Fitness, Verdict, check};
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::effect::{Effect, PositionedSensor};
use sideslip::flight::effect_file::DeclaredEffect;
use sideslip::flight::run::RunGeometry;
use sideslip::simulation::flight_model::{Asked, FlightModel};
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::Instruments;
use sideslip::simulation::pilot::Pilot;

const KNOT: f64 = 1852.0 / 3600.0;

fn flight() -> Flight {
    let asked = Asked { speed: Some(100.0 * KNOT), set: vec!["perturbation=small".to_owned()], ..Asked::default() };
    let mut flight = FlightModel::puma(&asked).unwrap().flight();
    flight.times_s = uniform_times(0.0, 30.0, 50.0).unwrap();
    for input in ["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.008:0.5:7", "lon_cyclic:3211:0.01:0.7:14"] {
        let spec = InputSpec::parse(input).unwrap();
        for control in Control::ALL.into_iter().filter(|control| control.channel() == spec.channel) {
            let history = &mut flight.inputs.controls[control.index()];
            *history = history.plus(1.0, &spec.deviation(LEAD_S));
        }
    }
    flight.pilot = Some(Pilot::ATTITUDE);
    flight.inputs = flight.inputs.sampled(&flight.times_s);
    flight.instruments = Instruments::flight_quality(1.0);
    // The run's own biases would add to those that are put in.
    flight.instruments.channels.iter_mut().for_each(|instrument| instrument.bias_std = 0.0);
    flight
}

fn checked(flight: &Flight, effects: &[Effect], seed: u64) -> Verdict {
    let flown = Flight { effects: effects.to_vec(), seed, ..flight.clone() }.fly().unwrap();
    let candidate = Candidate { name: "flight".to_owned(), samples: flown.samples, geometry: RunGeometry::default() };
    check(&[candidate]).remove(0)
}

/// The main number of an effect and whether two are of the same instrument and kind.
fn same(a: &Effect, b: &Effect) -> Option<(f64, f64)> {
    match (*a, *b) {
        (Effect::SensorBias { channel: c, value: x }, Effect::SensorBias { channel: d, value: y }) if c == d => Some((x, y)),
        (Effect::SensorScale { channel: c, factor: x }, Effect::SensorScale { channel: d, factor: y }) if c == d => Some((x, y)),
        (Effect::SensorLag { channel: c, tau: x }, Effect::SensorLag { channel: d, tau: y }) if c == d => Some((x, y)),
        (Effect::SensorDelay { channel: c, delay: x }, Effect::SensorDelay { channel: d, delay: y }) if c == d => Some((x, y)),
        (Effect::SensorPosition { sensor: c, offset_m: x }, Effect::SensorPosition { sensor: d, offset_m: y }) if c == d => {
            let axis = (0..3).max_by(|&i, &j| x[i].abs().total_cmp(&x[j].abs()))?;
            Some((x[axis], y[axis]))
        }
        _ => None,
    }
}

fn one_of_each() -> Vec<Effect> {
    use Channel::{Alpha, Ax, Ay, Az, Beta, P, Phi, Psi, Q, R, Tas, Theta};
    let mut all: Vec<Effect> = Vec::new();
    all.extend(
        [(Ax, 0.3), (Ay, 0.3), (Az, -0.3), (P, 0.01), (Q, 0.01), (R, -0.01), (Phi, 0.03), (Alpha, 0.03)]
            .map(|(channel, value)| Effect::SensorBias { channel, value }),
    );
    all.extend(
        [(P, 1.1), (Q, 0.9), (R, 1.1), (R, 1.05), (Ay, 1.15), (Beta, 0.8), (Alpha, 0.9), (Tas, 1.1), (Psi, 1.1), (Theta, 0.9)]
            .map(|(channel, factor)| Effect::SensorScale { channel, factor }),
    );
    all.extend(
        [(P, 0.1), (R, 0.2), (Beta, 0.3), (Phi, 0.2), (Alpha, 0.2), (Psi, 0.2)]
            .map(|(channel, tau)| Effect::SensorLag { channel, tau }),
    );
    all.extend(
        [(P, 0.05), (R, 0.1), (Beta, 0.2), (Phi, 0.1), (Alpha, 0.1), (Psi, 0.1), (Q, 0.1)]
            .map(|(channel, delay)| Effect::SensorDelay { channel, delay }),
    );
    all.extend(
        [[2.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, -3.0]]
            .map(|offset_m| Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m }),
    );
    all.push(Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: [6.0, 0.0, 0.0] });
    all
}

/// Each in some flights: named first or among what fits alike, its size within three standard errors, in nine of ten.
#[test]
fn errors_are_found_and_sized() {
    let flight = flight();
    let each = seeds(2);
    let errors = one_of_each();
    let results = over_seeds(each * errors.len() as u64, |number| {
        let error = &errors[(number / each) as usize];
        let verdict = checked(&flight, std::slice::from_ref(error), 100 + number % each);
        let named = |declared: &DeclaredEffect| {
            let (truth, found) = same(error, &declared.effect)?;
            Some((found - truth).abs() < 3.0 * declared.std?)
        };
        let all = verdict.corrections.iter().flat_map(|one| std::iter::once(&one.effect).chain(&one.alternatives));
        let sized: Vec<bool> = all.filter_map(named).collect();
        (!sized.is_empty(), sized.contains(&true))
    });
    for (place, error) in errors.iter().enumerate() {
        let own = &results[place * each as usize..(place + 1) * each as usize];
        eprintln!(
            "{error:?}: found {}, sized {} of {each}",
            own.iter().filter(|r| r.0).count(),
            own.iter().filter(|r| r.1).count()
        );
    }
    let (found, sized) = (results.iter().filter(|r| r.0).count(), results.iter().filter(|r| r.1).count());
    eprintln!("found {found}, sized {sized} of {}", results.len());
    assert!(found * 100 >= results.len() * 92 && sized * 100 >= results.len() * 88, "{found}, {sized} of {}", results.len());
}

/// Fifty flights (500 by SIDESLIP_SEEDS) with healthy instruments: false findings of a channel in at most 1 %, or one.
#[test]
fn healthy_instruments_are_left_alone() {
    let mut flight = flight();
    flight.instruments = Instruments::flight_quality(1.0);
    let count = seeds(50);
    let verdicts = over_seeds(count, |seed| checked(&flight, &[], seed));
    let false_findings: Vec<String> =
        verdicts.iter().flat_map(|verdict| &verdict.corrections).map(|one| format!("{:?}", one.effect.effect)).collect();
    eprintln!("{} false findings in {count} flights: {false_findings:?}", false_findings.len());
    assert!(verdicts.iter().all(|verdict| verdict.fitness != Fitness::NotFit));
    assert!(false_findings.len() as u64 <= 1 + count / 50, "{false_findings:?}");
}

/// Gusts move vanes and accelerometers alike: nothing may be named, and it is said that nothing can be.
#[test]
fn rough_air_is_said_and_blamed_on_no_instrument() {
    let flight = flight();
    let gusts = [Effect::Turbulence { sigma: 1.0, length: 150.0 }];
    for verdict in over_seeds(6, |seed| checked(&flight, &gusts, seed)) {
        assert!(verdict.corrections.is_empty(), "{verdict:?}");
        assert!(verdict.not_observable.iter().any(|what| what.contains("air is too rough")), "{verdict:?}");
    }
}

/// What a run lacks is the reason why it is not fit.
#[test]
fn runs_that_are_not_fit_say_why() {
    let flight = flight();
    let flown = flight.fly().unwrap();
    let verdict = |samples| check(&[Candidate { name: "cut".to_owned(), samples, geometry: RunGeometry::default() }]).remove(0);
    let short = verdict(flown.samples[..150].to_vec());
    assert!(short.fitness == Fitness::NotFit && short.reason.contains("too short"), "{short:?}");
    let slow = verdict(flown.samples.iter().step_by(10).copied().collect());
    assert!(slow.fitness == Fitness::NotFit && slow.reason.contains("5.0 Hz"), "{slow:?}");
    let mut blind = flown.samples.clone();
    blind.iter_mut().for_each(|sample| sample.clear(Channel::Q));
    let blind = verdict(blind);
    assert!(blind.fitness == Fitness::NotFit && blind.reason.contains("no angular rate q"), "{blind:?}");
    let still = verdict(flown.samples[..80].to_vec());
    assert!(still.fitness == Fitness::NotFit);
}
