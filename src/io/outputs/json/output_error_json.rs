//! Output error as a JSON object: the payload of `/output_error`, and `output_error` of `derivatives.json`.

use super::modes_json::RootsJson;
use crate::flight::channel::ControlNames;
use crate::io::outputs::words::status_text::{DerivativeLabel, derivative_unit};
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::modes::record::OscillatoryMode;
use serde::Serialize;

#[derive(Serialize)]
struct ParameterJson {
    name: String,
    value: f64,
    std: f64,
    std_cramer_rao: f64,
    unit: &'static str,
}

#[derive(Serialize)]
struct AllModes {
    #[serde(flatten)]
    roots: RootsJson,
    #[serde(skip_serializing_if = "Option::is_none")]
    short_period: Option<OscillatoryMode>,
}

#[derive(Serialize)]
pub(crate) struct OutputErrorJson {
    time: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    fitted: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    age: Option<f64>,
    status: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    parameters: Vec<ParameterJson>,
    modes: AllModes,
    manoeuvres: u32,
    dropped: u32,
    samples: u32,
}

impl OutputErrorJson {
    /// The record as of that time, s.
    pub(crate) fn at(record: &OutputErrorRecord, controls: ControlNames, time_s: f64) -> Self {
        let parameters = record.parameters.iter().map(|one| ParameterJson {
            name: DerivativeLabel { axis: one.axis, variable: Some(one.variable), controls }.to_string(),
            value: one.value,
            std: one.std,
            std_cramer_rao: one.std_cramer_rao,
            unit: derivative_unit(one.axis, Some(one.variable)),
        });
        let there = |value: f64| value.is_finite().then_some(value);
        let reason = (!record.reason.is_empty()).then(|| record.reason.as_str().to_owned());
        OutputErrorJson {
            time: time_s,
            fitted: there(record.fitted_s),
            age: there(time_s - record.fitted_s).map(|age| age.max(0.0)),
            status: record.progress.name().to_owned(),
            reason,
            parameters: parameters.collect(),
            modes: AllModes { roots: record.into(), short_period: record.short_period },
            manoeuvres: record.manoeuvres,
            dropped: record.dropped,
            samples: record.samples,
        }
    }

    /// The record as of its own time.
    pub(crate) fn new(record: &OutputErrorRecord, controls: ControlNames) -> Self {
        OutputErrorJson::at(record, controls, record.time_s)
    }
}
