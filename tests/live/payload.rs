//! Payloads: every record comes back from its payload as it was, and no foreign bytes bring a reader down.

use crate::support::program::puma;
use sideslip::flight::channel::Channel;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::io::bus::payload::{
    ABSENT, DerivativesPayload, EventPayload, InnovationsPayload, ModesPayload, OTHERS, SAMPLE, SamplePayload, SmoothedPayload,
    StatePayload, StatusBody,
};
use sideslip::io::outputs::record::{EventKind, EventRecord};
use sideslip::io::telemetry::recording::Recording;
use sideslip::realtime::estimation::record::{Aid, EstimationEvent, StateSet};
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig, Tick};
use sideslip::realtime::regression::record::{Reason, RegressionEvent, Status};
use std::fmt::Debug;

/// Every bit but those of a NaN shows in the text.
fn same(one: &impl Debug, other: &impl Debug) {
    assert_eq!(format!("{one:?}"), format!("{other:?}"));
}

fn statuses() -> Vec<Status> {
    let mut all = vec![Status::Waiting, Status::Exciting, Status::Converging, Status::Converged, Status::Stale];
    let reasons = [
        Reason::NoRates,
        Reason::NoAccelerometer { channel: Channel::Ay },
        Reason::NotConfirmed { channel: Channel::Ax },
        Reason::RateTooLow { hz: 2.4, needed_hz: 8.0 },
        Reason::Unobserved { variable: Variable::V, missing: Channel::Beta },
        Reason::Collinear { condition_index: f64::INFINITY },
        Reason::NotExcited { axis: Axis::N, variable: Variable::Pedal },
        Reason::Equation { axis: Axis::L },
        Reason::NoTrim { channel: Channel::Az },
        Reason::AidRejected { channel: Channel::Beta },
        Reason::Unresolved,
        Reason::NoInput,
        Reason::NoControl,
        Reason::InstrumentDoubted { channel: None },
        Reason::InstrumentDoubted { channel: Some(Channel::Tas) },
    ];
    all.extend(reasons.map(Status::NotIdentifiable));
    all
}

fn events() -> Vec<EventKind> {
    let (channel, aid) = (Channel::Rho, Aid::Altitude);
    let estimation = [
        EstimationEvent::NotFinite { channel },
        EstimationEvent::OutOfRange { channel, value: -1e300 },
        EstimationEvent::TimeNotFinite,
        EstimationEvent::DuplicateTime,
        EstimationEvent::TimeWentBack { by_s: 0.25 },
        EstimationEvent::Gap { seconds: 3.0 },
        EstimationEvent::SegmentRestart,
        EstimationEvent::Initialised,
        EstimationEvent::NoAccelerometer { channel },
        EstimationEvent::AidMissing { aid },
        EstimationEvent::AidRejected { aid, test_ratio: 1.5 },
        EstimationEvent::AidAccepted { aid },
        EstimationEvent::KinematicsDisagree { aid, r_squared: 0.965 },
        EstimationEvent::InnovationsTooLarge { aid, mean_nis: 4.0 },
        EstimationEvent::TrimNotSteady { rate_rms: 0.1 },
        EstimationEvent::NumericBreakdown,
        EstimationEvent::RatesSilent { seconds: 0.5 },
        EstimationEvent::StatesChosen {
            set: StateSet { specific_force: [true, false, true], scale_error: [false, true, false] },
        },
        EstimationEvent::LinesNotched { passing_hz: 17.2 },
        EstimationEvent::LineFolded,
    ];
    let mut all: Vec<EventKind> = estimation.map(EventKind::Estimation).to_vec();
    let regression = [
        RegressionEvent::ExcitationBegan,
        RegressionEvent::ExcitationEnded,
        RegressionEvent::SignalMissing { channel },
        RegressionEvent::NoTrim { channel },
    ];
    all.extend(regression.map(EventKind::Regression));
    let changed = |status| EventKind::Regression(RegressionEvent::StatusChanged { axis: Axis::N, status });
    all.extend(statuses().into_iter().map(changed));
    all
}

#[test]
fn every_status_and_every_event_comes_back() {
    let _turn = crate::alone();
    for status in statuses() {
        assert_eq!(StatusBody::from(status).status().unwrap(), status);
    }
    let mut codes = std::collections::BTreeSet::new();
    for kind in events() {
        let record = EventRecord { time_s: -0.0, kind };
        let payload = EventPayload::from(&record);
        codes.insert(payload.code);
        same(&payload.record().unwrap(), &record);
    }
    assert!(codes.into_iter().eq(0..25), "each kind has a code of its own");
}

