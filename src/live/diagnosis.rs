//! The diagnosis during a flight: findings reported, updated or retracted at the end of each manoeuvre.
//!
//! In: every sample, whether the aircraft is excited, and a model for what was flown. Out: [`FindingRecord`]s, one for each cause
//! (or `none`, or `unknown`). A cause keeps its number while the same effect on the same axis, control or channel is found; one
//! that the next diagnosis does not find is retracted. Only the newest [`MOST`] manoeuvres are used. Where the newest one is
//! predicted significantly worse with a current cause than without it, the aircraft or its instruments have changed: that cause
//! is retracted, earlier manoeuvres are discarded, and the other causes stay in the model until a later manoeuvre contradicts
//! them. Time is that of the samples, so that a recording gives the same findings at any speed of replay.
//! Refused: what [`crate::postflight::diagnosis::diagnose`] refuses, as a sentence; earlier findings stay.

use super::manoeuvre_buffer::{ManoeuvreBuffer, SegmentLimits};
use crate::flight::channel::ControlNames;
use crate::flight::effect::{Effect, same_cause};
use crate::flight::file::effect_file::DeclaredEffect;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::io::outputs::words::cause_sentence::{statement, unknown};
use crate::postflight::diagnosis::diagnose::{Diagnosis, Finding, diagnose};
use crate::postflight::diagnosis::holdout::holdout_gain::{HoldoutEvidence, held_out};
use crate::postflight::diagnosis::record::{FindingRecord, FindingStatus};
use crate::postflight::diagnosis::search::next_cause::SearchSettings;
use crate::postflight::recorded_run::RecordedRun;
use crate::simulation::flight_model::FlightModel;

/// Largest number of manoeuvres in a diagnosis.
pub const MOST: usize = 4;
/// What is cut out of the stream as a manoeuvre: two to twenty seconds of excitation, with two of trim before.
const LIMITS: SegmentLimits = SegmentLimits { lead_s: 2.0, shortest_s: 2.0, longest_s: 20.0, capacity: 16_384, most: MOST };
/// Change of a number in standard errors, and of a probability, below which a finding is not reported again.
const CHANGED: f64 = 0.05;

/// The model for some manoeuvres, and which of them were flown where it holds, by place; or why there is none.
pub type ModelOf = Box<dyn FnMut(&[RecordedRun]) -> Result<(FlightModel, Vec<usize>), String> + Send>;

/// The diagnosis beside a flight.
pub struct LiveDiagnosis {
    model_of: ModelOf,
    geometry: RunGeometry,
    manoeuvres: ManoeuvreBuffer,
    due: bool,
    /// Current causes from discarded manoeuvres.
    known: Vec<FindingRecord>,
    /// Current findings as last reported, those among them.
    reported: Vec<FindingRecord>,
    numbers: u32,
}

impl LiveDiagnosis {
    /// Before the first sample.
    pub fn new(model_of: ModelOf, geometry: RunGeometry) -> Self {
        LiveDiagnosis {
            model_of,
            geometry,
            manoeuvres: ManoeuvreBuffer::new(LIMITS),
            due: false,
            known: Vec::new(),
            reported: Vec::new(),
            numbers: 0,
        }
    }

    /// A sample as it came.
    pub fn sample(&mut self, sample: &Sample) {
        self.manoeuvres.sample(sample);
    }

    /// Whether the aircraft is excited at that time.
    pub fn set_excited(&mut self, time_s: f64, excited: bool) {
        self.due |= self.manoeuvres.set_excited(time_s, excited).is_some();
    }

    /// Whether a diagnosis is due.
    pub fn is_due(&self) -> bool {
        self.due
    }

    /// The end of the run.
    pub fn finish(&mut self) {
        self.due |= self.manoeuvres.finish().is_some();
    }

    /// Current findings, or one record that nothing has been diagnosed yet.
    pub fn current_findings(&self) -> Vec<FindingRecord> {
        if !self.reported.is_empty() {
            return self.reported.clone();
        }
        let mut record = FindingRecord::EMPTY;
        record.set_statement("no manoeuvre has been flown yet that the model can be compared with");
        vec![record]
    }

