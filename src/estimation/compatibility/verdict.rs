//! From parameters to words: corrections, what else they may be, what these runs cannot tell, and whether a run is fit.
//!
//! Consumes runs by name; produces [`Verdict`]s. A run that no fit can use is refused before, and the others go on without it.

use super::agreement::agreement;
use super::alone::Alone;
use super::fit::{Run, parameter_at, place_of};
use super::observable::{absent, doubted, drowned, idle, idled, motion, turned};
use super::parameter::{BIAS, Kind, STANDING, channel_at};
use super::record::Record;
use super::select::{Fault, Found, Name, is_gusty, is_stirred, run_of, select};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::effect::{Effect, PositionedSensor};
use crate::flight::effect_file::DeclaredEffect;
use crate::flight::run::RunGeometry;
use crate::flight::unit::STANDARD_GRAVITY;
use crate::telemetry::record::Sample;

const LENGTH_MIN_S: f64 = 5.0;
const RATE_MIN_HZ: f64 = 8.0;
/// Mean load factors that a run can have.
const LOAD_MIN: f64 = 0.4;
const LOAD_MAX: f64 = 3.0;
/// Standard deviation of the largest angular rate below which nothing moves, rad/s.
const MOTION_MIN: f64 = 0.004;
/// R2 of a flow angle's rate below which a run is not fit even when corrected.
const R2_FIT: f64 = 0.9;
/// R2 below which a flow angle's rate contradicts the kinematics: noise and rough air bring it towards zero, a sign that is wrong
/// far below; and the standard deviation from which an angle moves, rad.
const R2_CONTRARY: f64 = -0.5;
const MOVES_RAD: f64 = 0.01;

/// Standard errors that an error has to exceed in stirred air, where gusts that go with the motion are no noise: flights with
/// healthy instruments in gusts of 0.3 m/s feigned up to eight.
const STIRRED_STDS: f64 = 10.0;

/// A run to be checked.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What it is called.
    pub name: String,
    /// Its samples in order of time.
    pub samples: Vec<Sample>,
    /// Where its instruments are said to stand.
    pub geometry: RunGeometry,
}

/// How a run is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitness {
    /// As it is.
    Fit,
    /// Once the corrections are made.
    FitCorrected,
    /// Not for identification.
    NotFit,
}

impl Fitness {
    /// The words in results.
    pub const fn words(self) -> &'static str {
        match self {
            Fitness::Fit => "fit",
            Fitness::FitCorrected => "fit after corrections",
            Fitness::NotFit => "not fit",
        }
    }
}

/// One instrument's error.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// What it is, with its standard error.
    pub effect: DeclaredEffect,
    /// The one vane that stands elsewhere, where the other does not show it.
    pub vane: Option<Channel>,
    /// F against noise and what is normal.
    pub significance: f64,
    /// What else it may be.
    pub alternatives: Vec<DeclaredEffect>,
    /// What would tell these apart; empty where there is one explanation.
    pub split_by: Vec<&'static str>,
    /// Of the bias of ax or ay: the angle, rad, by which accelerometers that are turned would read so much of gravity.
    pub turned: Option<f64>,
    /// What each run of several says alone: run, value, standard error.
    pub by_run: Vec<(String, f64, f64)>,
}

/// What is to be said of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Its name.
    pub run: String,
    /// Whether it is fit.
    pub fitness: Fitness,
    /// Why.
    pub reason: String,
    /// Its corrections, the most significant first.
    pub corrections: Vec<Correction>,
    /// R2 of incidence and sideslip before and after.
    pub consistency: [Option<(f64, Option<f64>)>; 2],
    /// What cannot be known, a phrase each with its reason.
    pub not_observable: Vec<String>,
}

/// Checks all runs together.
pub fn check(candidates: &[Candidate]) -> Vec<Verdict> {
    let records: Vec<Record> = candidates.iter().map(|one| Record::of(&one.samples, &one.geometry)).collect();
    let refusals: Vec<Option<String>> =
        records.iter().zip(candidates).map(|(record, one)| refusal(record, &one.samples)).collect();
    let usable: Vec<usize> = (0..records.len()).filter(|&place| refusals.get(place).is_some_and(Option::is_none)).collect();
    let runs: Vec<Run> = usable.iter().filter_map(|&place| records.get(place).cloned()).map(run_of).collect();
    let found = if runs.is_empty() { None } else { select(runs) };
    let alone = found.as_ref().map_or(Vec::new(), |found| Alone::each(&found.runs, &found.point));
    let names: Vec<String> = usable.iter().filter_map(|&place| Some(candidates.get(place)?.name.clone())).collect();
    let rows = candidates.iter().zip(&records).zip(refusals).enumerate();
    rows.map(|(place, ((candidate, record), refusal))| {
        let number = usable.iter().position(|&used| used == place);
        match (number, &found) {
            (Some(number), Some(found)) => judged(&candidate.name, found, number, &names, &alone),
            _ => Verdict {
                run: candidate.name.clone(),
                fitness: Fitness::NotFit,
                reason: refusal.unwrap_or_else(|| "the kinematics cannot follow its motion".to_owned()),
                corrections: Vec::new(),
                consistency: [None; 2],
                not_observable: absent(record),
            },
        }
    })
    .collect()
}

