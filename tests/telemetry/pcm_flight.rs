//! A simulated Puma telemetered as PCM, against the same samples as they were measured: the same derivatives.
//!
//! 256 minor frames a second at 1 Mbit/s: flap angles in each, rates, forces, attitude and controls in every other, air data in
//! every eighth, in words of 16 bits. Gate: a tenth of a standard error in each derivative that has a number.

use super::derivatives::{apart, derivatives};
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use sideslip::io::telemetry::pcm::rows::PcmRows;
use sideslip::io::telemetry::record::RecordingRow;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::uniform_times;
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;

const FRAMES_HZ: f64 = 256.0;
const WORDS: u32 = 243;
const BITS: u32 = 32 + 16 * (WORDS - 1);
const INPUT: [&str; 2] = ["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.008:0.5:7"];

/// Channels, minor frames from one to the next, and what the word spans.
const CHANNELS: [(&[Channel], u32, f64); 6] = [
    (&[Channel::Flap0, Channel::Flap1c, Channel::Flap1s], 1, 0.5),
    (&[Channel::P, Channel::Q, Channel::R, Channel::Phi, Channel::Theta], 2, 2.0),
    (&[Channel::Ax, Channel::Ay, Channel::Az], 2, 20.0),
    (&[Channel::LonCyclic, Channel::LatCyclic, Channel::Collective, Channel::Pedal], 2, 0.5),
    (&[Channel::Alpha, Channel::Beta], 8, 1.0),
    (&[Channel::Tas], 8, 100.0),
];

/// Every channel in a word of its own, and how often.
fn words() -> Vec<(Channel, u32, f64)> {
    CHANNELS.iter().flat_map(|(channels, every, span)| channels.iter().map(|channel| (*channel, *every, *span))).collect()
}

fn format() -> PcmFormat {
    let mut text = format!(
        "bit_rate = {}\nwords = {WORDS}\nword_bits = 16\nminor_frames = 8\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n\
         [subframe_id]\nword = 1\n",
        FRAMES_HZ * f64::from(BITS)
    );
    for (word, (channel, every, span)) in (2..).zip(words()) {
        text += &format!(
            "[[parameter]]\nname = \"{}\"\nword = {word}\nencoding = \"twos_complement\"\n\
             calibration = {{ kind = \"polynomial\", coefficients = [0.0, {:e}] }}\n",
            channel.name(Default::default()),
            span / 32768.0
        );
        if every > 1 {
            text += &format!("frame = 1\nframe_interval = {every}\n");
        }
    }
    PcmFormat::from_toml(&text).unwrap()
}

/// The samples, a quarter of a millisecond behind the frames: where the words stand.
fn flown() -> Vec<Sample> {
    let mut flight = FlightModel::puma(&FlightRequest::default()).unwrap().flight();
    flight.times_s = uniform_times(0.0, 22.0, FRAMES_HZ).unwrap();
    for input in INPUT {
        let spec = InputSpec::parse(input).unwrap();
        for control in Control::ALL.into_iter().filter(|control| control.channel() == spec.channel) {
            let history = &mut flight.inputs.controls[control.index()];
            *history = history.plus(1.0, &spec.deviation(2.0));
        }
    }
    flight.instruments = InstrumentSet::flight_quality(1.0).with_rotor(1.0);
    flight.seed = 11;
    flight.fly().unwrap().samples
}

#[test]
fn a_puma_by_pcm_has_the_derivatives_of_its_samples() {
    let (samples, format) = (flown(), format());
    let measured: Vec<Sample> = (0_u32..)
        .zip(&samples)
        .map(|(frame, sample)| {
            let mut kept = Sample::new(sample.time_s);
            for (channel, ..) in words().into_iter().filter(|(_, every, _)| frame % every == 0) {
                sample.get(channel).into_iter().for_each(|value| kept.set(channel, value));
            }
            kept
        })
        .collect();
    let mut encoder = PcmEncoder::new(&format, 0.0).unwrap();
    let mut line = Vec::new();
    for sample in &samples {
        encoder.minor_frame(|parameter, _| sample.get(words()[parameter].0).unwrap(), &mut line).unwrap();
    }
    encoder.finish(&mut line);
    assert_eq!(encoder.saturated(), 0);

    let mut decoder = PcmDecoder::new(&format, 0.0);
    let mut rows = PcmRows::new(&format).unwrap();
    let mut received = Vec::new();
    let mut each = |row: &RecordingRow| received.push(row.sample);
    for bytes in line.chunks(1000) {
        decoder.feed(bytes, |sample| rows.put(&sample, &mut each));
    }
    decoder.finish(|sample| rows.put(&sample, &mut each));
    rows.finish(&mut each);
    // The words of a frame are one row here: 20 of 16 bits and the pattern are a third of a millisecond.
    assert_eq!(received.len(), measured.len());
    for (sent, got) in measured.iter().zip(&received) {
        assert_eq!(sent.present, got.present);
        assert!((0.0..0.4e-3).contains(&(got.time_s - sent.time_s)));
    }

    let found = apart(&derivatives(&measured), &derivatives(&received));
    eprintln!("{found:?}");
    assert!(found.compared > 12 && found.largest <= 0.1 && found.different.is_empty(), "{found:?}");
}
