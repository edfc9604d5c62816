//! The rotor hub: its velocity in hub-wind axes, and its forces and moments transferred to the centre of mass.
//!
//! Consumes velocity through the air and angular rates, body axes; produces, in the axes of an anticlockwise rotor (sigma = 1; a
//! clockwise one is mirrored by sigma = -1), with the hub h above and x_cg behind the centre of mass and the shaft tilted forward
//! by gamma_s,
//!     u_b = u - q h     v_b = v + p h [- r x_cg]     w_b = w + q x_cg                                 (1)
//!     u_h = u_b cos(gamma_s) + w_b sin(gamma_s)    w_h = w_b cos(gamma_s) - u_b sin(gamma_s)    v_h = sigma v_b
//!     p_h = sigma (p [cos(gamma_s) + r sin(gamma_s)])     q_h = q                             (2)
//!     mu = sqrt(u_h^2 + v_h^2)/(Omega R)     mu_z = w_h/(Omega R)     cos(psi_w) = u_h/(mu Omega R)   (3)
//! Two geometries. [`Hub::Exact`] includes the terms in brackets and the full rotation of forces and moments,
//!     X = X_h cos - Z_h sin     Y = Y_h     Z = Z_h cos + X_h sin
//!     L = L_h cos - N_h sin + h Y     M = M_h - h X + x_cg Z     N = L_h sin + N_h cos - x_cg Y       (4)
//! [`Hub::Published`] is the geometry of the published matrices: without the terms in brackets (no effect of yaw rate on the
//! rotor), and
//!     X = X_h - Z_h sin     Y = Y_h     Z = Z_h     L = L_s - N_h sin     M = M_h - h X + x_cg Z
//!     N = N_h + L_s sin     L_s = L_h + h Y                                                           (5)
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch. 3; (5) is inferred from the matrices of its appendix
//! 4B, which it reproduces to four digits. It is not consistent: the yawing moment of Y_h is that of a tilted arm.

/// Which geometry brings the hub's motion and forces to and from the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hub {
    /// That of the published matrices.
    Published,
    /// That of rigid bodies.
    Exact,
}

/// Tangents below which [`angle`] sums the arctangent's series; its tenth term is 3e-19 of the first there.
const SMALL: f64 = 0.125;

/// atan2, to rounding: t - t^3/3 + t^5/5 - .. where t = y/x is small and x leads, as in most of a flight.
#[inline]
pub(crate) fn angle(y: f64, x: f64) -> f64 {
    let t = y / x;
    if x > 0.0 && libm::fabs(t) < SMALL {
        let t2 = t * t;
        let t4 = t2 * t2;
        let less = t2 * (1.0 / 3.0 + t4 * (1.0 / 7.0 + t4 * (1.0 / 11.0 + t4 * (1.0 / 15.0 + t4 * (1.0 / 19.0)))));
        let more = t4 * (1.0 / 5.0 + t4 * (1.0 / 9.0 + t4 * (1.0 / 13.0 + t4 * (1.0 / 17.0))));
        t - t * (less - more)
    } else {
        libm::atan2(y, x)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HubPosition {
    pub(crate) geometry: Hub,
    /// 1 anticlockwise, -1 clockwise, seen from above.
    pub(crate) sigma: f64,
    pub(crate) height: f64,
    pub(crate) cg_forward: f64,
    /// Cosine and sine of the shaft's forward tilt.
    pub(crate) tilt: (f64, f64),
}

/// The hub's motion, mirrored; velocities m/s, rates rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HubMotion {
    /// Speed in the hub's plane.
    pub(crate) in_plane: f64,
    /// Speed down the shaft.
    pub(crate) axial: f64,
    /// Cosine and sine of the wind's azimuth; along x where there is no wind.
    pub(crate) wind: (f64, f64),
    pub(crate) p: f64,
    pub(crate) q: f64,
}

/// Forces and moments of the rotor at the hub, hub axes, mirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HubLoads {
    pub(crate) force: [f64; 3],
    pub(crate) moment: [f64; 3],
}

impl HubPosition {
    /// (1) to (3).
    #[inline]
    pub(crate) fn motion(&self, [u, v, w]: [f64; 3], [p, q, r]: [f64; 3]) -> HubMotion {
        let (cos, sin) = self.tilt;
        let yaw_arm = if self.geometry == Hub::Exact { r * self.cg_forward } else { 0.0 };
        let (u_b, v_b, w_b) = (u - q * self.height, v + p * self.height - yaw_arm, w + q * self.cg_forward);
        let (u_h, v_h, w_h) = (u_b * cos + w_b * sin, self.sigma * v_b, w_b * cos - u_b * sin);
        let in_plane = libm::sqrt(u_h * u_h + v_h * v_h);
        let per_speed = 1.0 / in_plane;
        let wind = if in_plane > 0.0 { (u_h * per_speed, v_h * per_speed) } else { (1.0, 0.0) };
        HubMotion { in_plane, axial: w_h, wind, p: self.roll([p, r]), q }
    }

