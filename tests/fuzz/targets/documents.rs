//! Files of one kind of TOML each: models of both kinds, instruments, and which MAVLink message gives which channel.

use super::Steps;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::io::telemetry::mavlink::packet::{Framer, Framing};
use sideslip::io::telemetry::mavlink::stream::VehicleStream;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::instrument_file::InstrumentFile;
use std::sync::OnceLock;

/// A model; one that can be flown is written and read again.
pub(super) fn model(bytes: &[u8]) -> usize {
    let text = String::from_utf8_lossy(bytes);
    let linear = ModelFile::parse(&text);
    let Ok(model) = FlightModel::parse(&text, &FlightRequest::default()) else { return 0 };
    if model.level1.is_none() {
        assert_eq!(linear.as_ref(), Ok(&model.file));
        assert_eq!(ModelFile::parse(&model.file.to_toml()).as_ref(), Ok(&model.file), "{}", model.file.to_toml());
    }
    let again = model.with_effects(&model.file.effects).unwrap();
    let read = FlightModel::parse(&again, &FlightRequest::default());
    let same = read.as_ref().is_ok_and(|read| read.file.effects == model.file.effects && read.file.linear == model.file.linear);
    assert!(same, "{again}\n{:?}", read.err());
    1
}

/// Instruments; a set of them is made.
pub(super) fn instruments(bytes: &[u8]) -> usize {
    let Ok(file) = InstrumentFile::parse(&String::from_utf8_lossy(bytes), |_| true) else { return 0 };
    let set = file.applied_to(InstrumentSet::flight_quality(1.0), 1.0);
    let mut steps = Steps { left: Channel::ALL.len() as u64 };
    for instrument in &set.channels {
        steps.one();
        assert!(instrument.noise_std >= 0.0 && instrument.lag_s >= 0.0);
        assert!(instrument.quantum.is_none_or(|quantum| quantum > 0.0), "{instrument:?}");
    }
    1
}

/// A mapping of MAVLink; a stream is read by it.
pub(super) fn mavlink_config(bytes: &[u8]) -> usize {
    let Ok(config) = MavlinkConfig::from_toml(&String::from_utf8_lossy(bytes)) else { return 0 };
    let line = line();
    let (mut framer, mut stream) = (Framer::new(Framing::Bare), VehicleStream::new(config, None));
    let mut rest = line;
    let (mut steps, mut things) = (Steps::of(line, 1), 0);
    while !rest.is_empty() {
        rest = &rest[framer.take(rest)..];
        while let Some(packet) = framer.next_packet() {
            stream.packet(&packet, None);
        }
    }
    stream.flush();
    while let Some(timed) = stream.next_sample() {
        steps.one();
        things += 1;
        assert!(timed.sample.time_s.is_finite());
    }
    things
}

/// Some seconds with every channel that is sent.
fn line() -> &'static [u8] {
    static MADE: OnceLock<Vec<u8>> = OnceLock::new();
    MADE.get_or_init(|| {
        let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::Rotorcraft);
        let mut line = Vec::new();
        for step in 0..20 {
            let mut sample = Sample::new(1.0 + 0.1 * f64::from(step));
            Channel::ALL.into_iter().for_each(|channel| sample.set(channel, 0.01 * f64::from(step)));
            encoder.sample(&sample, |frame| line.extend_from_slice(frame)).unwrap();
        }
        line
    })
}
