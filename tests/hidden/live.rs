//! The diagnosis while the flight goes on: a cause is said within a manoeuvre or two, and taken back when it is gone.

use super::case::{Plan, Sort, plan};
use super::flights::fly;
use sideslip::flight::effect::{Effect, Family, same_cause};
use sideslip::live::diagnosis::LiveDiagnosis;
use sideslip::postflight::diagnosis::record::{FindingRecord, FindingStatus};
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};

/// Seed of the case: what is hidden is an error of an instrument.
const SEED: u64 = 5;

/// Flies the runs of a plan one after the other, each excited from a second after its start to its end.
fn follow(live: &mut LiveDiagnosis, plan: &Plan, begin_s: &mut f64, runs: usize) -> Vec<Vec<FindingRecord>> {
    let (fit, _) = fly(plan).unwrap();
    let mut said = Vec::new();
    for run in fit.iter().cycle().take(runs) {
        let mut time_s = *begin_s;
        for sample in &run.samples {
            time_s = *begin_s + sample.time_s;
            let mut sample = *sample;
            sample.time_s = time_s;
            live.sample(&sample);
            live.set_excited(time_s, time_s > *begin_s + 1.0);
            assert!(!live.is_due(), "no look while the manoeuvre goes on");
        }
        live.set_excited(time_s, false);
        assert!(live.is_due());
        said.push(live.run_due());
        *begin_s = time_s + 1.0;
    }
    said
}

#[test]
fn a_cause_is_said_while_it_is_there_and_taken_back_when_it_is_gone() {
    let sick = plan(Sort::Single(Family::Instrument), SEED);
    let hidden = sick.hidden.effects[0];
    let (fit, _) = fly(&sick).unwrap();
    let model = FlightModel::parse(super::case::BASELINE, &FlightRequest::default()).unwrap();
    let every = move |runs: &[_]| Ok((model.clone(), (0..runs.len()).collect()));
    let mut live = LiveDiagnosis::new(Box::new(every), *fit[0].info.geometry());
    let mut begin_s = 0.0;
    let said = follow(&mut live, &sick, &mut begin_s, 2);
    let current = live.current_findings();
    eprintln!("hidden {hidden:?}; after two manoeuvres {current:#?}");
    assert!(said.iter().flatten().any(|one| same_cause(&one.effect, &hidden)), "said after a manoeuvre or two");
    let one = current.iter().find(|one| same_cause(&one.effect, &hidden)).expect("the finding is current");
    let off = one.effect.main_number().unwrap() - hidden.main_number().unwrap();
    assert!(one.standing == FindingStatus::Found && off.abs() < 3.0 * one.std, "{off} of {}", one.std);
    let number = one.number;
    let said = follow(&mut live, &sick.without(), &mut begin_s, 2);
    let back = said.iter().flatten().find(|one| one.number == number && one.standing == FindingStatus::Retracted);
    eprintln!("taken back {back:#?}; at the end {:#?}", live.current_findings());
    assert!(back.is_some_and(|back| back.statement.contains("taken back")));
    let [last] = live.current_findings().try_into().unwrap();
    assert!(last.standing == FindingStatus::Found && last.effect == Effect::None && last.probability > 0.5, "{last:?}");
}
