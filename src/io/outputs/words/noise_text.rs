//! The noise statistics that the filter used: a sentence, and a JSON object.
//!
//! Only channels of the run are listed. JSON: `std` of a channel in its SI unit, and, for gyros and accelerometers, the `walk`:
//! density of the process noise of angular acceleration (rad/s^2 per sqrt(s)) or of specific force (m/s^2 per sqrt(s)).

use crate::flight::channel::Channel;
use crate::io::outputs::number::Digits;
use crate::realtime::estimation::record::{Aid, Instrumentation, NoiseRecord};
use core::fmt;
use serde::ser::{Serialize, SerializeMap, Serializer};

/// The statistics, and which instruments they are of.
#[derive(Clone, Copy, Debug)]
pub struct NoiseUsed {
    /// What was used.
    pub noise: NoiseRecord,
    /// What the run brought.
    pub found: Instrumentation,
}

/// A channel, the standard deviation of its noise, the walk.
type Entry = (Channel, f64, Option<f64>);

impl NoiseUsed {
    /// Of a run with these instruments; `None` where the filter never ran.
    pub fn of(noise: &NoiseRecord, found: Instrumentation) -> Option<Self> {
        (found.gyros && found.rate_hz > 0.0).then_some(NoiseUsed { noise: *noise, found })
    }

    fn entries(&self) -> impl Iterator<Item = Entry> {
        let (noise, found) = (self.noise.noise, self.found);
        let gyros =
            [Channel::P, Channel::Q, Channel::R].into_iter().zip(noise.gyro_std).zip(self.noise.angular_acceleration_walk);
        let forces = [Channel::Ax, Channel::Ay, Channel::Az]
            .into_iter()
            .zip(noise.accelerometer_std)
            .zip(self.noise.specific_force_walk)
            .zip(found.accelerometers)
            .filter_map(|(entry, there)| there.then_some(entry));
        let inertial = gyros.filter(move |_| found.gyros).chain(forces).map(|((channel, std), walk)| (channel, std, Some(walk)));
        let aids = Aid::ALL.into_iter().zip(found.aids).filter(|(_, there)| *there);
        inertial.chain(aids.map(move |(aid, _)| (aid.channel(), noise.of(aid), None)))
    }
}

impl fmt::Display for NoiseUsed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("noise used:")?;
        for (place, (channel, std, _)) in self.entries().enumerate() {
            let comma = if place == 0 { "" } else { "," };
            write!(f, "{comma} {} {} {}", channel.name(Default::default()), Digits(std, 2), channel.si_unit())?;
        }
        f.write_str("; walk of")?;
        for (place, (channel, _, walk)) in self.entries().filter(|(.., walk)| walk.is_some()).enumerate() {
            let comma = if place == 0 { "" } else { "," };
            let dot = if matches!(channel, Channel::P | Channel::Q | Channel::R) { "-dot" } else { "" };
            write!(f, "{comma} {}{dot} {}", channel.name(Default::default()), Digits(walk.unwrap_or_default(), 2))?;
        }
        f.write_str(" per sqrt(s)")
    }
}

impl Serialize for NoiseUsed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(serde::Serialize)]
        struct One {
            std: f64,
            #[serde(skip_serializing_if = "Option::is_none")]
            walk: Option<f64>,
        }
        let mut map = serializer.serialize_map(None)?;
        for (channel, std, walk) in self.entries() {
            map.serialize_entry(channel.name(Default::default()), &One { std, walk })?;
        }
        map.end()
    }
}
