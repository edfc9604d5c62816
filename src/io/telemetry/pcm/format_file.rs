//! A PCM format as a TOML file, errors with line and column.
//!
//! ```toml
//! name = "basic aircraft"
//! bit_rate = 2_000_000             # bits a second
//! line_code = "nrz_l"              # or "rnrz_l"; default nrz_l
//! polarity = "automatic"           # or "normal", "inverted"; default automatic
//! words = 63                       # words a minor frame, the pattern counted as one; numbered from 1 behind it
//! word_bits = 16                   # 4 to 32, the parity bit included
//! parity = "none"                  # or "odd", "even"; default none
//! parity_place = "trailing"        # or "leading"; default trailing
//! minor_frames = 16                # a major frame; default 1
//! channel = 52                     # of an IRIG 106 Chapter 10 recording; default the first channel of PCM in it
//! [sync]
//! pattern = 0xFE6B_2840
//! bits = 32                        # 16 to 33
//! mask = 0xFFFF_FFFF               # bits that are compared; default all
//! search_errors = 1                # wrong bits borne in search, check and lock; defaults by the bits compared
//! check_errors = 1
//! lock_errors = 3
//! check_frames = 2                 # patterns that confirm lock
//! flywheel_frames = 3              # patterns in a row that may be missing
//! slip_bits = 2                    # bits that a pattern may stand beside its place
//! [subframe_id]
//! word = 1
//! bits = [13, 16]                  # first and last data bit, 1 the most significant; default all
//! first_value = 0                  # in minor frame 1
//! counts = "up"                    # or "down"
//! [[word]]                         # words of another length or parity
//! number = 4
//! bits = 12
//! parity = "odd"
//! [[parameter]]
//! name = "p"
//! unit = "deg/s"
//! word = 2
//! word_interval = 16               # supercommutated: also in words 18, 34, 50
//! encoding = "twos_complement"     # default unsigned
//! calibration = { kind = "polynomial", coefficients = [0.0, 0.01], range = [-32000, 32000], outside = "flag" }
//! limits = { low = -200, high = 200, step = 5 }   # step: the largest change from a sample to the next
//! [[parameter]]
//! name = "oil_temperature"
//! unit = "K"
//! word = 3
//! bits = [1, 12]
//! frame = 5                        # subcommutated: minor frames 5 and 13
//! frame_interval = 8
//! calibration = { kind = "pair_wise_linear", pairs = [[0, 233], [4095, 433]] }
//! [[parameter]]
//! name = "altitude"
//! parts = [{ word = 10 }, { word = 11, bits = [1, 8] }]   # concatenated, most significant first
//! [[parameter]]
//! name = "gear"
//! places = [{ word = 20, bits = [3, 3] }, { word = 40, bits = [3, 3], frame = 2 }]   # several unlike places
//! calibration = { kind = "table", pairs = [[0, 0], [1, 100]] }
//! [run]                            # keys of the run, as in the preamble of a CSV run file
//! aircraft = "Puma"
//! vane_position_m = [13.08, 0, 0]
//! ```

use super::bits::LineCode;
use super::calibration::{Calibration, OutsideRange};
use super::encoding::RawEncoding;
use super::format::{
    CountDirection, FrameSet, ParameterLimits, ParameterPlace, ParameterSpec, Parity, ParityPlace, PcmFormatSpec, SpecialWord,
    SubframeId, WordPart,
};
use super::format_error::FormatPlace;
use super::format_tables::{CalibrationTable, FormatDocument, IdTable, ParameterTable, PartTable, PlaceTable, SyncTable};
use super::layout::PcmFormat;
use super::sync_pattern::{PolarityRule, SyncPattern, SyncRules};
use crate::flight::file::run_file::RunInfo;
use crate::flight::file::toml_reader::nearest;
use crate::io::telemetry::record::RecordingError;
use crate::io::text_file::read_text;
use std::path::Path;
use toml::Spanned;