/// Why no fit can use a record.
fn refusal(record: &Record, samples: &[Sample]) -> Option<String> {
    let missing: Vec<&str> = (3..6)
        .filter(|&i| record.inputs.get(i).is_none_or(Option::is_none))
        .filter_map(|i| Some(channel_at(i)?.name(ControlNames::Rotorcraft)))
        .collect();
    if !missing.is_empty() {
        return Some(format!("no angular rate {}: nothing else says how the aircraft turns", missing.join(" ")));
    }
    let backwards = samples.windows(2).filter(|pair| matches!(pair, [a, b] if !(b.time_s > a.time_s))).count();
    if backwards * 20 > samples.len() {
        return Some(format!("its clock does not go forward at {backwards} of {} samples", samples.len()));
    }
    if !(record.length_s() >= LENGTH_MIN_S) {
        return Some(format!("too short: {:.1} s, at least {LENGTH_MIN_S:.0} s are needed", record.length_s()));
    }
    if !(record.sample_s * RATE_MIN_HZ < 1.0 + 1e-6) {
        return Some(format!("angular rates at {:.1} Hz: at least {RATE_MIN_HZ:.0} Hz are needed", 1.0 / record.sample_s));
    }
    // Whatever it does meanwhile, on average an aircraft is held up by its own weight.
    let (sum, count) = samples
        .iter()
        .filter_map(|sample| sample.get(Channel::Az))
        .filter(|az| az.is_finite())
        .fold((0.0, 0.0), |(sum, count), az| (sum + az, count + 1.0));
    let load = -sum / count / STANDARD_GRAVITY;
    if count > 0.0 && !(LOAD_MIN..=LOAD_MAX).contains(&load) {
        let found = -load * STANDARD_GRAVITY;
        return Some(format!(
            "az is {found:.2} m/s^2 on average, expected near -9.81 (z points down): its sign or its unit is wrong"
        ));
    }
    if record.outputs.iter().all(Option::is_none) {
        return Some("no attitude and no air data to compare the rates with".to_owned());
    }
    if record.gaps() as f64 > record.length_s() / LENGTH_MIN_S {
        return Some(format!("{} gaps in {:.0} s: no stretch is long enough", record.gaps(), record.length_s()));
    }
    let moved = record.inputs.iter().skip(3).flatten().map(motion);
    let most = moved.fold(0.0, f64::max);
    if most < MOTION_MIN {
        return Some(format!("no excitation: no angular rate moves more than {most:.4} rad/s rms"));
    }
    None
}

