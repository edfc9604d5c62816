//! The diagnosis while the flight goes on: at the end of each manoeuvre the newest of them are held against the model, and what
//! is found is said, refined, or taken back.
//!
//! In: every sample, whether the aircraft is excited, and a model for what was flown. Out: [`FindingRecord`]s, one for each cause
//! (or `none`, or `unknown`). A cause keeps its number while the same effect on the same axis, control or channel is named; one
//! that was said, and that the next look does not name, is taken back. Only the newest [`MOST`] manoeuvres are looked at; and
//! where the newest one, before it is looked at, is predicted worse with a cause that stands than without it, beyond chance,
//! the aircraft or its instruments have changed: that cause is taken back, what was flown before is forgotten, and causes that
//! were not contradicted stand as they did, in the model, until a later manoeuvre contradicts them too.
//! Time is the samples' own, so that a recording gives the same findings however fast it is played.
//! Refused: what [`crate::postflight::diagnosis::diagnose`] refuses, as a sentence; findings before it stand.

use super::manoeuvre_buffer::{ManoeuvreBuffer, SegmentLimits};
use crate::flight::channel::ControlNames;
use crate::flight::effect::{Effect, same_cause};
use crate::flight::file::effect_file::DeclaredEffect;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::io::outputs::words::cause_sentence::{statement, unknown};
use crate::io::outputs::words::set_aside::no_diagnosis;
use crate::postflight::diagnosis::data::run::RecordedRun;
use crate::postflight::diagnosis::diagnose::{Diagnosis, Finding, diagnose, held_out};
use crate::postflight::diagnosis::record::{FindingRecord, Standing};
use crate::postflight::diagnosis::search::next_cause::SearchSettings;
use crate::postflight::validation::improvement::{ImprovementVerdict, IntervalEstimate};
use crate::simulation::flight_model::FlightModel;

/// Manoeuvres that are looked at.
pub const MOST: usize = 4;
/// What is cut out of the stream as a manoeuvre: two to twenty seconds of excitation, with two of trim before.
const LIMITS: SegmentLimits = SegmentLimits { lead_s: 2.0, shortest_s: 2.0, longest_s: 20.0, capacity: 16_384, most: MOST };
/// Numbers that moved by less than this part of their standard error, and probabilities by less, are not said again.
const MOVED: f64 = 0.05;

/// The model for some manoeuvres, and which of them were flown where it holds, by place; or why there is none.
pub type ModelOf = Box<dyn FnMut(&[RecordedRun]) -> Result<(FlightModel, Vec<usize>), String> + Send>;

/// The diagnosis beside a flight.
pub struct LiveDiagnosis {
    model_of: ModelOf,
    geometry: RunGeometry,
    manoeuvres: ManoeuvreBuffer,
    due: bool,
    /// Causes that stand from manoeuvres that were forgotten.
    known: Vec<FindingRecord>,
    /// What stands, as it was last said, those among them.
    told: Vec<FindingRecord>,
    numbers: u32,
}

impl LiveDiagnosis {
    /// Nothing seen yet.
    pub fn new(model_of: ModelOf, geometry: RunGeometry) -> Self {
        LiveDiagnosis {
            model_of,
            geometry,
            manoeuvres: ManoeuvreBuffer::new(LIMITS),
            due: false,
            known: Vec::new(),
            told: Vec::new(),
            numbers: 0,
        }
    }

    /// A sample as it came.
    pub fn sample(&mut self, sample: &Sample) {
        self.manoeuvres.sample(sample);
    }

    /// Whether the aircraft is excited at that time.
    pub fn seen(&mut self, time_s: f64, excited: bool) {
        self.due |= self.manoeuvres.seen(time_s, excited).is_some();
    }

    /// Whether it is time to look.
    pub fn is_due(&self) -> bool {
        self.due
    }

    /// The end of the run.
    pub fn finish(&mut self) {
        self.due |= self.manoeuvres.finish().is_some();
    }

    /// What stands: that nothing has been looked at yet, where that is so.
    pub fn standing(&self) -> Vec<FindingRecord> {
        if !self.told.is_empty() {
            return self.told.clone();
        }
        let mut record = FindingRecord::EMPTY;
        record.say("nothing has been flown yet that could be held against the model");
        vec![record]
    }