/// A mistake in the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}:{column}: {what}")]
pub struct PcmFormatFileError {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What was expected and what was found.
    pub what: String,
}

impl PcmFormatFileError {
    /// The mistake at that byte of the text.
    pub(crate) fn in_text(text: &str, offset: usize, what: String) -> Self {
        let before = text.get(..offset).unwrap_or(text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        PcmFormatFileError { line, column, what }
    }
}

/// A format, and what its file says of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct PcmFormatFile {
    /// The format.
    pub format: PcmFormat,
    /// The table `run`.
    pub info: RunInfo,
    /// The channel of a Chapter 10 recording that has these frames.
    pub channel: Option<u16>,
}

impl PcmFormatFile {
    /// Reads the file's text.
    ///
    /// # Errors
    /// As [`PcmFormat::from_toml`], and where a key of the run has another type.
    pub fn from_toml(text: &str) -> Result<Self, PcmFormatFileError> {
        let document = parsed(text)?;
        let format = format_of(text, &document)?;
        let channel = document.channel;
        let Some(run) = &document.run else { return Ok(PcmFormatFile { format, info: RunInfo::default(), channel }) };
        let info = RunInfo::from_toml(&run.get_ref().to_string());
        let info = info.map_err(|wrong| in_text(text, (run.span().start, format!("run: {}", wrong.what))))?;
        Ok(PcmFormatFile { format, info, channel })
    }

    /// Reads the file.
    ///
    /// # Errors
    /// [`RecordingError`] with path, line and column.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let text = read_text(path).map_err(|wrong| whole(wrong.to_string()))?;
        PcmFormatFile::from_toml(&text).map_err(|wrong| whole(format!("expected a format of PCM frames: {wrong}")))
    }
}

/// A mistake: its byte offset, and what was expected and found.
type Wrong = (usize, String);

impl PcmFormat {
    /// Reads the file's text.
    ///
    /// # Errors
    /// [`PcmFormatFileError`] where it is not TOML, a key is not known or missing, or the format cannot be.
    pub fn from_toml(text: &str) -> Result<Self, PcmFormatFileError> {
        format_of(text, &parsed(text)?)
    }
}

fn format_of(text: &str, document: &FormatDocument) -> Result<PcmFormat, PcmFormatFileError> {
    let spec = spec_of(document).map_err(|wrong| in_text(text, wrong))?;
    PcmFormat::new(spec).map_err(|error| in_text(text, (start_of(document, &error.place), error.to_string())))
}

fn parsed(text: &str) -> Result<FormatDocument, PcmFormatFileError> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let start = error.span().map_or(0, |span| span.start);
        in_text(text, (start, with_nearest(error.message())))
    })
}

fn spec_of(document: &FormatDocument) -> Result<PcmFormatSpec, Wrong> {
    let line_codes = [("nrz_l", LineCode::NrzL), ("rnrz_l", LineCode::RnrzL)];
    let polarities =
        [("automatic", PolarityRule::Automatic), ("normal", PolarityRule::Normal), ("inverted", PolarityRule::Inverted)];
    let mut special_words = Vec::new();
    for word in &document.word {
        let word = word.get_ref();
        let parity = match (&word.parity, &word.parity_place) {
            (None, None) => None,
            (kind, place) => {
                Some(parity(kind.as_ref().or(document.parity.as_ref()), place.as_ref().or(document.parity_place.as_ref()))?)
            }
        };
        special_words.push(SpecialWord { word: word.number, bits: word.bits, parity });
    }
    let subframe_id = document.subframe_id.as_ref().map(|id| subframe_id(id.get_ref())).transpose()?;
    let (sync, rules) = sync_of(document.sync.get_ref());
    Ok(PcmFormatSpec {
        name: document.name.clone(),
        bit_rate: *document.bit_rate.get_ref(),
        line_code: chosen("line_code", document.line_code.as_ref(), &line_codes)?,
        polarity: chosen("polarity", document.polarity.as_ref(), &polarities)?,
        sync,
        rules: Some(rules),
        words: *document.words.get_ref(),
        word_bits: *document.word_bits.get_ref(),
        parity: parity(document.parity.as_ref(), document.parity_place.as_ref())?,
        special_words,
        minor_frames: document.minor_frames.as_ref().map_or(1, |frames| *frames.get_ref()),
        subframe_id,
        parameters: document.parameter.iter().map(parameter).collect::<Result<_, _>>()?,
    })
}

