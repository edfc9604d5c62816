//! Instruments as a file describes them (TOML): what differs from flight-test quality, channel by channel.
//!
//! Consumes a text such as
//!
//! ```toml
//! rate_hz = 100                        # of every channel without one of its own, Hz
//! accelerometer_position_m = [0.4, 0.0, -0.2]    # where they stand; the run says so
//! vane_position_m = [6.5, 0.0, 0.5]
//! [channel.p]                          # by a channel's name; any of these
//! rate_hz = 256                        # its own rate: rows at its own times
//! noise = 0.001                        # standard deviation of white noise, channel's unit
//! bias = 0.002                         # reads that much too much
//! bias_std = 0.0005                    # standard deviation of a bias that is drawn once a run
//! scale = 1.01                         # reads that many times the true value
//! lag = 0.02                           # first-order lag, s
//! delay = 0.01                         # reads late by, s
//! bits = 12                            # a PCM word: 2^bits counts from one end of the range to the other, held there
//! range = [-1.0, 1.0]
//! # quantum = 0.001                    # or steps of this size, with or without a range
//! dropouts = { rate = 0.1, mean_length = 0.2 }   # its own; losses a second of reception, s
//! [dropouts]                           # of the link: every channel at once
//! rate = 0.05
//! mean_length = 0.3
//! [vibration]                          # amplitudes at rotor speed times blades, and at twice that
//! blades = 4                           # those of a Level-1 aircraft where left out
//! az = [1.0, 0.3]                      # of ax ay az p q r
//! ```
//!
//! Produces instruments. What is left out is as in `FLIGHT_QUALITY`, or not there: a `bias` without `bias_std` is the whole bias.
//! Refused, with line and column: a key, channel or number that is none, a channel that the flight does not give.

use super::dropout::Dropouts;
use super::instrument::{Instrument, InstrumentSet};
use super::simulation_error::MOST_DROPOUTS;
use crate::flight::channel::{CHANNELS, Channel, ControlNames};
use crate::flight::file::toml_reader::{TomlEntry, TomlError, TomlTable, TomlText};

/// What a file says of the instruments.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct InstrumentFile {
    /// Rate of the channels that have none of their own, Hz.
    pub rate_hz: Option<f64>,
    /// Where the accelerometers stand from the centre of mass, body axes, m.
    pub accelerometer_position_m: Option<[f64; 3]>,
    /// Where the vanes stand from the centre of mass, body axes, m.
    pub vane_position_m: Option<[f64; 3]>,
    channels: Vec<Described>,
    dropouts: Option<Dropouts>,
    vibration: Vec<(Channel, [f64; 2])>,
    blades: Option<f64>,
}

/// What it says of one; `None` where it says nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Described {
    channel: Channel,
    rate_hz: Option<f64>,
    noise: Option<f64>,
    bias: Option<f64>,
    bias_std: Option<f64>,
    scale: Option<f64>,
    lag: Option<f64>,
    delay: Option<f64>,
    quantum: Option<f64>,
    range: Option<[f64; 2]>,
    dropouts: Option<Dropouts>,
}

const ROOT: [&str; 6] = ["rate_hz", "accelerometer_position_m", "vane_position_m", "channel", "dropouts", "vibration"];
const OF_CHANNEL: [&str; 11] =
    ["rate_hz", "noise", "bias", "bias_std", "scale", "lag", "delay", "bits", "range", "quantum", "dropouts"];
const SHAKEN: [Channel; 6] = [Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R];

/// Rates that a channel may have, Hz.
const RATES_HZ: [f64; 2] = [0.01, 1e4];

const MOST_BITS: f64 = 32.0;

/// Longest delay, s, either way.
const LONGEST_DELAY_S: f64 = 60.0;

impl InstrumentFile {
    /// Reads the text; `gives` says which channels the flight has.
    ///
    /// # Errors
    /// [`TomlError`] with the first wrong place.
    pub fn parse(text: &str, gives: impl Fn(Channel) -> bool) -> Result<Self, TomlError> {
        let document = TomlText(text).parse()?;
        let root = TomlTable::root(TomlText(text), &document);
        root.allow_only(&ROOT)?;
        let position = |key: &str| root.find(key).map(|entry| entry.vector()).transpose();
        let mut file = InstrumentFile {
            rate_hz: rate(&root)?,
            accelerometer_position_m: position("accelerometer_position_m")?,
            vane_position_m: position("vane_position_m")?,
            dropouts: dropouts(&root)?,
            ..InstrumentFile::default()
        };
        if let Some(channels) = root.find("channel") {
            for entry in channels.table("[channel]")?.entries() {
                let channel = named(&entry, &gives, &Channel::ALL)?;
                if file.channels.iter().any(|earlier| earlier.channel == channel) {
                    return Err(entry.misread("expected each channel once, found it again under its other name"));
                }
                file.channels.push(described(channel, &entry.table(&format!("[channel.{}]", entry.key))?)?);
            }
        }
        if let Some(vibration) = root.find("vibration") {
            for entry in vibration.table("[vibration]")?.entries() {
                if entry.key == "blades" {
                    file.blades = Some(entry.whole(1.0, 32.0)?);
                    continue;
                }
                let channel = named(&entry, &gives, &SHAKEN)?;
                let amplitudes = entry.numbers::<2>()?;
                if let Some(negative) = amplitudes.into_iter().find(|amplitude| *amplitude < 0.0) {
                    return Err(entry.misread(format_args!("expected amplitudes of zero or more, found {negative}")));
                }
                file.vibration.push((channel, amplitudes));
            }
        }
        Ok(file)
    }

