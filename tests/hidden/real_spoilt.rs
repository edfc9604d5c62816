//! Real flights with one thing spoilt: an instrument biased, scaled, late or turned, a control recorded late, turned or scaled, a
//! derivative of the model changed. The rest is as it was flown, with whatever else the model lacks.
//!
//! Rudder doublet and aileron run of the ATTAS, by the lateral model that output error identifies from both, with the positions
//! of vane and accelerometers as published. Of each fault: whether it stands first, its size in standard errors, and what is
//! relied upon beside it that is not found in the runs as they are.
//!
//!     SIDESLIP_SPOILT=all cargo nextest run --release --test slow --run-ignored all --no-capture -E 'test(real_spoilt)'
//! all of them, or those whose name has that word, such as `Late`.
//! Goals: the fault first in 0.9, its size within three standard errors in 0.9. An instrument may have such an error of its
//! own, so that sizes are of the difference between the fault and the same the other way.

use crate::support::manoeuvre::over_seeds;
use crate::support::program::{ended, folder, path, real, sideslip};
use crate::support::recorded_samples::remaining_samples;
use crate::support::wilson::proportion;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::effect::{Effect, same_cause};
use sideslip::io::telemetry::recording::Recording;
use sideslip::postflight::diagnosis::diagnose::{Diagnosis, Finding, diagnose};
use sideslip::postflight::diagnosis::search::next_cause::SearchSettings;
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use toml::{Table, Value};

use Channel::{Ay, Beta, LatCyclic as Aileron, P, Pedal as Rudder, Phi, R};

/// Probability that a reader relies upon.
const RELIED_UPON: f64 = 0.9;
/// Positions as published, m.
const VANE_M: [f64; 3] = [13.08, -0.01, -0.027];
const ACCELEROMETER_M: [f64; 3] = [-1.01, 0.886, 0.103];

/// What is spoilt.
#[derive(Clone, Copy, Debug)]
enum Fault {
    /// A channel reads so much more, SI.
    Bias(Channel, f64),
    /// A channel reads so many times the truth.
    Factor(Channel, f64),
    /// A channel is so many samples, of 0.04 s, late.
    Late(Channel, usize),
    /// A derivative of the model is so many times its own.
    Model(Axis, Variable, f64),
}
use Fault::{Bias, Factor, Late, Model};

const FAULTS: [Fault; 30] = [
    Bias(R, 0.02),
    Bias(P, 0.02),
    Bias(Ay, 0.4),
    Bias(Phi, 0.04),
    Bias(Beta, 0.02),
    Factor(Beta, 1.2),
    Factor(Beta, 0.8),
    Factor(R, 1.12),
    Factor(P, 1.15),
    Factor(Ay, 1.25),
    Factor(Phi, 1.2),
    Late(Beta, 5),
    Late(R, 5),
    Late(P, 5),
    Late(Ay, 5),
    Late(Phi, 5),
    Factor(Beta, -1.0),
    Factor(R, -1.0),
    Factor(P, -1.0),
    Factor(Ay, -1.0),
    Factor(Phi, -1.0),
    Factor(Aileron, -1.0),
    Factor(Rudder, -1.0),
    Late(Aileron, 5),
    Late(Rudder, 5),
    Factor(Rudder, 1.3),
    Model(Axis::L, Variable::P, 0.6),
    Model(Axis::N, Variable::V, 1.3),
    Model(Axis::N, Variable::R, 0.4),
    Model(Axis::L, Variable::LatCyclic, 0.7),
];

/// Those that run always.
const ALWAYS: [Fault; 2] = [Bias(Phi, 0.04), Factor(Ay, -1.0)];

/// The runs and the model as a file.
struct Flown {
    runs: Vec<RecordedRun>,
    model: String,
}

