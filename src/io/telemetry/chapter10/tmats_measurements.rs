//! What the setup says of the measurements of a PCM channel: their places, their coding, their conversion.
//!
//! Consumes [`Tmats`] and the name of a data link; produces the parameters of a PCM format, and a sentence for each measurement
//! that is left out. Attributes read:
//! | `D-x` | | `C-d` | |
//! | --- | --- | --- | --- |
//! | `DLN` | data link, that of the `P` group | `DCN` | name of the measurement, that of `MN-y-n` |
//! | `MN\N-y`, `MN-y-n` | measurements of list y (the first list) | `MN3` | engineering unit |
//! | `MN1-y-n` `MN3-y-n` | parity, order of transfer (`M`, `D`) | `BFM`, `FPF` | binary format, floating-point format |
//! | `LT-y-n` | kind of location: `WDFR`, word and frame | `DCT` | conversion: `NON`, `COE`, `PRS` |
//! | `MML\N-y-n` | locations m | `CO`, `CO\N`, `CO-n` | coefficients of a polynomial |
//! | `MNF\N-y-n-m` | fragments e of a location | `PS\N`, `PS1` | pair sets, whether a polynomial is fitted to them |
//! | `WP` `WI` `-y-n-m-e` | word, interval of words | `PS3-n`, `PS4-n` | telemetry value, engineering value |
//! | `FP` `FI` `-y-n-m-e` | minor frame, interval of minor frames | | |
//! | `WFM` `WFT` `WFP` `-y-n-m-e` | bit mask, order of transfer, position (1 the most significant) | | |
//!
//! Left out, each with the reason: other kinds of location, words sent least significant bit first, ends of intervals (`EWP`,
//! `EFP`), fragments in different minor frames, conversions by curve fits or algorithms, coefficients or pairs without a kind of
//! conversion or beyond their stated number, an attribute that stands twice with different values. A channel without binary
//! format is read as unsigned, and a sentence says so. A measurement that is called as a
//! channel, in capitals or not, or that a [map](MeasurementMap) names, is that channel; it needs a unit.
//! Source: IRIG 106-09 Chapter 9, attribute groups D and C.

use super::measurement_map::MeasurementMap;
use super::tmats::Tmats;
use crate::flight::channel::Channel;
use crate::flight::file::run_file::RecordingColumn;
use crate::io::telemetry::pcm::calibration::{Calibration, OutsideRange};
use crate::io::telemetry::pcm::encoding::RawEncoding;
use crate::io::telemetry::pcm::format::{FrameSet, ParameterPlace, ParameterSpec, WordPart};
use std::collections::HashMap;

/// Measurements that are read at most.
pub const MEASUREMENTS: u32 = 4096;
/// Locations of a measurement, fragments of a location, pairs and coefficients that are read at most.
const LISTED: u32 = 1024;

/// The measurements of a data link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TmatsMeasurements {
    /// Those that can be decommutated.
    pub parameters: Vec<ParameterSpec>,
    /// Those that cannot, each in a sentence; those called as a channel come first.
    pub left_out: Vec<String>,
    /// What the setup does not say of channels and was assumed, each in a sentence.
    pub assumed: Vec<String>,
}

