//! The samples of a flight as a stream of PCM, with the format of its frames as TOML.
//!
//! Consumes samples in SI and radians, in order of time; produces the bytes of the line (NRZ-L) and the text of a
//! [format file](super::format_file) whose table `run` is what the run says of itself. A minor frame stands for an instant: they
//! come as often as the fastest channel was sampled, or a multiple of it. Words have 32 bits, IEEE 754 of single precision; the
//! first counts the minor frames; the rates stand first. A channel that was sampled in every n-th minor frame is subcommutated,
//! while the major frame has no more than 256 of them; another is in every frame. A word is no number where its channel was not
//! sampled. Frames are filled so that the words of an instant stand within half a millisecond: they are one row then. Where that
//! takes more than 512 words, frames without a sample come between. Time begins at 0 with the first sample; a word is later than
//! its sample by its place in the frame.
//! Refused: less than two samples, none with a channel, times that are no whole number of frames apart.

use super::encoder::{PcmEncoder, PcmEncoderError};
use super::format_file::PcmFormatFileError;
use super::layout::{MINOR_FRAME_BITS_MAX, MINOR_FRAMES_MAX, PcmFormat};
use super::rows::ROW_S;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::sample::Sample;
use std::fmt::Write as _;

const WORD_BITS: u32 = 32;
const SYNC: u32 = 0xFE6B_2840;
/// Words of a minor frame at most.
const WORDS_MAX: u32 = MINOR_FRAME_BITS_MAX / WORD_BITS;
/// Minor frames a second, at most.
const FRAMES_HZ_MAX: f64 = 10_000.0;
/// How far from a whole number of frames a time may be, in frames.
const OFF_GRID: f64 = 0.02;

/// A stream and the format of its frames.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleStream {
    /// The bytes of the line; behind the last minor frame a pattern, which confirms it.
    pub line: Vec<u8>,
    /// The format as TOML.
    pub format: String,
}

/// Why a flight is no stream.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum SampleStreamError {
    #[error("expected two samples or more with channels, found {0}")]
    Samples(usize),
    #[error("at {time_s} s: expected samples a whole number of frames apart, found {frames:.3} frames at {frames_hz:.6} Hz")]
    Time { time_s: f64, frames: f64, frames_hz: f64 },
    #[error("expected at most {FRAMES_HZ_MAX} instants a second, found {0}: the rates of the channels have no common frame")]
    Rate(f64),
    #[error("format of the frames, {0}")]
    Format(#[from] PcmFormatFileError),
    #[error(transparent)]
    Encoder(#[from] PcmEncoderError),
}

/// A channel's word: in which minor frames, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ChannelWord {
    channel: Channel,
    first: usize,
    every: usize,
}

/// The minor frames, by their number from 0.
struct SampledFrames<'s> {
    hz: f64,
    samples: Vec<Option<&'s Sample>>,
}

fn frames(samples: &[Sample]) -> Result<SampledFrames<'_>, SampleStreamError> {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Err(SampleStreamError::Samples(0)) };
    let gaps = samples.windows(2).filter_map(|two| match two {
        [one, other] => Some(other.time_s - one.time_s),
        _ => None,
    });
    let least_s = gaps.fold(f64::INFINITY, f64::min);
    if !least_s.is_finite() {
        return Err(SampleStreamError::Samples(samples.len()));
    }
    if !(least_s * FRAMES_HZ_MAX >= 1.0) {
        return Err(SampleStreamError::Rate(1.0 / least_s));
    }
    let count = libm::round((last.time_s - first.time_s) / least_s);
    let sampled_hz = count / (last.time_s - first.time_s);
    let present = samples.iter().fold(0, |present, sample| present | sample.present).count_ones();
    let per_instant = libm::ceil(words_wanted(present.saturating_add(2), sampled_hz) / f64::from(WORDS_MAX)).max(1.0);
    // Slow samples need so long a frame that their words would not stand in one row: further frames without them lie between.
    let (count, hz) = (count * per_instant, sampled_hz * per_instant);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative; a cast of a float saturates")]
    let index = |frames: f64| frames as usize;
    let mut all = vec![None; index(count) + 1];
    for sample in samples {
        let at = (sample.time_s - first.time_s) * hz;
        match all.get_mut(index(libm::round(at))).filter(|_| libm::fabs(at - libm::round(at)) <= OFF_GRID) {
            Some(place) => *place = Some(sample),
            None => return Err(SampleStreamError::Time { time_s: sample.time_s, frames: at, frames_hz: hz }),
        }
    }
    Ok(SampledFrames { hz, samples: all })
}

