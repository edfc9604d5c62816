//! Messages as JSON objects: the payload of every topic, and the parts that `derivatives.json` shares with them.
//!
//! `time` (s) is the first key. Numbers have the shortest form that reads back as the same bits; numbers that are not finite are
//! null. Absent values are left out, because the schema readers of viewers do not support nullable objects.

use crate::flight::channel::{Channel, ControlNames};
use crate::flight::file::log_head::{ColumnTarget, LogHead};
use crate::flight::sample::Sample;
use crate::io::outputs::queue::LostMessages;
use crate::io::outputs::record::EventRecord;
use crate::io::outputs::words::event_text::{EventText, event_name, event_severity, event_subject};
use crate::io::outputs::words::status_text::{DerivativeLabel, ReasonText, StatusText, aid_name, derivative_unit};
use crate::realtime::estimation::record::{Innovation, LaggedRecord, StateRecord};
use crate::realtime::regression::record::{DerivativesRecord, EquationRecord, Status, TermRecord};
use core::slice::from_ref;
use serde::ser::{Serialize, SerializeMap, Serializer};

/// A sample as the object of `/sample`: a field for each column that was sampled.
pub(crate) struct SampleJson<'a> {
    pub(crate) sample: &'a Sample,
    pub(crate) unknown: &'a [f64],
    pub(crate) head: &'a LogHead,
    pub(crate) targets: &'a [ColumnTarget],
}

impl Serialize for SampleJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("time", &self.sample.time_s)?;
        let mut beyond_head = self.sample.present;
        for ((name, _), target) in self.head.channels.iter().zip(self.targets) {
            match *target {
                ColumnTarget::Known(channel) => {
                    beyond_head &= !(1 << channel.index());
                    if let Some(value) = self.sample.get(channel) {
                        map.serialize_entry(name, &value)?;
                    }
                }
                ColumnTarget::Unknown(place) => {
                    if let Some(value) = self.unknown.get(place).filter(|value| !value.is_nan()) {
                        map.serialize_entry(name, value)?;
                    }
                }
            }
        }
        if beyond_head != 0 {
            for channel in Channel::ALL {
                if beyond_head & (1 << channel.index()) != 0 {
                    map.serialize_entry(channel.name(self.head.controls), &self.sample.get(channel))?;
                }
            }
        }
        map.end()
    }
}

/// Names, unit, and where the numbers stand in the record.
type StateEntry = (&'static [&'static str], &'static str, fn(&StateRecord) -> &[f64]);

/// Triples and single numbers of a state, in the order in which they are written.
const STATE_ENTRIES: [StateEntry; 16] = [
    (&["u", "v", "w"], "m/s", |s| &s.velocity),
    (&["p", "q", "r"], "rad/s", |s| &s.rates),
    (&["phi", "theta", "psi"], "rad", |s| &s.attitude),
    (&["altitude"], "m", |s| from_ref(&s.altitude)),
    (&["std_u", "std_v", "std_w"], "m/s", |s| &s.velocity_std),
    (&["std_phi", "std_theta", "std_psi"], "rad", |s| &s.attitude_std),
    (&["std_altitude"], "m", |s| from_ref(&s.altitude_std)),
    (&["bias_ax", "bias_ay", "bias_az"], "m/s^2", |s| &s.accelerometer_bias),
    (&["bias_p", "bias_q", "bias_r"], "rad/s", |s| &s.gyro_bias),
    (&["std_bias_ax", "std_bias_ay", "std_bias_az"], "m/s^2", |s| &s.accelerometer_bias_std),
    (&["std_bias_p", "std_bias_q", "std_bias_r"], "rad/s", |s| &s.gyro_bias_std),
    (&["p_dot", "q_dot", "r_dot"], "rad/s^2", |s| &s.angular_acceleration),
    (&["ax", "ay", "az"], "m/s^2", |s| &s.specific_force),
    (&["std_p", "std_q", "std_r"], "rad/s", |s| &s.rates_std),
    (&["std_p_dot", "std_q_dot", "std_r_dot"], "rad/s^2", |s| &s.angular_acceleration_std),
    (&["std_ax", "std_ay", "std_az"], "m/s^2", |s| &s.specific_force_std),
];

