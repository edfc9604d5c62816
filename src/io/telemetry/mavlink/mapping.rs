//! The message that supplies each channel, and its scale: a configuration with defaults.
//!
//! Consumes [`MessageReading`]s with their time; produces values of channels. Of several messages that contain the same channels
//! the first in the list is used, and the next only after two seconds of silence, so that two instruments are never mixed.
//! Controls from pulse widths: (width - zero) full_deg/full_us, by default zero = 1500 us and 10 degrees at 500 us. Pressure
//! altitude from static pressure, ICAO standard atmosphere up to 11 km:
//!     h = T0/L (1 - (p/p0)^(R L/g0)),   T0 = 288.15 K, L = 6.5 K/km, p0 = 101325 Pa, R = 287.05287 J/(kg K)      (1)
//! Source: ICAO, Manual of the Standard Atmosphere, Doc 7488/3 (1993).

use super::message::{MessageBody, MessageKind, MessageReading, PULSES};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::unit::STANDARD_GRAVITY as G0;

/// A message that stands further down takes over after so long a silence, us.
pub const SILENCE_US: i64 = 2_000_000;

const T0: f64 = 288.15;
const LAPSE: f64 = 0.0065;
const P0: f64 = 101_325.0;
const GAS: f64 = 287.052_87;
const TROPOPAUSE_M: f64 = 11_000.0;

/// Channels that one message gives together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum ChannelGroup {
    /// ax ay az.
    Force,
    /// p q r.
    Rates,
    /// phi theta psi.
    Attitude,
    /// tas.
    Airspeed,
    /// alpha beta.
    Flow,
    /// altitude.
    Altitude,
    /// The four controls.
    Controls,
    /// `rotor_speed`.
    Rotor,
}

/// How many groups there are.
pub const GROUPS: usize = 8;

impl ChannelGroup {
    /// Key in the configuration, and the messages that can give it, in the order of their preference.
    pub(super) const ALL: [(ChannelGroup, &'static str, &'static [MessageKind]); GROUPS] = [
        (
            ChannelGroup::Force,
            "specific_force",
            &[
                MessageKind::HighresImu,
                MessageKind::ScaledImu,
                MessageKind::RawImu,
                MessageKind::ScaledImu2,
                MessageKind::ScaledImu3,
            ],
        ),
        (
            ChannelGroup::Rates,
            "rates",
            &[
                MessageKind::HighresImu,
                MessageKind::ScaledImu,
                MessageKind::RawImu,
                MessageKind::ScaledImu2,
                MessageKind::ScaledImu3,
                MessageKind::Attitude,
                MessageKind::AttitudeQuaternion,
            ],
        ),
        (ChannelGroup::Attitude, "attitude", &[MessageKind::Attitude, MessageKind::AttitudeQuaternion]),
        (ChannelGroup::Airspeed, "airspeed", &[MessageKind::Airspeed, MessageKind::VfrHud]),
        (ChannelGroup::Flow, "flow_angles", &[MessageKind::AoaSsa]),
        (
            ChannelGroup::Altitude,
            "altitude",
            &[MessageKind::ScaledPressure, MessageKind::HighresImu, MessageKind::GlobalPositionInt, MessageKind::VfrHud],
        ),
        (ChannelGroup::Controls, "controls", &[MessageKind::ServoOutputRaw, MessageKind::RcChannels, MessageKind::ManualControl]),
        (ChannelGroup::Rotor, "rotor_speed", &[MessageKind::Rpm]),
    ];
}

/// One control by its pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlScale {
    /// Output or input, from 1.
    pub number: usize,
    /// Width at zero, us.
    pub zero_us: f64,
    /// From zero to the full angle, us.
    pub full_us: f64,
    /// The full angle, degrees; negative where a wider pulse means less.
    pub full_deg: f64,
    /// Whether somebody stated the angle; else it is the default, and assumed.
    pub stated: bool,
}

impl ControlScale {
    /// The default of the output or input of that number.
    pub const fn of(number: usize) -> Self {
        ControlScale { number, zero_us: 1500.0, full_us: 500.0, full_deg: 10.0, stated: false }
    }

    /// rad.
    pub fn angle(&self, width_us: f64) -> f64 {
        ((width_us - self.zero_us) / self.full_us * self.full_deg).to_radians()
    }

    /// us.
    pub fn width(&self, angle: f64) -> f64 {
        self.zero_us + angle.to_degrees() / self.full_deg * self.full_us
    }
}

/// What maps messages to channels.
#[derive(Clone, Debug, PartialEq)]
pub struct MavlinkConfig {
    /// Messages by group, in the order of their preference.
    pub sources: [Vec<MessageKind>; GROUPS],
    /// Scales of the controls, in the order of [`Channel::CONTROLS`].
    pub controls: [ControlScale; 4],
    /// How the controls are called; `None`: after the kind of aircraft that the vehicle's heartbeat names.
    pub names: Option<ControlNames>,
    /// System id of the vehicle, where it is not who sends most messages of motion: in all of a recording, live in the
    /// first second (see [`vehicle_selection`](super::vehicle_selection)).
    pub system: Option<u8>,
    /// Component id of the vehicle.
    pub component: Option<u8>,
    /// Which of the two speeds of RPM is the rotor's, 1 or 2.
    pub rotor: usize,
    /// Rotor speed for one of that shaft.
    pub rotor_ratio: f64,
    /// Messages that come so much later than newer ones still find their place, us. Samples wait for so long.
    pub reorder_us: i64,
}