    /// The instruments that it describes, the rest as they are; random errors times `factor`.
    #[must_use]
    pub fn applied_to(&self, mut instruments: InstrumentSet, factor: f64) -> InstrumentSet {
        for said in &self.channels {
            let instrument = place_of(&mut instruments, said.channel);
            instrument.rate_hz = said.rate_hz.or(instrument.rate_hz);
            instrument.noise_std = said.noise.map_or(instrument.noise_std, |noise| factor * noise);
            let drawn = said.bias_std.or(said.bias.map(|_| 0.0));
            instrument.bias_std = drawn.map_or(instrument.bias_std, |bias_std| factor * bias_std);
            instrument.bias = said.bias.unwrap_or(instrument.bias);
            instrument.factor = said.scale.unwrap_or(instrument.factor);
            instrument.lag_s = said.lag.unwrap_or(instrument.lag_s);
            instrument.delay_s = said.delay.unwrap_or(instrument.delay_s);
            instrument.quantum = said.quantum.or(instrument.quantum);
            instrument.range = said.range.or(instrument.range);
            instrument.dropouts = said.dropouts.or(instrument.dropouts);
        }
        for &(channel, amplitudes) in &self.vibration {
            place_of(&mut instruments, channel).vibration = Some(amplitudes);
        }
        instruments.blades = self.blades.or(instruments.blades);
        instruments.dropouts = self.dropouts.or(instruments.dropouts);
        instruments
    }
}

/// The instrument of that channel; one is added where there is none.
fn place_of(instruments: &mut InstrumentSet, channel: Channel) -> &mut Instrument {
    let channels = &mut instruments.channels;
    let place = channels.iter().position(|instrument| instrument.channel == channel).unwrap_or_else(|| {
        channels.push(Instrument::perfect(channel));
        channels.len() - 1
    });
    &mut channels[place]
}

fn named(entry: &TomlEntry<'_>, gives: &impl Fn(Channel) -> bool, offered: &[Channel]) -> Result<Channel, TomlError> {
    match Channel::from_name(entry.key) {
        Some((channel, _)) if offered.contains(&channel) && gives(channel) => Ok(channel),
        _ => {
            let given = offered.iter().filter(|channel| gives(**channel));
            let names: Vec<&str> = given.map(|channel| channel.name(ControlNames::Rotorcraft)).collect();
            Err(entry.unknown_key("a channel that the model gives", &names))
        }
    }
}

fn described(channel: Channel, table: &TomlTable<'_>) -> Result<Described, TomlError> {
    table.allow_only(&OF_CHANNEL)?;
    let number = |key: &str| table.find(key).map(|entry| entry.number()).transpose();
    let not_negative = |key: &str| table.find(key).map(|entry| entry.not_negative()).transpose();
    let delay = number("delay")?;
    if let (Some(entry), Some(delay)) = (table.find("delay"), delay.filter(|delay| libm::fabs(*delay) > LONGEST_DELAY_S)) {
        return Err(entry.misread(format_args!("expected from -{LONGEST_DELAY_S} to {LONGEST_DELAY_S} s, found {delay}")));
    }
    let range = match table.find("range") {
        None => None,
        Some(entry) => match entry.numbers::<2>()? {
            [least, most] if least < most => Some([least, most]),
            [least, most] => {
                return Err(entry.misread(format_args!("expected [least, most], found [{least}, {most}]")));
            }
        },
    };
    let mut quantum = table.find("quantum").map(|entry| entry.positive()).transpose()?;
    if let Some(entry) = table.find("bits") {
        let bits = entry.whole(1.0, MOST_BITS)?;
        quantum = match (range, quantum) {
            (Some([least, most]), None) => Some((most - least) / (libm::exp2(bits) - 1.0)),
            (None, _) => return Err(entry.misread("expected `range = [least, most]` beside it, found none")),
            (_, Some(_)) => return Err(entry.misread("expected either `bits` or `quantum`, found both")),
        };
    }
    Ok(Described {
        channel,
        rate_hz: rate(table)?,
        noise: not_negative("noise")?,
        bias: number("bias")?,
        bias_std: not_negative("bias_std")?,
        scale: number("scale")?,
        lag: not_negative("lag")?,
        delay,
        quantum,
        range,
        dropouts: dropouts(table)?,
    })
}

fn rate(table: &TomlTable<'_>) -> Result<Option<f64>, TomlError> {
    let Some(entry) = table.find("rate_hz") else { return Ok(None) };
    let [least, most] = RATES_HZ;
    match entry.number()? {
        rate if (least..=most).contains(&rate) => Ok(Some(rate)),
        rate => Err(entry.misread(format_args!("expected {least} to {most} Hz, found {rate}"))),
    }
}