fn sync_of(table: &SyncTable) -> (SyncPattern, SyncRules) {
    let (pattern, bits) = (*table.pattern.get_ref(), *table.bits.get_ref());
    let whole = SyncPattern::whole(pattern, bits);
    let sync = SyncPattern { mask: table.mask.as_ref().map_or(whole.mask, |mask| *mask.get_ref()), ..whole };
    let default = SyncRules::for_length(sync.compared());
    let or = |given: &Option<Spanned<u32>>, default| given.as_ref().map_or(default, |given| *given.get_ref());
    let rules = SyncRules {
        search_errors: or(&table.search_errors, default.search_errors),
        check_errors: or(&table.check_errors, default.check_errors),
        lock_errors: or(&table.lock_errors, default.lock_errors),
        check_frames: or(&table.check_frames, default.check_frames),
        flywheel_frames: or(&table.flywheel_frames, default.flywheel_frames),
        slip_bits: or(&table.slip_bits, default.slip_bits),
    };
    (sync, rules)
}

fn subframe_id(table: &IdTable) -> Result<SubframeId, Wrong> {
    let directions = [("up", CountDirection::Up), ("down", CountDirection::Down)];
    let direction = chosen("counts", table.counts.as_ref(), &directions)?;
    let part = WordPart { word: table.word, bits: table.bits };
    Ok(SubframeId { part, first_value: table.first_value, direction })
}

fn parity(kind: Option<&Spanned<String>>, place: Option<&Spanned<String>>) -> Result<Parity, Wrong> {
    let places = [("trailing", ParityPlace::Trailing), ("leading", ParityPlace::Leading)];
    let place = chosen("parity_place", place, &places)?;
    chosen("parity", kind, &[("none", Parity::None), ("odd", Parity::Odd(place)), ("even", Parity::Even(place))])
}

fn parameter(spanned: &Spanned<ParameterTable>) -> Result<ParameterSpec, Wrong> {
    let table = spanned.get_ref();
    let start = table.name.span().start;
    let one = PlaceOf {
        word: &table.word,
        bits: &table.bits,
        parts: &table.parts,
        word_interval: &table.word_interval,
        frame: &table.frame,
        frame_interval: &table.frame_interval,
    };
    let places = match &table.places {
        None => vec![one.place(start)?],
        Some(places) if one.is_empty() => {
            let place = |spanned: &Spanned<PlaceTable>| {
                let PlaceTable { word, bits, parts, word_interval, frame, frame_interval } = spanned.get_ref();
                PlaceOf { word, bits, parts, word_interval, frame, frame_interval }.place(spanned.span().start)
            };
            places.get_ref().iter().map(place).collect::<Result<_, _>>()?
        }
        Some(places) => {
            let what = "places: expected nothing else that says where the parameter stands, found other keys".to_owned();
            return Err((places.span().start, what));
        }
    };
    let encodings = RawEncoding::ALL.map(|(encoding, name)| (name, encoding));
    let limits = table.limits.as_ref().map(|limits| limits.get_ref());
    Ok(ParameterSpec {
        name: table.name.get_ref().clone(),
        unit: table.unit.clone(),
        places,
        encoding: chosen("encoding", table.encoding.as_ref(), &encodings)?,
        calibration: table.calibration.as_ref().map_or(Ok(Calibration::Identity), calibration)?,
        limits: limits.map_or(ParameterLimits::default(), |limits| ParameterLimits {
            low: limits.low,
            high: limits.high,
            step: limits.step,
        }),
    })
}