impl TmatsMeasurements {
    /// Reads the measurements of the data link of that name; the map says which of them are channels under other names.
    pub fn of_link(tmats: &Tmats, link: &str, map: &MeasurementMap) -> Self {
        let mut found = TmatsMeasurements::default();
        let group = tmats.attributes().find_map(|(code, value)| {
            let group = code.strip_suffix("\\DLN")?;
            (group.starts_with("D-") && value == link).then(|| group.to_owned())
        });
        let Some(group) = group else { return found };
        let d = MeasurementList { tmats, group: &group };
        let conversions = conversions(tmats);
        if d.number("ML\\N").is_ok_and(|lists| lists.is_some_and(|lists| lists > 1)) {
            found.left_out.push(format!("{group} has several measurement lists: the first is used"));
        }
        let count = match d.number("MN\\N-1") {
            Ok(count) => count.unwrap_or(0),
            Err(why) => {
                found.left_out.push(format!("{group}: {why}"));
                return found;
            }
        };
        if count > MEASUREMENTS {
            found.left_out.push(format!("{group} has {count} measurements: the first {MEASUREMENTS} are read"));
        }
        let frame_parity = parity_of_link(tmats, link);
        let beyond = (count + 1..=MEASUREMENTS).map_while(|n| d.text(&format!("MN-1-{n}")));
        found.left_out.extend(beyond.map(|name| format!("measurement {name}: stands beyond the {count} of MN\\N-1")));
        let mut others = Vec::new();
        for n in 1..=count.min(MEASUREMENTS) {
            let Some(name) = d.text(&format!("MN-1-{n}")) else { continue };
            match d.measurement(n, name, map, &conversions, frame_parity) {
                Ok(MeasuredParameter { parameter, has_encoding, is_counts }) => {
                    if !has_encoding && Channel::from_name(&parameter.name).is_some() {
                        found
                            .assumed
                            .push(format!("measurement {name}: no binary format (BFM of its group C): read as unsigned"));
                    }
                    if is_counts && Channel::from_name(&parameter.name).is_some() {
                        let unit = &parameter.unit;
                        found
                            .assumed
                            .push(format!("measurement {name}: no conversion (DCT NON): its counts are taken as {unit}"));
                    }
                    found.parameters.push(parameter);
                }
                Err(why) => {
                    let is_channel =
                        map.of_measurement(name).is_some() || Channel::from_name(&name.to_ascii_lowercase()).is_some();
                    let left_out = if is_channel { &mut found.left_out } else { &mut others };
                    left_out.push(format!("measurement {name}: {why}"));
                }
            }
        }
        found.left_out.append(&mut others);
        found
    }
}

/// A measurement that can be decommutated.
struct MeasuredParameter {
    parameter: ParameterSpec,
    /// Whether the setup says how its bits are coded.
    has_encoding: bool,
    /// Whether whole numbers are not converted.
    is_counts: bool,
}

/// The parity of the words of a data link, `F3` of its group P.
fn parity_of_link<'a>(tmats: &'a Tmats, link: &str) -> Option<&'a str> {
    let group = tmats
        .attributes()
        .find_map(|(code, value)| code.strip_suffix("\\DLN").filter(|_| value == link && code.starts_with("P-")));
    tmats.get(&format!("{}\\F3", group?))
}

/// The group C of each measurement, by its name in small letters; of several the first.
fn conversions(tmats: &Tmats) -> HashMap<String, &str> {
    let mut groups = HashMap::new();
    for (code, value) in tmats.attributes() {
        if let Some(group) = code.strip_suffix("\\DCN").filter(|group| group.starts_with("C-")) {
            groups.entry(value.to_ascii_lowercase()).or_insert(group);
        }
    }
    groups
}

/// The attributes of a group D.
struct MeasurementList<'a> {
    tmats: &'a Tmats,
    group: &'a str,
}

