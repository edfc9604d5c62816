//! What a verdict made of an error that was put in: named alone, named among rivals, missed, and what else was named.

use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::effect::{Effect, PositionedSensor};
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::io::outputs::words::instrument_words::not_observable;
use sideslip::postflight::reconstruction::verdict::RunVerdict;
use std::collections::BTreeMap;

/// Counts over flights.
#[derive(Clone, Debug, Default)]
pub(crate) struct Score {
    /// Flights.
    pub(crate) flights: usize,
    /// True kind and channel, the only explanation.
    pub(crate) named: usize,
    /// True kind and channel beside others that fit alike.
    pub(crate) among_rivals: usize,
    /// Of both, within three standard errors.
    pub(crate) sized: usize,
    /// True name, but told only as a doubt.
    pub(crate) doubted: usize,
    /// Squares of the errors in standard errors, summed over what was found.
    pub(crate) squares: f64,
    /// Nothing of the true name, and it is said that so little could not be told.
    pub(crate) missed_and_said: usize,
    /// Nothing of the true name, nor a word of it.
    pub(crate) missed: usize,
    /// Findings without the truth in them, no rival given.
    pub(crate) wrong: usize,
    /// Findings without the truth in them, rivals given.
    pub(crate) wrong_among_rivals: usize,
    /// What was wrong, in words.
    pub(crate) said: Vec<String>,
}

impl Score {
    /// Two together.
    pub(crate) fn plus(mut self, other: &Score) -> Score {
        self.flights += other.flights;
        self.named += other.named;
        self.among_rivals += other.among_rivals;
        self.sized += other.sized;
        self.doubted += other.doubted;
        self.squares += other.squares;
        self.missed_and_said += other.missed_and_said;
        self.missed += other.missed;
        self.wrong += other.wrong;
        self.wrong_among_rivals += other.wrong_among_rivals;
        self.said.extend(other.said.iter().cloned());
        self
    }

    /// A line.
    pub(crate) fn line(&self) -> String {
        let found = (self.named + self.among_rivals).max(1) as f64;
        format!(
            "{} flights: named {}, among rivals {}, sized {} (rms {:.2} s.e.), doubted {}, missed and said {}, missed {}; \
             wrong {}, wrong among rivals {}",
            self.flights,
            self.named,
            self.among_rivals,
            self.sized,
            (self.squares / found).sqrt(),
            self.doubted,
            self.missed_and_said,
            self.missed,
            self.wrong,
            self.wrong_among_rivals
        )
    }
}

/// The main numbers of two effects, where both are of the same instrument and kind.
fn same(a: &Effect, b: &Effect) -> Option<(f64, f64)> {
    match (*a, *b) {
        (Effect::SensorBias { channel: c, value: x }, Effect::SensorBias { channel: d, value: y }) if c == d => Some((x, y)),
        (Effect::SensorScale { channel: c, factor: x }, Effect::SensorScale { channel: d, factor: y }) if c == d => Some((x, y)),
        (Effect::SensorLag { channel: c, tau: x }, Effect::SensorLag { channel: d, tau: y }) if c == d => Some((x, y)),
        (Effect::SensorDelay { channel: c, delay: x }, Effect::SensorDelay { channel: d, delay: y }) if c == d => Some((x, y)),
        (Effect::SensorPosition { sensor: c, offset_m: x }, Effect::SensorPosition { sensor: d, offset_m: y }) if c == d => {
            let axis = (0..3).max_by(|&i, &j| x[i].abs().total_cmp(&x[j].abs()))?;
            let other = (0..3).max_by(|&i, &j| y[i].abs().total_cmp(&y[j].abs()))?;
            (axis == other).then_some((x[axis], y[axis]))
        }
        _ => None,
    }
}

/// Scores of one error together, told.
pub(crate) fn told(what: &str, scores: &[Score]) -> Score {
    let all = scores.iter().fold(Score::default(), Score::plus);
    eprintln!("{what}: {}", all.line());
    for said in &all.said {
        eprintln!("    {said}");
    }
    all
}

/// The table by kind, told, and all together; of every error as many scores, one after the other.
pub(crate) fn told_by_kind(errors: &[Effect], scores: &[Score]) -> Score {
    let mut kinds: BTreeMap<&str, Score> = BTreeMap::new();
    for (error, scores) in errors.iter().zip(scores.chunks(scores.len() / errors.len())) {
        let one = told(&format!("{error:?}"), scores);
        let sum = kinds.entry(kind(error)).or_default();
        *sum = std::mem::take(sum).plus(&one);
    }
    for (kind, sum) in &kinds {
        eprintln!("== {kind}: {}", sum.line());
    }
    let sum = kinds.values().fold(Score::default(), Score::plus);
    eprintln!("== all: {}", sum.line());
    sum
}

