//! Uniform inflow of a rotor: momentum theory against blade elements.
//!
//! Consumes the advance ratios mu and mu_z (through the disc, down through it negative as w is positive down: mu_z = w/(Omega R))
//! and the thrust coefficient as a straight line of the inflow, C_T = c0 - c1 lambda; produces lambda with
//!     2 lambda sqrt(mu^2 + (lambda - mu_z)^2) = c0 - c1 lambda                            (1)
//! and the first cosine harmonic of the wake's skew chi = atan2(mu, lambda - mu_z), in wind axes,
//!     lambda_1c = lambda tan(chi/2) for chi < 90 degrees, else lambda cot(chi/2)           (2)
//! written without the angle: lambda mu/(sqrt(mu^2 + d^2) + |d|), d = lambda - mu_z.
//! Source: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch. 3.
//! Numerics: from a close start, such as the inflow of the previous step, one step of high order; otherwise Newton's method until
//! the next step would be below rounding. For mu_z <= 0 the left side minus the right is convex and increasing, so that Newton's
//! method converges from any start. In slow descent (1) has three roots; the one with lambda > mu_z (flow down through the disc)
//! is taken where it exists, inside a bracket; below mu_z, where a bracket may contain three roots, the start is the default and
//! not the caller's. So the result does not depend on the start.

/// Most iterations; bisection alone would end within them.
const ITERATIONS: usize = 80;

/// Part of lambda that the last step may leave.
const LEFT: f64 = 1e-16;

/// Part of lambda that the first terms of (3) may be.
const SHORT: f64 = 0.05;

/// Inflows of both rotors from which the next solution of (1) sets out; any others lead to the same, after more steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InflowGuess {
    /// lambda of the main rotor.
    pub(crate) main: f64,
    /// lambda of the tail rotor.
    pub(crate) tail: f64,
}

impl InflowGuess {
    /// Nothing is known: a cold start.
    pub(crate) const NONE: InflowGuess = InflowGuess { main: f64::NAN, tail: f64::NAN };
}

/// What (1) holds between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MomentumBalance {
    /// mu^2.
    pub(crate) mu2: f64,
    /// mu_z.
    pub(crate) mu_z: f64,
    /// Thrust coefficient without inflow, and what a lambda takes of it.
    pub(crate) c0: f64,
    pub(crate) c1: f64,
}

impl MomentumBalance {
    /// The lambda of (1), iterated from that guess. Its sign is that of c0. NaN where there is none: for numbers that are
    /// not finite, and for c1 of zero or less (a tail rotor far faster than it can fly, whose blades would thrust the more the
    /// more air comes through).
    #[inline]
    pub(crate) fn uniform(self, guess: f64) -> f64 {
        let [lambda] = uniform([self], [guess]);
        lambda
    }

    /// Upside down (1) is the same equation: with c0 not negative, and the sign.
    #[inline]
    fn upright(self) -> (Self, f64) {
        let sign = if self.c0 < 0.0 { -1.0 } else { 1.0 };
        (MomentumBalance { mu_z: sign * self.mu_z, c0: sign * self.c0, ..self }, sign)
    }
}

/// [`MomentumBalance::uniform`] of rotors that know nothing of each other, side by side: what one waits for the other is not
/// kept by.
#[inline]
pub(crate) fn uniform<const N: usize>(balances: [MomentumBalance; N], guesses: [f64; N]) -> [f64; N] {
    let mut lambdas = near(&balances, &guesses);
    for ((lambda, balance), guess) in lambdas.iter_mut().zip(balances).zip(guesses) {
        if lambda.is_nan() {
            *lambda = far(balance, guess);
        }
    }
    lambdas
}

