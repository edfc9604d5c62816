//! MAVLink 1 and 2: bytes of a tlog or of a live link become samples of one vehicle.
//!
//! In: bytes in any chunks ([`packet`]), tlog records ([`tlog`]), sockets and serial lines ([`link`]).
//! Out: samples on the vehicle's own boot clock ([`stream`], [`clock`]), channels by a configuration with defaults
//! ([`mapping`], [`config_file`]), counts of everything by sender and type ([`senders`]); the same as a recording
//! ([`recording`]). Live ([`live`]) the vehicle is chosen among the senders ([`vehicle_selection`]), and host time is a
//! witness of its clock ([`clock_monitor`], [`reboot`], [`host_time`]). The other way, samples as frames ([`encode`]).
//! Assumed: body axes and signs of MAVLink, which are ours; RAW_IMU in milli-g and mrad/s; airspeeds as true airspeed;
//! a message without a time of its own is as new as the newest of its sender.
//! Refused, counted and never fatal: bytes that are no frame, wrong checksums, messages that the dialect does not know,
//! times that contradict the others, messages that come too late. Signatures are not verified.
//!
//! Live, a link and a stream go together like this:
//! ```
//! use sideslip::io::telemetry::mavlink::{mapping::MavlinkConfig, packet::{Framer, Framing}, stream::VehicleStream};
//! let mut framer = Framer::new(Framing::Bare);
//! let mut stream = VehicleStream::new(MavlinkConfig::default(), None);
//! let mut bytes: &[u8] = &[0xFD, 0x09];                       // what a link has just received
//! while !bytes.is_empty() {
//!     bytes = &bytes[framer.take(bytes)..];
//!     while let Some(packet) = framer.next_packet() {
//!         stream.packet(&packet, None);                       // the host's time, where it is wanted
//!     }
//! }
//! while let Some(timed) = stream.next_sample() {
//!     println!("{} s", timed.sample.time_s);
//! }
//! ```

pub mod clock;
pub mod clock_monitor;
pub mod config_file;
pub mod encode;
pub mod host_time;
pub mod link;
pub mod live;
pub mod mapping;
pub mod message;
pub mod packet;
pub mod reboot;
pub mod recording;
pub mod senders;
pub mod serial;
pub mod stream;
pub mod tlog;
pub mod vehicle_selection;
