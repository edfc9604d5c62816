//! The linear Puma telemetered as MAVLink: through frames and back, the derivatives are within three standard errors.
//!
//! What the messages cost: single precision, milliseconds of attitude, and pulses of whole microseconds, 0.35 mrad of
//! control. Gate as without MAVLink: 95 % of the seeds for each quantity.

use super::WANTED;
use crate::support::asked::seeds;
use crate::support::manoeuvre::{INPUTS, fly, over_seeds};
use crate::support::puma::puma_100kn;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig as Mapping;
use sideslip::io::telemetry::mavlink::packet::{Framer, Framing};
use sideslip::io::telemetry::mavlink::stream::VehicleStream;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::simulation::instrument::InstrumentSet;

/// The samples as they come out of the frames that they went into.
fn telemetered(samples: &[Sample]) -> Vec<Sample> {
    let mut encoder = Encoder::new(ME, Mapping::default(), ControlNames::Rotorcraft);
    let mut framer = Framer::new(Framing::Bare);
    let mut stream = VehicleStream::new(Mapping::default(), None);
    let mut received = Vec::new();
    for sample in samples {
        encoder
            .sample(sample, |frame| {
                assert_eq!(framer.take(frame), frame.len());
                while let Some(packet) = framer.next_packet() {
                    stream.packet(&packet, None);
                }
            })
            .unwrap();
        received.extend(std::iter::from_fn(|| stream.next_sample()).map(|timed| timed.sample));
    }
    stream.flush();
    received.extend(std::iter::from_fn(|| stream.next_sample()).map(|timed| timed.sample));
    received
}

#[test]
fn every_channel_comes_back_within_the_resolution_of_its_message() {
    let Some(model) = puma_100kn() else { return };
    let sent = fly(&model, &INPUTS, &InstrumentSet::flight_quality(1.0), 1).samples;
    let received = telemetered(&sent);
    assert_eq!(sent.len(), received.len());
    for (sent, received) in sent.iter().zip(&received) {
        assert_eq!((sent.time_s, sent.present), (received.time_s, received.present));
        for channel in Channel::ALL {
            let Some((sent, received)) = sent.get(channel).zip(received.get(channel)) else { continue };
            let resolution = match channel {
                // Half a pulse of 0.02 degrees.
                _ if Channel::CONTROLS.contains(&channel) => 0.01_f64.to_radians() * 1.000_001,
                // Single precision of 900 hPa, 0.03 Pa, at 0.09 m/Pa.
                Channel::Altitude => 0.005,
                _ => 1e-7 * (sent.abs() + 1e-3),
            };
            assert!((sent - received).abs() <= resolution, "{channel:?}: {sent} became {received}");
        }
    }
}

#[test]
fn derivatives_through_mavlink_are_within_three_standard_errors_in_95_percent_of_seeds() {
    let Some(model) = puma_100kn() else { return };
    let count = seeds(100);
    let scores = over_seeds(count, |seed| {
        let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
        for sample in &telemetered(&fly(&model, &INPUTS, &InstrumentSet::flight_quality(1.0), seed).samples) {
            pipeline.step(sample);
        }
        let derivatives = pipeline.finish().derivatives.clone().unwrap();
        WANTED.map(|(axis, variable)| {
            let term = derivatives.equations[axis.index()].term(variable);
            term.map_or(f64::INFINITY, |term| (term.value - model.derivative(axis, variable)) / term.std)
        })
    });
    let mut failed = Vec::new();
    for (place, (axis, variable)) in WANTED.into_iter().enumerate() {
        let scores: Vec<f64> = scores.iter().map(|one| one[place]).collect();
        let within = scores.iter().filter(|score| score.abs() < 3.0).count();
        let mean = scores.iter().sum::<f64>() / count as f64;
        eprintln!("{axis:?} {variable:?}: {within} of {count} within 3 standard errors, mean {mean:+.2}");
        if (within as f64) < 0.95 * count as f64 {
            failed.push((axis, variable));
        }
    }
    assert!(failed.is_empty(), "outside their standard errors too often: {failed:?}");
}