/// How many numbers a state has.
const STATE_NUMBERS: usize = 44;

/// The fields of a state with their units, in the order of [`state_values`].
pub(crate) const STATE_FIELDS: [(&str, &str); STATE_NUMBERS] = {
    let mut fields = [("", ""); STATE_NUMBERS];
    let (mut entry, mut field) = (0, 0);
    while entry < STATE_ENTRIES.len() {
        let (names, unit, _) = STATE_ENTRIES[entry];
        let mut name = 0;
        while name < names.len() {
            fields[field] = (names[name], unit);
            (name, field) = (name + 1, field + 1);
        }
        entry += 1;
    }
    assert!(field == STATE_NUMBERS);
    fields
};

/// The numbers of a state, in the order of [`STATE_FIELDS`].
pub(crate) fn state_values(state: &StateRecord) -> [f64; STATE_NUMBERS] {
    let mut values = [f64::NAN; STATE_NUMBERS];
    let numbers = STATE_ENTRIES.iter().flat_map(|(_, _, of)| of(state));
    values.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
    values
}

fn serialize_state<M: SerializeMap>(map: &mut M, state: &StateRecord) -> Result<(), M::Error> {
    map.serialize_entry("time", &state.time_s)?;
    STATE_FIELDS.iter().zip(state_values(state)).try_for_each(|((name, _), value)| map.serialize_entry(name, &value))
}

/// A state as the object of `/state`.
pub(crate) struct StateJson<'a>(pub(crate) &'a StateRecord);

impl Serialize for StateJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        serialize_state(&mut map, self.0)?;
        map.serialize_entry("fused", &self.0.fused)?;
        map.end()
    }
}

/// A smoothed state as the object of `/smoothed`.
pub(crate) struct SmoothedJson<'a>(pub(crate) &'a LaggedRecord);

impl Serialize for SmoothedJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let LaggedRecord { state, lag_s } = self.0;
        let mut map = serializer.serialize_map(None)?;
        serialize_state(&mut map, state)?;
        map.serialize_entry("lag", lag_s)?;
        map.end()
    }
}

/// An innovation as the object of `/innovation`.
#[derive(serde::Serialize)]
pub(crate) struct InnovationJson {
    time: f64,
    aid: &'static str,
    channel: &'static str,
    observation: f64,
    observation_var: f64,
    innovation: f64,
    innovation_var: f64,
    test_ratio: f64,
    fused: bool,
}

impl InnovationJson {
    pub(crate) fn new(record: &Innovation, controls: ControlNames) -> Self {
        InnovationJson {
            time: record.time_s,
            aid: aid_name(record.aid),
            channel: record.aid.channel().name(controls),
            observation: record.observation,
            observation_var: record.observation_var,
            innovation: record.innovation,
            innovation_var: record.innovation_var,
            test_ratio: record.test_ratio,
            fused: record.fused,
        }
    }
}

/// A status as its text, with the reason behind a colon where there is one.
pub(crate) fn status_text(status: Status, controls: ControlNames) -> String {
    StatusText { status, controls }.to_string()
}

/// The reason alone, where there is no number and none to come.
pub(crate) fn reason_text(status: Status, controls: ControlNames) -> Option<String> {
    match status {
        Status::NotIdentifiable(reason) => Some(ReasonText { reason, controls }.to_string()),
        _ => None,
    }
}

#[derive(serde::Serialize)]
pub(crate) struct TermJson {
    name: String,
    value: f64,
    std: f64,
    partial_f: f64,
    std_white: f64,
    partial_f_white: f64,
    step: u8,
    primary: bool,
    unit: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency: Option<FrequencyJson>,
}

/// One equation; without numbers only its status.
#[derive(serde::Serialize)]
pub(crate) struct EquationJson {
    status: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    terms: Vec<TermJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unresolved: Vec<String>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    fit: Option<FitJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    disagreement: Option<DisagreementJson>,
}

