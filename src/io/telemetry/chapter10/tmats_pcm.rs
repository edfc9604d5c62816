//! What the setup says of a PCM channel: the format of its minor frames.
//!
//! Consumes [`Tmats`] and the number of a channel; produces [`TmatsPcmFormat`]. The way from channel to format: `R-x\TK1-n` is
//! the channel; its link `R-x\CDLN-n` (`PDLN-n` in older editions), or else its source `R-x\DSI-n`, is a `P-d\DLN`, or the
//! `M-m\ID` whose `M-m\BB\DLN` is one. Attributes read, all `P-d`:
//! | code | | code | |
//! | --- | --- | --- | --- |
//! | `D1` | code (NRZ-L, ...) | `MF\N` | minor frames in a major frame |
//! | `D2` | bit rate, 1/s | `MF1` | words in a minor frame, the sync pattern counting as one |
//! | `D4` | polarity N or I | `MF2` | bits in a minor frame |
//! | `D7` `D8` | randomised, length | `MF4` `MF5` | sync pattern: length, bits, first bit left |
//! | `F1` | bits in a word | `MFW1-n` `MFW2-n` | words of another length: number, bits |
//! | `F2` | M or L bit first | `SYNC1` to `SYNC4` | criteria to be in and out of lock |
//! | `F3` `F4` | parity EV OD NO, leading or trailing | `ISF\N`, `ISF1-n`, `IDC1-n` to `IDC10-n` | subframe identifiers |
//!
//! An attribute that is absent is `None`; one whose value cannot be read is named in `unreadable`, and nothing is put in its
//! place.
//! Source: IRIG 106-09 Chapter 9, attribute groups R, M and P.

use super::error::Chapter10Error;
use super::pcm_layout::{PcmLayout, PcmMode};
use super::tmats::Tmats;

/// Subframe identifiers that are read at most.
pub const COUNTERS: u32 = 64;
/// Words of another length that are read at most.
pub const OWN_LENGTHS: u32 = 16_384;

/// TmatsParity of words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TmatsParity {
    /// None.
    None,
    /// An even number of ones.
    Even,
    /// An odd number of ones.
    Odd,
}

/// A subframe identifier.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SubframeCounter {
    /// Its name, `ISF1-n`.
    pub name: String,
    /// Kind of subframe synchronisation, `ISF2-n`: `ID` is a counter.
    pub kind: String,
    /// Word in the minor frame that holds it, `IDC1-n`; 1 is the first behind the sync pattern.
    pub word: Option<u32>,
    /// Length of that word, `IDC2-n`, bits.
    pub word_bits: Option<u32>,
    /// Place of its most significant bit in the word, `IDC3-n`, from 1.
    pub bit: Option<u32>,
    /// Its length, `IDC4-n`, bits.
    pub bits: Option<u32>,
    /// Whether its least significant bit comes first, `IDC5-n`.
    pub lsb_first: Option<bool>,
    /// First value and the minor frame that has it, `IDC6-n`, `IDC7-n`.
    pub first: (Option<u32>, Option<u32>),
    /// Last value and the minor frame that has it, `IDC8-n`, `IDC9-n`.
    pub last: (Option<u32>, Option<u32>),
    /// Whether it counts up, `IDC10-n`.
    pub increasing: Option<bool>,
}

/// The format of a PCM channel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TmatsPcmFormat {
    /// Number d of the group `P-d`.
    pub group: u32,
    /// Name of the data link.
    pub link: String,
    /// Code, such as `NRZ-L`, `RNRZ-L`.
    pub code: Option<String>,
    /// Bits a second.
    pub bit_rate: Option<u64>,
    /// Whether the polarity is inverted.
    pub inverted: Option<bool>,
    /// Whether the bits are randomised.
    pub randomised: Option<bool>,
    /// Length of the randomiser, as it stands.
    pub randomiser: Option<String>,
    /// Bits in a word.
    pub word_bits: Option<u32>,
    /// Whether the least significant bit of a word comes first.
    pub lsb_first: Option<bool>,
    /// TmatsParity.
    pub parity: Option<TmatsParity>,
    /// Whether the parity bit leads the word.
    pub parity_leads: Option<bool>,
    /// Minor frames in a major frame.
    pub minor_frames: Option<u32>,
    /// Words in a minor frame, the sync pattern counting as one.
    pub words: Option<u32>,
    /// Bits in a minor frame.
    pub frame_bits: Option<u32>,
    /// Length of the sync pattern, bits.
    pub sync_bits: Option<u32>,
    /// The sync pattern, its first bit the most significant.
    pub sync_pattern: Option<u64>,
    /// Good patterns before lock, errors allowed in them, bad patterns before loss of lock, errors allowed in them.
    pub sync_criteria: [Option<u32>; 4],
    /// Words of another length than `word_bits`: number of the word (1 is the first behind the sync pattern), bits.
    pub own_lengths: Vec<(u32, u32)>,
    /// Subframe identifiers.
    pub counters: Vec<SubframeCounter>,
    /// How the recorder packs the data, `R-x\PDP-n`.
    pub mode: Option<PcmMode>,
    /// Attributes whose value cannot be read.
    pub unreadable: Vec<String>,
}

