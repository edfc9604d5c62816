//! Output error while the flight goes on: nearer the truth than the regression beside it, with honest errors, and repeatable.
//!
//! The long form: `SIDESLIP_SEEDS=32 cargo test --release --test slow recovery::live_output_error -- --nocapture`.

use super::WANTED;
use crate::support::asked::seeds;
use crate::support::manoeuvre::{INPUTS, fly, over_seeds};
use crate::support::puma::puma_100kn;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::live::output_error::LiveOutputError;
use sideslip::live::output_error_config::LiveOutputErrorConfig as LiveConfig;
use sideslip::live::regression_report::RegressionReport;
use sideslip::postflight::output_error::record::{OutputErrorProgress, OutputErrorRecord};
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::realtime::regression::record::DerivativesRecord;
use sideslip::simulation::instrument::InstrumentSet;

/// The last word of both on one flight, and every record of output error on the way.
fn flown(samples: &[Sample], streaming: bool) -> (DerivativesRecord, Vec<OutputErrorRecord>) {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut live = LiveOutputError::new(LiveConfig { streaming, ..LiveConfig::default() }, RunGeometry::default());
    let mut records = Vec::new();
    for sample in samples {
        let tick = pipeline.step(sample);
        live.sample(sample);
        if let Some(derivatives) = &tick.derivatives.clone() {
            records.extend(live.regression_report(&RegressionReport::new(derivatives, pipeline.regression())).cloned());
        }
        if live.is_due() {
            records.push(live.refit().clone());
        }
    }
    live.finish();
    if live.is_due() {
        records.push(live.refit().clone());
    }
    (pipeline.finish().derivatives.clone().unwrap(), records)
}

#[test]
fn live_output_error_is_nearer_the_truth_than_the_regression() {
    let Some(model) = puma_100kn() else { return };
    let count = seeds(8);
    let instruments = InstrumentSet::flight_quality(1.0);
    let all = over_seeds(count, |seed| {
        let (regression, records) = flown(&fly(&model, &INPUTS, &instruments, seed).samples, false);
        let last = records.last().unwrap().clone();
        assert!(
            matches!(last.progress, OutputErrorProgress::Converged | OutputErrorProgress::Converging),
            "{} {}",
            last.progress.name(),
            last.reason
        );
        (regression, last)
    });
    let (mut pooled, mut within) = ([0.0; 2], [0_usize; 2]);
    for (axis, variable) in WANTED {
        let truth = model.derivative(axis, variable);
        let (mut squares, mut scores) = ([0.0; 2], [0.0; 2]);
        for (regression, output_error) in &all {
            let one = regression.equations[axis.index()].term(variable).unwrap();
            let other = output_error.parameter(axis, variable).unwrap();
            for (place, (value, std)) in [(one.value, one.std), (other.value, other.std)].into_iter().enumerate() {
                squares[place] += (value / truth - 1.0).powi(2) / count as f64;
                scores[place] += ((value - truth) / std).powi(2) / count as f64;
                within[place] += usize::from((value - truth).abs() < 3.0 * std);
            }
        }
        for (pooled, squares) in pooled.iter_mut().zip(squares) {
            *pooled += squares / WANTED.len() as f64;
        }
        eprintln!(
            "{}_{}: off by {:.2} % (regression), {:.2} % (output error) rms; spread of z {:.2}, {:.2}",
            axis.name(),
            variable.name(Default::default()),
            100.0 * squares[0].sqrt(),
            100.0 * squares[1].sqrt(),
            scores[0].sqrt(),
            scores[1].sqrt()
        );
    }
    let [regression, output_error] = pooled.map(f64::sqrt);
    let of = count as usize * WANTED.len();
    eprintln!("all: {:.2} %, {:.2} %; within three standard errors {within:?} of {of}", 100.0 * regression, 100.0 * output_error);
    assert!(output_error < regression, "{output_error} {regression}");
    assert!(10 * within[1] >= 9 * of, "{within:?} of {of}");
}

#[test]
fn streaming_says_how_far_it_is_and_the_same_again() {
    let Some(model) = puma_100kn() else { return };
    let samples = fly(&model, &INPUTS[..1], &InstrumentSet::flight_quality(1.0), 1).samples;
    let samples = &samples[..samples.partition_point(|sample| sample.time_s < 9.0)];
    let (_, records) = flown(samples, true);
    let (_, again) = flown(samples, true);
    assert!(records.len() > 5, "{}", records.len());
    // NaN of a record without numbers is equal to none.
    assert_eq!(format!("{records:?}"), format!("{again:?}"));
    for two in records.windows(2) {
        assert!(two[1].time_s > two[0].time_s);
    }
    let last = records.last().unwrap();
    assert!(last.fitted_s > 8.5 && last.dutch_roll.is_some(), "{last:?}");
}
