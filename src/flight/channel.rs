//! The channels that Sideslip knows, with their names and the quantity each measures.
//!
//! Everything inside the program is SI and radians; a unit is converted once, where data enters or leaves (`unit`).

use super::unit::Quantity;

/// A measured channel. The discriminant is its place in a [`Sample`](super::sample::Sample).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Channel {
    /// Specific force along body x, m/s^2.
    Ax,
    /// Specific force along body y, m/s^2.
    Ay,
    /// Specific force along body z, m/s^2.
    Az,
    /// Roll rate, rad/s.
    P,
    /// Pitch rate, rad/s.
    Q,
    /// Yaw rate, rad/s.
    R,
    /// Bank angle, rad.
    Phi,
    /// Pitch attitude, rad.
    Theta,
    /// Heading, rad.
    Psi,
    /// True airspeed, m/s.
    Tas,
    /// Incidence vane, rad.
    Alpha,
    /// Sideslip vane, rad.
    Beta,
    /// Pressure altitude, m.
    Altitude,
    /// Longitudinal cyclic (fixed wing: elevator), rad.
    LonCyclic,
    /// Lateral cyclic (fixed wing: aileron), rad.
    LatCyclic,
    /// Collective (fixed wing: throttle), rad.
    Collective,
    /// Pedal as tail-rotor collective pitch (fixed wing: rudder), rad.
    Pedal,
    /// Measured tail-rotor collective pitch, rad.
    TailPitch,
    /// Main-rotor speed, rad/s.
    RotorSpeed,
    /// Engine torque, N m.
    Torque,
    /// Coning, rad.
    Flap0,
    /// Longitudinal flapping, rad.
    Flap1c,
    /// Lateral flapping, rad.
    Flap1s,
    /// Air density, kg/m^3.
    Rho,
}

/// How many channels there are.
pub const CHANNELS: usize = 24;

/// The channels that the kinematics of a rigid body are of, the first of [`Channel::ALL`].
pub const MOTION_CHANNELS: usize = Channel::Altitude.index() + 1;

/// What the four control channels are called: the same four places serve a helicopter and a fixed wing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ControlNames {
    /// `lon_cyclic lat_cyclic collective pedal`.
    #[default]
    Rotorcraft,
    /// `elevator aileron throttle rudder`.
    FixedWing,
}

impl Channel {
    /// Every channel, in the order of its place in a sample.
    pub const ALL: [Channel; CHANNELS] = [
        Channel::Ax,
        Channel::Ay,
        Channel::Az,
        Channel::P,
        Channel::Q,
        Channel::R,
        Channel::Phi,
        Channel::Theta,
        Channel::Psi,
        Channel::Tas,
        Channel::Alpha,
        Channel::Beta,
        Channel::Altitude,
        Channel::LonCyclic,
        Channel::LatCyclic,
        Channel::Collective,
        Channel::Pedal,
        Channel::TailPitch,
        Channel::RotorSpeed,
        Channel::Torque,
        Channel::Flap0,
        Channel::Flap1c,
        Channel::Flap1s,
        Channel::Rho,
    ];

    /// The accelerometers, in the order of the body axes.
    pub const ACCELEROMETERS: [Channel; 3] = [Channel::Ax, Channel::Ay, Channel::Az];
    /// The rate gyros, in the order of the body axes.
    pub const GYROS: [Channel; 3] = [Channel::P, Channel::Q, Channel::R];
    /// The gyros, then the accelerometers.
    pub const INERTIAL: [Channel; 6] = [Channel::P, Channel::Q, Channel::R, Channel::Ax, Channel::Ay, Channel::Az];
    /// The four pilot controls, in the order of the control derivatives.
    pub const CONTROLS: [Channel; 4] = [Channel::LonCyclic, Channel::LatCyclic, Channel::Collective, Channel::Pedal];

