//! The tailplane: normal force and pitching moment.
//!
//! Consumes velocity through the air, pitch rate, induced velocity of the main rotor, density; produces its force along body z,
//! which acts at arm x behind the centre of mass:
//!     w_tp = w + q x - k_lambda v_i     alpha = alpha_0 + atan2(w_tp, u)                               (1)
//!     C_Z = gain (alpha + c3 alpha^3)     Z = rho (u^2 + w_tp^2) S C_Z/2     M = x Z                   (2)
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, appendix 4B. Beyond its maximum the polynomial
//! would fall; there the coefficient is held at the maximum.

use super::hub::angle;

/// Data of the tailplane, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tailplane {
    /// Area, m^2.
    pub area: f64,
    /// Distance aft of the main hub's foot point, m.
    pub aft: f64,
    /// alpha_0, rad.
    pub incidence: f64,
    /// Factor of the polynomial.
    pub gain: f64,
    /// c3.
    pub cubic: f64,
    /// Angle beyond which the coefficient is held, rad.
    pub hold: f64,
    /// k_lambda: part of the main rotor's induced velocity that it feels.
    pub downwash: f64,
}

impl Tailplane {
    /// (1), (2): force along body z, N, its arm behind the centre of mass given.
    #[inline]
    pub(crate) fn normal_force(&self, [u, _, w]: [f64; 3], pitch_rate: f64, (density, induced): (f64, f64), arm: f64) -> f64 {
        let w_tp = w + pitch_rate * arm - self.downwash * induced;
        let alpha = (self.incidence + angle(w_tp, u)).clamp(-self.hold, self.hold);
        let coefficient = self.gain * alpha * (1.0 + self.cubic * alpha * alpha);
        0.5 * density * (u * u + w_tp * w_tp) * self.area * coefficient
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_is_that_computed_by_hand() {
        let plane = Tailplane { area: 1.34, aft: 9.0, incidence: -0.03, gain: -3.7, cubic: -3.92, hold: 0.29, downwash: 0.5 };
        // w + q x - v_i/2 = 2 + 0.9 - 2.5 = 0.4 at u = 40: alpha = -0.03 + 0.0099997 = -0.0200003, C = 0.0738851.
        let found = plane.normal_force([40.0, 5.0, 2.0], 0.1, (1.2, 5.0), 9.0);
        assert!((found - 0.5 * 1.2 * 1600.16 * 1.34 * 0.073_885).abs() < 0.01, "{found}");
    }
}
