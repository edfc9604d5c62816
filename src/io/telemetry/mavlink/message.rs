//! Fields of the messages that Sideslip uses, in SI and radians.
//!
//! Consumes a [`Packet`]; produces a [`MessageReading`]. Fields are read by their offset in the payload, so that an unknown value
//! of an enumeration does not invalidate the message. Axes are body axes (x forward, y right, z down); accelerometers measure
//! specific force, -1 g along z at rest, as MAVLink defines it. NaN is "not provided" in MAVLink: the field was not sampled.
//! RAW_IMU is raw counts by definition; present autopilots fill it like SCALED_IMU (milli-g, mrad/s), and it is read so. The
//! airspeed of VFR_HUD and AIRSPEED is used as true airspeed; an indicated airspeed is less than that at altitude.

use super::packet::Packet;
use crate::flight::unit::STANDARD_GRAVITY as G0;

/// A message that is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "each is the message of that name")]
pub enum MessageKind {
    Heartbeat,
    SystemTime,
    ScaledImu,
    RawImu,
    ScaledPressure,
    Attitude,
    AttitudeQuaternion,
    GlobalPositionInt,
    ServoOutputRaw,
    RcChannels,
    ManualControl,
    VfrHud,
    HighresImu,
    ScaledImu2,
    ScaledImu3,
    Rpm,
    Airspeed,
    AoaSsa,
}

/// Every message that is used: id, kind, name.
const KINDS: [(u32, MessageKind, &str); 18] = [
    (0, MessageKind::Heartbeat, "HEARTBEAT"),
    (2, MessageKind::SystemTime, "SYSTEM_TIME"),
    (26, MessageKind::ScaledImu, "SCALED_IMU"),
    (27, MessageKind::RawImu, "RAW_IMU"),
    (29, MessageKind::ScaledPressure, "SCALED_PRESSURE"),
    (30, MessageKind::Attitude, "ATTITUDE"),
    (31, MessageKind::AttitudeQuaternion, "ATTITUDE_QUATERNION"),
    (33, MessageKind::GlobalPositionInt, "GLOBAL_POSITION_INT"),
    (36, MessageKind::ServoOutputRaw, "SERVO_OUTPUT_RAW"),
    (65, MessageKind::RcChannels, "RC_CHANNELS"),
    (69, MessageKind::ManualControl, "MANUAL_CONTROL"),
    (74, MessageKind::VfrHud, "VFR_HUD"),
    (105, MessageKind::HighresImu, "HIGHRES_IMU"),
    (116, MessageKind::ScaledImu2, "SCALED_IMU2"),
    (129, MessageKind::ScaledImu3, "SCALED_IMU3"),
    (226, MessageKind::Rpm, "RPM"),
    (295, MessageKind::Airspeed, "AIRSPEED"),
    (11020, MessageKind::AoaSsa, "AOA_SSA"),
];

impl MessageKind {
    /// The kind of a message id, where it is used.
    pub fn of(id: u32) -> Option<MessageKind> {
        KINDS.iter().find(|(known, ..)| *known == id).map(|(_, kind, _)| *kind)
    }

    /// The kind of that name.
    pub fn from_name(name: &str) -> Option<MessageKind> {
        KINDS.iter().find(|(_, _, known)| *known == name).map(|(_, kind, _)| *kind)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        KINDS.iter().find(|(_, kind, _)| *kind == self).map_or("", |(_, _, name)| name)
    }

    /// Whether it measures the motion of an aircraft: who sends most of these is the vehicle.
    pub fn is_motion(self) -> bool {
        matches!(
            self,
            MessageKind::ScaledImu
                | MessageKind::ScaledImu2
                | MessageKind::ScaledImu3
                | MessageKind::RawImu
                | MessageKind::HighresImu
                | MessageKind::Attitude
                | MessageKind::AttitudeQuaternion
        )
    }
}

/// The time in a message, on the sender's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamp {
    /// The message has none.
    None,
    /// Milliseconds since boot; starts again from zero after 2^32.
    BootMs(u32),
    /// Microseconds since boot, or since 1970.
    Us(u64),
    /// Microseconds since boot; starts again from zero after 2^32 (71.6 minutes).
    WrappingUs(u32),
}

/// How many outputs or inputs of pulses are read.
pub const PULSES: usize = 16;