/// The term in which the frequency domain disagrees most.
#[derive(serde::Serialize)]
struct DisagreementJson {
    name: String,
    standard_errors: f64,
}

/// A term estimated in the band of frequencies.
#[derive(serde::Serialize)]
struct FrequencyJson {
    value: f64,
    std: f64,
    disagreement: Option<f64>,
}

#[derive(serde::Serialize)]
struct FitJson {
    r2: f64,
    f_total: f64,
    samples: f64,
    residual_std: f64,
    collinearity: f64,
}

impl EquationJson {
    pub(crate) fn new(equation: &EquationRecord, controls: ControlNames) -> Self {
        let axis = equation.axis;
        let term = |term: &TermRecord| TermJson {
            name: DerivativeLabel { axis, variable: term.variable, controls }.to_string(),
            value: term.value,
            std: term.std,
            partial_f: term.partial_f(),
            std_white: term.std_white,
            partial_f_white: term.partial_f_white(),
            step: term.step,
            primary: term.primary,
            unit: derivative_unit(axis, term.variable),
            frequency: term.frequency.map(|second| FrequencyJson {
                value: second.value,
                std: second.std,
                disagreement: term.disagreement(),
            }),
        };
        EquationJson {
            status: status_text(equation.status, controls),
            reason: reason_text(equation.status, controls),
            terms: equation.terms.iter().map(term).collect(),
            unresolved: equation
                .unresolved_variables()
                .map(|variable| DerivativeLabel { axis, variable: Some(variable), controls }.to_string())
                .collect(),
            fit: (!equation.terms.is_empty()).then_some(FitJson {
                r2: equation.r_squared,
                f_total: equation.f_total,
                samples: equation.samples,
                residual_std: equation.residual_std,
                collinearity: equation.condition_index,
            }),
            disagreement: equation.disagreement().map(|(variable, standard_errors)| DisagreementJson {
                name: DerivativeLabel { axis, variable: Some(variable), controls }.to_string(),
                standard_errors,
            }),
        }
    }
}

/// All equations by the letter of their axis.
pub(crate) struct EquationsJson<'a> {
    pub(crate) equations: &'a [EquationRecord],
    pub(crate) controls: ControlNames,
}

impl Serialize for EquationsJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.equations.iter().map(|e| (e.axis.name(), EquationJson::new(e, self.controls))))
    }
}

/// Derivatives as the object of `/derivatives`.
#[derive(serde::Serialize)]
pub(crate) struct DerivativesJson<'a> {
    time: f64,
    excited: bool,
    equations: EquationsJson<'a>,
}

impl<'a> DerivativesJson<'a> {
    pub(crate) fn new(record: &'a DerivativesRecord, controls: ControlNames) -> Self {
        let equations = EquationsJson { equations: &record.equations, controls };
        DerivativesJson { time: record.time_s, excited: record.excited, equations }
    }
}

/// An event as the object of `/event`.
#[derive(serde::Serialize)]
pub(crate) struct EventJson {
    time: f64,
    severity: &'static str,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    subject: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    count: Option<u64>,
    text: String,
}

impl EventJson {
    pub(crate) fn new(event: &EventRecord, controls: ControlNames) -> Self {
        EventJson {
            time: event.time_s,
            severity: event_severity(&event.kind).name(),
            kind: event_name(&event.kind),
            subject: event_subject(&event.kind, controls),
            count: None,
            text: EventText { kind: &event.kind, controls }.to_string(),
        }
    }

    /// Messages that never reached the log because the queue to it was full.
    pub(crate) fn lost(lost: &LostMessages) -> Self {
        let text = format!("{} messages did not reach the log: it could not keep up", lost.count);
        EventJson::loss(lost.time_s, "messages_lost", lost.count, text)
    }

    /// Messages that could not be written.
    pub(crate) fn loss(time: f64, kind: &'static str, count: u64, text: String) -> Self {
        EventJson {
            time,
            severity: crate::io::outputs::words::event_text::Severity::DataLost.name(),
            kind,
            subject: None,
            count: Some(count),
            text,
        }
    }
}