/// The roots of (1) close by, in one step; NaN where that is not close enough for rounding.
///
/// Squared, (1) is a quartic polynomial, f = 4 lambda^2 (mu^2 + d^2) - (c0 - c1 lambda)^2 with d = lambda - mu_z: no square root
/// stands in the way. With s = f/f', k = f''/(2 f'), c = f'''/(6 f'), e = f''''/(24 f') its inverse series is
///     lambda - s - k s^2 - (2 k^2 - c) s^3 - (5 k^3 - 5 k c + e) s^4 - (14 k^4 - 21 k^2 c + 6 k e + 3 c^2) s^5        (3)
/// and what follows is about the last term times 2 s (1/lambda + |k|). Between zero and c0/c1 a root of f is one of (1), and
/// below zero inflow and in edgewise flow the only one.
#[inline]
fn near<const N: usize>(balances: &[MomentumBalance; N], guesses: &[f64; N]) -> [f64; N] {
    let mut found = [f64::NAN; N];
    for ((found, &balance), &guess) in found.iter_mut().zip(balances).zip(guesses) {
        let (MomentumBalance { mu2, mu_z, c0, c1 }, sign) = balance.upright();
        let lambda = sign * guess;
        let (d, right) = (lambda - mu_z, c0 - c1 * lambda);
        let (r2, lambda2, along) = (mu2 + d * d, lambda * lambda, lambda * d);
        let value = 4.0 * lambda2 * r2 - right * right;
        let over = 1.0 / (8.0 * lambda * (r2 + along) + 2.0 * c1 * right);
        let (s, e) = (value * over, 4.0 * over);
        let (k, c) = ((4.0 * (r2 + lambda2) + 16.0 * along - c1 * c1) * over, 8.0 * (d + lambda) * over);
        let k2 = k * k;
        let (cubic, quartic) = (2.0 * k2 - c, 5.0 * k * (k2 - c) + e);
        let last = s * (7.0 * k2 * (2.0 * k2 - 3.0 * c) + 6.0 * k * e + 3.0 * c * c);
        let s2 = s * s;
        let next = lambda - s * (1.0 + s * k + s2 * (cubic + s * quartic + s * last));
        let short = libm::fabs(s) * (lambda * libm::fabs(k) + 1.0);
        let left = 2.0 * short * libm::fabs(last) * (s2 * s2);
        let close = (left <= LEFT * lambda2) & (short < SHORT * lambda) & (over > 0.0);
        let edgewise = (mu_z <= 0.0) | (4.0 * mu2 > mu_z * mu_z);
        let between = (next > 0.0) & (c1 > 0.0) & (c1 * next < c0);
        *found = if close & edgewise & between { sign * next } else { f64::NAN };
    }
    found
}

/// The root by as many steps as it takes.
#[cold]
#[inline(never)]
fn far(balance: MomentumBalance, guess: f64) -> f64 {
    let (MomentumBalance { mu2, mu_z, c0, c1 }, sign) = balance.upright();
    let guess = sign * guess;
    if !(c1 > 0.0 && c1.is_finite()) {
        return f64::NAN;
    }
    if !(c0 > 0.0) {
        return sign * c0;
    }
    let cold = || c0 / (2.0 * libm::sqrt(mu2 + mu_z * mu_z) + c1);
    let known = guess > 0.0 && guess < 1.0;
    sign * if mu_z > 0.0 {
        bracketed(mu2, mu_z, (c0, c1), known.then_some(guess), cold)
    } else {
        rising(mu2, mu_z, (c0, c1), if known { guess } else { cold() })
    }
}

/// One step of Newton's: left less right side f of (1), the next lambda, and whether that is the solution to rounding.
///
/// The step s = f/f' leaves k s^2 with k = f''/(2 f').
fn step(mu2: f64, mu_z: f64, (c0, c1): (f64, f64), lambda: f64) -> (f64, f64, bool) {
    let d = lambda - mu_z;
    let r2 = mu2 + d * d;
    let r = libm::sqrt(r2);
    let value = 2.0 * lambda * r - c0 + c1 * lambda;
    // r f' = 2 r^2 + c1 r + 2 lambda d; r^3 f''/2 = 2 d r^2 + lambda mu^2.
    let over = 1.0 / (r2 * (2.0 * r2 + c1 * r + 2.0 * lambda * d));
    let (s, k) = (value * r * r2 * over, (2.0 * d * r2 + lambda * mu2) * over);
    (value, lambda - s, libm::fabs(k * s * s) <= LEFT * lambda)
}

/// For mu_z <= 0.
fn rising(mu2: f64, mu_z: f64, line: (f64, f64), start: f64) -> f64 {
    let mut lambda = start;
    for _ in 0..ITERATIONS {
        let (_, next, settled) = step(mu2, mu_z, line, lambda);
        lambda = next;
        if settled {
            break;
        }
    }
    lambda
}