    /// Diagnoses the newest manoeuvres; returns findings that are new, changed or retracted.
    pub fn run_due(&mut self) -> Vec<FindingRecord> {
        self.due = false;
        let geometry = self.geometry;
        let recorded = |(place, samples): (usize, &[Sample])| RecordedRun {
            name: format!("manoeuvre {}", place + 1),
            samples: samples.to_vec(),
            geometry,
            screened: false,
        };
        let mut runs: Vec<RecordedRun> = self.manoeuvres.runs().into_iter().enumerate().map(recorded).collect();
        let Some(time_s) = runs.last().and_then(|last| last.samples.last()).map(|last| last.time_s) else { return Vec::new() };
        if let Some(known) = runs.last().and_then(|newest| self.unrefuted_causes(newest)) {
            self.known = known;
            self.manoeuvres.keep_the_newest();
            runs.drain(..runs.len() - 1);
        }
        let known: Vec<DeclaredEffect> = self.known.iter().map(declared).collect();
        let diagnosed = (self.model_of)(&runs).and_then(|(mut model, places)| {
            model.file.effects.extend(known);
            let fit: Vec<RecordedRun> =
                runs.into_iter().enumerate().filter(|(place, _)| places.contains(place)).map(|(_, run)| run).collect();
            let diagnosis = diagnose(&model, &fit, &[], &SearchSettings::default()).map_err(|wrong| wrong.to_string())?;
            let used = fit.len().saturating_sub(diagnosis.set_aside.len());
            Ok(finding_records(&diagnosis, &model, geometry.controls, time_s, used))
        });
        match diagnosed {
            Ok(found) => {
                // `none` is no finding beside a cause.
                let nothing = |one: &FindingRecord| !self.known.is_empty() && one.effect == Effect::None;
                let found = found.into_iter().filter(|one| !nothing(one));
                let all = self.known.iter().cloned().chain(found).collect();
                self.report_changes(all, time_s)
            }
            Err(why) => {
                let mut record = FindingRecord { time_s, standing: FindingStatus::Failed, ..FindingRecord::EMPTY };
                record.set_statement(&why);
                vec![record]
            }
        }
    }

    /// Where a new manoeuvre is predicted worse with a current cause than without it: the other causes.
    fn unrefuted_causes(&mut self, newest: &RecordedRun) -> Option<Vec<FindingRecord>> {
        let stands =
            |one: &&FindingRecord| one.effect.main_number().is_some() && !matches!(one.effect, Effect::Turbulence { .. });
        let reported: Vec<FindingRecord> = self.reported.iter().filter(stands).cloned().collect();
        let causes: Vec<Effect> = reported.iter().map(|one| one.effect).collect();
        let newest = std::slice::from_ref(newest);
        if causes.is_empty() {
            return None;
        }
        let (model, _) = (self.model_of)(newest).ok()?;
        let (ratios, _) = held_out(&model, &causes, newest).ok()?;
        let worse = |own: &Option<HoldoutEvidence>| own.as_ref().is_some_and(|own| own.ratio.is_refuted());
        let others = reported.into_iter().zip(&ratios).filter(|(_, ratio)| !worse(ratio)).map(|(one, _)| one);
        ratios.iter().any(worse).then(|| others.collect())
    }