/// Reads attributes that have one prefix, and remembers those that cannot be read.
struct Attributes<'a> {
    tmats: &'a Tmats,
    prefix: String,
    unreadable: Vec<String>,
}

impl<'a> Attributes<'a> {
    /// The value; `None` where it is absent or empty.
    fn text(&self, name: &str) -> Option<&'a str> {
        self.tmats.get(&format!("{}\\{name}", self.prefix)).filter(|value| !value.is_empty())
    }

    fn read<T>(&mut self, name: &str, parse: impl Fn(&str) -> Option<T>) -> Option<T> {
        let value = self.text(name)?;
        let parsed = parse(value);
        if parsed.is_none() && !matches!(value.to_ascii_uppercase().as_str(), "N/A" | "NS") {
            self.unreadable.push(format!("{}\\{name}", self.prefix));
        }
        parsed
    }

    fn number<T: std::str::FromStr>(&mut self, name: &str) -> Option<T> {
        self.read(name, |value| value.parse().ok())
    }

    /// One of two letters: `true` for the first.
    fn either(&mut self, name: &str, yes: char, no: char) -> Option<bool> {
        self.read(name, |value| match value.chars().next().map(|letter| letter.to_ascii_uppercase()) {
            Some(letter) if letter == yes => Some(true),
            Some(letter) if letter == no => Some(false),
            _ => None,
        })
    }
}

impl TmatsPcmFormat {
    /// The format of a recorder channel.
    ///
    /// # Errors
    /// [`Chapter10Error`] where the setup has no such channel, or it leads to no format.
    pub fn of_channel(tmats: &Tmats, channel: u16) -> Result<Self, Chapter10Error> {
        let (recorder, number) = recorder_channel(tmats, channel).ok_or(Chapter10Error::TmatsNoChannel { channel })?;
        let of = |name: &str| tmats.get(&format!("{recorder}\\{name}-{number}"));
        let links = ["CDLN", "PDLN", "DSI"].into_iter().filter_map(of);
        let group = links.filter_map(|link| group_of_link(tmats, link)).next();
        let group = group.ok_or(Chapter10Error::TmatsNoFormat { channel })?;
        let mut format = TmatsPcmFormat::of_group(tmats, group);
        let mut recorder = Attributes { tmats, prefix: recorder.to_owned(), unreadable: Vec::new() };
        format.mode = recorder.read(&format!("PDP-{number}"), |value| match value.to_ascii_uppercase().as_str() {
            "UN" => Some(PcmMode::Unpacked),
            "PFS" => Some(PcmMode::Packed),
            "TM" => Some(PcmMode::Throughput),
            _ => None,
        });
        format.unreadable.append(&mut recorder.unreadable);
        Ok(format)
    }