/// The keys that say where a parameter stands.
struct PlaceOf<'t> {
    word: &'t Option<Spanned<u32>>,
    bits: &'t Option<Spanned<(u32, u32)>>,
    parts: &'t Option<Spanned<Vec<PartTable>>>,
    word_interval: &'t Option<Spanned<u32>>,
    frame: &'t Option<Spanned<u32>>,
    frame_interval: &'t Option<Spanned<u32>>,
}

impl PlaceOf<'_> {
    fn is_empty(&self) -> bool {
        let word = self.word.is_none() && self.bits.is_none() && self.parts.is_none();
        word && self.word_interval.is_none() && self.frame.is_none() && self.frame_interval.is_none()
    }

    fn place(&self, start: usize) -> Result<ParameterPlace, Wrong> {
        let parts = match (self.word, self.parts) {
            (Some(word), None) => vec![WordPart { word: *word.get_ref(), bits: self.bits.as_ref().map(|bits| *bits.get_ref()) }],
            (None, Some(parts)) if self.bits.is_none() => {
                parts.get_ref().iter().map(|part| WordPart { word: part.word, bits: part.bits }).collect()
            }
            (None, Some(parts)) => {
                return Err((parts.span().start, "parts: expected the bits of each part in it, found bits beside it".into()));
            }
            (Some(_), Some(parts)) => return Err((parts.span().start, "expected word or parts, found both".into())),
            (None, None) => return Err((start, "expected word, parts or places, found none of them".into())),
        };
        let interval = self.frame_interval.as_ref();
        if let (Some(interval), None) = (interval, self.frame) {
            return Err((interval.span().start, "frame_interval: expected frame beside it, found none".into()));
        }
        let interval = interval.map(|interval| *interval.get_ref());
        let frames = self.frame.as_ref().map(|first| FrameSet { first: *first.get_ref(), interval });
        let word_interval = self.word_interval.as_ref().map(|interval| *interval.get_ref());
        Ok(ParameterPlace { parts, word_interval, frames })
    }
}

fn calibration(spanned: &Spanned<CalibrationTable>) -> Result<Calibration, Wrong> {
    let CalibrationTable { kind, coefficients, pairs, range, outside } = spanned.get_ref();
    let outsides = [("refuse", OutsideRange::Refuse), ("flag", OutsideRange::Flag)];
    let beyond = chosen("outside", outside.as_ref(), &outsides)?;
    let kinds = [("identity", 0), ("polynomial", 1), ("table", 2), ("pair_wise_linear", 3)];
    // What each kind takes: coefficients, pairs, range, outside.
    let (takes, found) = match (chosen("kind", Some(kind), &kinds)?, coefficients, pairs) {
        (1, Some(coefficients), _) => {
            let (coefficients, range) = (coefficients.clone(), range.as_ref().map(|range| *range.get_ref()));
            ([true, false, true, true], Calibration::Polynomial { coefficients, range, outside: beyond })
        }
        (2, _, Some(pairs)) => ([false, true, false, false], Calibration::Table { pairs: pairs.clone() }),
        (3, _, Some(pairs)) => {
            ([false, true, false, true], Calibration::PairWiseLinear { pairs: pairs.clone(), outside: beyond })
        }
        (0, ..) => ([false; 4], Calibration::Identity),
        (1, ..) => return Err((kind.span().start, "polynomial: expected coefficients, found none".into())),
        _ => return Err((kind.span().start, format!("{}: expected pairs, found none", kind.get_ref()))),
    };
    let given = [
        ("coefficients", coefficients.is_some()),
        ("pairs", pairs.is_some()),
        ("range", range.is_some()),
        ("outside", outside.is_some()),
    ];
    match given.iter().zip(takes).find(|((_, given), takes)| *given && !takes) {
        Some(((key, _), _)) => Err((spanned.span().start, format!("{}: expected no {key}, found some", kind.get_ref()))),
        None => Ok(found),
    }
}