impl Default for MavlinkConfig {
    fn default() -> Self {
        MavlinkConfig {
            sources: ChannelGroup::ALL.map(|(_, _, kinds)| kinds.to_vec()),
            controls: [2, 1, 3, 4].map(ControlScale::of),
            names: None,
            system: None,
            component: None,
            rotor: 1,
            rotor_ratio: 1.0,
            reorder_us: 20_000,
        }
    }
}

impl MavlinkConfig {
    /// Controls, by place, of whose angles nobody stated the scale.
    pub fn assumed_scale(&self) -> [bool; 4] {
        self.controls.map(|scale| !scale.stated)
    }

    /// The same, and the choice of sources that it begins with.
    pub fn mapping(self) -> Mapping {
        Mapping { config: self, giving: [None; GROUPS] }
    }

    fn rank(&self, group: ChannelGroup, kind: MessageKind) -> Option<usize> {
        self.sources.get(group as usize)?.iter().position(|source| *source == kind)
    }

    /// Every value that a reading can give, whether or not another message gives it too.
    pub fn values(&self, reading: &MessageReading, mut put: impl FnMut(ChannelGroup, Channel, f64)) {
        let mut all = |group: ChannelGroup, channels: &[Channel], values: &[Option<f64>]| {
            for (channel, value) in channels.iter().zip(values) {
                if let Some(value) = value {
                    put(group, *channel, *value);
                }
            }
        };
        const FORCES: [Channel; 3] = [Channel::Ax, Channel::Ay, Channel::Az];
        const RATES: [Channel; 3] = [Channel::P, Channel::Q, Channel::R];
        match &reading.body {
            MessageBody::Imu { force, rates, altitude } => {
                all(ChannelGroup::Force, &FORCES, force);
                all(ChannelGroup::Rates, &RATES, rates);
                all(ChannelGroup::Altitude, &[Channel::Altitude], &[*altitude]);
            }
            MessageBody::Attitude { angles, rates } => {
                all(ChannelGroup::Rates, &RATES, rates);
                all(ChannelGroup::Attitude, &[Channel::Phi, Channel::Theta, Channel::Psi], angles);
            }
            MessageBody::Air { airspeed, altitude } => {
                all(ChannelGroup::Airspeed, &[Channel::Tas], &[*airspeed]);
                all(ChannelGroup::Altitude, &[Channel::Altitude], &[*altitude]);
            }
            MessageBody::Flow { alpha, beta } => all(ChannelGroup::Flow, &[Channel::Alpha, Channel::Beta], &[*alpha, *beta]),
            MessageBody::Pressure(pressure) => {
                all(ChannelGroup::Altitude, &[Channel::Altitude], &[pressure.and_then(pressure_altitude)]);
            }
            MessageBody::Pulses(widths) => {
                let angle = |scale: &ControlScale| {
                    let width = widths.get(scale.number.wrapping_sub(1)).copied().flatten();
                    width.map(|width| scale.angle(width))
                };
                all(ChannelGroup::Controls, &Channel::CONTROLS, &self.controls.each_ref().map(angle));
            }
            MessageBody::Sticks { positions, .. } => {
                // A stick at its stop is as far as a pulse of 500 us from zero.
                let angle = |scale: &ControlScale| {
                    let position = positions.get(scale.number.wrapping_sub(1)).copied().flatten();
                    position.map(|position| (position * scale.full_deg).to_radians())
                };
                all(ChannelGroup::Controls, &Channel::CONTROLS, &self.controls.each_ref().map(angle));
            }
            MessageBody::Rotors(speeds) => {
                let speed = speeds.get(self.rotor.wrapping_sub(1)).copied().flatten();
                all(ChannelGroup::Rotor, &[Channel::RotorSpeed], &[speed.map(|speed| speed * self.rotor_ratio)]);
            }
            MessageBody::UnixTime(_) | MessageBody::Presence { .. } => {}
        }
    }

    /// Channels that a reading can give and that its lists allow it to give, a bit each.
    pub fn channels(&self, reading: &MessageReading) -> u32 {
        let mut mask = 0;
        self.values(reading, |group, channel, _| {
            if self.rank(group, reading.kind).is_some() {
                mask |= 1 << channel.index();
            }
        });
        mask
    }
}

/// A configuration with the choice of sources as it stands.
#[derive(Clone, Debug)]
pub struct Mapping {
    config: MavlinkConfig,
    /// Rank of the source that gives each group, and when it last did, us.
    giving: [Option<(usize, i64)>; GROUPS],
}

impl Mapping {
    /// The configuration.
    pub fn config(&self) -> &MavlinkConfig {
        &self.config
    }

