//! A validated format: each word and each place of a parameter as bits of the minor frame.

use super::encoding::RawEncoding;
use super::format::{
    CountDirection, FrameSet, ParameterPlace, ParameterSpec, Parity, ParityPlace, PcmFormatSpec, SubframeId, WordPart,
};
use super::format_error::{FormatMistake, FormatPlace, PcmFormatError};
use super::sync_pattern::{SyncPattern, SyncRules};
use std::collections::BTreeSet;

/// Longest minor frame, bits (IRIG 106 Chapter 4, class II; class I has 8,192).
pub const MINOR_FRAME_BITS_MAX: u32 = 16_384;
/// Most words of a minor frame, its pattern counted as one.
pub const WORDS_MAX: u32 = 4096;
/// Most minor frames of a major frame.
pub const MINOR_FRAMES_MAX: u32 = 256;
/// Shortest and longest word, bits (class I: to 16).
pub const WORD_BITS: (u32, u32) = (4, 32);
/// Slowest and fastest line, bits a second.
const BIT_RATES: (f64, f64) = (1.0, 1e11);
/// Most places of one parameter as described, and most parts of a place.
const LISTED_MAX: usize = 4096;
/// Most samples of a major frame.
const SAMPLES_MAX: usize = 1 << 18;

/// Bits of one word in the minor frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordLayout {
    /// First bit, counted from the start of the minor frame.
    pub offset: u32,
    /// Length, its parity bit included.
    pub bits: u32,
    /// Its parity.
    pub parity: Parity,
}

impl WordLayout {
    /// First data bit, and how many there are.
    #[must_use]
    pub const fn data(&self) -> (u32, u32) {
        match self.parity {
            Parity::None => (self.offset, self.bits),
            Parity::Odd(ParityPlace::Leading) | Parity::Even(ParityPlace::Leading) => (self.offset + 1, self.bits - 1),
            Parity::Odd(ParityPlace::Trailing) | Parity::Even(ParityPlace::Trailing) => (self.offset, self.bits - 1),
        }
    }
}

/// Bits of a part of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PartLayout {
    pub(super) word: u32,
    pub(super) offset: u32,
    pub(super) bits: u32,
}

/// One place of a parameter in the minor frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PlaceLayout {
    pub(super) parameter: usize,
    /// First bit of the first sent of its words.
    pub(super) offset: u32,
    /// All of its bits.
    pub(super) bits: u32,
    pub(super) parts: Vec<PartLayout>,
    pub(super) frames: Option<FrameSet>,
}

/// A format that was found to be whole.
#[derive(Clone, Debug, PartialEq)]
pub struct PcmFormat {
    spec: PcmFormatSpec,
    rules: SyncRules,
    words: Vec<WordLayout>,
    minor_frame_bits: u32,
    subframe_id: Option<PartLayout>,
    places: Vec<PlaceLayout>,
}

impl PcmFormat {
    /// Validates a description.
    ///
    /// # Errors
    /// [`PcmFormatError`], the first mistake found.
    pub fn new(spec: PcmFormatSpec) -> Result<Self, PcmFormatError> {
        match PcmFormat::leaving_out(spec)? {
            (format, left_out) if left_out.is_empty() => Ok(format),
            (_, left_out) => Err(left_out.into_iter().next().unwrap_or_else(|| at("parameter", FormatMistake::NoName))),
        }
    }

