//! One fit of output error beside a flight: at 10 s of record, eight states, from the estimates before and from nothing.

use crate::ledger::{Ledger, group};
use criterion::Criterion;
use sideslip::flight::control::Control;
use sideslip::flight::run::RunGeometry;
use sideslip::live::output_error::LiveOutputError;
use sideslip::live::output_error_config::LiveOutputErrorConfig as LiveConfig;
use sideslip::live::regression_report::RegressionReport;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::simulation::flight_model::{FlightModel, FlightRequest, PUMA};
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;
use std::hint::black_box;

const RATE_HZ: f64 = 100.0;
/// Steady flight before the input, s.
const LEAD_S: f64 = 2.0;

/// Output error just before a fit, after so many seconds of a pedal 3211 and a lateral cyclic one.
fn after(seconds: f64, streaming: bool) -> LiveOutputError {
    let model = FlightModel::parse(PUMA, &FlightRequest::default()).unwrap();
    let times_s = uniform_times(0.0, LEAD_S + seconds, RATE_HZ).unwrap();
    let mut flight = Flight { times_s, instruments: InstrumentSet::flight_quality(1.0), seed: 1, ..model.flight() };
    for input in ["pedal:3211:0.018:0.7", "lat_cyclic:3211:0.008:0.5:5"] {
        let spec = InputSpec::parse(input).unwrap();
        for control in Control::ALL.into_iter().filter(|control| control.channel() == spec.channel) {
            let history = &mut flight.inputs.controls[control.index()];
            *history = history.plus(1.0, &spec.deviation(LEAD_S));
        }
    }
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut live = LiveOutputError::new(LiveConfig { streaming, ..LiveConfig::default() }, RunGeometry::default());
    for sample in &flight.fly().unwrap().samples {
        let tick = pipeline.step(sample);
        live.sample(sample);
        if let Some(derivatives) = &tick.derivatives.clone() {
            let _ = live.regression_report(&RegressionReport::new(derivatives, pipeline.regression()));
        }
        if streaming && live.is_due() {
            live.refit();
        }
    }
    live
}

pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger) {
    let mut group = group(criterion, "live");
    let (warm, cold) = (after(10.0, true), after(10.0, false));
    let mut say = |name: &'static str, live: &LiveOutputError| {
        let mut tried = live.clone();
        let record = tried.refit();
        let (progress, parameters, samples) = (record.progress.name(), record.parameters.len(), record.samples);
        ledger.note(format!("{name}: {progress}, {parameters} derivatives, {samples} samples"));
        ledger.bench(&mut group, name, || {
            let mut live = live.clone();
            black_box(live.refit());
        });
        ledger.tell(name, 1.0, " a fit (500 000 000 is the time from one to the next)");
    };
    say("live output error: from the fit before", &warm);
    say("live output error: from nothing", &cold);
    group.finish();
}