/// One run's verdict out of all runs' fit.
fn judged(name: &str, found: &Found, number: usize, names: &[String], alone: &[Option<Alone>]) -> Verdict {
    let Some(run) = found.runs.get(number) else {
        return Verdict {
            run: name.to_owned(),
            fitness: Fitness::NotFit,
            reason: String::new(),
            corrections: Vec::new(),
            consistency: [None; 2],
            not_observable: Vec::new(),
        };
    };
    let mut corrections: Vec<Correction> = Vec::new();
    let mut doubts: Vec<String> = Vec::new();
    for fault in &found.faults {
        let (parameter, own) = parameter_at(fault.name.place);
        if own.is_some_and(|own| own != number) || !run.active.contains(&parameter.index) {
            continue;
        }
        // An axis that hardly moves is blamed only where one that moves would fit as well.
        if let Some(part) = idle(&found.runs, parameter, fault.value)
            && fault.rivals.iter().all(|rival| idle(&found.runs, parameter_at(rival.0.place).0, rival.1).is_some())
        {
            doubts.push(doubted(parameter, &idled(part), fault.value, fault.std));
            continue;
        }
        let others = found.faults.iter().map(|other| parameter_at(other.name.place).0);
        if let Some(reason) = turned(parameter, others) {
            doubts.push(doubted(parameter, &reason, fault.value, fault.std));
            continue;
        }
        let stands_out = fault.value.abs() > STIRRED_STDS * fault.std;
        if parameter.is_feigned_by_gusts() && (is_gusty(run) || is_stirred(run) && !stands_out) {
            doubts.push(doubted(parameter, "the air is too rough in this run", fault.value, fault.std));
            continue;
        }
        let Some((value, std)) = in_run(found, number, fault) else { continue };
        let Some((effect, vane)) = effect_of(fault.name, value) else { continue };
        let alternatives: Vec<DeclaredEffect> = fault
            .rivals
            .iter()
            .filter_map(|&(name, value, std, _)| Some(DeclaredEffect { effect: effect_of(name, value)?.0, std: Some(std) }))
            .collect();
        let by_run = if own.is_none() && parameter.kind != Kind::Bias {
            alone
                .iter()
                .zip(names)
                .filter_map(|(one, name)| one.as_ref()?.says(parameter).map(|(x, std)| (name.clone(), x, std)))
                .collect()
        } else {
            Vec::new()
        };
        let split_by = splits(fault.name, fault.rivals.iter().map(|rival| rival.0));
        let effect = DeclaredEffect { effect, std: Some(std) };
        let as_turned = match effect.effect {
            Effect::SensorBias { channel: Channel::Ax | Channel::Ay, value } => Some(value / STANDARD_GRAVITY),
            _ => None,
        };
        corrections.push(Correction {
            turned: as_turned,
            effect,
            vane,
            significance: fault.significance,
            alternatives,
            split_by,
            by_run,
        });
    }
    corrections.sort_by(|a, b| b.significance.total_cmp(&a.significance));
    let corrections = merged(corrections);
    let before = agreement(&run.record, &super::parameter::Theta::NONE);
    let after = agreement(&run.record, &found.point.theta(number));
    let consistency = [0, 1].map(|angle| before[angle].map(|before| (before, after[angle])));
    let (fitness, reason) = fitness(run, after, corrections.len());
    let mut not_observable = absent(&run.record);
    not_observable.extend(doubts);
    not_observable.extend(drowned(found, number));
    Verdict { run: name.to_owned(), fitness, reason, corrections, consistency, not_observable }
}

/// Whether a run is fit with that many corrections, R2 of incidence and sideslip after them given, and why.
fn fitness(run: &Run, after: [Option<f64>; 2], corrections: usize) -> (Fitness, String) {
    let record = &run.record;
    let contrary = ["alpha", "beta"].into_iter().zip(after).enumerate().find_map(|(place, (angle, after))| {
        let after = after.filter(|after| *after < R2_CONTRARY && spread(record, 1 + place) > MOVES_RAD)?;
        Some((angle, after))
    });
    if let Some((angle, after)) = contrary {
        let what = "a channel with its sign turned or under another's name, damaged samples, or air too rough";
        let reason =
            format!("the rate of {angle} contradicts the accelerometers and gyros (R2 {after:.3}), corrected or not: {what}");
        return (Fitness::NotFit, reason);
    }
    // The angle that hardly moves is moved by what the kinematics do not know, such as the flow in sideslip.
    let (angle, place) = if spread(record, 1) > spread(record, 2) { ("alpha", 0) } else { ("beta", 1) };
    // Either angle's kinematics take the other's; and in rough air neither follows from what is measured.
    let both = [1, 2].into_iter().all(|output| record.outputs.get(output).is_some_and(Option::is_some));
    let rough = is_gusty(run);
    match after[place].filter(|after| *after < R2_FIT && both && !rough) {
        Some(after) => (
            Fitness::NotFit,
            format!("the rate of {angle} does not follow from the accelerometers and gyros (R2 {after:.3}), corrected or not"),
        ),
        None if corrections == 0 => {
            let scope = match (record.velocities, rough) {
                (false, _) => " (attitude and rates only)",
                (true, true) => " (attitude and rates only: the air is too rough for the rest)",
                (true, false) => "",
            };
            (Fitness::Fit, format!("its instruments agree with each other{scope}"))
        }
        None => (Fitness::FitCorrected, format!("{corrections} instrument error(s) found")),
    }
}

/// A fault's value and standard error in one run: a bias that stands over all is there with the run's own, once.
fn in_run(found: &Found, number: usize, fault: &Fault) -> Option<(f64, f64)> {
    let (parameter, _) = parameter_at(fault.name.place);
    let Some(measured) = parameter.measured.filter(|_| parameter.kind == Kind::Bias) else {
        return Some((fault.value, fault.std));
    };
    let (standing, own) = (place_of(number, STANDING + measured), place_of(number, BIAS + measured));
    if !found.point.free.contains(&standing) {
        return Some((fault.value, fault.std));
    }
    let places = [standing, own];
    let minimum = found.local.minimum(&found.point);
    let value = places.iter().map(|&place| minimum.get(place).copied().unwrap_or(0.0)).sum();
    let variance = found.local.colour(&found.runs, &places) * found.local.variance_of(&places);
    (fault.name.place == standing).then_some((value, libm::sqrt(variance)))
}

