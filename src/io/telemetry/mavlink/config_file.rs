//! The configuration of MAVLink as a TOML file: all keys optional, errors with line and column.
//!
//! ```toml
//! system = 1                       # the vehicle; default: the sender of most messages of motion
//! component = 1
//! aircraft = "fixed_wing"          # or "rotorcraft": names of the controls; default: by the heartbeat
//! reorder_ms = 20                  # messages up to this late are put in order
//! [sources]                        # messages in order of preference, by the channels they contain
//! specific_force = ["HIGHRES_IMU", "SCALED_IMU"]
//! rates = ["HIGHRES_IMU", "ATTITUDE"]
//! attitude = ["ATTITUDE"]
//! airspeed = ["VFR_HUD"]
//! flow_angles = ["AOA_SSA"]
//! altitude = []                    # not used
//! controls = ["RC_CHANNELS"]
//! rotor_speed = ["RPM"]
//! [controls.rudder]                # or pedal: output or input number, scale
//! channel = 4
//! zero_us = 1500
//! full_us = 500                    # where neither full_us nor full_deg is given the scale is assumed, and said to be
//! full_deg = -20
//! [rpm]
//! sensor = 1
//! ratio = 0.1                      # rotor speed over shaft speed
//! ```

use super::mapping::{ChannelGroup, ControlScale, MavlinkConfig};
use super::message::{MessageKind, PULSES};
use crate::flight::channel::ControlNames;
use crate::flight::control::Control;
use crate::flight::file::run_file::{RunFileError, quoted};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    system: Option<u8>,
    component: Option<u8>,
    aircraft: Option<Spanned<String>>,
    reorder_ms: Option<Spanned<f64>>,
    #[serde(default)]
    sources: BTreeMap<Spanned<String>, Vec<Spanned<String>>>,
    #[serde(default)]
    controls: BTreeMap<Spanned<String>, Scale>,
    rpm: Option<Rpm>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Scale {
    channel: Option<Spanned<usize>>,
    zero_us: Option<Spanned<f64>>,
    full_us: Option<Spanned<f64>>,
    full_deg: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rpm {
    sensor: Option<Spanned<usize>>,
    ratio: Option<Spanned<f64>>,
}

/// A mistake: its byte offset, and what was expected and found.
type Wrong = (usize, String);

impl MavlinkConfig {
    /// Reads the file's text.
    ///
    /// # Errors
    /// [`RunFileError`] where it is not TOML, a key is not known, or a value is out of its range.
    pub fn from_toml(text: &str) -> Result<Self, RunFileError> {
        let document: Document = toml::from_str(text).map_err(|error: toml::de::Error| {
            place(text, (error.span().map_or(0, |span| span.start), format!("expected TOML of MAVLink: {}", error.message())))
        })?;
        apply(document).map_err(|wrong| place(text, wrong))
    }
}

fn apply(document: Document) -> Result<MavlinkConfig, Wrong> {
    let mut config = MavlinkConfig { system: document.system, component: document.component, ..MavlinkConfig::default() };
    config.names = document.aircraft.map(names).transpose()?;
    if let Some(ms) = document.reorder_ms {
        #[expect(clippy::cast_possible_truncation, reason = "0 to a million")]
        let us = (within("reorder_ms", &ms, 0.0, 1000.0)? * 1e3) as i64;
        config.reorder_us = us;
    }
    for (key, listed) in document.sources {
        let known = ChannelGroup::ALL.iter().zip(&mut config.sources).find(|((_, name, _), _)| name == key.get_ref());
        let Some(((_, name, can), sources)) = known else {
            let keys: Vec<&str> = ChannelGroup::ALL.iter().map(|(_, name, _)| *name).collect();
            let what = format!("sources: expected one of {}, found {}", keys.join(", "), quoted(key.get_ref()));
            return Err((key.span().start, what));
        };
        *sources = Vec::with_capacity(listed.len());
        for entry in listed {
            match MessageKind::from_name(entry.get_ref()).filter(|kind| can.contains(kind)) {
                Some(kind) => sources.push(kind),
                None => {
                    let names: Vec<&str> = can.iter().map(|kind| kind.name()).collect();
                    let what = format!("{name}: expected one of {}, found {}", names.join(", "), quoted(entry.get_ref()));
                    return Err((entry.span().start, what));
                }
            }
        }
    }
    for (key, scale) in document.controls {
        let Some(control) = Control::from_name(key.get_ref()) else {
            let what = format!("controls: expected the name of a control, found {}", quoted(key.get_ref()));
            return Err((key.span().start, what));
        };
        if let Some(place) = config.controls.get_mut(control.index()) {
            change(place, &scale)?;
        }
    }
    if let Some(rpm) = document.rpm {
        if let Some(sensor) = rpm.sensor {
            config.rotor = number("sensor", &sensor, 2)?;
        }
        if let Some(ratio) = rpm.ratio {
            config.rotor_ratio = within("ratio", &ratio, 1e-6, 1e6)?;
        }
    }
    Ok(config)
}

fn names(text: Spanned<String>) -> Result<ControlNames, Wrong> {
    match text.get_ref().as_str() {
        "rotorcraft" => Ok(ControlNames::Rotorcraft),
        "fixed_wing" => Ok(ControlNames::FixedWing),
        other => {
            Err((text.span().start, format!("aircraft: expected \"rotorcraft\" or \"fixed_wing\", found {}", quoted(other))))
        }
    }
}

fn change(place: &mut ControlScale, scale: &Scale) -> Result<(), Wrong> {
    if let Some(channel) = &scale.channel {
        place.number = number("channel", channel, PULSES)?;
    }
    if let Some(zero) = &scale.zero_us {
        place.zero_us = within("zero_us", zero, 0.0, 65_535.0)?;
    }
    place.stated |= scale.full_us.is_some() || scale.full_deg.is_some();
    if let Some(full) = &scale.full_us {
        place.full_us = within("full_us", full, 1.0, 65_535.0)?;
    }
    if let Some(full) = &scale.full_deg {
        place.full_deg = within("full_deg", full, -360.0, 360.0)?;
        if libm::fabs(place.full_deg) < 1e-6 {
            return Err((full.span().start, "full_deg: expected an angle that is not zero, found 0".into()));
        }
    }
    Ok(())
}

fn within(key: &str, value: &Spanned<f64>, least: f64, most: f64) -> Result<f64, Wrong> {
    let found = *value.get_ref();
    if (least..=most).contains(&found) {
        Ok(found)
    } else {
        Err((value.span().start, format!("{key}: expected {least} to {most}, found {found}")))
    }
}

fn number(key: &str, value: &Spanned<usize>, most: usize) -> Result<usize, Wrong> {
    let found = *value.get_ref();
    if (1..=most).contains(&found) {
        Ok(found)
    } else {
        Err((value.span().start, format!("{key}: expected 1 to {most}, found {found}")))
    }
}

fn place(text: &str, (offset, what): Wrong) -> RunFileError {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    RunFileError { line, column, what }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_changes_its_setting_and_the_rest_stays() {
        let text = "system = 7\naircraft = \"fixed_wing\"\nreorder_ms = 0\n[sources]\nairspeed = [\"VFR_HUD\"]\naltitude = []\n\
                    [controls.rudder]\nchannel = 12\nfull_deg = -20\n[rpm]\nsensor = 2\nratio = 0.1\n";
        let mut expected = MavlinkConfig {
            system: Some(7),
            names: Some(ControlNames::FixedWing),
            reorder_us: 0,
            rotor: 2,
            rotor_ratio: 0.1,
            ..MavlinkConfig::default()
        };
        expected.sources[ChannelGroup::Airspeed as usize] = vec![MessageKind::VfrHud];
        expected.sources[ChannelGroup::Altitude as usize] = Vec::new();
        expected.controls[3] = ControlScale { number: 12, full_deg: -20.0, stated: true, ..ControlScale::of(4) };
        assert_eq!(MavlinkConfig::from_toml(text), Ok(expected));
        assert_eq!(MavlinkConfig::from_toml(""), Ok(MavlinkConfig::default()));
    }

    #[test]
    fn every_mistake_is_found_where_it_stands() {
        for (text, line, column, word) in [
            ("system = 300", 1, 10, "u8"),
            ("vehicle = 1", 1, 1, "vehicle"),
            ("\n[sources]\nairspeed = [\"VFR_HUD\", \"GPS\"]", 3, 24, "AIRSPEED, VFR_HUD"),
            ("[sources]\nspeed = []", 2, 1, "airspeed"),
            ("[controls.flaps]\nchannel = 1", 1, 11, "control"),
            ("[controls.pedal]\nchannel = 17", 2, 11, "1 to 16"),
            ("[controls.pedal]\nfull_deg = 0", 2, 12, "not zero"),
            ("aircraft = \"kite\"", 1, 12, "rotorcraft"),
            ("[rpm]\nratio = nan", 2, 9, "0.000001"),
            ("x", 1, 2, "TOML"),
        ] {
            let error = MavlinkConfig::from_toml(text).unwrap_err();
            assert!(error.line == line && error.what.contains(word), "{text}: {error}");
            assert!(error.column == column || text == "x", "{text}: {error}");
        }
    }
}