/// What a message says, SI and radians; `None` where a field was not provided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MessageBody {
    /// Specific force, m/s^2, and body rates, rad/s.
    Imu {
        /// ax ay az.
        force: [Option<f64>; 3],
        /// p q r.
        rates: [Option<f64>; 3],
        /// Pressure altitude, m.
        altitude: Option<f64>,
    },
    /// phi theta psi, rad, and p q r, rad/s.
    Attitude {
        /// phi theta psi.
        angles: [Option<f64>; 3],
        /// p q r.
        rates: [Option<f64>; 3],
    },
    /// Airspeed, m/s, and altitude, m.
    Air {
        /// Airspeed.
        airspeed: Option<f64>,
        /// Altitude above sea level.
        altitude: Option<f64>,
    },
    /// Flow angles, rad.
    Flow {
        /// Incidence.
        alpha: Option<f64>,
        /// Sideslip.
        beta: Option<f64>,
    },
    /// Static pressure, Pa.
    Pressure(Option<f64>),
    /// Pulse widths, us; `None` for an output that is not used.
    Pulses([Option<f64>; PULSES]),
    /// Sticks of a pilot on the ground: roll, pitch, thrust, yaw, each -1 to 1 (thrust 0 to 1), and to which system.
    Sticks {
        /// In the order of the pulses' channels 1 to 4.
        positions: [Option<f64>; 4],
        /// System id that they are for.
        target: u8,
    },
    /// Rotational speeds, rad/s.
    Rotors([Option<f64>; 2]),
    /// Microseconds since 1970; zero where it does not know.
    UnixTime(u64),
    /// MAV_TYPE and MAV_AUTOPILOT.
    Presence {
        /// MAV_TYPE.
        vehicle: u8,
        /// MAV_AUTOPILOT; 8 is "no autopilot".
        autopilot: u8,
    },
}

/// One message that is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MessageReading {
    /// Which.
    pub kind: MessageKind,
    /// Its time.
    pub stamp: Stamp,
    /// What it says.
    pub body: MessageBody,
}

/// Fields of a payload by their place in bytes; a place outside it reads as zero, as MAVLink 2 has it.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn bytes<const N: usize>(&self, at: usize) -> [u8; N] {
        self.0.get(at..).and_then(|rest| rest.first_chunk::<N>()).copied().unwrap_or([0; N])
    }

    fn u8(&self, at: usize) -> u8 {
        u8::from_le_bytes(self.bytes(at))
    }

    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes(self.bytes(at))
    }

    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.bytes(at))
    }

    fn u64(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.bytes(at))
    }

    fn i16(&self, at: usize) -> f64 {
        f64::from(i16::from_le_bytes(self.bytes(at)))
    }

    fn f32(&self, at: usize) -> Option<f64> {
        let value = f32::from_le_bytes(self.bytes(at));
        (!value.is_nan()).then_some(f64::from(value))
    }

    fn triple(&self, at: usize) -> [Option<f64>; 3] {
        [self.f32(at), self.f32(at + 4), self.f32(at + 8)]
    }

    /// Accelerometers in milli-g and gyros in mrad/s, six whole numbers in a row.
    fn milli_imu(&self, at: usize) -> MessageBody {
        let force = [0, 2, 4].map(|i| Some(self.i16(at + i) * 1e-3 * G0));
        let rates = [6, 8, 10].map(|i| Some(self.i16(at + i) * 1e-3));
        MessageBody::Imu { force, rates, altitude: None }
    }

    /// Pulse widths; neither 0 nor 65535 is one.
    fn pulses(&self, places: [usize; PULSES]) -> MessageBody {
        MessageBody::Pulses(places.map(|at| match self.u16(at) {
            0 | u16::MAX => None,
            width => Some(f64::from(width)),
        }))
    }
}