/// How much an output moves.
fn spread(record: &Record, output: usize) -> f64 {
    record.outputs.get(output).and_then(Option::as_ref).map_or(0.0, motion)
}

/// The effect of that name, and which vane it is where only one.
fn effect_of(name: Name, value: f64) -> Option<(Effect, Option<Channel>)> {
    let (parameter, _) = parameter_at(name.place);
    let along = |axis: usize| core::array::from_fn(|i| if i == axis { value } else { 0.0 });
    let vane = |axis| Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: along(axis) };
    Some(match parameter.kind {
        Kind::Bias => (Effect::SensorBias { channel: parameter.channel()?, value }, None),
        Kind::Scale => (Effect::SensorScale { channel: parameter.channel()?, factor: 1.0 + value }, None),
        Kind::Timing if name.lag => (Effect::SensorLag { channel: parameter.channel()?, tau: value.max(0.0) }, None),
        Kind::Timing => (Effect::SensorDelay { channel: parameter.channel()?, delay: value }, None),
        Kind::VanePlace(axis) => (vane(axis), None),
        Kind::AlphaPlace(axis) => (vane(axis), Some(Channel::Alpha)),
        Kind::BetaPlace(axis) => (vane(axis), Some(Channel::Beta)),
        Kind::AccelerometerPlace(axis) => {
            (Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m: along(axis) }, None)
        }
        Kind::Flow(_) | Kind::Turned(_) => return None,
    })
}

/// Components of one sensor's offset in one correction; its standard error is that of the largest.
fn merged(corrections: Vec<Correction>) -> Vec<Correction> {
    let mut merged: Vec<Correction> = Vec::new();
    for one in corrections {
        let place = |correction: &Correction| match correction.effect.effect {
            Effect::SensorPosition { sensor, offset_m } => Some((sensor, offset_m)),
            _ => None,
        };
        let same = merged.iter_mut().find(|other| {
            other.vane == one.vane && matches!((place(other), place(&one)), (Some((a, _)), Some((b, _))) if a == b)
        });
        match (same, place(&one)) {
            (Some(other), Some((sensor, added))) => {
                let Some((_, mut offset_m)) = place(other) else { continue };
                let largest = |offset: [f64; 3]| offset.iter().fold(0.0f64, |most, part| most.max(part.abs()));
                let std = if largest(added) > largest(offset_m) { one.effect.std } else { other.effect.std };
                offset_m.iter_mut().zip(added).for_each(|(part, more)| *part += more);
                other.effect = DeclaredEffect { effect: Effect::SensorPosition { sensor, offset_m }, std };
                other.alternatives.extend(one.alternatives);
                let split_by = one.split_by.into_iter().filter(|words| !other.split_by.contains(words));
                let split_by: Vec<&'static str> = split_by.collect();
                other.split_by.extend(split_by);
            }
            _ => merged.push(one),
        }
    }
    merged
}

/// What would tell a fault from its rivals.
fn splits(name: Name, rivals: impl Iterator<Item = Name>) -> Vec<&'static str> {
    let kind = |name: Name| parameter_at(name.place).0.kind;
    let is_place =
        |kind: Kind| matches!(kind, Kind::AlphaPlace(_) | Kind::BetaPlace(_) | Kind::VanePlace(_) | Kind::AccelerometerPlace(_));
    let mut said = Vec::new();
    for rival in rivals {
        let words = match (kind(name), kind(rival)) {
            (Kind::Timing, Kind::Timing) if name.place == rival.place => {
                "lag or skew: a sharper input, with edges above 1 Hz (a lag attenuates them, a skew does not)"
            }
            (a, b) if is_place(a) && is_place(b) => {
                "vane or accelerometers: measure the two places; or climbs and banks, which altitude and airspeed feel"
            }
            (a, Kind::Timing) if is_place(a) => "place or lateness: the same input at another speed (an arm reads r/V)",
            (Kind::Timing, b) if is_place(b) => "place or lateness: the same input at another speed (an arm reads r/V)",
            (Kind::Scale, Kind::Scale) => "one factor or another: steady turns against flat sideslips, with the heading measured",
            (Kind::Bias, Kind::Bias) => {
                "one bias or another: the trim of a model, or steady flight at several bank and pitch angles"
            }
            (Kind::Bias, Kind::Scale) | (Kind::Scale, Kind::Bias) => "bias or factor: larger changes of the quantity itself",
            _ => "a larger input on the other axis, or the same one again",
        };
        if !said.contains(&words) {
            said.push(words);
        }
    }
    said
}
