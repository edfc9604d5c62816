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

/// Standard error of zeta, and of omega relative to itself, above which a pair is not resolved.
const RESOLVED: f64 = 0.3;
/// Standard errors from which on an unstable mode is one: of some ten thousand readings of stable aircraft in gusts, one was
/// beyond two. A stable one too, where the answer is a verdict.
const UNSTABLE: f64 = 3.0;

/// What the data say of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeStability {
    /// It decays, by three standard errors.
    Stable,
    /// It grows, by three standard errors.
    Unstable,
    /// It may do either.
    Unclear,
}

impl ModeStability {
    /// Of a number that is positive where the mode decays.
    fn of(decay: f64, std: f64) -> Self {
        if !(std > 0.0 && libm::fabs(decay) >= UNSTABLE * std) {
            ModeStability::Unclear
        } else if decay > 0.0 {
            ModeStability::Stable
        } else {
            ModeStability::Unstable
        }
    }
}

impl OscillatoryMode {
    /// Whether it decays: by the damping ratio and its standard error.
    pub fn stability(&self) -> ModeStability {
        ModeStability::of(self.zeta, self.std_zeta)
    }

    /// Whether the standard errors resolve it: of omega to 0.3 of itself, of zeta to 0.3; an unstable one by three of them, for
    /// what may as well be stable is not reported as unstable.
    pub fn is_resolved(&self) -> bool {
        let unclear = self.zeta < 0.0 && -self.zeta < UNSTABLE * self.std_zeta;
        self.std_omega < RESOLVED * self.omega && self.std_zeta < RESOLVED && !unclear
    }
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

impl RealRoot {
    /// Whether it decays: by the root and its standard error.
    pub fn stability(&self) -> ModeStability {
        ModeStability::of(-self.value, self.std)
    }

    /// Whether the standard error resolves it: to its own size, an unstable one to a third of it.
    pub fn is_resolved(&self) -> bool {
        let unclear = if self.value > 0.0 { UNSTABLE * self.std } else { self.std };
        unclear > 0.0 && unclear < self.value.abs()
    }
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

impl ModesRecord {
    /// Without a mode.
    pub const fn empty(time_s: f64, status: Status) -> Self {
        ModesRecord { time_s, status, dutch_roll: None, roll: None, spiral: None, lateral_phugoid: None, coupled: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_is_resolved_by_its_standard_errors_and_an_unstable_one_by_three() {
        let pair = |zeta: f64, std_zeta: f64, std_omega: f64| {
            OscillatoryMode { real: -zeta * 1.4, imag: 1.4, omega: 1.4, zeta, std_omega, std_zeta }.is_resolved()
        };
        assert!(pair(0.15, 0.02, 0.05) && pair(0.05, 0.1, 0.05), "stable, however near");
        assert!(!pair(0.15, 0.31, 0.05) && !pair(0.15, 0.02, 0.5));
        assert!(!pair(-0.05, 0.03, 0.05) && pair(-0.1, 0.03, 0.05));
        let root = |value: f64, std: f64| RealRoot { value, std }.is_resolved();
        assert!(root(-0.5, 0.4) && !root(-0.5, 0.6) && !root(0.5, 0.2) && root(0.5, 0.1));
        assert!(!root(0.0, 0.0), "nothing is known exactly");
    }

    #[test]
    fn a_verdict_takes_three_standard_errors_either_way() {
        let root = |value: f64, std: f64| RealRoot { value, std }.stability();
        assert_eq!((root(-0.5, 0.1), root(0.5, 0.1)), (ModeStability::Stable, ModeStability::Unstable));
        for unclear in [root(-0.5, 0.2), root(0.5, 0.2), root(-0.5, 0.0), root(-0.5, f64::NAN), root(f64::NAN, 0.1)] {
            assert_eq!(unclear, ModeStability::Unclear);
        }
        let pair = OscillatoryMode { zeta: 0.2, std_zeta: 0.05, ..OscillatoryMode::default() };
        assert_eq!(pair.stability(), ModeStability::Stable);
        assert_eq!(OscillatoryMode { zeta: -0.2, ..pair }.stability(), ModeStability::Unstable);
    }
}
