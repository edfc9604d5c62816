//! Measured frequency responses with coherence, from one input to one output.
//!
//! Consumes an input and an output on a uniform grid; produces, at each frequency w asked for, from the segments of `num::welch`
//! that overlap by three quarters, n of them independent,
//!     H = G_xy/G_xx,   G_xy = mean X* Y,   coherence = |G_xy|^2/(G_xx G_yy)                            (1)
//!     std(|H|)/|H| = std(arg H) = sqrt((1 - coherence)/(2 n coherence))                                (2)
//! Coherence below one is noise, another input, nonlinearity, or a segment too short for the response.
//! Source: J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010, ch. 9 and 11; M. B. Tischler and R. K. Remple, Aircraft
//! and Rotorcraft System Identification, 2nd ed., 2012, ch. 7.
//! Numerics: a segment of L seconds resolves frequencies from about 2/L on, 1/L apart; a delay t of the output lowers the
//! coherence by about 13 (t/L)^2.

use super::welch::{Overlap, WelchConfig, coherence};
use nalgebra::Complex;

/// The response at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyResponsePoint {
    /// The frequency, rad/s.
    pub rad_s: f64,
    /// H, output over input.
    pub response: Complex<f64>,
    /// Between 0 and 1.
    pub coherence: f64,
    /// (2): standard error of the gain over the gain, and of the phase, rad.
    pub std: f64,
}

/// Why there is no response.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum FrequencyResponseError {
    #[error("expected input and output of one length, found {input} and {output} samples")]
    Lengths { input: usize, output: usize },
    /// The record has fewer than three segments (two half-overlapped neighbours say too little), or a segment is a few samples.
    #[error("expected a segment of 8 samples or more and a record of two segments, found {segment} samples in {record}")]
    TooShort { segment: usize, record: usize },
    #[error("expected frequencies from {from} to {to} rad/s, found {rad_s}")]
    Frequency { rad_s: f64, from: f64, to: f64 },
    #[error("expected an input and an output that move, and are numbers")]
    Still,
}

