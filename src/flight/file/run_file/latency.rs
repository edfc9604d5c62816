//! The key `latency_s` of a run: how late channels were stamped, each by its own seconds.
//!
//! Consumes the table of that key, channel name to s; produces the latency of each channel. A sample of a channel is of the
//! time (stamp - latency). Refused: what is no table, a name that is no channel, a latency that is no number of
//! 0 to [`LATENCY_MAX_S`] s, one control under its names of two kinds of aircraft.

use super::error::quoted;
use crate::flight::channel::{CHANNELS, Channel, ControlNames};
use crate::flight::file::toml_reader::nearest;
use toml::{Table, Value};

/// The longest latency, s: rows wait for it.
pub const LATENCY_MAX_S: f64 = 5.0;

/// Latencies of channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelLatencies {
    by_channel_s: [f64; CHANNELS],
}

impl ChannelLatencies {
    /// Of a channel, s; 0 where the run names none.
    pub fn of(&self, channel: Channel) -> f64 {
        self.by_channel_s.get(channel.index()).copied().unwrap_or_default()
    }

    /// The largest, s.
    pub fn largest_s(&self) -> f64 {
        self.by_channel_s.iter().copied().fold(0.0, f64::max)
    }

    /// Channels that are late, each with its latency, in words.
    pub fn words(&self, controls: ControlNames) -> String {
        let late = Channel::ALL.into_iter().filter(|channel| self.of(*channel) > 0.0);
        let words: Vec<String> = late.map(|channel| format!("{} {} s", channel.name(controls), self.of(channel))).collect();
        if words.is_empty() { "no channel".to_owned() } else { words.join(", ") }
    }

    /// Reads the table of the key.
    pub(super) fn from_value(value: &Value) -> Result<Self, String> {
        let wrong = || format!("latency_s: expected a table of channels and seconds such as {{ tas = 0.25 }}, found {value}");
        let table = value.as_table().ok_or_else(wrong)?;
        let mut latencies = ChannelLatencies::default();
        let mut named = 0_u32;
        for (name, value) in table {
            let Some((channel, _)) = Channel::from_name(name) else { return Err(unknown(name)) };
            let seconds = number(value).filter(|seconds| (0.0..=LATENCY_MAX_S).contains(seconds));
            let Some(seconds) = seconds else {
                return Err(format!("latency_s: {name}: expected a number of 0 to {LATENCY_MAX_S} s, found {value}"));
            };
            let bit = 1 << channel.index();
            if named & bit != 0 {
                return Err(format!("latency_s: {name}: expected one name of a control, found two of the same"));
            }
            named |= bit;
            if let Some(place) = latencies.by_channel_s.get_mut(channel.index()) {
                *place = seconds;
            }
        }
        Ok(latencies)
    }
}

/// What `subtracted` says already, with a further table of latencies.
pub(super) fn added(subtracted: Option<&Value>, latencies: &Table) -> Table {
    let mut sum = subtracted.and_then(Value::as_table).cloned().unwrap_or_default();
    for (name, value) in latencies {
        let before = sum.get(name).and_then(number).unwrap_or_default();
        sum.insert(name.clone(), Value::Float(before + number(value).unwrap_or_default()));
    }
    sum
}

fn number(value: &Value) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "seconds: far below 2^53")]
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn unknown(name: &str) -> String {
    let names = |controls: ControlNames| Channel::ALL.map(|channel| channel.name(controls));
    let valid = [names(ControlNames::Rotorcraft), names(ControlNames::FixedWing)].concat();
    let near = nearest(name, &valid).map(|name| format!("; nearest is `{name}`")).unwrap_or_default();
    format!("latency_s: expected the name of a channel, found {}{near}", quoted(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::file::run_file::RunInfo;

    #[test]
    fn latencies_are_of_channels_and_within_their_range() {
        let info = RunInfo::from_toml("latency_s = { tas = 0.25, rudder = 1 }").unwrap();
        let latencies = info.latencies().unwrap();
        assert_eq!((latencies.of(Channel::Tas), latencies.of(Channel::Pedal), latencies.of(Channel::P)), (0.25, 1.0, 0.0));
        assert_eq!((latencies.largest_s(), latencies.words(ControlNames::Rotorcraft)), (1.0, "tas 0.25 s, pedal 1 s".into()));
        assert_eq!(RunInfo::from_toml(&info.to_toml()), Ok(info));
        assert_eq!(RunInfo::from_toml("run = \"a\"").unwrap().latencies(), None);
        let refused = |text: &str| RunInfo::from_toml(text).unwrap_err();
        let error = refused("run = \"a\"\nlatency_s = { tass = 0.25 }");
        assert!(error.line == 2 && error.what.contains("found `tass`; nearest is `tas`"), "{error:?}");
        for wrong in ["{ tas = -0.1 }", "{ tas = 5.1 }", "{ tas = nan }", "{ tas = inf }", "{ tas = \"0.1\" }"] {
            assert!(refused(&format!("latency_s = {wrong}")).what.contains("tas: expected a number of 0 to 5 s"), "{wrong}");
        }
        assert!(refused("latency_s = 0.25").what.contains("expected a table of channels"));
        assert!(refused("latency_s = { pedal = 0.1, rudder = 0.2 }").what.contains("one name of a control"));
    }

    #[test]
    fn what_was_subtracted_is_no_latency_any_more() {
        let mut info = RunInfo::from_toml("latency_subtracted_s = { tas = 0.25 }").unwrap();
        info.set("latency_s={ tas = 0.5, beta = 0.125 }").unwrap();
        assert_eq!(info.latencies().map(|latencies| latencies.of(Channel::Tas)), Some(0.5));
        assert_eq!(info.take_latencies().map(|latencies| latencies.of(Channel::Beta)), Some(0.125));
        assert_eq!(info.latencies(), None);
        assert_eq!(info.take_latencies(), None);
        assert_eq!(info.to_toml(), "latency_subtracted_s.beta = 0.125\nlatency_subtracted_s.tas = 0.75\n");
    }
}
