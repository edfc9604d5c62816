//! The format of a PCM channel, with its measurements, as the setup says it.
//!
//! Consumes [`Tmats`] and the number of a channel; produces a [`PcmFormat`] for the decommutator. Words are numbered in the setup
//! as in the format. Refused: a setup that does not say pattern, words or bit rate, contradicts itself, or has words sent least
//! significant bit first. Measurements that cannot be decommutated are left out, each with a sentence.
//! Source: IRIG 106-09 Chapter 9, attribute groups P, D and C.

use super::measurement_map::MeasurementMap;
use super::pcm_layout::PcmMode;
use super::tmats::Tmats;
use super::tmats_check::{Contradiction, own_contradictions};
use super::tmats_measurements::TmatsMeasurements;
use super::tmats_pcm::{SubframeCounter, TmatsParity, TmatsPcmFormat};
use crate::io::telemetry::pcm::bits::LineCode;
use crate::io::telemetry::pcm::format::{CountDirection, Parity, ParityPlace, PcmFormatSpec, SpecialWord, SubframeId, WordPart};
use crate::io::telemetry::pcm::layout::PcmFormat;
use crate::io::telemetry::pcm::sync_pattern::{PolarityRule, SyncPattern};

/// What the setup says of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct TmatsChannel {
    /// The format.
    pub format: PcmFormat,
    /// The attributes that it was made from.
    pub written: TmatsPcmFormat,
    /// Measurements that are left out, each in a sentence.
    pub left_out: Vec<String>,
    /// What the setup does not say of channels and was assumed, each in a sentence.
    pub assumed: Vec<String>,
}

impl TmatsChannel {
    /// The format of a recorder channel; the map says which of its measurements are channels under other names.
    ///
    /// # Errors
    /// A sentence where the setup has no such channel, or its format is not whole or cannot be.
    pub fn of_channel(tmats: &Tmats, channel: u16, map: &MeasurementMap) -> Result<Self, String> {
        let written = TmatsPcmFormat::of_channel(tmats, channel).map_err(|error| error.to_string())?;
        refuse_ambiguous(tmats, &written)?;
        // Unpacked words stand in cells of their own, which do not show how long they are.
        let own = own_contradictions(&written).into_iter().find(|one| matches!(one, Contradiction::OwnLength { .. }));
        if let Some(own) = own.filter(|_| written.mode == Some(PcmMode::Unpacked)) {
            return Err(format!("{own}: which of them is right is not known, give a format of its frames"));
        }
        let TmatsMeasurements { parameters, mut left_out, assumed } = TmatsMeasurements::of_link(tmats, &written.link, map);
        let spec = PcmFormatSpec { parameters, ..spec_of(&written)? };
        // A measurement outside of the frame is left out, not the whole format.
        let (format, wrong) = PcmFormat::leaving_out(spec).map_err(|error| format!("P-{}: {error}", written.group))?;
        left_out.extend(wrong.iter().map(ToString::to_string));
        Ok(TmatsChannel { format, written, left_out, assumed })
    }
}

/// Where the group of the channel says two things of one, none of them is right by itself.
fn refuse_ambiguous(tmats: &Tmats, written: &TmatsPcmFormat) -> Result<(), String> {
    let prefix = format!("P-{}\\", written.group);
    let is_used = |name: &str| ["D1", "D2", "D4", "D7", "D8"].contains(&name) || USED.iter().any(|used| name.starts_with(used));
    if let Some(code) = tmats.contradicted().find(|code| code.strip_prefix(&prefix).is_some_and(is_used)) {
        return Err(format!("{code} stands twice, with different values: give a format of its frames"));
    }
    let same = |(code, value): &(&str, &str)| code.starts_with("P-") && code.ends_with("\\DLN") && *value == written.link;
    match tmats.attributes().filter(same).count() {
        0 | 1 => Ok(()),
        count => Err(format!("{count} groups P describe the data link {}: give a format of its frames", written.link)),
    }
}

/// How the names of attributes of a group P begin that are used, beside those of the line.
const USED: [&str; 5] = ["F", "MF", "SYNC", "ISF", "IDC"];

/// The format without its measurements.
fn spec_of(written: &TmatsPcmFormat) -> Result<PcmFormatSpec, String> {
    let group = written.group;
    let missing = |attribute: &str| {
        let code = format!("P-{group}\\{attribute}");
        let found = if written.unreadable.contains(&code) { "one that cannot be read" } else { "none" };
        format!("{code}: expected a value, found {found}")
    };
    if written.lsb_first == Some(true) {
        return Err(format!("P-{group}\\F2: words are sent least significant bit first, which is not read"));
    }
    let pattern = written.sync_pattern.ok_or_else(|| missing("MF5"))?;
    let bits = written.sync_bits.ok_or_else(|| missing("MF4"))?;
    let code = written.code.as_deref().unwrap_or("NRZ-L").to_ascii_uppercase();
    let line_code = match (code.as_str(), written.randomised) {
        ("RNRZ-L", _) | ("NRZ-L", Some(true)) => LineCode::RnrzL,
        // Other codes are undone by the bit synchroniser before a recorder; what it hands on is NRZ-L.
        _ => LineCode::NrzL,
    };
    let polarity = match written.inverted {
        Some(true) => PolarityRule::Inverted,
        Some(false) => PolarityRule::Normal,
        None => PolarityRule::Automatic,
    };
    let place = if written.parity_leads == Some(true) { ParityPlace::Leading } else { ParityPlace::Trailing };
    let parity = match written.parity {
        Some(TmatsParity::Odd) => Parity::Odd(place),
        Some(TmatsParity::Even) => Parity::Even(place),
        Some(TmatsParity::None) | None => Parity::None,
    };
    let special = written.own_lengths.iter().map(|(word, bits)| SpecialWord { word: *word, bits: Some(*bits), parity: None });
    Ok(PcmFormatSpec {
        name: written.link.clone(),
        bit_rate: written.bit_rate.ok_or_else(|| missing("D2"))? as f64,
        line_code,
        polarity,
        sync: SyncPattern::whole(pattern, bits),
        rules: None,
        words: written.words.ok_or_else(|| missing("MF1"))?,
        word_bits: written.word_bits.ok_or_else(|| missing("F1"))?,
        parity,
        special_words: special.collect(),
        minor_frames: written.minor_frames.unwrap_or(1),
        subframe_id: written.counters.iter().find(|counter| counter.kind == "ID").and_then(subframe_id),
        parameters: Vec::new(),
    })
}

/// The counter; `None` where the setup does not say where it stands, or counts least significant bit first.
fn subframe_id(counter: &SubframeCounter) -> Option<SubframeId> {
    if counter.lsb_first == Some(true) {
        return None;
    }
    let bits = match (counter.bit, counter.bits) {
        (Some(first), Some(bits)) if bits > 0 => Some((first, first.checked_add(bits - 1)?)),
        _ => None,
    };
    let part = WordPart { word: counter.word?, bits };
    let (value, frame) = (counter.first.0.unwrap_or(0), counter.first.1.unwrap_or(1).saturating_sub(1));
    let (direction, first_value) = match counter.increasing {
        Some(false) => (CountDirection::Down, value.checked_add(frame)?),
        _ => (CountDirection::Up, value.checked_sub(frame)?),
    };
    Some(SubframeId { part, first_value, direction })
}

#[cfg(test)]
#[path = "tmats_format_tests.rs"]
mod tests;