fn common_divisor(one: usize, other: usize) -> usize {
    let (mut a, mut b) = (one, other);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Words of a minor frame of which `used` that follow each other stand within a row's time, with a tenth to spare.
fn words_wanted(used: u32, frames_hz: f64) -> f64 {
    f64::from(used) / (0.9 * ROW_S * frames_hz)
}

/// The words of the channels, and the minor frames of a major frame.
fn words(frames: &SampledFrames<'_>) -> (Vec<ChannelWord>, usize) {
    let mut channels = Channel::ALL;
    channels.sort_by_key(|channel| !Channel::GYROS.contains(channel));
    let (mut words, mut major) = (Vec::new(), 1);
    for channel in channels {
        let has = |sample: &Option<&Sample>| sample.is_some_and(|sample| sample.get(channel).is_some());
        let mut places = (0..).zip(&frames.samples).filter(|(_, sample)| has(sample)).map(|(place, _): (usize, _)| place);
        let Some(first) = places.next() else { continue };
        // The greatest interval that has every place; 0 where there is one place alone.
        let every = places.fold(0, |every, place| common_divisor(place - first, every)).max(1);
        let multiple = major / common_divisor(major, every) * every;
        if multiple <= MINOR_FRAMES_MAX as usize {
            major = multiple;
            words.push(ChannelWord { channel, first: first % every, every });
        } else {
            words.push(ChannelWord { channel, first: 0, every: 1 });
        }
    }
    (words, major)
}

fn format_text(words: &[ChannelWord], major: usize, frames_hz: f64, controls: ControlNames, run: &toml::Table) -> String {
    let used = u32::try_from(words.len()).unwrap_or(u32::MAX).saturating_add(2);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; a cast of a float saturates")]
    let count = (libm::ceil(words_wanted(used, frames_hz)) as u32).clamp(used, WORDS_MAX);
    let mut text = format!(
        "name = \"simulated flight\"\nbit_rate = {:?}\nwords = {count}\nword_bits = {WORD_BITS}\nminor_frames = {major}\n\
         [sync]\npattern = {SYNC:#X}\nbits = 32\n[subframe_id]\nword = 1\n",
        frames_hz * f64::from(count * WORD_BITS)
    );
    for (word, place) in (2..).zip(words) {
        let (name, unit) = (place.channel.name(controls), place.channel.si_unit());
        let _ =
            write!(text, "[[parameter]]\nname = \"{name}\"\nunit = \"{unit}\"\nword = {word}\nencoding = \"ieee754_single\"\n");
        if place.every > 1 {
            let _ = write!(text, "frame = {}\nframe_interval = {}\n", place.first + 1, place.every);
        }
    }
    let run = toml::Table::from_iter([("run".to_owned(), toml::Value::Table(run.clone()))]);
    let _ = write!(text, "\n{run}");
    text
}

/// The stream of a flight; `run` is what it says of itself.
///
/// # Errors
/// [`SampleStreamError`] where times or rates fit no frames.
pub fn stream_of_samples(
    samples: &[Sample],
    controls: ControlNames,
    run: &toml::Table,
) -> Result<SampleStream, SampleStreamError> {
    let frames = frames(samples)?;
    let (words, major) = words(&frames);
    if words.is_empty() {
        return Err(SampleStreamError::Samples(0));
    }
    let text = format_text(&words, major, frames.hz, controls, run);
    let format = PcmFormat::from_toml(&text)?;
    let mut encoder = PcmEncoder::new(&format, 0.0)?;
    let mut line = Vec::new();
    for sample in &frames.samples {
        let value = |parameter: usize, _| {
            let channel = words.get(parameter).map(|word| word.channel);
            sample.zip(channel).and_then(|(sample, channel)| sample.get(channel)).unwrap_or(f64::NAN)
        };
        encoder.minor_frame(value, &mut line)?;
    }
    encoder.finish(&mut line);
    line.extend(SYNC.to_be_bytes());
    Ok(SampleStream { line, format: text })
}

#[cfg(test)]
#[path = "sample_stream_tests.rs"]
mod tests;