fn compare(tick: &Tick) -> usize {
    if let Some(state) = &tick.state {
        same(&StatePayload::from(state).record().unwrap(), state);
    }
    if let Some(smoothed) = &tick.smoothed {
        same(&SmoothedPayload::from(smoothed).record(), smoothed);
    }
    if let Some(first) = tick.innovations.first() {
        same(&InnovationsPayload::new(first.time_s, &tick.innovations).records().unwrap(), &tick.innovations);
    }
    if let Some(modes) = &tick.modes {
        same(&ModesPayload::from(modes).record().unwrap(), modes);
    }
    match &tick.derivatives {
        Some(derivatives) => {
            same(&DerivativesPayload::from(derivatives).record().unwrap(), derivatives);
            usize::from(derivatives.lateral.is_some())
        }
        None => 0,
    }
}

#[test]
fn every_record_of_a_flight_comes_back() {
    let _turn = crate::alone();
    let mut recording = Recording::open(&puma()).unwrap();
    let mut pipeline = Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap();
    let mut with_lateral = 0;
    while let Some(row) = recording.next_row().unwrap() {
        let others = [1.5, f64::NAN, -0.0];
        let payload = SamplePayload::new(&row.sample, others.into_iter(), SAMPLE);
        same(&payload.sample(), &row.sample);
        same(&payload.others[..4].to_vec(), &vec![1.5, f64::NAN, -0.0, f64::NAN]);
        with_lateral += compare(pipeline.step(&row.sample));
    }
    with_lateral += compare(pipeline.finish());
    assert!(with_lateral > 100, "{with_lateral}");
}

#[test]
fn bits_stay_even_of_what_is_no_number() {
    let _turn = crate::alone();
    let odd = [f64::from_bits(0x7ff8_0000_dead_beef), f64::from_bits(1), -0.0, f64::NEG_INFINITY];
    let mut sample = Sample::new(odd[0]);
    odd.iter().zip(Channel::ALL).for_each(|(value, channel)| sample.set(channel, *value));
    let payload = SamplePayload::new(&sample, std::iter::repeat_n(odd[0], OTHERS + 5), SAMPLE);
    let back = payload.sample();
    assert_eq!(back.time_s.to_bits(), sample.time_s.to_bits());
    assert_eq!(back.values.map(f64::to_bits), sample.values.map(f64::to_bits));
    assert_eq!(payload.others.map(f64::to_bits), [odd[0].to_bits(); OTHERS]);
}

#[test]
fn codes_that_there_are_not_are_refused_with_the_field() {
    let _turn = crate::alone();
    let refused = |error: String, words: &str| assert!(error.contains(words), "{error}");
    let status = |code, reason, places| StatusBody { code, reason, places, numbers: [0.0; 2] }.status().unwrap_err().to_string();
    refused(status(8, ABSENT, [0; 2]), "sideslip.Status.1: code: expected 0 to 7, found 8");
    refused(status(5, 14, [0; 2]), "reason: expected 0 to 13, found 14");
    refused(status(5, 3, [10, 0]), "variable: expected a place in its table, found 10");
    let event = EventPayload { code: 0, subject: 24, ..EventPayload::default() };
    refused(event.record().unwrap_err().to_string(), "subject");
    refused(EventPayload { code: 27, ..event }.record().unwrap_err().to_string(), "code");
    let mut derivatives = DerivativesPayload::default();
    derivatives.record().unwrap();
    derivatives.equations[0].count = 12;
    refused(derivatives.record().unwrap_err().to_string(), "count");
    derivatives.equations[0].count = 1;
    derivatives.equations[0].terms[0].variable = 10;
    refused(derivatives.record().unwrap_err().to_string(), "variable");
    refused(ModesPayload { present: 32, ..ModesPayload::default() }.record().unwrap_err().to_string(), "present");
    refused(InnovationsPayload { count: 8, ..InnovationsPayload::default() }.records().unwrap_err().to_string(), "count");
    refused(StatePayload { fused: 256, ..StatePayload::default() }.record().unwrap_err().to_string(), "fused");
}
