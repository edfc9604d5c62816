//! The fuselage: forces and moments as polynomials of incidence and sideslip near the nose, wind-tunnel tables elsewhere.
//!
//! Consumes velocity through the air, induced velocity of the main rotor, density; produces force and moment about the centre of
//! mass. With w_f = w - k_lambda v_i, V^2 = u^2 + v^2 + w_f^2, alpha = atan2(w_f, u),
//! beta = asin(v/V) = atan2(v, sqrt(u^2 + w_f^2)):
//!     near:  X Z M = polynomial(alpha), Y N = polynomial(beta), times (rho/rho_ref) (V/V_ref)^2        (1)
//!     far:   X Z = C(alpha) S_p, M = C(alpha) S_p l, Y = C(beta) S_s, N = C(beta) S_s l, times rho V^2/2   (2)
//! (1) up to the near limit, (2) beyond the far limit; between them a smooth step blends (1), held at its limit, into (2). L is
//! zero.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, appendix 4B, for (1); the tables of (2) as in open
//! toolboxes; the blending is ours.

use super::hub::angle;

/// A line of straight pieces through points, angle (rad) and coefficient.
pub type PiecewiseLines = Vec<[f64; 2]>;

/// Data of the fuselage, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Fuselage {
    /// S_p, m^2.
    pub plan_area: f64,
    /// S_s, m^2.
    pub side_area: f64,
    /// l, m.
    pub length: f64,
    /// k_lambda: part of the main rotor's induced velocity that it feels.
    pub downwash: f64,
    /// V_ref, m/s.
    pub reference_speed: f64,
    /// rho_ref, kg/m^3.
    pub reference_density: f64,
    /// Angles up to which (1) and from which (2) holds, rad.
    pub limits: (f64, f64),
    /// Coefficients of (1) by rising power: X Z M of incidence, Y N of sideslip, N and N m.
    pub near: [[f64; 4]; 5],
    /// (2), in the same order.
    pub far: [PiecewiseLines; 5],
}

impl Fuselage {
    /// Force, N, and moment, N m, (1) and (2).
    #[inline]
    pub(crate) fn loads(&self, [u, v, w]: [f64; 3], (density, induced): (f64, f64)) -> ([f64; 3], [f64; 3]) {
        let w_f = w - self.downwash * induced;
        let speed2 = u * u + v * v + w_f * w_f;
        if !(speed2 > 0.0) {
            return ([0.0; 3], [0.0; 3]);
        }
        let alpha = angle(w_f, u);
        let beta = angle(v, libm::sqrt(u * u + w_f * w_f));
        let near = density * speed2 / (self.reference_density * self.reference_speed * self.reference_speed);
        let [x, z, m, y, n] = &self.near;
        let most = self.limits.0;
        if libm::fabs(alpha) <= most && libm::fabs(beta) <= most {
            let force = [power_sum(x, alpha), power_sum(y, beta), power_sum(z, alpha)].map(|part| near * part);
            return (force, [0.0, near * power_sum(m, alpha), near * power_sum(n, beta)]);
        }
        let far = 0.5 * density * speed2;
        let (plan, side) = (far * self.plan_area, far * self.side_area);
        let [far_x, far_z, far_m, far_y, far_n] = &self.far;
        let by = |angle: f64, polynomial: &[f64; 4], lines: &PiecewiseLines, scale: f64| {
            let part = self.far_part(angle);
            let close = (1.0 - part) * near * power_sum(polynomial, angle.clamp(-most, most));
            close + if part > 0.0 { part * scale * along(lines, angle) } else { 0.0 }
        };
        (
            [by(alpha, x, far_x, plan), by(beta, y, far_y, side), by(alpha, z, far_z, plan)],
            [0.0, by(alpha, m, far_m, plan * self.length), by(beta, n, far_n, side * self.length)],
        )
    }

    /// 0 where (1) holds, 1 where (2) does.
    fn far_part(&self, angle: f64) -> f64 {
        let (near, far) = self.limits;
        let way = ((libm::fabs(angle) - near) / (far - near)).clamp(0.0, 1.0);
        way * way * (3.0 - 2.0 * way)
    }
}

fn power_sum([c0, c1, c2, c3]: &[f64; 4], x: f64) -> f64 {
    c0 + x * (c1 + x * (c2 + x * c3))
}

/// The line at that angle; level beyond its ends.
fn along(lines: &PiecewiseLines, angle: f64) -> f64 {
    let after = lines.partition_point(|[at, _]| *at <= angle);
    match (after.checked_sub(1).and_then(|before| lines.get(before)), lines.get(after)) {
        (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * ((angle - x0) / (x1 - x0)),
        (Some([_, y]), None) | (None, Some([_, y])) => *y,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fuselage() -> Fuselage {
        let lines = |value: f64| vec![[-3.2, -value], [0.0, 0.0], [3.2, value]];
        Fuselage {
            plan_area: 20.0,
            side_area: 30.0,
            length: 14.0,
            downwash: 0.0,
            reference_speed: 30.0,
            reference_density: 1.225,
            limits: (0.35, 0.5),
            near: [
                [-800.0, 0.0, 900.0, 0.0],
                [0.0, -5000.0, 0.0, 0.0],
                [-1000.0, 8000.0, 0.0, 0.0],
                [0.0, -1e4, 0.0, 0.0],
                [0.0; 4],
            ],
            far: [lines(-0.1), lines(-1.6), lines(0.2), lines(-0.8), lines(0.1)],
        }
    }

    #[test]
    fn near_the_nose_it_is_the_polynomial() {
        let (force, moment) = fuselage().loads([60.0, 0.0, 6.0], (1.225, 0.0));
        let (alpha, scale) = (0.1f64.atan(), 3636.0 / 900.0);
        assert!((force[0] - scale * (-800.0 + 900.0 * alpha * alpha)).abs() < 1e-9);
        assert!((force[2] + scale * 5000.0 * alpha).abs() < 1e-9 && force[1].abs() < 1e-12);
        assert!((moment[1] - scale * (-1000.0 + 8000.0 * alpha)).abs() < 1e-9);
    }

    #[test]
    fn falling_flat_it_is_the_line_and_the_passage_has_no_step() {
        let (force, _) = fuselage().loads([0.0, 0.0, 10.0], (1.2, 0.0));
        let wanted = -1.6 * (std::f64::consts::FRAC_PI_2 / 3.2) * 0.5 * 1.2 * 100.0 * 20.0;
        assert!((force[2] - wanted).abs() < 1e-9, "{force:?}");
        for edge in [0.35f64, 0.5] {
            let at = |alpha: f64| fuselage().loads([10.0 * alpha.cos(), 0.0, 10.0 * alpha.sin()], (1.2, 0.0)).0[2];
            assert!((at(edge + 1e-9) - at(edge - 1e-9)).abs() < 1e-4);
        }
        assert_eq!(fuselage().loads([0.0; 3], (1.2, 0.0)), ([0.0; 3], [0.0; 3]));
    }
}