    /// Numbers the findings by the current ones, and retracts those that were not found again.
    fn report_changes(&mut self, found: Vec<FindingRecord>, time_s: f64) -> Vec<FindingRecord> {
        let mut before = std::mem::take(&mut self.reported);
        let mut said = Vec::new();
        for mut record in found {
            let known = before.iter().position(|one| same_cause(&one.effect, &record.effect));
            let moved = match known.map(|place| before.swap_remove(place)) {
                Some(one) => {
                    record.number = one.number;
                    has_changed(&one, &record)
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
            self.reported.push(record);
        }
        for one in before {
            let mut record = FindingRecord { time_s, standing: FindingStatus::Retracted, ..one };
            let was = record.statement.clone();
            record.set_statement(&format!("taken back, the newest manoeuvres do not show it: {was}"));
            said.insert(0, record);
        }
        said
    }
}

/// Records of a diagnosis: one a cause, or one `none`, or one `unknown`.
fn finding_records(
    diagnosis: &Diagnosis,
    model: &FlightModel,
    naming: ControlNames,
    time_s: f64,
    manoeuvres: usize,
) -> Vec<FindingRecord> {
    let manoeuvres = u32::try_from(manoeuvres).unwrap_or(u32::MAX);
    let blank = FindingRecord { time_s, standing: FindingStatus::Found, manoeuvres, ..FindingRecord::EMPTY };
    if let Some(one) = &diagnosis.unknown {
        let mut record = FindingRecord { effect: Effect::Unknown { axis: one.axis }, ..blank };
        record.set_statement(&unknown(one));
        return vec![record];
    }
    let of_cause = |finding: &Finding| {
        let cause = finding.cause;
        let rivals = u32::try_from(finding.plausible().len().saturating_sub(1)).unwrap_or(u32::MAX);
        let mut record =
            FindingRecord { effect: cause.effect, std: cause.std, probability: cause.probability, rivals, ..blank.clone() };
        record.set_statement(&statement(&cause, model.linear(), naming));
        record
    };
    if diagnosis.findings.is_empty() {
        let mut record = FindingRecord { probability: diagnosis.none.0, ..blank };
        record.set_statement("the model explains what was flown, within its noise and the model's own tolerance");
        return vec![record];
    }
    diagnosis.findings.iter().map(of_cause).collect()
}

fn declared(record: &FindingRecord) -> DeclaredEffect {
    DeclaredEffect { effect: record.effect, std: Some(record.std) }
}

/// Whether the finding has changed by more than [`CHANGED`].
fn has_changed(before: &FindingRecord, now: &FindingRecord) -> bool {
    let apart = |a: f64, b: f64, by: f64| (a - b).abs() > by;
    let number = |record: &FindingRecord| record.effect.main_number().unwrap_or(0.0);
    before.manoeuvres != now.manoeuvres
        || before.rivals != now.rivals
        || apart(number(before), number(now), CHANGED * now.std)
        || apart(before.std, now.std, CHANGED * now.std)
        || apart(before.probability, now.probability, CHANGED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;

    fn found(effect: Effect, std: f64) -> FindingRecord {
        FindingRecord { standing: FindingStatus::Found, effect, std, probability: 0.9, ..FindingRecord::EMPTY }
    }

    #[test]
    fn a_cause_keeps_its_number_and_is_taken_back_where_it_is_not_found_again() {
        let mut live = LiveDiagnosis::new(Box::new(|_| Err("no model".to_owned())), RunGeometry::DEFAULT);
        assert_eq!(live.current_findings()[0].standing, FindingStatus::Waiting);
        let late = |delay| found(Effect::SensorDelay { channel: Channel::R, delay }, 0.01);
        let numbers_and_status = |said: Vec<FindingRecord>| -> Vec<(u32, FindingStatus)> {
            said.into_iter().map(|one| (one.number, one.standing)).collect()
        };
        assert_eq!(
            numbers_and_status(live.report_changes(vec![found(Effect::None, f64::NAN)], 1.0)),
            [(1, FindingStatus::Found)]
        );
        assert_eq!(
            numbers_and_status(live.report_changes(vec![late(0.12)], 2.0)),
            [(1, FindingStatus::Retracted), (2, FindingStatus::Found)]
        );
        assert_eq!(
            numbers_and_status(live.report_changes(vec![late(0.1201)], 3.0)),
            [],
            "a twentieth of its error is nothing new"
        );
        assert_eq!(numbers_and_status(live.report_changes(vec![late(0.13)], 3.0)), [(2, FindingStatus::Found)]);
        let other = found(Effect::SensorDelay { channel: Channel::P, delay: 0.13 }, 0.01);
        assert_eq!(
            numbers_and_status(live.report_changes(vec![other], 4.0)),
            [(2, FindingStatus::Retracted), (3, FindingStatus::Found)]
        );
        assert_eq!(live.current_findings().len(), 1);
    }

    #[test]
    fn without_a_model_the_reason_is_said() {
        let mut live =
            LiveDiagnosis::new(Box::new(|runs| Err(format!("no model for {} runs", runs.len()))), RunGeometry::DEFAULT);
        for k in 0..100 {
            let time_s = 0.1 * f64::from(k);
            live.sample(&Sample::new(time_s));
            live.set_excited(time_s, true);
        }
        assert!(!live.is_due() && live.run_due()[0].statement == "no model for 1 runs");
        live.finish();
        assert!(live.is_due() && live.run_due()[0].standing == FindingStatus::Failed);
    }
}