/// The value of a name; the first where there is none.
fn chosen<T: Copy>(key: &str, given: Option<&Spanned<String>>, known: &[(&str, T)]) -> Result<T, Wrong> {
    let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
    let (start, name) = match given {
        Some(given) => (given.span().start, given.get_ref().as_str()),
        None => (0, names.first().copied().unwrap_or_default()),
    };
    known.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
        let nearest = nearest(name, &names).unwrap_or_default();
        (start, format!("{key}: expected one of {}, found {name:?}; nearest is {nearest:?}", names.join(", ")))
    })
}

/// The byte at which stands what a mistake is about.
fn start_of(document: &FormatDocument, place: &FormatPlace) -> usize {
    fn of<T>(given: Option<&Spanned<T>>) -> Option<usize> {
        given.map(|given| given.span().start)
    }
    let sync = document.sync.get_ref();
    let found = match place {
        FormatPlace::Format("bit_rate") => of(Some(&document.bit_rate)),
        FormatPlace::Format("words") => of(Some(&document.words)),
        FormatPlace::Format("word_bits") => of(Some(&document.word_bits)),
        FormatPlace::Format("minor_frames") => of(document.minor_frames.as_ref()),
        FormatPlace::Format("subframe_id") => of(document.subframe_id.as_ref()),
        FormatPlace::Format("sync.pattern") => of(Some(&sync.pattern)),
        FormatPlace::Format("sync.bits") => of(Some(&sync.bits)),
        FormatPlace::Format("sync.mask") => of(sync.mask.as_ref()),
        FormatPlace::Format("sync.search_errors") => of(sync.search_errors.as_ref()),
        FormatPlace::Format("sync.check_errors") => of(sync.check_errors.as_ref()),
        FormatPlace::Format("sync.lock_errors") => of(sync.lock_errors.as_ref()),
        FormatPlace::Format("sync.check_frames") => of(sync.check_frames.as_ref()),
        FormatPlace::Format("sync.flywheel_frames") => of(sync.flywheel_frames.as_ref()),
        FormatPlace::Format("sync.slip_bits") => of(sync.slip_bits.as_ref()),
        FormatPlace::Format(_) => of(Some(&document.sync)),
        FormatPlace::SpecialWord(index) => of(document.word.get(*index)),
        FormatPlace::Parameter(index, _, key) => document.parameter.get(*index).and_then(|table| {
            let table = table.get_ref();
            let key = match *key {
                "word" => of(table.word.as_ref()).or(of(table.parts.as_ref())),
                "parts" => of(table.parts.as_ref()),
                "word_interval" => of(table.word_interval.as_ref()),
                "frame" => of(table.frame.as_ref()),
                "frame_interval" => of(table.frame_interval.as_ref()),
                "encoding" => of(table.encoding.as_ref()),
                "calibration" => of(table.calibration.as_ref()),
                "limits" => of(table.limits.as_ref()),
                _ => None,
            };
            key.or(of(table.places.as_ref())).or(of(Some(&table.name)))
        }),
    };
    found.unwrap_or_else(|| document.sync.span().start)
}

/// The message, and after an unknown key the nearest that is known.
fn with_nearest(message: &str) -> String {
    let mut names = message.split('`').skip(1).step_by(2);
    match names.next().filter(|_| message.starts_with("unknown field")) {
        Some(found) => match nearest(found, &names.collect::<Vec<_>>()) {
            Some(name) => format!("{message}; nearest is `{name}`"),
            None => message.to_owned(),
        },
        None => message.to_owned(),
    }
}

fn in_text(text: &str, (offset, what): Wrong) -> PcmFormatFileError {
    PcmFormatFileError::in_text(text, offset, what)
}

#[cfg(test)]
#[path = "format_file_tests.rs"]
mod tests;
