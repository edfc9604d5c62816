//! The link of a simulated flight: 256 minor frames a second at 1 Mbit/s, and a Puma flown with a pedal and a cyclic 3211.
//!
//! Flap angles stand in each minor frame, rates, forces, attitude and controls in every other, air data in every eighth, in
//! words of 16 bits.

use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use sideslip::io::telemetry::pcm::rows::{PcmRows, UnusedSamples};
use sideslip::io::telemetry::record::RecordingRow;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::uniform_times;
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;

/// How wrong words are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Guard {
    /// By nothing.
    None,
    /// By the range of each channel.
    Limits,
    /// By its range and its largest step from sample to sample.
    Steps,
    /// By a parity bit in each word.
    Parity,
}

const FRAMES_HZ: f64 = 256.0;
const WORDS: u32 = 243;
const BITS: u32 = 32 + 16 * (WORDS - 1);
const INPUT: [&str; 2] = ["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.008:0.5:7"];

/// Channels, minor frames from one to the next, what the word spans, and the largest step: some ten times the noise, and more
/// than the motion makes of it.
const CHANNELS: [(&[Channel], u32, f64, f64); 7] = [
    (&[Channel::Flap0, Channel::Flap1c, Channel::Flap1s], 1, 0.5, 0.02),
    (&[Channel::P, Channel::Q, Channel::R], 2, 2.0, 0.02),
    (&[Channel::Phi, Channel::Theta], 2, 2.0, 0.03),
    (&[Channel::Ax, Channel::Ay, Channel::Az], 2, 20.0, 0.3),
    (&[Channel::LonCyclic, Channel::LatCyclic, Channel::Collective, Channel::Pedal], 2, 0.5, 0.01),
    (&[Channel::Alpha, Channel::Beta], 8, 1.0, 0.04),
    (&[Channel::Tas], 8, 100.0, 5.0),
];

/// A channel's word.
#[derive(Clone, Copy)]
pub(crate) struct ChannelWord {
    pub(crate) channel: Channel,
    /// In every so many minor frames.
    pub(crate) every: u32,
    pub(crate) span: f64,
    step: f64,
}

/// Every channel in a word of its own.
pub(crate) fn words() -> Vec<ChannelWord> {
    let word = |(channel, every, span, step): (&Channel, u32, f64, f64)| ChannelWord { channel: *channel, every, span, step };
    let all = CHANNELS.iter().flat_map(|(channels, every, span, step)| channels.iter().map(|c| (c, *every, *span, *step)));
    all.map(word).collect()
}

pub(crate) fn format(guard: Guard) -> PcmFormat {
    let mut text = format!(
        "bit_rate = {}\nwords = {WORDS}\nword_bits = 16\nminor_frames = 8\nparity = \"{}\"\n\
         [sync]\npattern = 0xFE6B_2840\nbits = 32\n[subframe_id]\nword = 1\n",
        FRAMES_HZ * f64::from(BITS),
        if guard == Guard::Parity { "odd" } else { "none" },
    );
    let counts = if guard == Guard::Parity { 16384.0 } else { 32768.0 };
    for (number, word) in (2..).zip(words()) {
        let (name, every) = (word.channel.name(Default::default()), word.every);
        text += &format!(
            "[[parameter]]\nname = \"{name}\"\nword = {number}\nencoding = \"twos_complement\"\n\
             calibration = {{ kind = \"polynomial\", coefficients = [0.0, {:e}] }}\n",
            word.span / counts
        );
        // A little beyond what was flown.
        let (low, high) = if word.channel == Channel::Tas { (30.0, 70.0) } else { (-0.6 * word.span, 0.6 * word.span) };
        match guard {
            Guard::None | Guard::Parity => {}
            Guard::Limits => text += &format!("limits = {{ low = {low:?}, high = {high:?} }}\n"),
            Guard::Steps => text += &format!("limits = {{ low = {low:?}, high = {high:?}, step = {:?} }}\n", word.step),
        }
        if every > 1 {
            text += &format!("frame = 1\nframe_interval = {every}\n");
        }
    }
    PcmFormat::from_toml(&text).unwrap()
}

/// The samples of a flight, at every minor frame.
pub(crate) fn flown(seed: u64) -> Vec<Sample> {
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
    flight.seed = seed;
    flight.fly().unwrap().samples
}

/// The bytes of the line.
pub(crate) fn sent(format: &PcmFormat, samples: &[Sample]) -> Vec<u8> {
    let (mut encoder, mut line, words) = (PcmEncoder::new(format, 0.0).unwrap(), Vec::new(), words());
    for sample in samples {
        encoder.minor_frame(|parameter, _| sample.get(words[parameter].channel).unwrap(), &mut line).unwrap();
    }
    encoder.finish(&mut line);
    assert_eq!(encoder.saturated(), 0);
    line
}

/// What came of a line.
pub(crate) struct Received {
    pub(crate) samples: Vec<Sample>,
    pub(crate) unused: UnusedSamples,
    pub(crate) decoder: PcmDecoder,
}

/// Decodes a line.
pub(crate) fn received(format: &PcmFormat, line: &[u8]) -> Received {
    let (mut decoder, mut rows, mut samples) = (PcmDecoder::new(format, 0.0), PcmRows::new(format).unwrap(), Vec::new());
    let mut each = |row: &RecordingRow| samples.push(row.sample);
    for bytes in line.chunks(1000) {
        decoder.feed(bytes, |sample| rows.put(&sample, &mut each));
    }
    decoder.finish(|sample| rows.put(&sample, &mut each));
    rows.finish(&mut each);
    Received { samples, unused: rows.unused(), decoder }
}
