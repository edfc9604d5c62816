//! MAVLink 1 and 2: bytes of a tlog or of a live link become samples of one vehicle.
//!
//! In: bytes in chunks of any size ([`packet`]), tlog records ([`tlog`]), sockets and serial lines ([`link`]).
//! Out: samples on the vehicle's boot clock ([`stream`], [`clock`]), channels by a configuration with defaults ([`mapping`],
//! [`config_file`]), counts by sender and message type ([`senders`]); the same as a recording ([`recording`]). Live ([`live`])
//! the vehicle is selected among the senders ([`vehicle_selection`]), and host time supervises its clock ([`clock_monitor`],
//! [`reboot`], [`host_time`]). The reverse, samples as frames: [`encode`].
//! Assumed: body axes and signs of MAVLink, which are those of Sideslip; RAW_IMU in milli-g and mrad/s; airspeeds are true
//! airspeed; a message without time stamp has the time of the newest message of its sender.
//! Refused and counted, never fatal: bytes that are no frame, wrong checksums, messages that the dialect does not contain, times
//! that contradict the others, messages that are too late. Where a key is set, frames that are not rightly signed ([`signing`]).
//!
//! A link and a stream, live:
//! ```
//! use sideslip::io::telemetry::mavlink::{mapping::MavlinkConfig, packet::{Framer, Framing}, stream::VehicleStream};
//! let mut framer = Framer::new(Framing::Bare);
//! let mut stream = VehicleStream::new(MavlinkConfig::default(), None);
//! let mut bytes: &[u8] = &[0xFD, 0x09];                       // bytes received from a link
//! while !bytes.is_empty() {
//!     bytes = &bytes[framer.take(bytes)..];
//!     while let Some(packet) = framer.next_packet() {
//!         stream.packet(&packet, None);                       // host time, if available
//!     }
//! }
//! while let Some(timed) = stream.next_sample() {
//!     println!("{} s", timed.sample.time_s);
//! }
//! ```

pub mod clock;
pub mod clock_monitor;
pub mod clock_rate;
pub mod config_file;
pub mod encode;
pub mod frame_signature;
pub mod host_time;
pub mod link;
pub mod live;
#[cfg(test)]
mod live_tests;
pub mod mapping;
pub mod message;
pub mod packet;
pub mod reboot;
pub mod recording;
mod running_crc;
pub mod senders;
pub mod serial;
pub mod signing;
pub mod signing_key;
pub mod signing_time;
pub mod stream;
pub mod tlog;
pub mod vehicle_selection;
