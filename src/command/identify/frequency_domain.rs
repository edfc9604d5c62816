//! `--domain frequency`: the equations of each run from a band of frequencies, and measured responses beside them.

use crate::command::recordings::run_result::RunResult;
use serde_json::{Value, json};
use sideslip::error::Failure;
use sideslip::flight::setting::check;
use sideslip::io::outputs::charts::chart::{ChartError, Curve, Figure, Panel, figure};
use sideslip::io::outputs::html::page::{escaped, words};
use sideslip::io::outputs::number::Fixed;
use sideslip::io::outputs::tables::terminal::{EstimateTable, Style};
use sideslip::num::frequency_response::FrequencyResponsePoint;
use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::measured_responses::{COHERENT, MeasuredResponse, responses};
use sideslip::postflight::identification::model_variables::ModelVariables;
use sideslip::realtime::pipeline::PipelineConfig;
use sideslip::realtime::regression::frequency::band::{Band, FREQUENCIES};
use std::f64::consts::TAU;
use std::fmt::Write;

/// What the equations of a run are fitted to.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub(super) enum Domain {
    /// Signals over time.
    Time,
    /// Their Fourier transforms in a band.
    Frequency,
}

/// Nothing is forgotten of a record that is over, s.
const NEVER_S: f64 = 1e9;

/// A band as a person writes it.
pub(super) fn band(text: &str) -> Result<Band, String> {
    let wrong = |what: &str| format!("expected LOW:HIGH in Hz, such as 0.1:1.5, {what}, found `{text}`");
    let ends = text.split_once(':').and_then(|(from, to)| Some((from.trim().parse().ok()?, to.trim().parse().ok()?)));
    let Some((from_hz, to_hz)) = ends.filter(|(from, to): &(f64, f64)| from < to && from.is_finite() && to.is_finite()) else {
        return Err(wrong("the lower first"));
    };
    let band = Band { from_hz, to_hz, step_hz: (to_hz - from_hz) / (FREQUENCIES - 1) as f64 };
    check(&band.settings()).map(|()| band).map_err(|error| wrong(&error.to_string()))
}

/// What was asked for: the band, where it is not the domain of time.
pub(super) fn asked(domain: Domain, band: Option<Band>) -> Result<Option<Band>, Failure> {
    match (domain, band) {
        (Domain::Time, None) => Ok(None),
        (Domain::Time, Some(_)) => Err(Failure::Input("--band: expected --domain frequency beside it".to_owned())),
        (Domain::Frequency, band) => Ok(Some(band.unwrap_or_default())),
    }
}

/// A pipeline whose transforms are of the whole record, in that band.
pub(super) fn whole_record(config: &mut PipelineConfig, band: Band) {
    config.regression.band = band;
    config.regression.forgetting_s = NEVER_S;
}

/// What the frequency domain says besides.
pub(super) struct FrequencyDomainResult {
    band: Band,
    responses: Vec<MeasuredResponse>,
}

impl FrequencyDomainResult {
    /// Measures the responses of every state to every input.
    pub(super) fn of(runs: &[Columns], choice: &ModelVariables, band: Band) -> Self {
        FrequencyDomainResult { band, responses: responses(runs, choice, band.from_hz, band.to_hz) }
    }

    /// For a program: which domain, and the responses.
    pub(super) fn put(&self, document: &mut Value) {
        let Band { from_hz, to_hz, .. } = self.band;
        let band = json!({ "from_hz": from_hz, "to_hz": to_hz });
        document["domain"] = json!("frequency");
        document["band"] = band.clone();
        for run in document["runs"].as_array_mut().into_iter().flatten() {
            run["domain"] = json!("frequency");
            run["band"] = band.clone();
        }
        document["frequency_responses"] = self.responses.iter().map(response_json).collect();
    }

    /// For a person: the equations run by run, then a line a response.
    pub(super) fn text(&self, played: &[RunResult], style: Style) -> String {
        let Band { from_hz, to_hz, .. } = self.band;
        let mut text = String::new();
        for run in played {
            let estimates = run.estimates_in_band();
            let heading = format!("{}: equations in the band of {from_hz} to {to_hz} Hz, whole record", estimates.run);
            let (controls, derivatives, modes) = (estimates.controls, estimates.derivatives, estimates.modes);
            let table = EstimateTable { controls, derivatives, modes, excited_until_s: None, events: &[], notes: &[], style };
            let _ = writeln!(text, "{}\n{table}", style.bold(heading));
        }
        let _ = writeln!(text, "{}", style.bold("Measured frequency responses"));
        for response in &self.responses {
            let _ = writeln!(text, "  {}", line(response));
        }
        text
    }

