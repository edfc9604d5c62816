//! The fin: a thick section with little lift at small sideslip.
//!
//! Consumes velocity through the air, angular rates, density; produces the side force, which acts x behind and h above the centre
//! of mass, and its moments (N, N m, body axes):
//!     v_fn = v - r x + p h     V^2 = u^2 + v_fn^2     beta = beta_0 + asin(v_fn/V) = beta_0 + atan2(v_fn, |u|)     (1)
//!     C_Y = gain (c3 beta^3 + c5 beta^5)     Y = rho V^2 S C_Y/2     L = h Y     N = -x Y              (2)
//! Beyond its maximum the polynomial would fall; there the coefficient is held at the maximum.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, appendix 4B.

use super::hub::angle;

/// Data of the fin, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fin {
    /// Area, m^2.
    pub area: f64,
    /// Distance aft of the main hub's foot point, m.
    pub aft: f64,
    /// Height above the centre of mass, m.
    pub height: f64,
    /// beta_0, rad.
    pub incidence: f64,
    /// Factor of the polynomial.
    pub gain: f64,
    /// c3.
    pub cubic: f64,
    /// c5.
    pub quintic: f64,
    /// Angle beyond which the coefficient is held, rad.
    pub hold: f64,
}

impl Fin {
    /// (1), (2): side force, N, its arm behind the centre of mass given.
    #[inline]
    pub(crate) fn side_force(&self, [u, v, _]: [f64; 3], [p, _, r]: [f64; 3], density: f64, arm: f64) -> f64 {
        let v_fn = v - r * arm + p * self.height;
        let speed2 = u * u + v_fn * v_fn;
        let beta = self.incidence + angle(v_fn, libm::fabs(u));
        0.5 * density * speed2 * self.area * self.coefficient(beta)
    }

    fn coefficient(&self, beta: f64) -> f64 {
        let beta = beta.clamp(-self.hold, self.hold);
        let square = beta * beta;
        self.gain * beta * square * (self.cubic + self.quintic * square)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_at_one_degree_is_a_thirtieth_of_that_at_six() {
        let fin =
            Fin { area: 1.4, aft: 9.0, height: 1.0, incidence: 0.0, gain: -3.5, cubic: 11.143, quintic: -85.714, hold: 0.279 };
        // gain (3 c3 b^2 + 5 c5 b^4) at b = 0.0175 and 0.105, by hand: -0.0357 and -1.1076.
        let slope = |b: f64| (fin.coefficient(b + 1e-6) - fin.coefficient(b - 1e-6)) / 2e-6;
        assert!((slope(0.0175) + 0.0357).abs() < 2e-4 && (slope(0.105) + 1.1076).abs() < 1e-4);
        assert!((fin.coefficient(0.5) - fin.coefficient(0.279)).abs() < 1e-15);
        assert!(fin.side_force([0.0; 3], [0.0; 3], 1.2, 9.0) == 0.0);
    }
}