    /// Values of a reading at that time, of the groups that its message gives now.
    pub fn map(&mut self, reading: &MessageReading, time_us: i64, mut put: impl FnMut(Channel, f64)) {
        let mut gives = [false; GROUPS];
        for (group, giving) in ChannelGroup::ALL.iter().map(|(group, ..)| *group).zip(&mut self.giving) {
            let Some(rank) = self.config.rank(group, reading.kind) else { continue };
            // A message that could give a group but brings no value of it does not count as giving it.
            let mut any = false;
            self.config.values(reading, |of, _, _| any |= of == group);
            let free = giving.is_none_or(|(before, last_us)| rank <= before || time_us - last_us > SILENCE_US);
            if any && free {
                let newest_us = giving.map_or(time_us, |(_, last_us)| last_us.max(time_us));
                *giving = Some((rank, newest_us));
                if let Some(place) = gives.get_mut(group as usize) {
                    *place = true;
                }
            }
        }
        self.config.values(reading, |group, channel, value| {
            if gives.get(group as usize) == Some(&true) {
                put(channel, value);
            }
        });
    }
}

/// Pressure altitude, m, by (1); `None` outside the troposphere, or of what is no pressure.
pub fn pressure_altitude(pressure_pa: f64) -> Option<f64> {
    let height = T0 / LAPSE * (1.0 - libm::pow(pressure_pa / P0, GAS * LAPSE / G0));
    (pressure_pa > 0.0 && height <= TROPOPAUSE_M && height > -2000.0).then_some(height)
}

/// Static pressure, Pa, at a pressure altitude: (1) turned about.
pub fn standard_pressure(altitude_m: f64) -> Option<f64> {
    let within = altitude_m <= TROPOPAUSE_M && altitude_m > -2000.0;
    within.then(|| P0 * libm::pow(1.0 - LAPSE * altitude_m / T0, G0 / (GAS * LAPSE)))
}

const _: () = assert!(PULSES >= 4, "the default scales read outputs 1 to 4");

#[cfg(test)]
mod tests {
    use super::super::message::Stamp;
    use super::*;

    #[test]
    fn the_standard_atmosphere_is_that_of_its_tables() {
        // Geopotential altitude and pressure, as tables of the standard atmosphere print them.
        for (height, pressure) in [(0.0, 101_325.0), (1000.0, 89_874.6), (5000.0, 54_019.9)] {
            assert!((standard_pressure(height).unwrap() / pressure - 1.0).abs() < 2e-6, "{height}");
            assert!((pressure_altitude(pressure).unwrap() - height).abs() < 0.05, "{height}");
        }
        assert_eq!([pressure_altitude(0.0), pressure_altitude(f64::NAN), pressure_altitude(1e3)], [None; 3]);
    }

    #[test]
    fn five_hundred_microseconds_are_ten_degrees() {
        let scale = ControlScale::of(1);
        assert!((scale.angle(2000.0) - 0.174_532_925_199_432_95).abs() < 1e-15);
        assert!((scale.width(scale.angle(1432.0)) - 1432.0).abs() < 1e-9);
    }

    #[test]
    fn the_first_of_the_list_gives_the_channel_and_the_next_only_after_its_silence() {
        let mut mapping = MavlinkConfig::default().mapping();
        let mut given = |kind: MessageKind, time_us: i64, speed: f64| {
            let body = MessageBody::Air { airspeed: Some(speed), altitude: None };
            let mut value = None;
            mapping.map(&MessageReading { kind, stamp: Stamp::None, body }, time_us, |_, found| value = Some(found));
            value
        };
        assert_eq!(given(MessageKind::VfrHud, 0, 50.0), Some(50.0));
        assert_eq!(given(MessageKind::Airspeed, 100_000, 51.0), Some(51.0));
        assert_eq!(given(MessageKind::VfrHud, 200_000, 52.0), None);
        assert_eq!(given(MessageKind::VfrHud, 2_200_000, 53.0), Some(53.0));
        assert_eq!(given(MessageKind::Airspeed, 2_300_000, 54.0), Some(54.0));
    }

    #[test]
    fn attitude_gives_rates_only_where_nothing_else_does() {
        let mut mapping = MavlinkConfig::default().mapping();
        let imu = MessageBody::Imu { force: [Some(0.0); 3], rates: [Some(1.0); 3], altitude: None };
        let attitude = MessageBody::Attitude { angles: [Some(0.1); 3], rates: [Some(2.0); 3] };
        let mut rate = |kind: MessageKind, body: MessageBody, time_us: i64| {
            let mut value = None;
            mapping.map(&MessageReading { kind, stamp: Stamp::None, body }, time_us, |channel, found| {
                if channel == Channel::P {
                    value = Some(found);
                }
            });
            value
        };
        assert_eq!(rate(MessageKind::Attitude, attitude, 0), Some(2.0));
        assert_eq!(rate(MessageKind::RawImu, imu, 10), Some(1.0));
        assert_eq!(rate(MessageKind::Attitude, attitude, 20), None);
    }
}
