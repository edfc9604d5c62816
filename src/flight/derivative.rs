//! Names of stability and control derivatives: `AXIS_variable`, such as `N_v` or `L_lat_cyclic`.
//!
//! Force derivatives are divided by mass (X Y Z: m/s^2 per unit of the variable); moment derivatives carry the product-of-inertia
//! terms (L M N: rad/s^2 per unit), so that `dr/dt = N_v v + N_p p + N_r r + ...`: Padfield et al. 1987, (23), (24).

use super::channel::{Channel, ControlNames};

/// An axis of force or moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Axis {
    /// Specific force along body x, m/s^2.
    X,
    /// Specific force along body y, m/s^2.
    Y,
    /// Specific force along body z, m/s^2.
    Z,
    /// Roll acceleration, rad/s^2.
    L,
    /// Pitch acceleration, rad/s^2.
    M,
    /// Yaw acceleration, rad/s^2.
    N,
}

/// How many axes there are.
pub const AXES: usize = 6;

impl Axis {
    /// Every axis, in the order of its place in a record.
    pub const ALL: [Axis; AXES] = [Axis::X, Axis::Y, Axis::Z, Axis::L, Axis::M, Axis::N];

    /// Place in a record.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The letter in names.
    pub const fn name(self) -> &'static str {
        match self {
            Axis::X => "X",
            Axis::Y => "Y",
            Axis::Z => "Z",
            Axis::L => "L",
            Axis::M => "M",
            Axis::N => "N",
        }
    }

    /// The axis of that letter.
    pub fn from_name(name: &str) -> Option<Axis> {
        Axis::ALL.into_iter().find(|axis| axis.name() == name)
    }

    /// Whether the axis is a force (divided by mass) rather than a moment.
    pub const fn is_force(self) -> bool {
        matches!(self, Axis::X | Axis::Y | Axis::Z)
    }

    /// Whether its equation is of the lateral motion (v p r) rather than of the longitudinal (u w q).
    pub const fn is_lateral(self) -> bool {
        matches!(self, Axis::Y | Axis::L | Axis::N)
    }
}

/// What a linear derivative is taken with respect to: six body velocities and rates, four controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Variable {
    /// Velocity along body x through the air, m/s.
    U,
    /// Velocity along body y through the air, m/s.
    V,
    /// Velocity along body z through the air, m/s.
    W,
    /// Roll rate, rad/s.
    P,
    /// Pitch rate, rad/s.
    Q,
    /// Yaw rate, rad/s.
    R,
    /// Longitudinal cyclic or elevator, rad.
    LonCyclic,
    /// Lateral cyclic or aileron, rad.
    LatCyclic,
    /// Collective or throttle, rad.
    Collective,
    /// Pedal or rudder, rad.
    Pedal,
}

/// How many linear variables there are.
pub const VARIABLES: usize = 10;

impl Variable {
    /// Every variable, in the order of its place in a record.
    pub const ALL: [Variable; VARIABLES] = [
        Variable::U,
        Variable::V,
        Variable::W,
        Variable::P,
        Variable::Q,
        Variable::R,
        Variable::LonCyclic,
        Variable::LatCyclic,
        Variable::Collective,
        Variable::Pedal,
    ];

    /// The four controls.
    pub const CONTROLS: [Variable; 4] = [Variable::LonCyclic, Variable::LatCyclic, Variable::Collective, Variable::Pedal];

    /// Place in a record.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Whether it is a pilot control.
    pub const fn is_control(self) -> bool {
        self.index() >= Variable::LonCyclic.index()
    }

    /// Whether it is of the lateral motion (v p r, lateral cyclic and pedal) rather than of the longitudinal.
    pub const fn is_lateral(self) -> bool {
        matches!(self, Variable::V | Variable::P | Variable::R | Variable::LatCyclic | Variable::Pedal)
    }

    /// The control channel that carries it; `None` for a body velocity or rate.
    pub const fn control_channel(self) -> Option<Channel> {
        match self {
            Variable::LonCyclic => Some(Channel::LonCyclic),
            Variable::LatCyclic => Some(Channel::LatCyclic),
            Variable::Collective => Some(Channel::Collective),
            Variable::Pedal => Some(Channel::Pedal),
            _ => None,
        }
    }

    /// The name in derivatives; controls after the aircraft's own naming.
    pub const fn name(self, controls: ControlNames) -> &'static str {
        match self {
            Variable::U => "u",
            Variable::V => "v",
            Variable::W => "w",
            Variable::P => "p",
            Variable::Q => "q",
            Variable::R => "r",
            Variable::LonCyclic => Channel::LonCyclic.name(controls),
            Variable::LatCyclic => Channel::LatCyclic.name(controls),
            Variable::Collective => Channel::Collective.name(controls),
            Variable::Pedal => Channel::Pedal.name(controls),
        }
    }

    /// The variable of that name, in either naming of the controls.
    pub fn from_name(name: &str) -> Option<Variable> {
        Variable::ALL
            .into_iter()
            .find(|variable| variable.name(ControlNames::Rotorcraft) == name || variable.name(ControlNames::FixedWing) == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_and_variables_are_at_their_own_places_and_found_by_name() {
        for (place, axis) in Axis::ALL.into_iter().enumerate() {
            assert_eq!((axis.index(), Axis::from_name(axis.name())), (place, Some(axis)));
        }
        for (place, variable) in Variable::ALL.into_iter().enumerate() {
            assert_eq!(variable.index(), place);
            assert_eq!(variable.is_control(), variable.control_channel().is_some());
            for naming in [ControlNames::Rotorcraft, ControlNames::FixedWing] {
                assert_eq!(Variable::from_name(variable.name(naming)), Some(variable));
            }
        }
        assert_eq!(Variable::from_name("phi"), None);
    }
}