    /// (2) of the roll and yaw rate, or of their rates of change.
    pub(crate) fn roll(&self, [p, r]: [f64; 2]) -> f64 {
        let (cos, sin) = self.tilt;
        match self.geometry {
            Hub::Published => self.sigma * p,
            Hub::Exact => self.sigma * (p * cos + r * sin),
        }
    }

    /// (4) or (5): force and moment about the centre of mass, body axes.
    #[inline]
    pub(crate) fn at_centre_of_mass(&self, loads: HubLoads) -> ([f64; 3], [f64; 3]) {
        let (cos, sin) = self.tilt;
        let [x_h, y_h, z_h] = loads.force;
        let [l_h, m_h, n_h] = loads.moment;
        let (y, l_h, n_h) = (self.sigma * y_h, self.sigma * l_h, self.sigma * n_h);
        match self.geometry {
            Hub::Published => {
                let (x, l_s) = (x_h - z_h * sin, l_h + self.height * y);
                let moment = [l_s - n_h * sin, m_h - self.height * x + self.cg_forward * z_h, n_h + sin * l_s];
                ([x, y, z_h], moment)
            }
            Hub::Exact => {
                let (x, z) = (x_h * cos - z_h * sin, z_h * cos + x_h * sin);
                let moment = [
                    l_h * cos - n_h * sin + self.height * y,
                    m_h - self.height * x + self.cg_forward * z,
                    l_h * sin + n_h * cos - self.cg_forward * y,
                ];
                ([x, y, z], moment)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }

    fn place(geometry: Hub, sigma: f64) -> HubPosition {
        HubPosition { geometry, sigma, height: 2.1, cg_forward: 0.4, tilt: (0.1f64.cos(), 0.1f64.sin()) }
    }

    #[test]
    fn an_angle_is_that_of_the_library_to_rounding() {
        for place in -4000..=4000 {
            let y = f64::from(place) * 1e-3;
            for x in [9.0f64, 1.0, 1e-3, 0.0, -1.0, -9.0] {
                let (found, known) = (angle(y, x), f64::atan2(y, x));
                assert!((found - known).abs() <= 2.0 * f64::EPSILON * known.abs(), "{y}, {x}: {found} is not {known}");
            }
        }
        assert!(angle(f64::NAN, 1.0).is_nan() && angle(1.0, f64::NAN).is_nan());
    }

    #[test]
    fn the_exact_geometry_is_that_of_a_rigid_body() {
        let arm = [-0.4, 0.0, -2.1];
        let (velocity, rates) = ([40.0, 3.0, -2.0], [0.3, -0.2, 0.5]);
        let exact = place(Hub::Exact, 1.0);
        let turning = cross(rates, arm);
        let [u, v, w] = [velocity[0] + turning[0], velocity[1] + turning[1], velocity[2] + turning[2]];
        let (cos, sin) = exact.tilt;
        let motion = exact.motion(velocity, rates);
        assert!((motion.in_plane - (u * cos + w * sin).hypot(v)).abs() < 1e-13);
        assert!((motion.axial - (w * cos - u * sin)).abs() < 1e-13);
        let loads = HubLoads { force: [100.0, -30.0, -5000.0], moment: [70.0, -20.0, 900.0] };
        let (force, moment) = exact.at_centre_of_mass(loads);
        let rotated = |[x, y, z]: [f64; 3]| [x * cos - z * sin, y, z * cos + x * sin];
        let (there, own) = (rotated(loads.force), rotated(loads.moment));
        let lever = cross(arm, there);
        for axis in 0..3 {
            assert!((force[axis] - there[axis]).abs() < 1e-9);
            assert!((moment[axis] - own[axis] - lever[axis]).abs() < 1e-9, "axis {axis}");
        }
    }

    #[test]
    fn without_tilt_and_offset_both_geometries_agree() {
        let plain = |geometry| HubPosition { cg_forward: 0.0, tilt: (1.0, 0.0), ..place(geometry, -1.0) };
        let (published, exact) = (plain(Hub::Published), plain(Hub::Exact));
        let (velocity, rates) = ([40.0, 3.0, -2.0], [0.3, -0.2, 0.5]);
        assert_eq!(published.motion(velocity, rates), exact.motion(velocity, rates));
        let loads = HubLoads { force: [100.0, -30.0, -5000.0], moment: [70.0, -20.0, 900.0] };
        assert_eq!(published.at_centre_of_mass(loads), exact.at_centre_of_mass(loads));
    }
}