impl<'a> MeasurementList<'a> {
    fn text(&self, name: &str) -> Option<&'a str> {
        self.tmats.get(&format!("{}\\{name}", self.group)).filter(|value| !value.is_empty())
    }

    /// The names of its attributes.
    fn names(&self) -> impl Iterator<Item = &'a str> {
        let group = self.group;
        self.tmats.attributes().filter_map(move |(code, _)| code.strip_prefix(group)?.strip_prefix('\\'))
    }

    /// Where an attribute of such a name stands twice with different values, none of them is right by itself.
    fn refuse_contradicted(&self, is_used: impl Fn(&str) -> bool) -> Result<(), String> {
        let own = |code: &'a str| code.strip_prefix(self.group)?.strip_prefix('\\').filter(|name| is_used(name));
        match self.tmats.contradicted().find_map(own) {
            Some(name) => Err(format!("{name} stands twice, with different values")),
            None => Ok(()),
        }
    }

    /// Numbered attributes beyond their stated count: one of the two is wrong.
    fn refuse_beyond(&self, prefix: &str, count: u32, stated: &str) -> Result<(), String> {
        let beyond = |name: &&str| {
            let number = name.strip_prefix(prefix).and_then(|number| number.parse::<u32>().ok());
            number.is_some_and(|number| number > count) && self.text(name).is_some()
        };
        match self.names().find(beyond) {
            Some(name) => Err(format!("{name} stands beyond the {count} of {stated}")),
            None => Ok(()),
        }
    }

    /// `None` where it is not there; what is no number is no default either.
    fn number(&self, name: &str) -> Result<Option<u32>, String> {
        let parsed = |text: &str| text.parse().map_err(|_| format!("{name}: expected a whole number, found {text}"));
        self.text(name).map(parsed).transpose()
    }

    /// A number that a conversion cannot do without.
    fn value(&self, name: &str) -> Result<f64, String> {
        let text = self.text(name).ok_or_else(|| format!("{name}: expected a number, found none"))?;
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| format!("{name}: expected a number, found {text}"))
    }

    fn measurement(
        &self,
        n: u32,
        name: &str,
        map: &MeasurementMap,
        conversions: &HashMap<String, &str>,
        frame_parity: Option<&str>,
    ) -> Result<MeasuredParameter, String> {
        let own = format!("1-{n}");
        self.refuse_contradicted(|code| {
            let place = code.split_once('-').map_or("", |(_, place)| place);
            place.strip_prefix(&own).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
        })?;
        match self.text(&format!("LT-1-{n}")) {
            None | Some("WDFR") => {}
            Some(other) => return Err(format!("location of kind {other}, word and frame (WDFR) is read")),
        }
        match self.text(&format!("MN1-1-{n}")) {
            Some(own @ ("EV" | "OD")) if frame_parity != Some(own) => {
                return Err(format!("parity of its own (MN1 {own}); that of all words (F3 of group P) is read"));
            }
            _ => {}
        }
        self.most_significant_first(&format!("MN3-1-{n}"))?;
        let count = self.number(&format!("MML\\N-1-{n}"))?.unwrap_or(1);
        if !(1..=LISTED).contains(&count) {
            return Err(format!("{count} locations"));
        }
        let places = (1..=count).map(|m| self.place(n, m)).collect::<Result<Vec<_>, _>>()?;
        let lower = name.to_ascii_lowercase();
        let group = conversions.get(&lower).copied();
        let named = map.of_measurement(name);
        let name = match named {
            Some(named) => named.channel.clone(),
            None if Channel::from_name(&lower).is_none() => name.to_owned(),
            None => match map.of_channel(&lower) {
                None => lower,
                Some(other) => return Err(format!("{} is the channel {lower}, as the map says", other.measurement)),
            },
        };
        let mut parameter = ParameterSpec { name, places, ..ParameterSpec::default() };
        let conversion = group.map(|group| MeasurementList { tmats: self.tmats, group });
        if let Some(conversion) = &conversion {
            conversion.convert(&mut parameter)?;
        }
        let has_encoding = conversion.as_ref().is_some_and(|conversion| conversion.text("BFM").is_some());
        let is_float = conversion.as_ref().is_some_and(|conversion| conversion.text("BFM") == Some("FPT"));
        let is_counts = !is_float && conversion.is_some_and(|conversion| conversion.text("DCT") == Some("NON"));
        if let Some(unit) = named.and_then(|named| named.unit.as_ref()) {
            parameter.unit.clone_from(unit);
        }
        if Channel::from_name(&parameter.name).is_some() {
            if parameter.unit.is_empty() {
                return Err("no engineering unit (MN3 of its group C): not used as a channel".to_owned());
            }
            RecordingColumn::new(&parameter.name, Some(&parameter.unit))?;
        }
        Ok(MeasuredParameter { parameter, has_encoding, is_counts })
    }

    fn most_significant_first(&self, attribute: &str) -> Result<(), String> {
        match self.text(attribute) {
            None | Some("M" | "D" | "MSB") => Ok(()),
            Some(other) => Err(format!("order of transfer {other}, the most significant bit first is read")),
        }
    }

    /// The location m.
    fn place(&self, n: u32, m: u32) -> Result<ParameterPlace, String> {
        let count = self.number(&format!("MNF\\N-1-{n}-{m}"))?.unwrap_or(1);
        if !(1..=LISTED).contains(&count) {
            return Err(format!("{count} fragments"));
        }
        // Position of each fragment, its parts, its interval of words and its minor frames.
        let mut fragments = Vec::new();
        for e in 1..=count {
            let of = |name: &str| format!("{name}-1-{n}-{m}-{e}");
            for end in ["EWP", "EFP"] {
                if self.text(&of(end)).is_some() {
                    return Err(format!("interval with an end ({end})"));
                }
            }
            self.most_significant_first(&of("WFT"))?;
            let word = self.number(&of("WP"))?.ok_or_else(|| "no word position".to_owned())?;
            let interval = self.number(&of("WI"))?.filter(|interval| *interval > 0);
            let frames = match (self.number(&of("FP"))?, self.number(&of("FI"))?) {
                (Some(first), Some(interval)) => (!(first == 1 && interval == 1))
                    .then_some(FrameSet { first, interval: Some(interval).filter(|interval| *interval > 0) }),
                (Some(first), None) => (first > 1).then_some(FrameSet { first, interval: None }),
                (None, _) => None,
            };
            let position = self.number(&of("WFP"))?.unwrap_or(e);
            fragments.push((position, masked(word, self.text(&of("WFM")))?, interval, frames));
        }
        fragments.sort_by_key(|(position, ..)| *position);
        if fragments.windows(2).any(|pair| matches!(pair, [(one, ..), (next, ..)] if one == next)) {
            return Err("two fragments at one position: their order is not known".to_owned());
        }
        let Some((_, _, word_interval, frames)) = fragments.first().cloned() else { return Err("no fragment".to_owned()) };
        if fragments.iter().any(|(_, _, interval, set)| *interval != word_interval || *set != frames) {
            return Err("fragments in different minor frames or at different intervals".to_owned());
        }
        let parts = fragments.into_iter().flat_map(|(_, parts, ..)| parts).collect();
        Ok(ParameterPlace { parts, word_interval, frames })
    }

    /// Unit, encoding and calibration by this group C.
    fn convert(&self, parameter: &mut ParameterSpec) -> Result<(), String> {
        let c = self;
        c.refuse_contradicted(|_| true)?;
        parameter.unit = unit(c.text("MN3").unwrap_or_default());
        parameter.encoding = c.encoding(parameter)?;
        parameter.calibration = match c.text("DCT") {
            Some("NON") => Calibration::Identity,
            None => match c.names().find(|name| name.starts_with("CO") || name.starts_with("PS")) {
                Some(name) => return Err(format!("{name} without a kind of conversion (DCT)")),
                None => Calibration::Identity,
            },
            Some("COE") => {
                let order = c.number("CO\\N")?.ok_or_else(|| "no order of its polynomial (CO\\N)".to_owned())?;
                if order > LISTED {
                    return Err(format!("{order} coefficients"));
                }
                c.refuse_beyond("CO-", order, "CO\\N")?;
                let codes = std::iter::once("CO".to_owned()).chain((1..=order).map(|n| format!("CO-{n}")));
                let coefficients = codes
                    .map(|code| c.value(&code).map_err(|why| format!("coefficient {why}")))
                    .collect::<Result<Vec<f64>, _>>()?;
                Calibration::Polynomial { coefficients, range: None, outside: OutsideRange::Refuse }
            }
            Some("PRS") => c.pairs()?,
            Some(other) => return Err(format!("conversion of kind {other}; NON, COE and PRS are read")),
        };
        Ok(())
    }

    /// Pairs joined by straight lines.
    fn pairs(&self) -> Result<Calibration, String> {
        if self.text("PS1").is_some_and(|fitted| fitted.starts_with(['Y', 'y'])) {
            return Err("conversion by a curve fitted to pair sets".to_owned());
        }
        let count = self.number("PS\\N")?.unwrap_or(0);
        if count > LISTED {
            return Err(format!("{count} pairs"));
        }
        ["PS3-", "PS4-"].iter().try_for_each(|prefix| self.refuse_beyond(prefix, count, "PS\\N"))?;
        let mut pairs = (1..=count)
            .map(|n| Ok((self.value(&format!("PS3-{n}"))?, self.value(&format!("PS4-{n}"))?)))
            .collect::<Result<Vec<(f64, f64)>, String>>()?;
        pairs.sort_by(|one, two| one.0.total_cmp(&two.0));
        Ok(Calibration::PairWiseLinear { pairs, outside: OutsideRange::Refuse })
    }

    fn encoding(&self, parameter: &ParameterSpec) -> Result<RawEncoding, String> {
        match self.text("BFM") {
            None | Some("UNS") => Ok(RawEncoding::Unsigned),
            Some("TWO" | "INT") => Ok(RawEncoding::TwosComplement),
            Some("ONE") => Ok(RawEncoding::OnesComplement),
            Some("OFF") => Ok(RawEncoding::OffsetBinary),
            Some("SIG") => Ok(RawEncoding::SignMagnitude),
            Some("BCD") => Ok(RawEncoding::Bcd),
            Some("FPT") => {
                let format = self.text("FPF").unwrap_or_default().to_ascii_uppercase();
                let kinds = [
                    (&["IEEE", "32"][..], RawEncoding::Ieee754Single),
                    (&["IEEE", "64"], RawEncoding::Ieee754Double),
                    (&["1750A", "32"], RawEncoding::Mil1750A32),
                    (&["1750A", "48"], RawEncoding::Mil1750A48),
                ];
                let found = kinds.iter().find(|(words, _)| words.iter().all(|word| format.contains(word)));
                found.map(|(_, encoding)| *encoding).ok_or_else(|| format!("floating-point format `{format}`"))
            }
            Some(other) => Err(format!("binary format {other} of {}", parameter.name)),
        }
    }
}