    /// Looks at the newest manoeuvres; what is new, what has moved, what is taken back.
    pub fn look(&mut self) -> Vec<FindingRecord> {
        self.due = false;
        let geometry = self.geometry;
        let recorded = |(place, samples): (usize, &[Sample])| RecordedRun {
            name: format!("manoeuvre {}", place + 1),
            samples: samples.to_vec(),
            geometry,
        };
        let mut runs: Vec<RecordedRun> = self.manoeuvres.runs().into_iter().enumerate().map(recorded).collect();
        let Some(time_s) = runs.last().and_then(|last| last.samples.last()).map(|last| last.time_s) else { return Vec::new() };
        if let Some(known) = runs.last().and_then(|newest| self.not_refuted(newest)) {
            self.known = known;
            self.manoeuvres.keep_the_newest();
            runs.drain(..runs.len() - 1);
        }
        let known: Vec<DeclaredEffect> = self.known.iter().map(declared).collect();
        let looked = (self.model_of)(&runs).and_then(|(mut model, places)| {
            model.file.effects.extend(known);
            let fit: Vec<RecordedRun> =
                runs.into_iter().enumerate().filter(|(place, _)| places.contains(place)).map(|(_, run)| run).collect();
            let diagnosis = diagnose(&model, &fit, &[], &SearchSettings::default()).map_err(|wrong| no_diagnosis(&wrong))?;
            let used = fit.len().saturating_sub(diagnosis.set_aside.len());
            Ok(said(&diagnosis, &model, geometry.controls, time_s, used))
        });
        match looked {
            Ok(found) => {
                // That the model explains the rest is no finding beside one.
                let nothing = |one: &FindingRecord| !self.known.is_empty() && one.effect == Effect::None;
                let found = found.into_iter().filter(|one| !nothing(one));
                let all = self.known.iter().cloned().chain(found).collect();
                self.told_of(all, time_s)
            }
            Err(why) => {
                let mut record = FindingRecord { time_s, standing: Standing::Failed, ..FindingRecord::EMPTY };
                record.say(&why);
                vec![record]
            }
        }
    }

    /// Where a manoeuvre that was not looked at yet is predicted worse with a cause that stands than without it: the others.
    fn not_refuted(&mut self, newest: &RecordedRun) -> Option<Vec<FindingRecord>> {
        let stands =
            |one: &&FindingRecord| one.effect.main_number().is_some() && !matches!(one.effect, Effect::Turbulence { .. });
        let told: Vec<FindingRecord> = self.told.iter().filter(stands).cloned().collect();
        let causes: Vec<Effect> = told.iter().map(|one| one.effect).collect();
        let newest = std::slice::from_ref(newest);
        if causes.is_empty() {
            return None;
        }
        let (model, _) = (self.model_of)(newest).ok()?;
        let (ratios, _) = held_out(&model, &causes, newest).ok()?;
        let worse = |ratio: &Option<IntervalEstimate>| {
            ratio.as_ref().is_some_and(|ratio| ratio.verdict() == ImprovementVerdict::Loss && !ratio.is_negligible())
        };
        let others = told.into_iter().zip(&ratios).filter(|(_, ratio)| !worse(ratio)).map(|(one, _)| one);
        ratios.iter().any(worse).then(|| others.collect())
    }

    /// Numbers what was found, by what was told before, and takes back what was not found again.
    fn told_of(&mut self, found: Vec<FindingRecord>, time_s: f64) -> Vec<FindingRecord> {
        let mut before = std::mem::take(&mut self.told);
        let mut said = Vec::new();
        for mut record in found {
            let known = before.iter().position(|one| same_cause(&one.effect, &record.effect));
            let moved = match known.map(|place| before.swap_remove(place)) {
                Some(one) => {
                    record.number = one.number;
                    has_moved(&one, &record)
                }
                None => {
                    self.numbers += 1;
                    record.number = self.numbers;
                    true
                }
            };
            if moved {
                said.push(record.clone());
            }
            self.told.push(record);
        }
        for one in before {
            let mut record = FindingRecord { time_s, standing: Standing::TakenBack, ..one };
            let was = record.statement.clone();
            record.say(&format!("taken back, the newest manoeuvres do not show it: {was}"));
            said.insert(0, record);
        }
        said
    }
}

