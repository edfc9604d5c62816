//! Effective yaw damping of the Dutch roll, the N_p that explains it, and the same from its root.
//!
//! Consumes derivatives (v in m/s; L and N over inertia, in rad/s^2 per unit) and airspeed V; produces, with the roll equation
//! solved for p where the motion is slow beside L_p, 1/(s - L_p) = -1/L_p - s/L_p^2 and v' = -V r,
//!     N_r_eff = N_r - N_p (L_r/L_p - V L_v/L_p^2)      zeta = -N_r_eff/(2 omega)                       (25)
//!     N_r_eff = N_r + N_p V L_v/L_p^2                                                                  (26)
//!     N_p = (N_r_eff - N_r) L_p^2/(V L_v)                                                              (27)
//! numbered as in the source, which prints (25) with + N_p and without the minus of zeta; the signs here are those that follow
//! from the elimination, and (26) is as printed. (27) takes N_r_eff from a fit without N_p and L_r, and N_r from the simulation.
//! At s = j omega, without neglecting Y_v, gravity and omega^2 beside L_p^2:
//!     2 Re(lambda) = N_r + Y_v + ((N_p V - g) L_v - g L_v L_p N_r/omega^2 - N_p L_r L_p)/(L_p^2 + omega^2)    (28)
//!     N_p = ((2 Re(lambda) - N_r - Y_v)(L_p^2 + omega^2) + g L_v + g L_v L_p N_r/omega^2)/(V L_v - L_r L_p)   (29)
//! Source: Padfield et al. 1987, section 4; (28) by the same elimination, and (29) by solving it for N_p.
//! Without dihedral, L_v = 0, N_p is not identifiable: (27) and (29) are then infinite or NaN.

use crate::flight::unit::STANDARD_GRAVITY as G0;

/// Derivatives that damp the Dutch roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveDamping {
    /// 1/s.
    pub y_v: f64,
    /// rad/(s m).
    pub l_v: f64,
    /// 1/s.
    pub l_p: f64,
    /// 1/s.
    pub l_r: f64,
    /// 1/s.
    pub n_p: f64,
    /// 1/s.
    pub n_r: f64,
    /// V, m/s.
    pub speed: f64,
}

impl EffectiveDamping {
    /// (25), 1/s.
    pub fn effective(&self) -> f64 {
        self.n_r - self.n_p * (self.l_r / self.l_p - self.speed * self.l_v / (self.l_p * self.l_p))
    }

    /// (26), 1/s.
    pub fn effective_by_dihedral(&self) -> f64 {
        self.n_r + self.n_p * self.speed * self.l_v / (self.l_p * self.l_p)
    }

    /// (27), 1/s: the N_p that gives this effective damping (1/s); `n_p` is not used.
    pub fn n_p_of(&self, effective: f64) -> f64 {
        (effective - self.n_r) * self.l_p * self.l_p / (self.speed * self.l_v)
    }

    /// (29), 1/s: the N_p from the real part (1/s) and frequency (rad/s) of a Dutch roll.
    pub fn n_p_of_root(&self, real: f64, omega: f64) -> f64 {
        let EffectiveDamping { y_v, l_v, l_p, l_r, n_r, speed, .. } = *self;
        let square = omega * omega;
        let left = (2.0 * real - n_r - y_v) * (l_p * l_p + square);
        (left + G0 * l_v + G0 * l_v * l_p * n_r / square) / (speed * l_v - l_r * l_p)
    }
}

/// A function of several quantities and its standard error by the delta method, with central differences of a thousandth of
/// theirs.
///
/// `cov` is by row and column of `at`.
pub fn with_std<const N: usize>(at: [f64; N], cov: impl Fn(usize, usize) -> f64, value: impl Fn([f64; N]) -> f64) -> (f64, f64) {
    let mut slopes = [0.0; N];
    for (place, slope) in slopes.iter_mut().enumerate() {
        let step = 1e-3 * libm::sqrt(cov(place, place).max(0.0));
        if step > 0.0 {
            let perturbed = |by: f64| {
                let mut at = at;
                if let Some(one) = at.get_mut(place) {
                    *one += by;
                }
                value(at)
            };
            *slope = (perturbed(step) - perturbed(-step)) / (2.0 * step);
        }
    }
    let mut var = 0.0;
    for (i, si) in slopes.iter().enumerate() {
        for (j, sj) in slopes.iter().enumerate() {
            var += si * sj * cov(i, j);
        }
    }
    (value(at), libm::sqrt(var.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn climb() -> EffectiveDamping {
        EffectiveDamping { y_v: -0.141, l_v: -0.110_972, l_p: -1.38, l_r: 0.12, n_p: -0.295, n_r: -0.5, speed: 51.44 }
    }

    /// (28): twice the real part of the Dutch roll at that frequency, 1/s.
    fn twice_the_real_part(damping: &EffectiveDamping, omega: f64) -> f64 {
        let EffectiveDamping { y_v, l_v, l_p, l_r, n_p, n_r, speed } = *damping;
        let square = omega * omega;
        n_r + y_v + ((n_p * speed - G0) * l_v - G0 * l_v * l_p * n_r / square - n_p * l_r * l_p) / (l_p * l_p + square)
    }

    #[test]
    fn adverse_yaw_with_dihedral_takes_damping_away() {
        // N_r_eff = -0.5 + 0.295*51.44*0.110972/1.9044 by hand.
        assert!((climb().effective_by_dihedral() - 0.384_26).abs() < 1e-4);
        assert!((climb().effective() - (0.384_26 - 0.295 * 0.12 / 1.38)).abs() < 1e-4);
        // The root is 0.052: twice that is 0.104; at omega the approximation is near.
        assert!((twice_the_real_part(&climb(), 1.451) - 0.127).abs() < 2e-3);
    }

    #[test]
    fn the_derived_n_p_is_the_one_that_was_put_in() {
        let all = climb();
        assert!((all.n_p_of(all.effective_by_dihedral()) - all.n_p).abs() < 1e-12);
        assert!((all.n_p_of_root(0.5 * twice_the_real_part(&all, 1.4), 1.4) - all.n_p).abs() < 1e-12);
    }

    #[test]
    fn errors_go_through_as_they_do_by_hand() {
        let cov = [[0.04, 0.01], [0.01, 0.09]];
        let (value, std) = with_std([2.0, 3.0], |i, j| cov[i][j], |[a, b]| a * b);
        // (b s_a)^2 + (a s_b)^2 + 2 a b cov.
        assert!((value - 6.0).abs() < 1e-12 && (std - f64::sqrt(9.0 * 0.04 + 4.0 * 0.09 + 12.0 * 0.01)).abs() < 1e-9);
    }
}