    /// Place in a sample.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The name in files and on topics.
    pub const fn name(self, controls: ControlNames) -> &'static str {
        match (self, controls) {
            (Channel::LonCyclic, ControlNames::FixedWing) => "elevator",
            (Channel::LatCyclic, ControlNames::FixedWing) => "aileron",
            (Channel::Collective, ControlNames::FixedWing) => "throttle",
            (Channel::Pedal, ControlNames::FixedWing) => "rudder",
            (Channel::Ax, _) => "ax",
            (Channel::Ay, _) => "ay",
            (Channel::Az, _) => "az",
            (Channel::P, _) => "p",
            (Channel::Q, _) => "q",
            (Channel::R, _) => "r",
            (Channel::Phi, _) => "phi",
            (Channel::Theta, _) => "theta",
            (Channel::Psi, _) => "psi",
            (Channel::Tas, _) => "tas",
            (Channel::Alpha, _) => "alpha",
            (Channel::Beta, _) => "beta",
            (Channel::Altitude, _) => "altitude",
            (Channel::LonCyclic, _) => "lon_cyclic",
            (Channel::LatCyclic, _) => "lat_cyclic",
            (Channel::Collective, _) => "collective",
            (Channel::Pedal, _) => "pedal",
            (Channel::TailPitch, _) => "tail_pitch",
            (Channel::RotorSpeed, _) => "rotor_speed",
            (Channel::Torque, _) => "torque",
            (Channel::Flap0, _) => "flap_0",
            (Channel::Flap1c, _) => "flap_1c",
            (Channel::Flap1s, _) => "flap_1s",
            (Channel::Rho, _) => "rho",
        }
    }

    /// The channel of that name, and which naming of the controls the name belongs to (`None` where both share it).
    pub fn from_name(name: &str) -> Option<(Channel, Option<ControlNames>)> {
        for channel in Channel::ALL {
            let rotorcraft = channel.name(ControlNames::Rotorcraft);
            let fixed_wing = channel.name(ControlNames::FixedWing);
            if rotorcraft == fixed_wing {
                if name == rotorcraft {
                    return Some((channel, None));
                }
            } else if name == rotorcraft {
                return Some((channel, Some(ControlNames::Rotorcraft)));
            } else if name == fixed_wing {
                return Some((channel, Some(ControlNames::FixedWing)));
            }
        }
        None
    }

    /// The quantity that the channel measures; decides which units it may come in.
    pub const fn quantity(self) -> Quantity {
        match self {
            Channel::Ax | Channel::Ay | Channel::Az => Quantity::Acceleration,
            Channel::P | Channel::Q | Channel::R | Channel::RotorSpeed => Quantity::AngularRate,
            Channel::Tas => Quantity::Speed,
            Channel::Altitude => Quantity::Length,
            Channel::Torque => Quantity::Torque,
            Channel::Rho => Quantity::Density,
            Channel::Phi
            | Channel::Theta
            | Channel::Psi
            | Channel::Alpha
            | Channel::Beta
            | Channel::LonCyclic
            | Channel::LatCyclic
            | Channel::Collective
            | Channel::Pedal
            | Channel::TailPitch
            | Channel::Flap0
            | Channel::Flap1c
            | Channel::Flap1s => Quantity::Angle,
        }
    }

    /// The SI unit as written in files.
    pub const fn si_unit(self) -> &'static str {
        self.quantity().si_unit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_is_at_its_own_place_and_found_by_each_of_its_names() {
        for (place, channel) in Channel::ALL.into_iter().enumerate() {
            assert_eq!(channel.index(), place);
            for naming in [ControlNames::Rotorcraft, ControlNames::FixedWing] {
                let (found, _) = Channel::from_name(channel.name(naming)).unwrap();
                assert_eq!(found, channel);
            }
        }
        assert_eq!(Channel::from_name("Pedal"), None);
        assert_eq!(Channel::from_name("rudder"), Some((Channel::Pedal, Some(ControlNames::FixedWing))));
    }
}