    /// The format in a group `P-d`.
    pub fn of_group(tmats: &Tmats, group: u32) -> Self {
        let mut p = Attributes { tmats, prefix: format!("P-{group}"), unreadable: Vec::new() };
        let sync_pattern = p.read("MF5", pattern);
        let mut format = TmatsPcmFormat {
            group,
            link: p.text("DLN").unwrap_or_default().to_owned(),
            code: p.text("D1").map(str::to_owned),
            bit_rate: p.number("D2"),
            inverted: p.either("D4", 'I', 'N'),
            randomised: p.either("D7", 'Y', 'N'),
            randomiser: p.text("D8").map(str::to_owned),
            word_bits: p.number("F1"),
            lsb_first: p.either("F2", 'L', 'M'),
            parity: p.read("F3", |value| match value.to_ascii_uppercase().as_str() {
                "EV" => Some(TmatsParity::Even),
                "OD" => Some(TmatsParity::Odd),
                "NO" => Some(TmatsParity::None),
                _ => None,
            }),
            parity_leads: p.either("F4", 'L', 'T'),
            minor_frames: p.number("MF\\N"),
            words: p.number("MF1"),
            frame_bits: p.number("MF2"),
            sync_bits: p.number("MF4"),
            sync_pattern: sync_pattern.map(|(pattern, _)| pattern),
            sync_criteria: [p.number("SYNC1"), p.number("SYNC2"), p.number("SYNC3"), p.number("SYNC4")],
            ..TmatsPcmFormat::default()
        };
        // A length that is not written is that of the pattern.
        format.sync_bits = format.sync_bits.or(sync_pattern.map(|(_, bits)| bits));
        for n in 1..=OWN_LENGTHS {
            let Some(word) = p.number(&format!("MFW1-{n}")) else { break };
            let Some(bits) = p.number(&format!("MFW2-{n}")) else { break };
            format.own_lengths.push((word, bits));
        }
        for n in 1..=p.number("ISF\\N").unwrap_or(0).min(COUNTERS) {
            format.counters.push(counter(&mut p, n));
        }
        format.unreadable = p.unreadable;
        format
    }

    /// Where the words stand, as far as the setup says; `None` where it does not, or says what cannot be.
    pub fn layout(&self) -> Option<PcmLayout> {
        let sync_bits = u8::try_from(self.sync_bits?).ok()?;
        let words = usize::try_from(self.words?.checked_sub(1)?).ok()?;
        if u64::try_from(words).ok()? > super::pcm_layout::FRAME_BITS {
            return None;
        }
        let mut widths = vec![u8::try_from(self.word_bits?).ok()?; words];
        for (word, bits) in &self.own_lengths {
            *widths.get_mut(usize::try_from(word.checked_sub(1)?).ok()?)? = u8::try_from(*bits).ok()?;
        }
        PcmLayout::new(sync_bits, widths).ok()
    }
}

fn counter(p: &mut Attributes<'_>, n: u32) -> SubframeCounter {
    let mut number = |item: u32| p.number(&format!("IDC{item}-{n}"));
    let [word, word_bits, bit, bits] = [number(1), number(2), number(3), number(4)];
    let [first, last] = [(number(6), number(7)), (number(8), number(9))];
    SubframeCounter {
        name: p.text(&format!("ISF1-{n}")).unwrap_or_default().to_owned(),
        kind: p.text(&format!("ISF2-{n}")).unwrap_or_default().to_owned(),
        word,
        word_bits,
        bit,
        bits,
        lsb_first: p.either(&format!("IDC5-{n}"), 'L', 'M'),
        first,
        last,
        increasing: p.either(&format!("IDC10-{n}"), 'I', 'D'),
    }
}

/// Bits written as zeros and ones, the first one left, and how many there are.
fn pattern(text: &str) -> Option<(u64, u32)> {
    let digits: Vec<u8> = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
    let fits = !digits.is_empty() && digits.len() <= 64 && digits.iter().all(|digit| matches!(digit, b'0' | b'1'));
    let value = digits.iter().fold(0_u64, |value, digit| value << 1 | u64::from(digit & 1));
    fits.then_some((value, u32::try_from(digits.len()).ok()?))
}

/// Group (`R-x`) and number n of the recorder's channel.
fn recorder_channel(tmats: &Tmats, channel: u16) -> Option<(&str, &str)> {
    tmats.attributes().filter(|(code, value)| code.starts_with("R-") && value.parse() == Ok(channel)).find_map(|(code, _)| {
        let (group, name) = code.split_once('\\')?;
        Some((group, name.strip_prefix("TK1-")?))
    })
}

