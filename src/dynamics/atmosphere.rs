//! The standard atmosphere: altitude from density, and density from altitude.
//!
//! Consumes a density (kg/m^3); produces the pressure altitude h (m, geopotential) at which air at rest has it, with
//! T0 = 288.15 K, L = 6.5 K/km, p0 = 101325 Pa, R = 287.05287 J/(kg K), rho0 = p0/(R T0):
//!     h = T0/L (1 - (rho/rho0)^(1/(g/(R L) - 1)))                  up to 11 km              (1)
//!     h = 11 km - R T11/g ln(rho/rho11)                            above, T11 = T0 - L 11 km (2)
//! Source: ISO 2533:1975, Standard Atmosphere. (1) is extrapolated below sea level, (2) above 20 km, where the standard has a
//! temperature gradient.

use crate::flight::unit::STANDARD_GRAVITY;

const T0: f64 = 288.15;
const LAPSE: f64 = 0.006_5;
const P0: f64 = 101_325.0;
const R: f64 = 287.052_87;
const TROPOPAUSE_M: f64 = 11_000.0;

/// The altitude of that density, m; (1), (2). Not a number for a density that is none.
pub fn altitude_of(density: f64) -> f64 {
    let exponent = STANDARD_GRAVITY / (R * LAPSE) - 1.0;
    let share = density / (P0 / (R * T0));
    let below = T0 / LAPSE * (1.0 - libm::pow(share, 1.0 / exponent));
    if !(below > TROPOPAUSE_M) {
        return below;
    }
    let coldest = T0 - LAPSE * TROPOPAUSE_M;
    let at_tropopause = libm::pow(coldest / T0, exponent);
    TROPOPAUSE_M - R * coldest / STANDARD_GRAVITY * libm::log(share / at_tropopause)
}

/// The density at that altitude, kg/m^3: (1), (2) solved for it.
pub fn density_at(altitude: f64) -> f64 {
    let exponent = STANDARD_GRAVITY / (R * LAPSE) - 1.0;
    let at = |altitude: f64| P0 / (R * T0) * libm::pow(1.0 - LAPSE * altitude / T0, exponent);
    if !(altitude > TROPOPAUSE_M) {
        return at(altitude);
    }
    let coldest = T0 - LAPSE * TROPOPAUSE_M;
    at(TROPOPAUSE_M) * libm::exp(-STANDARD_GRAVITY / (R * coldest) * (altitude - TROPOPAUSE_M))
}

#[cfg(test)]
mod tests {
    use super::{altitude_of, density_at};

    #[test]
    fn it_is_the_table_of_the_standard() {
        // Geopotential altitude and density as the standard's table prints them.
        for (altitude, density) in
            [(0.0, 1.22500), (1000.0, 1.11164), (2000.0, 1.00649), (3000.0, 0.909122), (11000.0, 0.363918), (15000.0, 0.193674)]
        {
            let found = altitude_of(density);
            assert!((found - altitude).abs() < 0.1, "{density}: {found} is not {altitude}");
            assert!((density_at(altitude) / density - 1.0).abs() < 1e-5, "{altitude}");
        }
        assert!(altitude_of(f64::NAN).is_nan() && altitude_of(-1.0).is_nan());
    }
}