impl MessageReading {
    /// Reads a frame, where its message is used. Outputs of a second port, and messages without content, are not.
    pub fn of(packet: &Packet) -> Option<MessageReading> {
        let kind = MessageKind::of(packet.id)?;
        let f = Fields(packet.payload());
        let (stamp, body) = match kind {
            MessageKind::Heartbeat => (Stamp::None, MessageBody::Presence { vehicle: f.u8(4), autopilot: f.u8(5) }),
            MessageKind::SystemTime => (Stamp::BootMs(f.u32(8)), MessageBody::UnixTime(f.u64(0))),
            MessageKind::ScaledImu | MessageKind::ScaledImu2 | MessageKind::ScaledImu3 => {
                (Stamp::BootMs(f.u32(0)), f.milli_imu(4))
            }
            MessageKind::RawImu => (Stamp::Us(f.u64(0)), f.milli_imu(8)),
            MessageKind::HighresImu => (Stamp::Us(f.u64(0)), highres(&f)),
            MessageKind::ScaledPressure => (Stamp::BootMs(f.u32(0)), MessageBody::Pressure(f.f32(4).map(|hpa| hpa * 100.0))),
            MessageKind::Attitude => {
                (Stamp::BootMs(f.u32(0)), MessageBody::Attitude { angles: f.triple(4), rates: f.triple(16) })
            }
            MessageKind::AttitudeQuaternion => (
                Stamp::BootMs(f.u32(0)),
                MessageBody::Attitude { angles: angles([f.f32(4), f.f32(8), f.f32(12), f.f32(16)]), rates: f.triple(20) },
            ),
            MessageKind::GlobalPositionInt => {
                let altitude = f64::from(i32::from_le_bytes(f.bytes(12))) * 1e-3;
                (Stamp::BootMs(f.u32(0)), MessageBody::Air { airspeed: None, altitude: Some(altitude) })
            }
            MessageKind::VfrHud => (Stamp::None, MessageBody::Air { airspeed: f.f32(0), altitude: f.f32(8) }),
            MessageKind::Airspeed => (Stamp::None, MessageBody::Air { airspeed: f.f32(0), altitude: None }),
            MessageKind::AoaSsa => (
                Stamp::Us(f.u64(0)),
                MessageBody::Flow { alpha: f.f32(8).map(f64::to_radians), beta: f.f32(12).map(f64::to_radians) },
            ),
            MessageKind::ServoOutputRaw if f.u8(20) != 0 => return None,
            MessageKind::ServoOutputRaw => {
                let place = |i: usize| if i < 8 { 4 + 2 * i } else { 21 + 2 * (i - 8) };
                (Stamp::WrappingUs(f.u32(0)), f.pulses(std::array::from_fn(place)))
            }
            MessageKind::RcChannels => {
                let count = usize::from(f.u8(40));
                let MessageBody::Pulses(mut widths) = f.pulses(std::array::from_fn(|i| 4 + 2 * i)) else { return None };
                widths.iter_mut().skip(count).for_each(|width| *width = None);
                (Stamp::BootMs(f.u32(0)), MessageBody::Pulses(widths))
            }
            MessageKind::ManualControl => {
                let axis =
                    |at: usize| Some(f.i16(at)).filter(|value| *value <= 1000.0 && *value >= -1000.0).map(|value| value / 1000.0);
                (Stamp::None, MessageBody::Sticks { positions: [axis(2), axis(0), axis(4), axis(6)], target: f.u8(10) })
            }
            MessageKind::Rpm => {
                let speed = |at: usize| f.f32(at).filter(|rpm| *rpm >= 0.0).map(|rpm| rpm * std::f64::consts::TAU / 60.0);
                (Stamp::None, MessageBody::Rotors([speed(0), speed(4)]))
            }
        };
        Some(MessageReading { kind, stamp, body })
    }
}

/// Only what the message says it has updated; one that says nothing at all is taken to have updated its inertial part.
fn highres(f: &Fields<'_>) -> MessageBody {
    let updated = match f.u16(60) {
        0 => 0b11_1111,
        updated => updated,
    };
    let part = |bit: usize, value: Option<f64>| value.filter(|_| updated >> bit & 1 == 1);
    let [ax, ay, az] = f.triple(8);
    let [p, q, r] = f.triple(20);
    MessageBody::Imu {
        force: [part(0, ax), part(1, ay), part(2, az)],
        rates: [part(3, p), part(4, q), part(5, r)],
        altitude: part(11, f.f32(52)),
    }
}

/// phi theta psi of the rotation (w, x, y, z) from the earth's axes (north, east, down) to the body's.
fn angles(quaternion: [Option<f64>; 4]) -> [Option<f64>; 3] {
    let [Some(w), Some(x), Some(y), Some(z)] = quaternion else { return [None; 3] };
    let square = w * w + x * x + y * y + z * z;
    if !(square > 0.5 && square < 2.0) {
        return [None; 3];
    }
    let (w2, x2, y2, z2) = (w * w / square, x * x / square, y * y / square, z * z / square);
    let phi = libm::atan2(2.0 * (w * x + y * z) / square, w2 - x2 - y2 + z2);
    let theta = libm::asin((2.0 * (w * y - z * x) / square).clamp(-1.0, 1.0));
    let psi = libm::atan2(2.0 * (w * z + x * y) / square, w2 + x2 - y2 - z2);
    [Some(phi), Some(theta), Some(psi)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::Message as _;
    use mavlink::dialects::ardupilotmega::MavMessage;

    #[test]
    fn ids_and_names_are_those_of_the_dialect() {
        for (id, kind, name) in KINDS {
            assert_eq!(MavMessage::message_id_from_name(name), Some(id));
            assert_eq!((MessageKind::of(id), MessageKind::from_name(name), kind.name()), (Some(kind), Some(kind), name));
        }
    }

    #[test]
    fn a_quaternion_gives_the_angles_that_made_it() {
        let (phi, theta, psi) = (0.3_f64, -0.4_f64, 2.1_f64);
        let half = |angle: f64| libm::sincos(angle / 2.0);
        let ((sp, cp), (st, ct), (ss, cs)) = (half(phi), half(theta), half(psi));
        let w = cp * ct * cs + sp * st * ss;
        let x = sp * ct * cs - cp * st * ss;
        let y = cp * st * cs + sp * ct * ss;
        let z = cp * ct * ss - sp * st * cs;
        for (found, truth) in angles([w, x, y, z].map(Some)).into_iter().zip([phi, theta, psi]) {
            assert!((found.unwrap() - truth).abs() < 1e-14);
        }
        assert_eq!(angles([Some(0.0); 4]), [None; 3]);
    }
}
