//! Flapping of the main rotor: coning and tilt of the disc, quasi-steady or as states.
//!
//! Consumes the quantities that drive the flap, in hub-wind axes (x into the wind in the plane of the hub, azimuth in the
//! direction of rotation, anticlockwise; `hub` mirrors the other); produces beta = beta0 + beta1c cos(psi) + beta1s sin(psi),
//! rad. With the Lock number gamma, lambda_beta^2 = 1 + K_beta/(I_beta Omega^2), e = 8 (lambda_beta^2 - 1)/gamma, forcing minus
//! restoring moment is, row by row,
//!     R0 = (1 + mu^2) theta0 + (4/5 + 2/3 mu^2) theta_tw + 4/3 mu theta1s + 4/3 (mu_z - lambda0) + 2/3 mu p
//!          - 8 lambda_beta^2/gamma beta0                                                                       (1)
//!     R1 = (1 + mu^2/2) theta1c + 16/gamma p + q - lambda1c - 4/3 mu beta0 - e beta1c - (1 + mu^2/2) beta1s    (2)
//!     R2 = 8/3 mu theta0 + 2 mu theta_tw + (1 + 3/2 mu^2) theta1s + 2 mu (mu_z - lambda0) + p - 16/gamma q
//!          + (1 - mu^2/2) beta1c - e beta1s                                                                    (3)
//! Quasi-steady: R0 = R1 = R2 = 0. As states, ' = d/dpsi, p q over Omega:
//!     beta0'' + gamma/8 beta0' + gamma/12 mu beta1s' = gamma/8 R0                                              (4)
//!     beta1c'' + gamma/8 beta1c' + 2 beta1s' = gamma/8 R1 + q'                                                 (5)
//!     beta1s'' + gamma/8 beta1s' - 2 beta1c' + gamma/6 mu beta0' = gamma/8 R2 + p'                             (6)
//! and to first order without the second derivatives, the products of mu with flap rates, and p', q'.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch. 3; `first_principles_tests` integrates the blade
//! numerically.

/// What drives the flap, wind axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlapDrive {
    /// Advance ratio in the hub's plane.
    pub(crate) mu: f64,
    /// Collective, and the twist from root to tip, rad.
    pub(crate) theta0: f64,
    pub(crate) twist: f64,
    /// Cyclic pitch, rad.
    pub(crate) theta1s: f64,
    pub(crate) theta1c: f64,
    /// Flow up through the disc, mu_z - lambda0.
    pub(crate) through: f64,
    /// Cosine harmonic of the inflow.
    pub(crate) lambda1c: f64,
    /// Hub rates over Omega.
    pub(crate) p: f64,
    pub(crate) q: f64,
    /// Lock number and lambda_beta^2.
    pub(crate) lock: f64,
    pub(crate) lambda_beta2: f64,
}

/// Coning, longitudinal tilt (forward positive) and lateral tilt (up at psi = 90 degrees positive), rad, or their rates.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Flap {
    /// beta0.
    pub coning: f64,
    /// beta1c.
    pub cosine: f64,
    /// beta1s.
    pub sine: f64,
}

impl Flap {
    /// From hub axes to wind axes, the wind at azimuth psi_w with this cosine and sine.
    #[must_use]
    pub(crate) fn to_wind(self, (cos_w, sin_w): (f64, f64)) -> Self {
        let Flap { coning, cosine, sine } = self;
        Flap { coning, cosine: cosine * cos_w - sine * sin_w, sine: sine * cos_w + cosine * sin_w }
    }

    /// From wind axes to hub axes.
    #[must_use]
    pub(crate) fn to_hub(self, (cos_w, sin_w): (f64, f64)) -> Self {
        self.to_wind((cos_w, -sin_w))
    }

    #[must_use]
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Flap { coning: factor * self.coning, cosine: factor * self.cosine, sine: factor * self.sine }
    }
}

impl FlapDrive {
    /// e and 1/gamma.
    #[inline]
    fn spring(&self) -> (f64, f64) {
        let per_lock = 1.0 / self.lock;
        (8.0 * (self.lambda_beta2 - 1.0) * per_lock, per_lock)
    }

