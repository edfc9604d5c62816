//! Uniform inflow of a rotor: momentum theory against blade elements.
//!
//! Consumes the advance ratios mu and mu_z (through the disc, down through it negative as w is positive down: mu_z = w/(Omega R))
//! and the thrust coefficient as a straight line of the inflow, C_T = c0 - c1 lambda; produces lambda with
//!     2 lambda sqrt(mu^2 + (lambda - mu_z)^2) = c0 - c1 lambda                            (1)
//! and the first cosine harmonic of the wake's skew chi = atan2(mu, lambda - mu_z), in wind axes,
//!     lambda_1c = lambda tan(chi/2) for chi < 90 degrees, else lambda cot(chi/2)           (2)
//! written without the angle: lambda mu/(sqrt(mu^2 + d^2) + |d|), d = lambda - mu_z.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch. 3.
//! Numerics: Newton's method inside a bracket that holds one sign change, to the last digit. In slow descent (1) has three
//! roots; the one with lambda > mu_z (air still driven down through the disc) is taken wherever it exists.

/// Most iterations; bisection alone would end within them.
const ITERATIONS: usize = 80;

/// The lambda of (1). Its sign is that of c0. NaN where there is none: for numbers that are not finite, and for c1 of zero or
/// less (a tail rotor far faster than it can fly, whose blades would thrust the more the more air comes through).
pub(crate) fn uniform(mu: f64, mu_z: f64, c0: f64, c1: f64) -> f64 {
    if !(c1 > 0.0 && (mu + mu_z + c0 + c1).is_finite()) {
        return f64::NAN;
    }
    // Upside down (1) is the same equation.
    if c0 < 0.0 { -lifting(mu, -mu_z, -c0, c1) } else { lifting(mu, mu_z, c0, c1) }
}

fn lifting(mu: f64, mu_z: f64, c0: f64, c1: f64) -> f64 {
    let value_and_slope = |lambda: f64| {
        let d = lambda - mu_z;
        let r = libm::sqrt(mu * mu + d * d);
        let slope = 2.0 * r + c1 + if r > 0.0 { 2.0 * lambda * d / r } else { 0.0 };
        (2.0 * lambda * r - c0 + c1 * lambda, slope)
    };
    let (mut low, mut high) = (0.0, c0 / c1);
    if mu_z > low && mu_z < high {
        if value_and_slope(mu_z).0 <= 0.0 { low = mu_z } else { high = mu_z }
    }
    let mut lambda = (c0 / (2.0 * libm::sqrt(mu * mu + mu_z * mu_z) + c1)).clamp(low, high);
    for _ in 0..ITERATIONS {
        let (value, slope) = value_and_slope(lambda);
        if value > 0.0 {
            high = lambda
        } else {
            low = lambda
        }
        let newton = lambda - value / slope;
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        let step = libm::fabs(next - lambda);
        lambda = next;
        if !(step > f64::EPSILON * lambda) {
            break;
        }
    }
    lambda
}

/// The harmonic of (2).
pub(crate) fn harmonic(mu: f64, mu_z: f64, lambda: f64) -> f64 {
    let d = lambda - mu_z;
    let sum = libm::sqrt(mu * mu + d * d) + libm::fabs(d);
    if sum > 0.0 { lambda * mu / sum } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_there_is_no_inflow_it_says_so() {
        for (mu, c0, c1) in
            [(1.9, 0.01, -0.02), (0.2, 0.01, 0.0), (f64::NAN, 0.01, 0.1), (0.1, f64::INFINITY, 0.1), (0.1, 0.1, f64::NAN)]
        {
            assert!(uniform(mu, 0.0, c0, c1).is_nan());
        }
    }

    #[test]
    fn axial_flight_is_the_quadratic_of_momentum_theory() {
        // 2 lambda (lambda - mu_z) = c0 - c1 lambda, a quadratic: hover, climb (mu_z < 0) and descent.
        let (c0, c1): (f64, f64) = (0.012, 0.13);
        for mu_z in [0.0, -0.05, -0.2, 0.01, 0.05] {
            let b: f64 = c1 - 2.0 * mu_z;
            let exact = (-b + (b * b + 8.0 * c0).sqrt()) / 4.0;
            assert!((uniform(0.0, mu_z, c0, c1) - exact).abs() < 1e-16, "mu_z {mu_z}");
            assert!((uniform(0.0, -mu_z, -c0, c1) + exact).abs() < 1e-16, "upside down, mu_z {mu_z}");
        }
    }

    #[test]
    fn it_solves_its_equation_everywhere() {
        for mu in [0.0, 1e-7, 0.01, 0.1, 0.4] {
            for place in -40..=40 {
                let mu_z = f64::from(place) * 0.01;
                for c0 in [-0.02, -1e-6, 0.0, 1e-9, 0.004, 0.03] {
                    let (c1, lambda) = (0.13, uniform(mu, mu_z, c0, 0.13));
                    let r = (mu * mu + (lambda - mu_z) * (lambda - mu_z)).sqrt();
                    let off = 2.0 * lambda * r - c0 + c1 * lambda;
                    assert!(off.abs() < 1e-16, "mu {mu}, mu_z {mu_z}, c0 {c0}: lambda {lambda}, off by {off:e}");
                }
            }
        }
    }

    #[test]
    fn the_harmonic_is_the_tangent_of_half_the_skew_and_its_inverse() {
        for (mu, mu_z, lambda) in [(0.2, -0.05, 0.02), (0.05, 0.04, 0.03), (0.001, 0.0, 0.05)] {
            let half = 0.5 * f64::atan2(mu, lambda - mu_z);
            let exact = if lambda > mu_z { lambda * half.tan() } else { lambda / half.tan() };
            assert!((harmonic(mu, mu_z, lambda) - exact).abs() < 1e-15);
        }
        assert!(harmonic(0.0, 0.0, 0.0) == 0.0);
    }
}
