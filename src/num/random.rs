//! Normal noise from a seed, the same bits on every target.
//!
//! Consumes a seed and a stream's number; produces independent standard normal numbers by Box and Muller's method:
//!     n1 = sqrt(-2 ln a) cos(2 pi b),  n2 = sqrt(-2 ln a) sin(2 pi b),  a in (0, 1], b in [0, 1)   (1)
//! Each channel has a stream of its own, so that a further channel does not change the others.
//! Source: Box, Muller, "A note on the generation of random normal deviates", Ann. Math. Stat. 29 (1958).

use core::f64::consts::TAU;
use rand_core::Rng;
use rand_pcg::Pcg64;

/// A stream of standard normal numbers.
#[derive(Clone, Debug)]
pub struct NormalNoise {
    generator: Pcg64,
    spare: Option<f64>,
}

impl NormalNoise {
    /// The stream of that number under that seed.
    pub fn new(seed: u64, stream: u64) -> Self {
        NormalNoise { generator: Pcg64::new(u128::from(seed), u128::from(stream)), spare: None }
    }

    /// The next number.
    pub fn draw(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let a = 1.0 - self.uniform();
        let b = self.uniform();
        let radius = libm::sqrt(-2.0 * libm::log(a));
        let (sin, cos) = libm::sincos(TAU * b);
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// Uniform on [0, 1), 53 bits.
    pub(crate) fn uniform(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        (self.generator.next_u64() >> 11) as f64 * STEP
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_and_tails_are_those_of_the_normal_law() {
        let mut noise = NormalNoise::new(7, 3);
        let count = 200_000;
        let draws: Vec<f64> = (0..count).map(|_| noise.draw()).collect();
        let moment = |power: i32| draws.iter().map(|x| x.powi(power)).sum::<f64>() / f64::from(count);
        // Standard errors: sqrt(1, 2, 15, 96) / sqrt(count); five of them are allowed.
        for (power, wanted, spread) in [(1, 0.0, 1.0f64), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
            let allowed = 5.0 * (spread / f64::from(count)).sqrt();
            assert!((moment(power) - wanted).abs() < allowed, "moment {power}: {}", moment(power));
        }
        let within = draws.iter().filter(|x| x.abs() < 1.96).count() as f64 / f64::from(count);
        assert!((within - 0.95).abs() < 0.003, "{within}");
        let product: f64 = draws.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / f64::from(count);
        assert!(product.abs() < 0.012, "successive draws go together: {product}");
    }

    #[test]
    fn streams_differ_and_a_seed_repeats() {
        let first = |seed, stream| NormalNoise::new(seed, stream).draw().to_bits();
        assert_eq!(first(1, 1), first(1, 1));
        assert_ne!(first(1, 1), first(1, 2));
        assert_ne!(first(1, 1), first(2, 1));
    }
}
