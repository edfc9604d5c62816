//! Samples as MAVLink 2 frames: tlog files of simulated flights, and playback over a link.
//!
//! Consumes samples in SI and radians; produces frames of HIGHRES_IMU, ATTITUDE, AIRSPEED, AOA_SSA, SCALED_PRESSURE,
//! SERVO_OUTPUT_RAW and RPM, and one HEARTBEAT a second, which the default mapping reads back. Boot time is the time of the
//! sample, truncated to milliseconds where the message has no microseconds. Resolution: single precision; pulse widths of 1 us,
//! by default 0.02 degrees (0.35 mrad). Refused: a pulse width outside the format's range, a negative time.

use super::mapping::{MavlinkConfig, standard_pressure};
use super::senders::Sender;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::sample::Sample;
use mavlink::dialects::ardupilotmega as dialect;
use mavlink::dialects::ardupilotmega::MavMessage;
use mavlink::{MAVLinkV2MessageRaw, MavHeader};

/// The autopilot of system 1.
pub const ME: Sender = Sender { system: 1, component: 1 };

/// Channels that no message carries.
pub const NOT_CARRIED: [Channel; 6] =
    [Channel::TailPitch, Channel::Torque, Channel::Flap0, Channel::Flap1c, Channel::Flap1s, Channel::Rho];

/// Why a sample cannot be sent.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum EncodeError {
    #[error("expected a time from 0 to 49 days, found {0} s")]
    Time(f64),
    #[error("expected a pulse of 1 to 65534 us for {control}, found {width_us:.0} us for {angle} rad")]
    Pulse { control: &'static str, angle: f64, width_us: f64 },
    #[error("expected an altitude of -2000 to 11000 m, found {0} m")]
    Altitude(f64),
}

/// Numbers frames and puts messages into them.
#[derive(Debug)]
pub struct Frames {
    sender: Sender,
    sequence: u8,
    raw: MAVLinkV2MessageRaw,
}

impl Frames {
    /// Frames of that sender.
    pub fn new(sender: Sender) -> Self {
        Frames { sender, sequence: 0, raw: MAVLinkV2MessageRaw::new() }
    }

    /// The next frame.
    pub fn frame(&mut self, message: &MavMessage) -> &[u8] {
        let header =
            MavHeader { system_id: u32::from(self.sender.system), component_id: self.sender.component, sequence: self.sequence };
        self.sequence = self.sequence.wrapping_add(1);
        self.raw.serialize_message(header, message);
        self.raw.raw_bytes()
    }
}

/// Samples as frames.
#[derive(Debug)]
pub struct Encoder {
    frames: Frames,
    config: MavlinkConfig,
    fixed_wing: bool,
    heartbeat_s: Option<f64>,
}

impl Encoder {
    /// Frames of that sender, scaled as the configuration reads them.
    pub fn new(sender: Sender, config: MavlinkConfig, controls: ControlNames) -> Self {
        Encoder { frames: Frames::new(sender), config, fixed_wing: controls == ControlNames::FixedWing, heartbeat_s: None }
    }