/// What a diagnosis says: a record a cause, or one that nothing is wrong, or one of what is unknown.
fn said(diagnosis: &Diagnosis, model: &FlightModel, naming: ControlNames, time_s: f64, manoeuvres: usize) -> Vec<FindingRecord> {
    let manoeuvres = u32::try_from(manoeuvres).unwrap_or(u32::MAX);
    let blank = FindingRecord { time_s, standing: Standing::Found, manoeuvres, ..FindingRecord::EMPTY };
    if let Some(one) = &diagnosis.unknown {
        let mut record = FindingRecord { effect: Effect::Unknown { axis: one.axis }, ..blank };
        record.say(&unknown(one));
        return vec![record];
    }
    let of_cause = |finding: &Finding| {
        let cause = finding.cause;
        let rivals = u32::try_from(finding.plausible().len().saturating_sub(1)).unwrap_or(u32::MAX);
        let mut record =
            FindingRecord { effect: cause.effect, std: cause.std, probability: cause.probability, rivals, ..blank.clone() };
        record.say(&statement(&cause, model.linear(), naming));
        record
    };
    if diagnosis.findings.is_empty() {
        let mut record = FindingRecord { probability: diagnosis.none.0, ..blank };
        record.say("the model explains what was flown, within its noise and the model's own tolerance");
        return vec![record];
    }
    diagnosis.findings.iter().map(of_cause).collect()
}

/// A cause as models have it.
fn declared(record: &FindingRecord) -> DeclaredEffect {
    DeclaredEffect { effect: record.effect, std: Some(record.std) }
}

/// Whether there is anything to say anew.
fn has_moved(before: &FindingRecord, now: &FindingRecord) -> bool {
    let apart = |a: f64, b: f64, by: f64| (a - b).abs() > by;
    let number = |record: &FindingRecord| record.effect.main_number().unwrap_or(0.0);
    before.manoeuvres != now.manoeuvres
        || before.rivals != now.rivals
        || apart(number(before), number(now), MOVED * now.std)
        || apart(before.std, now.std, MOVED * now.std)
        || apart(before.probability, now.probability, MOVED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;

    fn found(effect: Effect, std: f64) -> FindingRecord {
        FindingRecord { standing: Standing::Found, effect, std, probability: 0.9, ..FindingRecord::EMPTY }
    }

    #[test]
    fn a_cause_keeps_its_number_and_is_taken_back_where_it_is_not_found_again() {
        let mut live = LiveDiagnosis::new(Box::new(|_| Err("no model".to_owned())), RunGeometry::DEFAULT);
        assert_eq!(live.standing()[0].standing, Standing::Waiting);
        let late = |delay| found(Effect::SensorDelay { channel: Channel::R, delay }, 0.01);
        let heard = |said: Vec<FindingRecord>| -> Vec<(u32, Standing)> {
            said.into_iter().map(|one| (one.number, one.standing)).collect()
        };
        assert_eq!(heard(live.told_of(vec![found(Effect::None, f64::NAN)], 1.0)), [(1, Standing::Found)]);
        assert_eq!(heard(live.told_of(vec![late(0.12)], 2.0)), [(1, Standing::TakenBack), (2, Standing::Found)]);
        assert_eq!(heard(live.told_of(vec![late(0.1201)], 3.0)), [], "a twentieth of its error is nothing new");
        assert_eq!(heard(live.told_of(vec![late(0.13)], 3.0)), [(2, Standing::Found)]);
        let other = found(Effect::SensorDelay { channel: Channel::P, delay: 0.13 }, 0.01);
        assert_eq!(heard(live.told_of(vec![other], 4.0)), [(2, Standing::TakenBack), (3, Standing::Found)]);
        assert_eq!(live.standing().len(), 1);
    }

    #[test]
    fn without_a_model_the_reason_is_said() {
        let mut live =
            LiveDiagnosis::new(Box::new(|runs| Err(format!("no model for {} runs", runs.len()))), RunGeometry::DEFAULT);
        for k in 0..100 {
            let time_s = 0.1 * f64::from(k);
            live.sample(&Sample::new(time_s));
            live.seen(time_s, true);
        }
        assert!(!live.is_due() && live.look()[0].statement == "no model for 1 runs");
        live.finish();
        assert!(live.is_due() && live.look()[0].standing == Standing::Failed);
    }
}
