//! Properties of a run besides its samples: positions of instruments and names of controls.

use super::channel::ControlNames;

/// Geometry of a run's instruments, body axes, relative to the centre of mass, and the naming of its controls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunGeometry {
    /// Where the accelerometers stand, m.
    pub accelerometer_position_m: [f64; 3],
    /// Where the flow-angle vanes stand, m.
    pub vane_position_m: [f64; 3],
    /// Blades of the main rotor, where the run says so.
    pub blades: Option<u32>,
    /// How the four controls are called.
    pub controls: ControlNames,
}

impl RunGeometry {
    /// Every instrument at the centre of mass of a rotorcraft.
    pub const DEFAULT: RunGeometry = RunGeometry {
        accelerometer_position_m: [0.0; 3],
        vane_position_m: [0.0; 3],
        blades: None,
        controls: ControlNames::Rotorcraft,
    };
}

impl Default for RunGeometry {
    fn default() -> Self {
        RunGeometry::DEFAULT
    }
}
