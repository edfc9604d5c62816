//! Why a format cannot be used, and where in its description.

use super::calibration::CalibrationError;
use super::encoding::RawEncoding;

/// A mistake in a description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}{mistake}")]
pub struct PcmFormatError {
    /// Where.
    pub place: FormatPlace,
    /// What was expected and what was found.
    pub mistake: FormatMistake,
}

/// Where in a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FormatPlace {
    /// The format itself: the key of the file.
    Format(&'static str),
    /// A special word by its index, from 0.
    SpecialWord(usize),
    /// A parameter by its index, from 0, its name, and the key.
    Parameter(usize, String, &'static str),
}

impl std::fmt::Display for FormatPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FormatPlace::Format(key) => write!(f, "{key}: "),
            FormatPlace::SpecialWord(index) => write!(f, "special word {}: ", index + 1),
            FormatPlace::Parameter(index, name, key) => write!(f, "parameter {} ({name:?}), {key}: ", index + 1),
        }
    }
}

fn bits_in_words(least: u32, most: u32) -> String {
    if least == most { format!("{least} bits") } else { format!("{least} to {most} bits") }
}

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum FormatMistake {
    #[error("expected {low} to {high}, found {found}")]
    OutOf { low: u64, high: u64, found: u64 },
    #[error("expected a finite number above zero, found {found}")]
    NotPositive { found: f64 },
    #[error("expected {low} to {high} bits a second, found {found}")]
    BitRate { low: f64, high: f64, found: f64 },
    #[error("expected a pattern and a mask of {bits} bits, found 0x{pattern:X} and 0x{mask:X}")]
    PatternBits { bits: u32, pattern: u64, mask: u64 },
    #[error("expected at least {least} compared bits, found {found}")]
    TooFewCompared { least: u32, found: u32 },
    #[error(
        "differs from itself {shift} bits further in {found} bits only, expected more than {errors}: a slip could not be told"
    )]
    LikeItself { shift: u32, found: u32, errors: u32 },
    #[error("word {word} is listed twice")]
    WordTwice { word: u32 },
    #[error("expected at most {most} bits a minor frame, found {found}")]
    FrameTooLong { most: u32, found: u64 },
    #[error("expected data bits 1 to {most} of word {word}, found {first} to {last}")]
    BitRange { word: u32, most: u32, first: u32, last: u32 },
    #[error("{minor_frames} minor frames do not fit {bits} bits counted from {first} {direction}")]
    CounterTooSmall { minor_frames: u32, bits: u32, first: u32, direction: &'static str },
    #[error("expected a subframe identifier, as a parameter stands in some of the minor frames only")]
    NoSubframeId,
    #[error("expected a name, found none")]
    NoName,
    #[error("expected a name that no other parameter has")]
    NameTwice,
    #[error("expected 1 to {most} places, found {found}")]
    Places { most: usize, found: usize },
    #[error("{} takes {}, found {found}", encoding.name(), bits_in_words(*least, *most))]
    EncodingBits { encoding: RawEncoding, least: u32, most: u32, found: u64 },
    #[error("{0}")]
    Calibration(CalibrationError),
    #[error("expected a low limit below the high one, found {low} and {high}")]
    Limits { low: f64, high: f64 },
    #[error("expected at most {most} samples a major frame, found more")]
    TooManySamples { most: usize },
}