    /// The same without the parameters that cannot be, and what is wrong with each of these.
    ///
    /// # Errors
    /// [`PcmFormatError`], the first mistake found outside of the parameters.
    pub fn leaving_out(mut spec: PcmFormatSpec) -> Result<(Self, Vec<PcmFormatError>), PcmFormatError> {
        let (low, high) = BIT_RATES;
        if !(low..=high).contains(&spec.bit_rate) {
            return Err(at("bit_rate", FormatMistake::BitRate { low, high, found: spec.bit_rate }));
        }
        let rules = check_sync(&spec)?;
        within("words", spec.words, 2, WORDS_MAX)?;
        within("word_bits", spec.word_bits, WORD_BITS.0, WORD_BITS.1)?;
        within("minor_frames", spec.minor_frames, 1, MINOR_FRAMES_MAX)?;
        let (words, minor_frame_bits) = lay_out_words(&spec)?;
        let parameters = std::mem::take(&mut spec.parameters);
        let mut format = PcmFormat { spec, rules, words, minor_frame_bits, subframe_id: None, places: Vec::new() };
        format.subframe_id = match &format.spec.subframe_id {
            Some(id) => Some(format.check_subframe_id(id)?),
            None => None,
        };
        let (mut names, mut samples, mut left_out) = (BTreeSet::new(), 0, Vec::new());
        for parameter in parameters {
            match format.admit(&parameter, &mut names, &mut samples) {
                Ok(()) => format.spec.parameters.push(parameter),
                Err((key, mistake)) => {
                    let index = format.spec.parameters.len();
                    left_out.push(PcmFormatError { place: FormatPlace::Parameter(index, parameter.name, key), mistake });
                }
            }
        }
        // Samples come in the order of their time.
        format.places.sort_by_key(|place: &PlaceLayout| (place.offset, place.parameter));
        Ok((format, left_out))
    }

    /// Lays out the next parameter, or leaves everything as it was.
    fn admit(
        &mut self,
        parameter: &ParameterSpec,
        names: &mut BTreeSet<String>,
        samples: &mut usize,
    ) -> Result<(), (&'static str, FormatMistake)> {
        if parameter.name.is_empty() {
            return Err(("name", FormatMistake::NoName));
        }
        if names.contains(&parameter.name) {
            return Err(("name", FormatMistake::NameTwice));
        }
        check_values(parameter)?;
        let (index, before) = (self.spec.parameters.len(), *samples);
        let mut places = Vec::new();
        for place in &parameter.places {
            *samples += self.lay_out(index, parameter.encoding, place, &mut places).inspect_err(|_| *samples = before)?;
            if *samples > SAMPLES_MAX {
                *samples = before;
                return Err(("places", FormatMistake::TooManySamples { most: SAMPLES_MAX }));
            }
        }
        names.insert(parameter.name.clone());
        self.places.append(&mut places);
        Ok(())
    }

    /// What it was made of.
    #[must_use]
    pub fn spec(&self) -> &PcmFormatSpec {
        &self.spec
    }

    /// The tolerances in force.
    #[must_use]
    pub fn rules(&self) -> SyncRules {
        self.rules
    }

    /// Length of a minor frame, bits.
    #[must_use]
    pub fn minor_frame_bits(&self) -> usize {
        self.minor_frame_bits as usize
    }

    /// Minor frames a second.
    #[must_use]
    pub fn minor_frame_rate(&self) -> f64 {
        self.spec.bit_rate / f64::from(self.minor_frame_bits)
    }

    /// The words behind the pattern, number 1 first.
    #[must_use]
    pub fn words(&self) -> &[WordLayout] {
        &self.words
    }

    /// What is measured, in the order in which samples name it.
    #[must_use]
    pub fn parameters(&self) -> &[ParameterSpec] {
        &self.spec.parameters
    }

    pub(super) fn subframe_part(&self) -> Option<PartLayout> {
        self.subframe_id
    }

    pub(super) fn places(&self) -> &[PlaceLayout] {
        &self.places
    }

    fn check_subframe_id(&self, id: &SubframeId) -> Result<PartLayout, PcmFormatError> {
        let part = self.part(&id.part).map_err(|mistake| at("subframe_id", mistake))?;
        let (frames, first) = (u64::from(self.spec.minor_frames), u64::from(id.first_value));
        let greatest = u64::MAX >> (64 - part.bits);
        let (fits, direction) = match id.direction {
            CountDirection::Up => (first + frames - 1 <= greatest, "up"),
            CountDirection::Down => (first <= greatest && first + 1 >= frames, "down"),
        };
        if fits {
            return Ok(part);
        }
        let (minor_frames, bits) = (self.spec.minor_frames, part.bits);
        Err(at("subframe_id", FormatMistake::CounterTooSmall { minor_frames, bits, first: id.first_value, direction }))
    }