impl Flown {
    /// `None` where the recordings are absent.
    fn read() -> Option<Flown> {
        let (rudder, aileron) = (real("attas-rud1.csv")?, real("attas-ail1.csv")?);
        let folder = folder("real-spoilt");
        let call = ["identify", path(&rudder), path(&aileron), "--states", "v,p,phi,r", "--inputs", "aileron,rudder"];
        let positions = [format!("vane_position_m={VANE_M:?}"), format!("accelerometer_position_m={ACCELEROMETER_M:?}")];
        let known = ["--set", &positions[0], "--set", &positions[1], "--out", path(&folder)];
        let (status, _, said) = ended(&sideslip(&[&call[..], &["--outputs", "beta,p,phi,r,ay"], &known].concat()));
        assert!(status == 0 || status == 3, "{said}");
        let runs = [rudder, aileron].map(|file| {
            let mut recording = Recording::open(&file).unwrap();
            let mut geometry = *recording.info().geometry();
            geometry.vane_position_m = VANE_M;
            geometry.accelerometer_position_m = ACCELEROMETER_M;
            let samples = remaining_samples(&mut recording);
            RecordedRun { name: path(&file).to_owned(), samples, geometry, screened: false }
        });
        Some(Flown { runs: runs.to_vec(), model: std::fs::read_to_string(folder.join("model.toml")).unwrap() })
    }

    /// What is said of them with that fault, and the effect that it is.
    fn with(&self, fault: Option<Fault>) -> (Result<Diagnosis, String>, Effect) {
        let mut runs = self.runs.clone();
        let mut table: Table = self.model.parse().unwrap();
        let effect = match fault {
            None => Effect::None,
            Some(Bias(channel, value)) => {
                changed(&mut runs, channel, |own, _| own + value);
                Effect::SensorBias { channel, value }
            }
            Some(Factor(channel, factor)) => {
                changed(&mut runs, channel, |own, _| factor * own);
                match Control::ALL.into_iter().find(|control| control.channel() == channel) {
                    // Recorded too large, it does too little.
                    Some(control) => Effect::ControlEffectiveness { control, factor: 1.0 / factor },
                    None => Effect::SensorScale { channel, factor },
                }
            }
            Some(Late(channel, samples)) => {
                changed(&mut runs, channel, |_, before| before(samples));
                Effect::SensorDelay { channel, delay: 0.04 * samples as f64 }
            }
            Some(Model(axis, variable, factor)) => {
                let own = table["derivatives"][axis.name()].as_table_mut().unwrap();
                let key = own.keys().find(|key| variable.name(ControlNames::FixedWing) == *key).unwrap().clone();
                let value = own[&key].as_float().unwrap();
                own.insert(key, Value::Float(factor * value));
                Effect::Derivative { axis, variable, delta: (1.0 - factor) * value }
            }
        };
        let model = FlightModel::parse(&toml::to_string(&table).unwrap(), &FlightRequest::default()).unwrap();
        (diagnose(&model, &runs, &[], &SearchSettings::default()).map_err(|refused| refused.to_string()), effect)
    }
}

/// The channel's readings, each from its own value and those so many samples before, in every run.
fn changed(runs: &mut [RecordedRun], channel: Channel, reading: impl Fn(f64, &dyn Fn(usize) -> f64) -> f64) {
    for run in runs {
        let own: Vec<Option<f64>> = run.samples.iter().map(|sample| sample.get(channel)).collect();
        for (place, sample) in run.samples.iter_mut().enumerate() {
            let before = |samples: usize| own[place.saturating_sub(samples)].unwrap_or(f64::NAN);
            if let Some(value) = own[place] {
                sample.set(channel, reading(value, &before));
            }
        }
    }
}

fn is_cause(one: &Finding) -> bool {
    !matches!(one.cause.effect, Effect::Turbulence { .. })
}

/// What came out of one fault.
struct Scored {
    first: bool,
    /// Error of its size in standard errors.
    size: Option<f64>,
    /// Causes that are relied upon, are not it and are not found without it.
    others: usize,
}

/// Size and standard error of the cause among the findings; of a factor those of its logarithm.
fn size_of(found: &Diagnosis, effect: &Effect) -> Option<(f64, f64)> {
    let one = found.findings.iter().find(|one| same_cause(&one.cause.effect, effect))?;
    let (number, std) = (one.cause.effect.main_number()?, one.cause.std.max(f64::MIN_POSITIVE));
    Some(if is_factor(effect) { (number.abs().ln(), std / number.abs()) } else { (number, std) })
}

fn is_factor(effect: &Effect) -> bool {
    matches!(effect, Effect::SensorScale { .. } | Effect::ControlEffectiveness { .. })
}

/// The same fault the other way.
fn opposite(fault: Fault) -> Option<Fault> {
    match fault {
        Bias(channel, value) => Some(Bias(channel, -value)),
        Factor(channel, factor) if factor > 0.0 => Some(Factor(channel, 1.0 / factor)),
        Model(axis, variable, factor) => Some(Model(axis, variable, 2.0 - factor)),
        Factor(..) | Late(..) => None,
    }
}

