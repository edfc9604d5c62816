//! From a sample on the bus to its estimate on the bus nothing of ours is allocated once everybody has been found: by the
//! library's parts alone (the program's own path, log included, is held to it in `command/estimate/run.rs`).
//!
//! The middleware itself (iceoryx2 0.10) takes and gives back one small block for each message that is sent, none for one
//! that is received; the test holds it to that.

use super::stage::stage;
use crate::support::allocations::during;
use crate::support::program::puma;
use sideslip::flight::run::RunGeometry;
use sideslip::io::bus::payload::{
    DerivativesPayload, InnovationsPayload, ModesPayload, SAMPLE, SamplePayload, SmoothedPayload, StatePayload,
};
use sideslip::io::bus::service::Bus;
use sideslip::io::telemetry::recording::Recording;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};

/// Samples until both sides have found each other.
const FOUND: u64 = 50;

#[test]
fn nothing_of_ours_is_allocated_between_the_sample_and_the_estimate_on_the_bus() {
    let _turn = crate::alone();
    let root = stage("real-time").join("root");
    let (telemetry, estimator) = (Bus::enter(&root).unwrap(), Bus::enter(&root).unwrap());
    let mut feed = telemetry.publisher::<SamplePayload>().unwrap();
    let mut states_read = telemetry.subscriber::<StatePayload>().unwrap();
    let mut samples = estimator.subscriber::<SamplePayload>().unwrap();
    let mut states = estimator.publisher::<StatePayload>().unwrap();
    let mut smoothed = estimator.publisher::<SmoothedPayload>().unwrap();
    let mut innovations = estimator.publisher::<InnovationsPayload>().unwrap();
    let mut derivatives = estimator.publisher::<DerivativesPayload>().unwrap();
    let mut modes = estimator.publisher::<ModesPayload>().unwrap();
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut recording = Recording::open(&puma()).unwrap();
    let (mut rows, mut read, mut worst) = (0, 0, [0; 3]);
    while let Some(row) = recording.next_row().unwrap() {
        let payload = SamplePayload::new(&row.sample, std::iter::empty(), SAMPLE);
        let sending = during(|| {
            feed.publish(&payload, None).unwrap();
        });
        let estimating = during(|| {
            while let Some(sample) = samples.receive().unwrap() {
                let tick = pipeline.step(&sample.sample());
                let sampled_ns = Some(sample.header.sampled_ns);
                if let Some(state) = &tick.state {
                    states.publish(&state.into(), sampled_ns).unwrap();
                }
                if let Some(lagged) = &tick.smoothed {
                    smoothed.publish(&lagged.into(), sampled_ns).unwrap();
                }
                innovations.publish(&InnovationsPayload::new(sample.header.time_s, &tick.innovations), sampled_ns).unwrap();
                if let (Some(some), Some(others)) = (&tick.derivatives, &tick.modes) {
                    derivatives.publish(&some.into(), sampled_ns).unwrap();
                    modes.publish(&others.into(), sampled_ns).unwrap();
                }
            }
        });
        let reading = during(|| {
            while states_read.receive().unwrap().is_some() {
                read += 1;
            }
        });
        rows += 1;
        if rows > FOUND {
            [sending, estimating, reading].iter().zip(&mut worst).for_each(|(now, worst)| *worst = (*worst).max(*now));
        }
    }
    eprintln!("allocations for one sample, at most: sending {}, estimating {}, reading {}", worst[0], worst[1], worst[2]);
    assert!(read > 1000, "{read}");
    // A block taken and given back counts as two.
    assert_eq!(worst, [2, 5 * 2, 0]);
}