    /// The bits of a part.
    fn part(&self, part: &WordPart) -> Result<PartLayout, FormatMistake> {
        let last_word = self.words.len() as u64;
        let layout = usize::try_from(part.word).ok().and_then(|word| self.words.get(word.checked_sub(1)?));
        let Some(layout) = layout else {
            return Err(FormatMistake::OutOf { low: 1, high: last_word, found: part.word.into() });
        };
        let (offset, most) = layout.data();
        let (first, last) = part.bits.unwrap_or((1, most));
        if first == 0 || last > most || first > last {
            return Err(FormatMistake::BitRange { word: part.word, most, first, last });
        }
        Ok(PartLayout { word: part.word, offset: offset + first - 1, bits: last - first + 1 })
    }

    /// Adds every place that the description stands for; returns how many samples of a major frame these are.
    fn lay_out(
        &self,
        parameter: usize,
        encoding: RawEncoding,
        place: &ParameterPlace,
        places: &mut Vec<PlaceLayout>,
    ) -> Result<usize, (&'static str, FormatMistake)> {
        if !(1..=LISTED_MAX).contains(&place.parts.len()) {
            return Err(("parts", FormatMistake::Places { most: LISTED_MAX, found: place.parts.len() }));
        }
        let frames = self.count_frames(place)?;
        let last_word = self.words.len() as u64;
        let interval = place.word_interval.map(u64::from);
        if interval.is_some_and(|interval| interval == 0 || interval > last_word) {
            let found = interval.unwrap_or_default();
            return Err(("word_interval", FormatMistake::OutOf { low: 1, high: last_word, found }));
        }
        let greatest = place.parts.iter().map(|part| u64::from(part.word)).max().unwrap_or_default();
        let again = interval.map_or(0, |interval| last_word.saturating_sub(greatest) / interval);
        for k in 0..=again {
            let moved = |part: &WordPart| {
                let by = k * interval.unwrap_or_default();
                let word = u32::try_from(u64::from(part.word) + by).unwrap_or(u32::MAX);
                self.part(&WordPart { word, ..*part })
            };
            let parts: Vec<PartLayout> = place.parts.iter().map(moved).collect::<Result<_, _>>().map_err(|m| ("word", m))?;
            let bits: u64 = parts.iter().map(|part| u64::from(part.bits)).sum();
            let (least, most) = encoding.widths();
            if !(u64::from(least)..=u64::from(most)).contains(&bits) {
                return Err(("encoding", FormatMistake::EncodingBits { encoding, least, most, found: bits }));
            }
            let word_offset = |part: &PartLayout| self.words.get(part.word as usize - 1).map(|word| word.offset);
            let offset = parts.iter().filter_map(word_offset).min().unwrap_or_default();
            places.push(PlaceLayout { parameter, offset, bits: bits as u32, parts, frames: place.frames });
        }
        Ok(frames * (again as usize + 1))
    }

    fn count_frames(&self, place: &ParameterPlace) -> Result<usize, (&'static str, FormatMistake)> {
        let Some(frames) = place.frames else { return Ok(self.spec.minor_frames as usize) };
        if self.subframe_id.is_none() {
            return Err(("frame", FormatMistake::NoSubframeId));
        }
        let high = u64::from(self.spec.minor_frames);
        let out_of = |found: u32| FormatMistake::OutOf { low: 1, high, found: found.into() };
        if !(1..=self.spec.minor_frames).contains(&frames.first) {
            return Err(("frame", out_of(frames.first)));
        }
        match frames.interval {
            Some(interval) if !(1..=self.spec.minor_frames).contains(&interval) => Err(("frame_interval", out_of(interval))),
            Some(interval) => Ok(((self.spec.minor_frames - frames.first) / interval) as usize + 1),
            None => Ok(1),
        }
    }
}

fn at(key: &'static str, mistake: FormatMistake) -> PcmFormatError {
    PcmFormatError { place: FormatPlace::Format(key), mistake }
}

fn within(key: &'static str, found: u32, low: u32, high: u32) -> Result<(), PcmFormatError> {
    if (low..=high).contains(&found) {
        return Ok(());
    }
    Err(at(key, FormatMistake::OutOf { low: low.into(), high: high.into(), found: found.into() }))
}