/// The response (1) at each of the frequencies, rad/s, from segments of that length, s.
///
/// # Errors
/// [`FrequencyResponseError`] with what is wrong.
pub fn frequency_response(
    input: &[f64],
    output: &[f64],
    interval_s: f64,
    segment_s: f64,
    frequencies: &[f64],
) -> Result<Vec<FrequencyResponsePoint>, FrequencyResponseError> {
    if input.len() != output.len() {
        return Err(FrequencyResponseError::Lengths { input: input.len(), output: output.len() });
    }
    let segment = libm::round(segment_s / interval_s) as usize;
    if segment < 8 || input.len() < 2 * segment {
        return Err(FrequencyResponseError::TooShort { segment, record: input.len() });
    }
    let (from, to) = (2.0 * std::f64::consts::TAU / segment_s, std::f64::consts::PI / interval_s);
    if let Some(&rad_s) = frequencies.iter().find(|rad_s| !(**rad_s >= from * (1.0 - 1e-9) && **rad_s <= to)) {
        return Err(FrequencyResponseError::Frequency { rad_s, from, to });
    }
    let config = WelchConfig {
        segment_s,
        overlap: Overlap::ThreeQuarters,
        hz: frequencies.iter().map(|rad_s| rad_s / std::f64::consts::TAU).collect(),
    };
    let (inputs, outputs) = (config.segments(input, interval_s), config.segments(output, interval_s));
    let independent = config.overlap.independent(inputs.len());
    let powers = config.density(&inputs).into_iter().zip(config.density(&outputs));
    let crossed = config.cross_density(&inputs, &outputs).into_iter().zip(powers);
    frequencies
        .iter()
        .zip(crossed)
        .map(|(&rad_s, (cross, (xx, yy)))| {
            let (re, im) = cross;
            if !(xx > 0.0 && yy > 0.0 && re.is_finite() && im.is_finite()) {
                return Err(FrequencyResponseError::Still);
            }
            let coherence = coherence(cross, (xx, yy));
            let std = libm::sqrt((1.0 - coherence) / (2.0 * independent * coherence));
            Ok(FrequencyResponsePoint { rad_s, response: Complex::new(re, im) / xx, coherence, std })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pseudo-random sequence, uniform about zero, of variance one.
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut state = seed;
        let step = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * libm::sqrt(12.0)
        };
        (0..count).map(step).collect()
    }

    const INTERVAL_S: f64 = 0.02;

    /// An input without much above 2 Hz, and the output of y'' + 2 zeta omega y' + omega^2 y = omega^2 u by many small steps.
    fn oscillator(seed: u64, count: usize) -> (Vec<f64>, Vec<f64>) {
        let (omega, zeta) = (2.0, 0.3);
        let (mut u, mut slow, mut y, mut v) = (0.0, 0.0, 0.0, 0.0);
        let mut signals = (Vec::new(), Vec::new());
        for drive in noise(seed, count) {
            signals.0.push(u);
            signals.1.push(y);
            slow += 0.2 * (drive - slow);
            let next = u + 0.2 * (slow - u);
            for part in 0..200 {
                let now = u + (next - u) * (f64::from(part) + 0.5) / 200.0;
                let h = INTERVAL_S / 200.0;
                v += h * (omega * omega * (now - y) - 2.0 * zeta * omega * v);
                y += h * v;
            }
            u = next;
        }
        signals
    }

    #[test]
    fn the_response_is_that_of_the_model_within_its_standard_errors() {
        let (input, clean) = oscillator(7, 30_000);
        let output: Vec<f64> = clean.iter().zip(noise(11, clean.len())).map(|(y, n)| y + 0.05 * n).collect();
        let frequencies: Vec<f64> = (2..20).map(|k| 0.45 * f64::from(k)).collect();
        let exact = frequency_response(&input, &clean, INTERVAL_S, 60.0, &frequencies).unwrap();
        let found = frequency_response(&input, &output, INTERVAL_S, 60.0, &frequencies).unwrap();
        let mut scores = Vec::new();
        // At resonance the output is 1.7 s late: a segment of 60 s then misses 1 % of the coherence, one of 30 s 4 %.
        for (exact, found) in exact.iter().zip(&found) {
            let s = Complex::new(0.0, found.rad_s);
            let model = Complex::new(4.0, 0.0) / (s * s + s * 1.2 + 4.0);
            assert!(exact.coherence > 0.97, "{exact:?}");
            assert!((exact.response / model - 1.0).norm() < 0.05, "{exact:?} for {model}");
            assert!(found.coherence <= exact.coherence);
            let ratio = found.response / model;
            scores.extend([(ratio.norm() - 1.0) / found.std, ratio.arg() / found.std]);
        }
        assert!(scores.iter().all(|score| score.abs() < 4.5), "{scores:?}");
        let spread = (scores.iter().map(|score| score * score).sum::<f64>() / scores.len() as f64).sqrt();
        assert!((0.5..1.8).contains(&spread), "{spread}");
        // The gain falls with the square of the frequency and the noise does not: so does the coherence.
        assert!(found[0].coherence > 0.9 && found[17].coherence < 0.9 * exact[17].coherence, "{found:?}");
    }

    #[test]
    fn what_cannot_be_estimated_is_refused() {
        let x = noise(3, 100);
        let of =
            |x: &[f64], y: &[f64], segment_s: f64, rad_s: f64| frequency_response(x, y, 0.1, segment_s, &[rad_s]).unwrap_err();
        assert!(matches!(of(&x, &x[1..], 4.0, 4.0), FrequencyResponseError::Lengths { .. }));
        assert!(matches!(of(&x, &x, 6.0, 4.0), FrequencyResponseError::TooShort { segment: 60, record: 100 }));
        assert!(matches!(of(&x, &x, 4.0, 3.0), FrequencyResponseError::Frequency { .. }));
        assert_eq!(of(&[1.0; 100], &x, 4.0, 4.0), FrequencyResponseError::Still);
    }
}
