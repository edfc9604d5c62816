//! Discrete Fourier transform of lengths that are powers of two.
//!
//! Consumes F numbers x(k); produces
//!     X(f) = sum_k x(k) e^(-2 pi j f k/F)                                                          (1)
//! by decimation in time (radix 2).
//! Source: J. W. Cooley and J. W. Tukey, Math. Comput. 19, 1965. Numerics: twiddle factors of every stage are stored
//! contiguously.

/// A length with its factors.
#[derive(Clone, Debug)]
pub struct FourierTransform {
    length: usize,
    /// Of all stages, one after the other: 1 + 2 + 4 + ... + F/2 numbers.
    cosines: Vec<f64>,
    sines: Vec<f64>,
}

/// Numbers with their imaginary parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComplexSeries {
    /// Real parts.
    pub re: Vec<f64>,
    /// Imaginary parts.
    pub im: Vec<f64>,
}

impl ComplexSeries {
    /// Zeros.
    pub fn zeros(length: usize) -> Self {
        ComplexSeries { re: vec![0.0; length], im: vec![0.0; length] }
    }
}

impl FourierTransform {
    /// Of at least so many samples.
    pub fn at_least(samples: usize) -> Self {
        let length = samples.max(2).next_power_of_two();
        let (mut cosines, mut sines) = (Vec::with_capacity(length), Vec::with_capacity(length));
        let mut half = 1;
        while half < length {
            for j in 0..half {
                let angle = -core::f64::consts::PI * j as f64 / half as f64;
                cosines.push(libm::cos(angle));
                sines.push(libm::sin(angle));
            }
            half *= 2;
        }
        FourierTransform { length, cosines, sines }
    }

    /// F.
    pub fn length(&self) -> usize {
        self.length
    }

    /// (1) in place.
    pub fn forward(&self, x: &mut ComplexSeries) {
        let bits = self.length.trailing_zeros();
        for i in 0..self.length {
            let j = i.reverse_bits() >> (usize::BITS - bits);
            if i < j {
                x.re.swap(i, j);
                x.im.swap(i, j);
            }
        }
        let (mut half, mut from) = (1, 0);
        while half < self.length {
            let (cosines, sines) = (&self.cosines[from..from + half], &self.sines[from..from + half]);
            for (re, im) in x.re.chunks_exact_mut(2 * half).zip(x.im.chunks_exact_mut(2 * half)) {
                let ((re0, re1), (im0, im1)) = (re.split_at_mut(half), im.split_at_mut(half));
                let (re0, re1, im0, im1) = (&mut re0[..half], &mut re1[..half], &mut im0[..half], &mut im1[..half]);
                for j in 0..half {
                    let (c, s) = (cosines[j], sines[j]);
                    let (a, b) = (c * re1[j] - s * im1[j], c * im1[j] + s * re1[j]);
                    re1[j] = re0[j] - a;
                    im1[j] = im0[j] - b;
                    re0[j] += a;
                    im0[j] += b;
                }
            }
            from += half;
            half *= 2;
        }
    }

    /// Frequencies 0 to F/2 of two real series at once.
    pub fn of_two(&self, one: &[f64], two: &[f64]) -> (ComplexSeries, ComplexSeries) {
        let mut x = ComplexSeries::zeros(self.length);
        x.re[..one.len()].copy_from_slice(one);
        x.im[..two.len()].copy_from_slice(two);
        self.forward(&mut x);
        let half = self.length / 2 + 1;
        let (mut first, mut second) = (ComplexSeries::zeros(half), ComplexSeries::zeros(half));
        for f in 0..half {
            let mirror = (self.length - f) % self.length;
            let (a, b, c, d) = (x.re[f], x.im[f], x.re[mirror], x.im[mirror]);
            (first.re[f], first.im[f]) = (0.5 * (a + c), 0.5 * (b - d));
            (second.re[f], second.im[f]) = (0.5 * (b + d), 0.5 * (c - a));
        }
        (first, second)
    }

    /// The real series whose transform has these frequencies 0 to F/2.
    pub fn back(&self, half: &ComplexSeries) -> Vec<f64> {
        let mut x = ComplexSeries::zeros(self.length);
        for f in 0..self.length {
            let (from, sign) = if f <= self.length / 2 { (f, 1.0) } else { (self.length - f, -1.0) };
            // The inverse by the forward transform of the conjugate.
            (x.re[f], x.im[f]) = (half.re[from], -sign * half.im[from]);
        }
        self.forward(&mut x);
        x.re.iter().map(|value| value / self.length as f64).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_sum_written_out_and_goes_back() {
        let transform = FourierTransform::at_least(13);
        assert_eq!(transform.length(), 16);
        let one: Vec<f64> = (0..13).map(|k| libm::sin(0.7 * f64::from(k)) + 0.1 * f64::from(k)).collect();
        let two: Vec<f64> = (0..11).map(|k| libm::cos(1.9 * f64::from(k))).collect();
        let (first, second) = transform.of_two(&one, &two);
        for (found, series) in [(&first, &one), (&second, &two)] {
            for f in 0..=8 {
                let angle = |k: usize| -2.0 * core::f64::consts::PI * (f * k) as f64 / 16.0;
                let re: f64 = series.iter().enumerate().map(|(k, x)| x * libm::cos(angle(k))).sum();
                let im: f64 = series.iter().enumerate().map(|(k, x)| x * libm::sin(angle(k))).sum();
                assert!((found.re[f] - re).abs() < 1e-12 && (found.im[f] - im).abs() < 1e-12);
            }
        }
        let again = transform.back(&first);
        assert!(again.iter().zip(one.iter().chain([0.0; 3].iter())).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}