fn check_sync(spec: &PcmFormatSpec) -> Result<SyncRules, PcmFormatError> {
    let SyncPattern { pattern, mask, bits } = spec.sync;
    within("sync.bits", bits, SyncPattern::SHORTEST, SyncPattern::LONGEST)?;
    if pattern >> bits != 0 || mask >> bits != 0 {
        return Err(at("sync.pattern", FormatMistake::PatternBits { bits, pattern, mask }));
    }
    let compared = spec.sync.compared();
    if compared < SyncPattern::SHORTEST / 2 {
        return Err(at("sync.mask", FormatMistake::TooFewCompared { least: SyncPattern::SHORTEST / 2, found: compared }));
    }
    let rules = spec.rules.unwrap_or(SyncRules::for_length(compared));
    let most_errors = compared / 4;
    within("sync.lock_errors", rules.lock_errors, 0, most_errors)?;
    within("sync.check_errors", rules.check_errors, 0, most_errors)?;
    within("sync.search_errors", rules.search_errors, 0, most_errors)?;
    within("sync.check_frames", rules.check_frames, 1, SyncRules::FRAMES_MAX)?;
    within("sync.flywheel_frames", rules.flywheel_frames, 0, SyncRules::FRAMES_MAX)?;
    within("sync.slip_bits", rules.slip_bits, 0, SyncRules::SLIP_MAX)?;
    let errors = rules.lock_errors.max(rules.check_errors);
    for shift in 1..=rules.slip_bits {
        let found = spec.sync.distance_to_itself(shift);
        if found <= errors {
            return Err(at("sync.pattern", FormatMistake::LikeItself { shift, found, errors }));
        }
    }
    Ok(rules)
}

fn lay_out_words(spec: &PcmFormatSpec) -> Result<(Vec<WordLayout>, u32), PcmFormatError> {
    let count = spec.words - 1;
    let mut words = vec![(spec.word_bits, spec.parity); count as usize];
    let mut listed = vec![false; count as usize];
    for (index, special) in spec.special_words.iter().enumerate() {
        let wrong = |mistake| PcmFormatError { place: FormatPlace::SpecialWord(index), mistake };
        let place = (special.word as usize).wrapping_sub(1);
        let (Some(word), Some(listed)) = (words.get_mut(place), listed.get_mut(place)) else {
            return Err(wrong(FormatMistake::OutOf { low: 1, high: count.into(), found: special.word.into() }));
        };
        if std::mem::replace(listed, true) {
            return Err(wrong(FormatMistake::WordTwice { word: special.word }));
        }
        let bits = special.bits.unwrap_or(word.0);
        if !(WORD_BITS.0..=WORD_BITS.1).contains(&bits) {
            return Err(wrong(FormatMistake::OutOf { low: WORD_BITS.0.into(), high: WORD_BITS.1.into(), found: bits.into() }));
        }
        *word = (bits, special.parity.unwrap_or(word.1));
    }
    let mut offset = spec.sync.bits;
    let mut laid_out = Vec::with_capacity(words.len());
    for (bits, parity) in words {
        laid_out.push(WordLayout { offset, bits, parity });
        offset += bits;
    }
    if offset > MINOR_FRAME_BITS_MAX {
        return Err(at("words", FormatMistake::FrameTooLong { most: MINOR_FRAME_BITS_MAX, found: offset.into() }));
    }
    Ok((laid_out, offset))
}

/// What of a parameter does not depend on its places.
fn check_values(parameter: &ParameterSpec) -> Result<(), (&'static str, FormatMistake)> {
    if !(1..=LISTED_MAX).contains(&parameter.places.len()) {
        return Err(("places", FormatMistake::Places { most: LISTED_MAX, found: parameter.places.len() }));
    }
    parameter.calibration.check().map_err(|error| ("calibration", FormatMistake::Calibration(error)))?;
    let (low, high) = (parameter.limits.low.unwrap_or(f64::NEG_INFINITY), parameter.limits.high.unwrap_or(f64::INFINITY));
    if !(low < high) {
        return Err(("limits", FormatMistake::Limits { low, high }));
    }
    match parameter.limits.step {
        Some(found) if !(found.is_finite() && found > 0.0) => Err(("limits", FormatMistake::NotPositive { found })),
        _ => Ok(()),
    }
}

#[cfg(test)]
#[path = "layout_tests.rs"]
mod tests;