/// For mu_z > 0.
fn bracketed(mu2: f64, mu_z: f64, (c0, c1): (f64, f64), guess: Option<f64>, cold: impl Fn() -> f64) -> f64 {
    let (mut low, mut high) = (0.0, c0 / c1);
    // The slope is positive wherever r^2 > lambda |d|, so everywhere in edgewise flow, and above mu_z.
    let mut single = 4.0 * mu2 > mu_z * mu_z;
    if mu_z < high {
        // (1) at lambda = mu_z.
        if 2.0 * mu_z * libm::sqrt(mu2) - c0 + c1 * mu_z <= 0.0 {
            (low, single) = (mu_z, true);
        } else {
            high = mu_z;
        }
    }
    let mut lambda = guess.filter(|_| single).unwrap_or_else(cold).max(low).min(high);
    for _ in 0..ITERATIONS {
        let (value, next, settled) = step(mu2, mu_z, (c0, c1), lambda);
        if value > 0.0 {
            high = lambda
        } else {
            low = lambda
        }
        let inside = next >= low && next <= high;
        let next = if inside { next } else { 0.5 * (low + high) };
        let moved = libm::fabs(next - lambda);
        lambda = next;
        if (inside && settled) || !(moved > f64::EPSILON * lambda) {
            break;
        }
    }
    lambda
}

/// The harmonic of (2), sqrt(mu^2 + (lambda - mu_z)^2) given.
#[inline]
pub(crate) fn harmonic(mu: f64, mu_z: f64, lambda: f64, speed: f64) -> f64 {
    let sum = speed + libm::fabs(lambda - mu_z);
    if sum > 0.0 { lambda * mu / sum } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solved(mu2: f64, mu_z: f64, (c0, c1): (f64, f64), guess: f64) -> f64 {
        MomentumBalance { mu2, mu_z, c0, c1 }.uniform(guess)
    }

    #[test]
    fn where_there_is_no_inflow_it_says_so() {
        for (mu, c0, c1) in
            [(1.9, 0.01, -0.02), (0.2, 0.01, 0.0), (f64::NAN, 0.01, 0.1), (0.1, f64::INFINITY, 0.1), (0.1, 0.1, f64::NAN)]
        {
            assert!(solved(mu * mu, 0.0, (c0, c1), f64::NAN).is_nan());
        }
    }

    #[test]
    fn axial_flight_is_the_quadratic_of_momentum_theory() {
        // 2 lambda (lambda - mu_z) = c0 - c1 lambda, a quadratic: hover, climb (mu_z < 0) and descent.
        let (c0, c1): (f64, f64) = (0.012, 0.13);
        for mu_z in [0.0, -0.05, -0.2, 0.01, 0.05] {
            let b: f64 = c1 - 2.0 * mu_z;
            let exact = (-b + (b * b + 8.0 * c0).sqrt()) / 4.0;
            assert!((solved(0.0, mu_z, (c0, c1), f64::NAN) - exact).abs() < 1e-16, "mu_z {mu_z}");
            assert!((solved(0.0, -mu_z, (-c0, c1), f64::NAN) + exact).abs() < 1e-16, "upside down, mu_z {mu_z}");
        }
    }

    #[test]
    fn it_solves_its_equation_everywhere() {
        for mu in [0.0, 1e-7, 0.01, 0.1, 0.4] {
            for place in -40..=40 {
                let mu_z = f64::from(place) * 0.01;
                for c0 in [-0.02, -1e-6, 0.0, 1e-9, 0.004, 0.03] {
                    let (c1, lambda) = (0.13, solved(mu * mu, mu_z, (c0, 0.13), f64::NAN));
                    let r = (mu * mu + (lambda - mu_z) * (lambda - mu_z)).sqrt();
                    let off = 2.0 * lambda * r - c0 + c1 * lambda;
                    assert!(off.abs() < 1e-16, "mu {mu}, mu_z {mu_z}, c0 {c0}: lambda {lambda}, off by {off:e}");
                    for guess in [0.0, 1e-9, 0.01, -0.02, 0.9, 7.0, lambda * (1.0 + 1e-6), lambda * 1.002, lambda * 0.99] {
                        let again = solved(mu * mu, mu_z, (c0, 0.13), guess);
                        let apart = (again - lambda).abs();
                        assert!(
                            apart <= 1e-14 * lambda.abs(),
                            "mu {mu}, mu_z {mu_z}, c0 {c0}: {lambda}, from {guess} {apart:e} off"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn the_harmonic_is_the_tangent_of_half_the_skew_and_its_inverse() {
        for (mu, mu_z, lambda) in [(0.2f64, -0.05, 0.02), (0.05, 0.04, 0.03), (0.001, 0.0, 0.05)] {
            let half = 0.5 * f64::atan2(mu, lambda - mu_z);
            let exact = if lambda > mu_z { lambda * half.tan() } else { lambda / half.tan() };
            assert!((harmonic(mu, mu_z, lambda, mu.hypot(lambda - mu_z)) - exact).abs() < 1e-15);
        }
        assert!(harmonic(0.0, 0.0, 0.0, 0.0) == 0.0);
    }
}