    /// The chart of every run: gain, phase and coherence.
    pub(super) fn section(&self, page: &mut String) -> Result<(), ChartError> {
        for of_run in self.responses.chunk_by(|a, b| a.run == b.run) {
            let Some(first) = of_run.first() else { continue };
            let _ = writeln!(page, "<h2>{}: measured frequency responses</h2>", escaped(&first.run));
            page.push_str("<div class=\"side\">\n");
            let mut inputs: Vec<&str> = Vec::new();
            for response in of_run.iter().filter(|response| response.points.is_ok()) {
                if !inputs.contains(&response.input.as_str()) {
                    inputs.push(&response.input);
                }
            }
            for input in inputs {
                for panel in panels(of_run, input) {
                    let _ = writeln!(page, "{}", figure(&panel, &[], &Figure::OF_A_PAGE)?);
                }
            }
            page.push_str("</div>\n<ul>\n");
            for response in of_run {
                let _ = writeln!(page, "<li>{}.</li>", words(&line(response)));
            }
            page.push_str("</ul>\n");
        }
        Ok(())
    }
}

fn line(response: &MeasuredResponse) -> String {
    let MeasuredResponse { run, output, input, segment_s, together, points } = response;
    let with = together.as_ref().map(|(other, coherence)| {
        format!("; {input} and {other} are correlated (coherence {coherence})", coherence = Fixed(*coherence, 2))
    });
    let with = with.unwrap_or_default();
    let name = format!("{run}: {output}/{input}");
    let points = match points {
        Err(reason) => return format!("{name}  none: {reason}"),
        Ok(points) => points,
    };
    let (Some((from, to)), Some(peak)) = (response.coherent(), response.peak()) else {
        let best = points.iter().map(|point| point.coherence).fold(0.0, f64::max);
        return format!(
            "{name}  coherence {best} at best, below {COHERENT} everywhere: not this input alone, or noise{with}",
            best = Fixed(best, 2)
        );
    };
    let (gain, std) = (peak.response.norm(), peak.std * peak.response.norm());
    let (hz, phase, coherence) = (peak.rad_s / TAU, peak.response.arg().to_degrees(), peak.coherence);
    format!(
        "{name}  coherence {COHERENT} or better from {from} to {to} Hz; largest gain {gain} +- {std} at {hz} Hz, \
         phase {phase} deg, coherence {coherence}; segments of {segment_s} s{with}",
        from = Fixed(from, 2),
        to = Fixed(to, 2),
        gain = Fixed(gain, 4),
        std = Fixed(std, 4),
        hz = Fixed(hz, 2),
        phase = Fixed(phase, 0),
        coherence = Fixed(coherence, 2),
        segment_s = Fixed(*segment_s, 1)
    )
}

fn response_json(response: &MeasuredResponse) -> Value {
    let MeasuredResponse { run, output, input, segment_s, together, points } = response;
    let together = together.as_ref().map(|(other, coherence)| json!({ "input": other, "coherence": coherence }));
    let mut document = json!({ "moves_with": together, "run": run, "output": output, "input": input, "segment_s": segment_s });
    match points {
        Err(reason) => document["reason"] = json!(reason),
        Ok(points) => {
            let all = points.iter().map(|point| {
                json!({ "hz": point.rad_s / TAU, "gain": point.response.norm(), "phase_deg": point.response.arg().to_degrees(),
                        "coherence": point.coherence, "std": point.std })
            });
            document["points"] = all.collect();
        }
    }
    document
}

/// Gain in decibels, phase without jumps, coherence of the responses to one input.
fn panels(of_run: &[MeasuredResponse], input: &str) -> Vec<Panel> {
    let curves = |value: &dyn Fn(&[FrequencyResponsePoint]) -> Vec<f64>| -> Vec<Curve> {
        let of_input = of_run.iter().filter(|response| response.input == input);
        let told = of_input.filter_map(|response| Some((response, response.points.as_ref().ok()?)));
        let curve = |(response, points): (&MeasuredResponse, &Vec<_>)| Curve {
            name: format!("{}/{}", response.output, response.input),
            points: points.iter().map(|point: &FrequencyResponsePoint| point.rad_s / TAU).zip(value(points)).collect(),
        };
        told.map(curve).collect()
    };
    let panel = |title: &str, y: &str, curves: Vec<Curve>| Panel {
        title: format!("{title}, response to {input}"),
        x: "frequency, Hz".to_owned(),
        y: y.to_owned(),
        curves,
    };
    let gains = curves(&|points| points.iter().map(|point| 20.0 * libm::log10(point.response.norm())).collect());
    let phases = curves(&|points| {
        let mut before = f64::NAN;
        let unwrapped = points.iter().map(|point| {
            let mut phase = point.response.arg().to_degrees();
            if before.is_finite() {
                phase += 360.0 * libm::round((before - phase) / 360.0);
            }
            before = phase;
            phase
        });
        unwrapped.collect()
    });
    let coherences = curves(&|points| points.iter().map(|point| point.coherence).collect());
    vec![
        panel("gain", "gain, dB (SI units)", gains),
        panel("phase", "phase, deg", phases),
        panel("coherence", "coherence, 1", coherences),
    ]
}
