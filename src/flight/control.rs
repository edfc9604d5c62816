//! The four pilot controls by place, independent of their names on an aircraft.

use super::channel::{Channel, ControlNames};
use super::derivative::Variable;

/// A pilot control; effects of the control path name one of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Control {
    /// Longitudinal cyclic or elevator, rad.
    LonCyclic,
    /// Lateral cyclic or aileron, rad.
    LatCyclic,
    /// Collective or throttle, rad.
    Collective,
    /// Pedal or rudder, rad.
    Pedal,
}

/// How many controls there are.
pub const CONTROLS: usize = 4;

impl Control {
    /// Every control, in the order of its place.
    pub const ALL: [Control; CONTROLS] = [Control::LonCyclic, Control::LatCyclic, Control::Collective, Control::Pedal];

    /// Place among the controls (that of [`Channel::CONTROLS`] and [`Variable::CONTROLS`]).
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The channel that measures it.
    pub const fn channel(self) -> Channel {
        match self {
            Control::LonCyclic => Channel::LonCyclic,
            Control::LatCyclic => Channel::LatCyclic,
            Control::Collective => Channel::Collective,
            Control::Pedal => Channel::Pedal,
        }
    }

    /// The variable of its derivatives.
    pub const fn variable(self) -> Variable {
        match self {
            Control::LonCyclic => Variable::LonCyclic,
            Control::LatCyclic => Variable::LatCyclic,
            Control::Collective => Variable::Collective,
            Control::Pedal => Variable::Pedal,
        }
    }

    /// The name, after the aircraft's own naming.
    pub const fn name(self, naming: ControlNames) -> &'static str {
        self.channel().name(naming)
    }

    /// The control of that name, in either naming.
    pub fn from_name(name: &str) -> Option<Control> {
        Control::ALL.into_iter().find(|c| c.name(ControlNames::Rotorcraft) == name || c.name(ControlNames::FixedWing) == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_agree_with_channels_and_variables() {
        for (place, control) in Control::ALL.into_iter().enumerate() {
            assert_eq!(control.index(), place);
            assert_eq!(control.channel(), Channel::CONTROLS[place]);
            assert_eq!(control.variable(), Variable::CONTROLS[place]);
            assert_eq!(Control::from_name(control.name(ControlNames::FixedWing)), Some(control));
        }
        assert_eq!(Control::from_name("tail_pitch"), None);
    }
}
