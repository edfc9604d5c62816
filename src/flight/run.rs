//! Properties of a run besides its samples: positions of instruments, names of controls, mass, inertia, reference dimensions.

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

/// Lengths and speeds that nondimensional derivatives are formed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReferenceDimensions {
    /// Of a wing.
    Wing {
        /// Area S, m^2.
        area_m2: f64,
        /// Span b, m.
        span_m: f64,
        /// Mean aerodynamic chord c, m.
        chord_m: f64,
    },
    /// Of a main rotor.
    Rotor {
        /// Radius R, m.
        radius_m: f64,
        /// Tip speed Omega R, m/s.
        tip_speed_mps: f64,
    },
}

/// Moments and product of inertia about body axes through the centre of mass, kg m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// About x.
    pub xx: f64,
    /// About y.
    pub yy: f64,
    /// About z.
    pub zz: f64,
    /// Product: the integral of x z over the mass.
    pub xz: f64,
}

/// Mass, inertia and reference dimensions, where the run says so.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AircraftProperties {
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Moments of inertia.
    pub inertia: Option<Inertia>,
    /// Reference dimensions.
    pub reference: Option<ReferenceDimensions>,
}