/// The kind of an error, for the table.
fn kind(error: &Effect) -> &'static str {
    match error {
        Effect::SensorBias { .. } => "bias",
        Effect::SensorScale { .. } => "scale",
        Effect::SensorLag { .. } => "lag",
        Effect::SensorDelay { .. } => "skew",
        _ => "place",
    }
}

/// How `not_observable` begins where it speaks of an error, and its size.
fn spoken_of(error: &Effect) -> (String, f64) {
    let name = |channel: Channel| channel.name(ControlNames::Rotorcraft);
    match *error {
        Effect::SensorBias { channel, value } => (format!("{} bias", name(channel)), value.abs()),
        Effect::SensorScale { channel, factor } => (format!("{} scale", name(channel)), (factor - 1.0).abs()),
        Effect::SensorLag { channel, tau } => (format!("{} lag or skew", name(channel)), tau),
        Effect::SensorDelay { channel, delay } => (format!("{} lag or skew", name(channel)), delay.abs()),
        Effect::SensorPosition { sensor, offset_m } => {
            let axis = (0..3).max_by(|&i, &j| offset_m[i].abs().total_cmp(&offset_m[j].abs())).unwrap();
            let sensor = if sensor == PositionedSensor::Vane { "vane" } else { "accelerometer" };
            (format!("{sensor} position {}", ["x", "y", "z"][axis]), offset_m[axis].abs())
        }
        _ => (String::new(), 0.0),
    }
}

/// Whether it is named as what would fit but is in doubt.
fn doubted(verdict: &RunVerdict, error: &Effect) -> bool {
    let (phrase, _) = spoken_of(error);
    verdict.not_observable.iter().map(not_observable).any(|what| what.starts_with(&phrase) && what.contains("would fit"))
}

/// Whether the run says that so small an error could not be told.
fn said(verdict: &RunVerdict, error: &Effect) -> bool {
    let (phrase, size) = spoken_of(error);
    let of_it = |what: &String| what.starts_with(&phrase);
    verdict.not_observable.iter().map(not_observable).filter(of_it).any(|what| match what.split_once("less than ") {
        None => true,
        Some((_, rest)) => {
            rest.split_whitespace().next().and_then(|text| text.parse().ok()).is_some_and(|least: f64| size < least)
        }
    }) || verdict.not_observable.iter().map(not_observable).any(|what| what.contains("the air is too rough"))
}

/// Judges a verdict against the errors that were put in.
pub(crate) fn score(verdict: &RunVerdict, errors: &[Effect]) -> Score {
    let mut score = Score { flights: errors.len(), ..Score::default() };
    let names = |declared: &DeclaredEffect, error: &Effect| -> Option<f64> {
        let (truth, found) = same(error, &declared.effect)?;
        Some(((found - truth) / declared.std?).abs())
    };
    for error in errors {
        let alone = verdict.corrections.iter().find_map(|one| Some((names(&one.effect, error)?, one.alternatives.is_empty())));
        let rival = || verdict.corrections.iter().flat_map(|one| &one.alternatives).find_map(|one| names(&one.effect, error));
        match alone.or_else(|| rival().map(|off| (off, false))) {
            Some((off, only)) => {
                let sized = off < 3.0;
                score.squares += off * off;
                score.named += usize::from(only);
                score.among_rivals += usize::from(!only);
                score.sized += usize::from(sized);
                if !sized {
                    let all = verdict
                        .corrections
                        .iter()
                        .flat_map(|one| std::iter::once(&one.effect).chain(one.alternatives.iter().map(|other| &other.effect)));
                    let them: Vec<String> = all.map(|one| format!("{:?} +- {:.4}", one.effect, one.std.unwrap())).collect();
                    score.said.push(format!("{error:?} not sized: {them:?}"));
                }
            }
            None if doubted(verdict, error) => score.doubted += 1,
            None if said(verdict, error) => score.missed_and_said += 1,
            None => {
                score.missed += 1;
                score.said.push(format!("{error:?} missed without a word"));
            }
        }
    }
    for one in &verdict.corrections {
        let all = || std::iter::once(&one.effect).chain(one.alternatives.iter().map(|other| &other.effect));
        if errors.iter().any(|error| all().any(|declared| names(declared, error).is_some())) {
            continue;
        }
        score.wrong += usize::from(one.alternatives.is_empty());
        score.wrong_among_rivals += usize::from(!one.alternatives.is_empty());
        let others: Vec<String> = one.alternatives.iter().map(|one| format!("{:?}", one.effect.effect)).collect();
        let std = one.effect.std.unwrap();
        score.said.push(format!("{errors:?} gave {:?} +- {std:.4} F {:.0} or {others:?}", one.effect.effect, one.significance));
    }
    score
}