    /// Gives every frame of a sample to `send`, in one go.
    ///
    /// # Errors
    /// [`EncodeError`] where a value does not fit; frames before it have gone.
    pub fn sample(&mut self, sample: &Sample, mut send: impl FnMut(&[u8])) -> Result<(), EncodeError> {
        let time_us = libm::round(sample.time_s * 1e6);
        if !(0.0..4_294_967_295_000.0).contains(&time_us) {
            return Err(EncodeError::Time(sample.time_s));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 2^42")]
        let time_us = time_us as u64;
        if self.heartbeat_s.is_none_or(|last_s| sample.time_s - last_s >= 1.0 || sample.time_s < last_s) {
            self.heartbeat_s = Some(sample.time_s);
            send(self.frames.frame(&self.heartbeat()));
        }
        for message in self.messages(sample, time_us)?.into_iter().flatten() {
            send(self.frames.frame(&message));
        }
        Ok(())
    }

    fn heartbeat(&self) -> MavMessage {
        let mavtype = if self.fixed_wing { dialect::MavType::MAV_TYPE_FIXED_WING } else { dialect::MavType::MAV_TYPE_HELICOPTER };
        MavMessage::HEARTBEAT(dialect::HEARTBEAT_DATA {
            custom_mode: 0,
            mavtype,
            autopilot: dialect::MavAutopilot::MAV_AUTOPILOT_GENERIC,
            base_mode: dialect::MavModeFlag::empty(),
            system_status: dialect::MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        })
    }

    fn messages(&self, sample: &Sample, time_us: u64) -> Result<[Option<MavMessage>; 7], EncodeError> {
        // Whole numbers of the message's own width: what is cut off is meant to be.
        let time_boot_ms = u32::try_from(time_us / 1000).unwrap_or(u32::MAX);
        let any = |channels: &[Channel]| channels.iter().any(|channel| sample.get(*channel).is_some());
        let inertial = any(&[Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R]);
        let attitude = any(&[Channel::Phi, Channel::Theta, Channel::Psi]).then(|| {
            MavMessage::ATTITUDE(dialect::ATTITUDE_DATA {
                time_boot_ms,
                roll: single(sample, Channel::Phi),
                pitch: single(sample, Channel::Theta),
                yaw: single(sample, Channel::Psi),
                rollspeed: single(sample, Channel::P),
                pitchspeed: single(sample, Channel::Q),
                yawspeed: single(sample, Channel::R),
            })
        });
        let airspeed = any(&[Channel::Tas]).then(|| {
            MavMessage::AIRSPEED(dialect::AIRSPEED_DATA {
                airspeed: single(sample, Channel::Tas),
                raw_press: f32::NAN,
                temperature: i16::MAX,
                id: 0,
                flags: dialect::AirspeedSensorFlags::empty(),
            })
        });
        let flow = any(&[Channel::Alpha, Channel::Beta]).then(|| {
            MavMessage::AOA_SSA(dialect::AOA_SSA_DATA {
                time_usec: time_us,
                AOA: single_of(sample.get(Channel::Alpha).map(f64::to_degrees)),
                SSA: single_of(sample.get(Channel::Beta).map(f64::to_degrees)),
            })
        });
        let rotor = sample.get(Channel::RotorSpeed).map(|speed| {
            let rpm = single_of(Some(speed / self.config.rotor_ratio * 60.0 / std::f64::consts::TAU));
            MavMessage::RPM(if self.config.rotor == 2 {
                dialect::RPM_DATA { rpm1: f32::NAN, rpm2: rpm }
            } else {
                dialect::RPM_DATA { rpm1: rpm, rpm2: f32::NAN }
            })
        });
        Ok([
            inertial.then(|| highres(sample, time_us)),
            attitude,
            airspeed,
            flow,
            sample.get(Channel::Altitude).map(|altitude| pressure(altitude, time_boot_ms)).transpose()?,
            any(&Channel::CONTROLS).then(|| self.pulses(sample, time_us)).transpose()?,
            rotor,
        ])
    }

    fn pulses(&self, sample: &Sample, time_us: u64) -> Result<MavMessage, EncodeError> {
        let mut widths = [0_u16; 8];
        for (channel, scale) in Channel::CONTROLS.into_iter().zip(&self.config.controls) {
            let Some(angle) = sample.get(channel) else { continue };
            let width_us = libm::round(scale.width(angle));
            let names = if self.fixed_wing { ControlNames::FixedWing } else { ControlNames::Rotorcraft };
            let refused = EncodeError::Pulse { control: channel.name(names), angle, width_us };
            if !(1.0..=65_534.0).contains(&width_us) {
                return Err(refused);
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked above")]
            let width = width_us as u16;
            *widths.get_mut(scale.number.wrapping_sub(1)).ok_or(refused)? = width;
        }
        let [servo1_raw, servo2_raw, servo3_raw, servo4_raw, servo5_raw, servo6_raw, servo7_raw, servo8_raw] = widths;
        #[expect(clippy::cast_possible_truncation, reason = "the message's clock starts again after 2^32")]
        let time_usec = time_us as u32;
        Ok(MavMessage::SERVO_OUTPUT_RAW(dialect::SERVO_OUTPUT_RAW_DATA {
            time_usec,
            servo1_raw,
            servo2_raw,
            servo3_raw,
            servo4_raw,
            servo5_raw,
            servo6_raw,
            servo7_raw,
            servo8_raw,
            port: 0,
        }))
    }
}

/// Single precision, NaN where it was not sampled.
fn single(sample: &Sample, channel: Channel) -> f32 {
    single_of(sample.get(channel))
}

#[expect(clippy::cast_possible_truncation, reason = "the message has single precision")]
fn single_of(value: Option<f64>) -> f32 {
    value.map_or(f32::NAN, |value| value as f32)
}

fn highres(sample: &Sample, time_us: u64) -> MavMessage {
    const INERTIAL: [Channel; 6] = [Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R];
    let updated = INERTIAL.iter().enumerate().filter(|(_, channel)| sample.get(**channel).is_some());
    let fields = updated.fold(0_u16, |fields, (bit, _)| fields | 1 << bit);
    MavMessage::HIGHRES_IMU(dialect::HIGHRES_IMU_DATA {
        time_usec: time_us,
        xacc: single(sample, Channel::Ax),
        yacc: single(sample, Channel::Ay),
        zacc: single(sample, Channel::Az),
        xgyro: single(sample, Channel::P),
        ygyro: single(sample, Channel::Q),
        zgyro: single(sample, Channel::R),
        fields_updated: dialect::HighresImuUpdatedFlags::from_bits_retain(fields),
        ..Default::default()
    })
}

fn pressure(altitude: f64, time_boot_ms: u32) -> Result<MavMessage, EncodeError> {
    let pressure_pa = standard_pressure(altitude).ok_or(EncodeError::Altitude(altitude))?;
    Ok(MavMessage::SCALED_PRESSURE(dialect::SCALED_PRESSURE_DATA {
        time_boot_ms,
        press_abs: single_of(Some(pressure_pa / 100.0)),
        press_diff: f32::NAN,
        temperature: 0,
    }))
}