    /// (1) to (3).
    #[inline]
    pub(crate) fn rows(&self, flap: Flap) -> [f64; 3] {
        let FlapDrive { mu, theta0, twist, theta1s, theta1c, through, lambda1c, p, q, lambda_beta2, .. } = *self;
        let (mu2, (e, per_lock)) = (mu * mu, self.spring());
        [
            (1.0 + mu2) * theta0
                + (0.8 + 2.0 / 3.0 * mu2) * twist
                + 4.0 / 3.0 * mu * theta1s
                + 4.0 / 3.0 * through
                + 2.0 / 3.0 * mu * p
                - 8.0 * lambda_beta2 * per_lock * flap.coning,
            (1.0 + 0.5 * mu2) * theta1c + 16.0 * per_lock * p + q
                - lambda1c
                - 4.0 / 3.0 * mu * flap.coning
                - e * flap.cosine
                - (1.0 + 0.5 * mu2) * flap.sine,
            8.0 / 3.0 * mu * theta0 + 2.0 * mu * twist + (1.0 + 1.5 * mu2) * theta1s + 2.0 * mu * through + p
                - 16.0 * per_lock * q
                + (1.0 - 0.5 * mu2) * flap.cosine
                - e * flap.sine,
        ]
    }

    /// The flap at which (1) to (3) vanish.
    #[inline]
    pub(crate) fn quasi_steady(&self) -> Flap {
        let [row0, ..] = self.rows(Flap::default());
        let coning = row0 * self.lock / (8.0 * self.lambda_beta2);
        let [_, row1, row2] = self.rows(Flap { coning, ..Flap::default() });
        // [e, 1 + mu^2/2; -(1 - mu^2/2), e] (beta1c, beta1s) = (row1, row2).
        let ((e, _), half) = (self.spring(), 0.5 * self.mu * self.mu);
        let per_determinant = 1.0 / (e * e + (1.0 + half) * (1.0 - half));
        let cosine = (e * row1 - (1.0 + half) * row2) * per_determinant;
        let sine = ((1.0 - half) * row1 + e * row2) * per_determinant;
        Flap { coning, cosine, sine }
    }

    /// Flap rates a radian of azimuth, to first order.
    pub(crate) fn first_order_rates(&self, flap: Flap) -> Flap {
        let [row0, row1, row2] = self.rows(flap);
        let damping = self.lock / 8.0;
        // [gamma/8, 2; -2, gamma/8] (beta1c', beta1s') = gamma/8 (row1, row2).
        let scale = damping / (damping * damping + 4.0);
        Flap { coning: row0, cosine: scale * (damping * row1 - 2.0 * row2), sine: scale * (2.0 * row1 + damping * row2) }
    }

    /// (4) to (6): flap accelerations a radian of azimuth squared, with p' and q' of the hub over Omega squared.
    pub(crate) fn accelerations(&self, flap: Flap, rates: Flap, p_rate: f64, q_rate: f64) -> Flap {
        let [row0, row1, row2] = self.rows(flap);
        let damping = self.lock / 8.0;
        Flap {
            coning: damping * (row0 - rates.coning - 2.0 / 3.0 * self.mu * rates.sine),
            cosine: damping * (row1 - rates.cosine) - 2.0 * rates.sine + q_rate,
            sine: damping * (row2 - rates.sine - 4.0 / 3.0 * self.mu * rates.coning) + 2.0 * rates.cosine + p_rate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> FlapDrive {
        FlapDrive {
            mu: 0.25,
            theta0: 0.25,
            twist: -0.14,
            theta1s: -0.03,
            theta1c: 0.04,
            through: -0.06,
            lambda1c: 0.012,
            p: 0.01,
            q: -0.02,
            lock: 9.4,
            lambda_beta2: 1.05,
        }
    }

    #[test]
    fn the_quasi_steady_flap_is_where_nothing_drives_it() {
        let flap = drive().quasi_steady();
        assert!(drive().rows(flap).iter().all(|row| row.abs() < 1e-15), "{:?}", drive().rows(flap));
        assert!(drive().first_order_rates(flap).sine.abs() < 1e-15);
        assert!(drive().accelerations(flap, Flap::default(), 0.0, 0.0).cosine.abs() < 1e-15);
    }

    #[test]
    fn hub_and_wind_axes_are_a_rotation_apart() {
        // beta at an azimuth is the same in both: psi_wind = psi + psi_w.
        let flap = Flap { coning: 0.1, cosine: 0.03, sine: -0.02 };
        let (psi, psi_w) = (1.3f64, 0.4f64);
        let wind = flap.to_wind((psi_w.cos(), psi_w.sin()));
        let at = |flap: Flap, psi: f64| flap.coning + flap.cosine * psi.cos() + flap.sine * psi.sin();
        assert!((at(flap, psi) - at(wind, psi + psi_w)).abs() < 1e-15);
        assert!((wind.to_hub((psi_w.cos(), psi_w.sin())).sine - flap.sine).abs() < 1e-16);
    }
}