/// The parts of a word that a mask selects, its runs of ones.
fn masked(word: u32, mask: Option<&str>) -> Result<Vec<WordPart>, String> {
    let Some(mask) = mask.filter(|mask| !mask.eq_ignore_ascii_case("FW")) else { return Ok(vec![WordPart { word, bits: None }]) };
    if mask.len() > 64 || mask.bytes().any(|bit| !matches!(bit, b'0' | b'1')) {
        return Err(format!("mask `{mask}`: expected FW or zeros and ones"));
    }
    let mut parts: Vec<WordPart> = Vec::new();
    for (bit, _) in (1..).zip(mask.bytes()).filter(|(_, bit)| *bit == b'1') {
        match parts.last_mut().and_then(|part| part.bits.as_mut()) {
            Some((_, last)) if *last + 1 == bit => *last = bit,
            _ => parts.push(WordPart { word, bits: Some((bit, bit)) }),
        }
    }
    if parts.is_empty() { Err("mask without a one".to_owned()) } else { Ok(parts) }
}

/// Names of units in setups that are not ours, in small letters.
const UNITS: [(&str, &str); 23] = [
    ("deg/sec", "deg/s"),
    ("rad/sec", "rad/s"),
    ("m/sec", "m/s"),
    ("m/s/s", "m/s^2"),
    ("mtr/s/s", "m/s^2"),
    ("mtr", "m"),
    ("kts", "kn"),
    ("knots", "kn"),
    ("g's", "g"),
    ("gs", "g"),
    ("kt", "kn"),
    ("knot", "kn"),
    ("mps", "m/s"),
    ("fps", "ft/s"),
    ("ft/sec", "ft/s"),
    ("kph", "km/h"),
    ("m/s2", "m/s^2"),
    ("m/s**2", "m/s^2"),
    ("m/sec2", "m/s^2"),
    ("m/sec/sec", "m/s^2"),
    ("ft/s2", "ft/s^2"),
    ("ft/sec2", "ft/s^2"),
    ("ft/s/s", "ft/s^2"),
];

/// The unit in our spelling: setups are often in capitals.
fn unit(text: &str) -> String {
    let lower = text.to_ascii_lowercase();
    let renamed = UNITS.iter().find(|(name, _)| *name == lower).map(|(_, unit)| (*unit).to_owned());
    let simple = |unit: &str| ["deg", "rad", "m", "s", "ft", "kn", "km", "h", "g", "rpm"].contains(&unit);
    renamed
        .unwrap_or_else(|| if lower.split('/').all(|part| simple(part.trim_end_matches("^2"))) { lower } else { text.to_owned() })
}

#[cfg(test)]
#[path = "tmats_measurements_tests.rs"]
mod tests;