/// Number of the group `P-d` to which a link leads, itself or through an M group.
fn group_of_link(tmats: &Tmats, link: &str) -> Option<u32> {
    let named = |name: &str| {
        tmats.attributes().find_map(|(code, value)| {
            let number = code.strip_prefix("P-")?.strip_suffix("\\DLN")?;
            if value == name { number.parse().ok() } else { None }
        })
    };
    if let Some(group) = named(link) {
        let has_format = tmats.get(&format!("P-{group}\\D1")).is_some() || tmats.get(&format!("P-{group}\\MF1")).is_some();
        if has_format {
            return Some(group);
        }
    }
    let through = tmats.attributes().find_map(|(code, value)| {
        let group = code.strip_prefix("M-")?.strip_suffix("\\ID")?;
        if value == link { tmats.get(&format!("M-{group}\\BB\\DLN")) } else { None }
    });
    through.and_then(named).or_else(|| named(link))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETUP: &str = "R-1\\TK1-1:3;R-1\\CDLN-1:A;R-1\\PDP-1:PFS;R-1\\TK1-2:4;R-1\\DSI-2:S;M-7\\ID:S;M-7\\BB\\DLN:B;\
        R-1\\TK1-3:5;R-1\\CDLN-3:nowhere;P-1\\DLN:A;P-1\\D1:NRZ-L;P-1\\D2:1666666;P-1\\D4:I;P-1\\D7:Y;P-1\\D8:STD;\
        P-1\\F1:12;P-1\\F2:M;P-1\\F3:OD;P-1\\F4:T;P-1\\MF\\N:4;P-1\\MF1:5;P-1\\MF2:70;P-1\\MF4:24;\
        P-1\\MF5:111110101111001100100000;P-1\\SYNC1:2;P-1\\SYNC3:NS;P-1\\MFW1-1:2;P-1\\MFW2-1:10;\
        P-1\\ISF\\N:1;P-1\\ISF1-1:SFID;P-1\\ISF2-1:ID;P-1\\IDC1-1:1;P-1\\IDC4-1:8;P-1\\IDC5-1:M;P-1\\IDC6-1:0;\
        P-1\\IDC8-1:3;P-1\\IDC10-1:INC;P-2\\DLN:B;P-2\\D2:fast;P-2\\MF1:3;P-2\\MF5:1010;";

    #[test]
    fn a_channel_leads_to_its_format_by_link_or_by_source() {
        let tmats = Tmats::parse(SETUP.as_bytes());
        let format = TmatsPcmFormat::of_channel(&tmats, 3).unwrap();
        assert_eq!(
            (format.group, format.bit_rate, format.inverted, format.randomised),
            (1, Some(1_666_666), Some(true), Some(true))
        );
        assert_eq!((format.parity, format.parity_leads, format.lsb_first), (Some(TmatsParity::Odd), Some(false), Some(false)));
        assert_eq!((format.sync_pattern, format.sync_bits, format.mode), (Some(0xFAF320), Some(24), Some(PcmMode::Packed)));
        assert_eq!((format.minor_frames, format.sync_criteria), (Some(4), [Some(2), None, None, None]));
        assert_eq!(format.unreadable, Vec::<String>::new());
        let layout = format.layout().unwrap();
        assert_eq!((layout.sync_bits(), layout.widths(), layout.frame_bits()), (24, &[12, 10, 12, 12][..], 70));
        let counter = &format.counters[0];
        assert_eq!((counter.name.as_str(), counter.word, counter.bits, counter.last.0), ("SFID", Some(1), Some(8), Some(3)));
        assert_eq!((counter.first, counter.increasing, counter.lsb_first), ((Some(0), None), Some(true), Some(false)));
        let other = TmatsPcmFormat::of_channel(&tmats, 4).unwrap();
        assert_eq!((other.group, other.bit_rate, other.sync_bits, other.unreadable), (2, None, Some(4), vec!["P-2\\D2".into()]));
        assert_eq!(TmatsPcmFormat::of_channel(&tmats, 5), Err(Chapter10Error::TmatsNoFormat { channel: 5 }));
        assert_eq!(TmatsPcmFormat::of_channel(&tmats, 6), Err(Chapter10Error::TmatsNoChannel { channel: 6 }));
    }

    #[test]
    fn hostile_numbers_make_no_layout() {
        for words in ["0", "1", "4294967295", "99999999999", "-1"] {
            let text = format!("P-1\\F1:255;P-1\\MF1:{words};P-1\\MF4:32;P-1\\ISF\\N:4294967295;");
            let format = TmatsPcmFormat::of_group(&Tmats::parse(text.as_bytes()), 1);
            assert_eq!(format.layout().map(|layout| layout.widths().len()), if words == "1" { Some(0) } else { None });
            assert_eq!(format.counters.len(), COUNTERS as usize);
        }
    }
}
