//! The standard atmosphere below 11 km, and angles from a quaternion.
//!
//! Consumes static pressure, Pa, or a quaternion; produces pressure altitude and density, or Euler angles.
//!     h = T0/L (1 - (p/p0)^(R L/g0)),   T = T0 (p/p0)^(R L/g0),   rho = p/(R T)                       (1)
//!     T0 = 288.15 K, L = 6.5 K/km, p0 = 101325 Pa, R = 287.05287 J/(kg K), g0 = 9.80665 m/s^2
//!     phi = atan2(2 (w x + y z), 1 - 2 (x^2 + y^2)),   theta = asin(2 (w y - z x)),
//!     psi = atan2(2 (w z + x y), 1 - 2 (y^2 + z^2))                                                   (2)
//! | w x y z | unit quaternion that turns body axes into north, east, down |
//! Source: ICAO, Manual of the Standard Atmosphere, Doc 7488/3 (1993); Stevens, Lewis, Johnson, Aircraft Control and
//! Simulation, 3rd edition, section 1.3.
//! Refused: pressures outside of -2000 m to 11 km, quaternions whose norm is not within a hundredth of 1.

const T0: f64 = 288.15;
const LAPSE: f64 = 0.0065;
const P0: f64 = 101_325.0;
const GAS: f64 = 287.052_87;
const G0: f64 = 9.806_65;
/// Density at sea level, kg/m^3.
pub const RHO0: f64 = P0 / (GAS * T0);

/// Pressure altitude, m, and standard density, kg/m^3, at a static pressure, by (1).
pub fn standard(pressure_pa: f64) -> Option<(f64, f64)> {
    let ratio = libm::pow(pressure_pa / P0, GAS * LAPSE / G0);
    let height = T0 / LAPSE * (1.0 - ratio);
    (pressure_pa > 0.0 && height <= 11_000.0 && height > -2000.0).then(|| (height, pressure_pa / (GAS * T0 * ratio)))
}

/// Static pressure, Pa, at a pressure altitude, m: (1) solved for it.
pub fn pressure_at(height: f64) -> Option<f64> {
    let within = height <= 11_000.0 && height > -2000.0;
    within.then(|| P0 * libm::pow(1.0 - LAPSE * height / T0, G0 / (GAS * LAPSE)))
}

/// Standard temperature, deg C, at a pressure altitude, m.
pub fn temperature_at(height: f64) -> f64 {
    T0 - 273.15 - LAPSE * height
}

/// Bank, pitch attitude and heading, rad, by (2).
pub fn angles([w, x, y, z]: [f64; 4]) -> Option<[f64; 3]> {
    let norm = libm::sqrt(w * w + x * x + y * y + z * z);
    if !(libm::fabs(norm - 1.0) < 0.01) {
        return None;
    }
    let [w, x, y, z] = [w, x, y, z].map(|part| part / norm);
    let sine = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0);
    Some([
        libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        libm::asin(sine),
        libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::super::encode::flight::quaternion;
    use super::*;

    #[test]
    fn the_standard_atmosphere_is_that_of_its_tables() {
        for (pressure, height, density) in [(101_325.0, 0.0, 1.2250), (89_874.6, 1000.0, 1.1116), (54_019.9, 5000.0, 0.73612)] {
            let (found, rho) = standard(pressure).unwrap();
            assert!((found - height).abs() < 0.05 && (rho / density - 1.0).abs() < 1e-4, "{height}");
            assert!((pressure_at(found).unwrap() - pressure).abs() < 1e-6, "{height}");
        }
        assert_eq!((pressure_at(-2000.0), pressure_at(11_001.0), pressure_at(f64::NAN)), (None, None, None));
        assert!([0.0, -1.0, f64::NAN, 1e3, 1e6].iter().all(|pressure| standard(*pressure).is_none()));
    }

    #[test]
    fn angles_come_back_from_their_quaternion() {
        for angles_in in [[0.3, -0.2, 2.0], [-2.9, 1.2, -0.4], [0.0, 0.0, 3.1]] {
            let found = angles(quaternion(angles_in)).unwrap();
            assert!(found.iter().zip(angles_in).all(|(found, angle)| (found - angle).abs() < 1e-12), "{angles_in:?}");
        }
        // A turn by 90 degrees about z: north becomes east.
        let half = libm::sqrt(0.5);
        assert!((angles([half, 0.0, 0.0, half]).unwrap()[2] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!([angles([0.0; 4]), angles([f64::NAN; 4]), angles([1.0, 0.2, 0.0, 0.0])], [None; 3]);
    }
}