/// Error of the size in standard errors. An instrument and a model may have such an error of their own: half the difference to
/// the same fault the other way is looked at, where there is one.
fn size_error(flown: &Flown, fault: Fault, found: &Diagnosis, effect: &Effect) -> Option<f64> {
    let truth = effect.main_number()?;
    let truth = if is_factor(effect) { truth.abs().ln() } else { truth };
    let (size, std) = size_of(found, effect)?;
    let Some(other) = opposite(fault) else { return Some((size - truth) / std) };
    let (other, effect) = flown.with(Some(other));
    let (other, other_std) = size_of(other.as_ref().ok()?, &effect)?;
    Some((0.5 * (size - other) - truth) / (0.5 * std.hypot(other_std)))
}

fn scored(flown: &Flown, fault: Fault, as_flown: &[Effect]) -> Scored {
    let (found, effect) = flown.with(Some(fault));
    let findings = found.as_ref().map(|found| &found.findings[..]).unwrap_or_default();
    let causes: Vec<&Finding> = findings.iter().filter(|one| is_cause(one)).collect();
    let is_it = |one: &Finding| same_cause(&one.cause.effect, &effect);
    let size = found.as_ref().ok().and_then(|found| size_error(flown, fault, found, &effect));
    let known = |one: &Finding| as_flown.iter().any(|there| same_cause(there, &one.cause.effect));
    let is_other = |one: &&&Finding| !is_it(one) && one.cause.probability >= RELIED_UPON && !known(one);
    let others = causes.iter().filter(is_other).count();
    let one = |one: &&Finding| {
        let (cause, share) = (&one.cause, one.error_share);
        format!("{:.2} {:?} +- {:.4}, {share:.2} of the error", cause.probability, cause.effect, cause.std)
    };
    let said: Vec<String> = causes.iter().map(one).collect();
    let rejected = |found: &Diagnosis| {
        found.rejected.iter().map(|one| format!("{:?} {:?}", one.reason, one.finding.cause.effect)).collect::<Vec<_>>()
    };
    let unknown =
        found.as_ref().map_or_else(String::clone, |found| format!("{:?}, rejected {:?}", found.unknown, rejected(found)));
    let first = causes.first().is_some_and(|one| is_it(one));
    eprintln!("{fault:?}: first {first}, size {size:.1?}, {others} others\n    {}\n    unknown {unknown}", said.join("\n    "));
    Scored { first, size, others }
}

/// The causes that are relied upon without any fault.
fn relied_upon(flown: &Flown) -> Vec<Effect> {
    let (found, _) = flown.with(None);
    let found = found.unwrap();
    for one in &found.findings {
        eprintln!("as flown: {:.2} {:?} +- {:.4}", one.cause.probability, one.cause.effect, one.cause.std);
    }
    found.findings.iter().map(|one| one.cause.effect).collect()
}

#[test]
fn a_bias_and_a_turned_sign_stand_first_on_real_flights() {
    let Some(flown) = Flown::read() else { return };
    let all = over_seeds(ALWAYS.len() as u64, |place| scored(&flown, ALWAYS[place as usize], &[]));
    assert!(all.iter().all(|one| one.first && one.size.is_some_and(|size| size.abs() < 3.0)));
}

#[test]
#[ignore = "a study"]
fn real_spoilt_study() {
    let (Ok(asked), Some(flown)) = (std::env::var("SIDESLIP_SPOILT"), Flown::read()) else { return };
    let faults: Vec<Fault> = FAULTS.into_iter().filter(|fault| asked == "all" || format!("{fault:?}").contains(&asked)).collect();
    let as_flown = relied_upon(&flown);
    let all = over_seeds(faults.len() as u64, |place| scored(&flown, faults[place as usize], &as_flown));
    let sizes: Vec<f64> = all.iter().filter_map(|one| one.size).collect();
    eprintln!("the fault first: {}", proportion(all.iter().filter(|one| one.first).count(), all.len()));
    eprintln!("sizes within three standard errors: {}", proportion(sizes.iter().filter(|z| z.abs() < 3.0).count(), sizes.len()));
    eprintln!("others relied upon: in {}", proportion(all.iter().filter(|one| one.others > 0).count(), all.len()));
}