fn dropouts(table: &TomlTable<'_>) -> Result<Option<Dropouts>, TomlError> {
    let Some(entry) = table.find("dropouts") else { return Ok(None) };
    let table = entry.table("dropouts")?;
    table.allow_only(&["rate", "mean_length"])?;
    let rate = table.require("rate")?;
    if rate.positive()? > MOST_DROPOUTS {
        return Err(rate.misread(format_args!("expected up to {MOST_DROPOUTS} a second, found {}", rate.number()?)));
    }
    Ok(Some(Dropouts { rate: rate.positive()?, mean_length_s: table.require("mean_length")?.positive()? }))
}

const _: () = assert!(CHANNELS < 100, "streams of noise are numbered by channel");

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are carried, or exact in binary")]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<InstrumentFile, TomlError> {
        InstrumentFile::parse(text, |channel| !matches!(channel, Channel::Rho | Channel::Torque))
    }

    fn of(instruments: &InstrumentSet, channel: Channel) -> Instrument {
        *instruments.channels.iter().find(|instrument| instrument.channel == channel).unwrap()
    }

    #[test]
    fn what_is_said_is_taken_and_the_rest_is_flight_quality() {
        let text = "[channel.r]\nrate_hz = 256\nbias = 0.25\nbits = 2\nrange = [-1.5, 1.5]\n[channel.beta]\nbias_std = 0.01\n\
                    [channel.tail_pitch]\nlag = 0.1\n[vibration]\nblades = 4\np = [0.1, 0]\n";
        let applied = read(text).unwrap().applied_to(InstrumentSet::flight_quality(2.0), 2.0);
        let yaw = of(&applied, Channel::R);
        assert_eq!((yaw.rate_hz, yaw.noise_std, yaw.bias_std, yaw.bias), (Some(256.0), 0.002, 0.0, 0.25));
        assert_eq!([-9.0, -0.6, -0.4, 0.9, 9.0].map(|value| yaw.word(value)), [-1.5, -0.5, -0.5, 0.5, 1.5]);
        let vane = of(&applied, Channel::Beta);
        assert_eq!((vane.noise_std, vane.bias_std, vane.bias), (0.004, 0.02, 0.0));
        assert_eq!((of(&applied, Channel::TailPitch).lag_s, of(&applied, Channel::P).vibration), (0.1, Some([0.1, 0.0])));
        let nothing = read("").unwrap().applied_to(InstrumentSet::flight_quality(1.0), 1.0);
        assert_eq!(nothing, InstrumentSet::flight_quality(1.0));
    }

    #[test]
    fn every_mistake_has_its_place() {
        for (text, line, column, part) in [
            ("rate = 3", 1, 1, "nearest is `rate_hz`"),
            ("rate_hz = 1e9", 1, 11, "expected 0.01 to 10000 Hz"),
            ("vane_position_m = [1, 2]", 1, 19, "three finite numbers"),
            ("[channel.pp]", 1, 10, "nearest is `p`"),
            ("[channel.torque]", 1, 10, "expected a channel that the model gives, found `torque`"),
            ("[channel.p]\nnoice = 1", 2, 1, "nearest is `noise`"),
            ("[channel.p]\nnoise = -1", 2, 9, "zero or more"),
            ("[channel.p]\nlag = inf", 2, 7, "finite number"),
            ("[channel.p]\ndelay = 61", 2, 9, "from -60 to 60 s"),
            ("[channel.p]\nrange = [1, 1]", 2, 9, "[least, most]"),
            ("[channel.p]\nbits = 12", 2, 8, "`range = [least, most]` beside it"),
            ("[channel.p]\nbits = 12.5\nrange = [0, 1]", 2, 8, "whole number from 1 to 32"),
            ("[channel.p]\nbits = 12\nrange = [0, 1]\nquantum = 0.1", 2, 8, "found both"),
            ("[channel.p]\nquantum = 0", 2, 11, "more than zero"),
            ("[channel.pedal]\n[channel.rudder]\n", 2, 1, "each channel once"),
            ("[dropouts]\nrate = 0.1", 1, 2, "lacks `mean_length`"),
            ("[dropouts]\nrate = 101\nmean_length = 1", 2, 8, "up to 100 a second"),
            ("[channel.p]\ndropouts = 3", 2, 12, "expected a table"),
            ("[vibration]\ntas = [1, 0]", 2, 1, "(of ax ay az p q r)"),
            ("[vibration]\naz = [1, -1]", 2, 6, "zero or more"),
            ("[vibration]\nblades = 0", 2, 10, "whole number"),
            ("channel = 3", 1, 11, "expected a table"),
            ("[channel", 1, 9, "not TOML"),
        ] {
            let misread = read(text).unwrap_err();
            assert!(misread.what.contains(part), "{text}: {misread}");
            assert_eq!((misread.line, misread.column), (line, column), "{text}: {misread}");
        }
    }
}
