//! The published vocabulary of the modes: Dutch roll, roll and spiral with their standard errors.
//!
//! The numbers of a root are one definition for the stage, the bus (in this order) and JSON (under these names).

use crate::realtime::regression::record::Status;
#[cfg(feature = "bus")]
use iceoryx2::prelude::ZeroCopySend;

/// A complex pair of roots `real +- j imag`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "std", derive(serde::Serialize))]
#[cfg_attr(feature = "bus", derive(ZeroCopySend), type_name("sideslip.Oscillation.1"))]
pub struct OscillatoryMode {
    /// Real part, 1/s (negative: damped).
    pub real: f64,
    /// Imaginary part, rad/s (positive).
    pub imag: f64,
    /// Undamped natural frequency sqrt(real^2 + imag^2), rad/s.
    pub omega: f64,
    /// Damping ratio -real/omega.
    pub zeta: f64,
    /// Standard error of omega, rad/s.
    pub std_omega: f64,
    /// Standard error of zeta.
    pub std_zeta: f64,
}

/// A real root.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "std", derive(serde::Serialize))]
#[cfg_attr(feature = "bus", derive(ZeroCopySend), type_name("sideslip.Root.1"))]
pub struct RealRoot {
    /// The root, 1/s (negative: stable).
    pub value: f64,
    /// Its standard error, 1/s.
    pub std: f64,
}

/// The lateral modes at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModesRecord {
    /// Time of the newest sample that they rest on, s.
    pub time_s: f64,
    /// How far they are.
    pub status: Status,
    /// Dutch roll; `None` where there is no number, or no oscillation among the roots.
    pub dutch_roll: Option<OscillatoryMode>,
    /// Roll subsidence: the largest real root in size.
    pub roll: Option<RealRoot>,
    /// Spiral: the smallest real root in size.
    pub spiral: Option<RealRoot>,
    /// The slower pair where roll and spiral have joined into a second oscillation.
    pub lateral_phugoid: Option<OscillatoryMode>,
    /// Dutch roll of the whole aircraft, coupled to u, w and q; `None` until all six equations have numbers.
    pub coupled: Option<OscillatoryMode>,
}
