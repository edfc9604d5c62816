//! The measurements that aid the filter: their order in per-aid tables and the channel of each.

use crate::flight::channel::Channel;

/// A measurement that aids the filter. The discriminant is its place in per-aid tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Aid {
    /// True airspeed, m/s.
    Airspeed,
    /// Incidence vane, rad.
    Incidence,
    /// Sideslip vane, rad.
    Sideslip,
    /// Bank angle, rad.
    Bank,
    /// Pitch attitude, rad.
    Pitch,
    /// Heading, rad.
    Heading,
    /// Pressure altitude, m.
    Altitude,
}

/// How many aids there are.
pub const AIDS: usize = 7;

impl Aid {
    /// Every aid, in the order of its place in per-aid tables; they are fused in this order.
    pub const ALL: [Aid; AIDS] =
        [Aid::Airspeed, Aid::Incidence, Aid::Sideslip, Aid::Bank, Aid::Pitch, Aid::Heading, Aid::Altitude];

    /// Place in per-aid tables.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The channel that carries the measurement.
    pub const fn channel(self) -> Channel {
        match self {
            Aid::Airspeed => Channel::Tas,
            Aid::Incidence => Channel::Alpha,
            Aid::Sideslip => Channel::Beta,
            Aid::Bank => Channel::Phi,
            Aid::Pitch => Channel::Theta,
            Aid::Heading => Channel::Psi,
            Aid::Altitude => Channel::Altitude,
        }
    }
}
