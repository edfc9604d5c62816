//! The tables of a PCM format file as they stand in TOML, with the places of what can be wrong.
//!
//! What the keys mean is said in [`format_file`](super::format_file).

use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FormatDocument {
    #[serde(default)]
    pub(super) name: String,
    pub(super) bit_rate: Spanned<f64>,
    pub(super) line_code: Option<Spanned<String>>,
    pub(super) polarity: Option<Spanned<String>>,
    pub(super) words: Spanned<u32>,
    pub(super) word_bits: Spanned<u32>,
    pub(super) parity: Option<Spanned<String>>,
    pub(super) parity_place: Option<Spanned<String>>,
    pub(super) minor_frames: Option<Spanned<u32>>,
    pub(super) sync: Spanned<SyncTable>,
    pub(super) subframe_id: Option<Spanned<IdTable>>,
    #[serde(default)]
    pub(super) word: Vec<Spanned<WordTable>>,
    #[serde(default)]
    pub(super) parameter: Vec<Spanned<ParameterTable>>,
    pub(super) run: Option<Spanned<toml::Table>>,
    pub(super) channel: Option<u16>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SyncTable {
    pub(super) pattern: Spanned<u64>,
    pub(super) bits: Spanned<u32>,
    pub(super) mask: Option<Spanned<u64>>,
    pub(super) search_errors: Option<Spanned<u32>>,
    pub(super) check_errors: Option<Spanned<u32>>,
    pub(super) lock_errors: Option<Spanned<u32>>,
    pub(super) check_frames: Option<Spanned<u32>>,
    pub(super) flywheel_frames: Option<Spanned<u32>>,
    pub(super) slip_bits: Option<Spanned<u32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IdTable {
    pub(super) word: u32,
    pub(super) bits: Option<(u32, u32)>,
    #[serde(default)]
    pub(super) first_value: u32,
    pub(super) counts: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WordTable {
    pub(super) number: u32,
    pub(super) bits: Option<u32>,
    pub(super) parity: Option<Spanned<String>>,
    pub(super) parity_place: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ParameterTable {
    pub(super) name: Spanned<String>,
    #[serde(default)]
    pub(super) unit: String,
    pub(super) word: Option<Spanned<u32>>,
    pub(super) bits: Option<Spanned<(u32, u32)>>,
    pub(super) parts: Option<Spanned<Vec<PartTable>>>,
    pub(super) places: Option<Spanned<Vec<Spanned<PlaceTable>>>>,
    pub(super) word_interval: Option<Spanned<u32>>,
    pub(super) frame: Option<Spanned<u32>>,
    pub(super) frame_interval: Option<Spanned<u32>>,
    pub(super) encoding: Option<Spanned<String>>,
    pub(super) calibration: Option<Spanned<CalibrationTable>>,
    pub(super) limits: Option<Spanned<LimitsTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaceTable {
    pub(super) word: Option<Spanned<u32>>,
    pub(super) bits: Option<Spanned<(u32, u32)>>,
    pub(super) parts: Option<Spanned<Vec<PartTable>>>,
    pub(super) word_interval: Option<Spanned<u32>>,
    pub(super) frame: Option<Spanned<u32>>,
    pub(super) frame_interval: Option<Spanned<u32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartTable {
    pub(super) word: u32,
    pub(super) bits: Option<(u32, u32)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CalibrationTable {
    pub(super) kind: Spanned<String>,
    pub(super) coefficients: Option<Vec<f64>>,
    pub(super) pairs: Option<Vec<(f64, f64)>>,
    pub(super) range: Option<Spanned<(f64, f64)>>,
    pub(super) outside: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsTable {
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
    pub(super) step: Option<f64>,
}
