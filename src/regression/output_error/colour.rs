//! What coloured residuals do to the errors of the estimates: the covariance of the likelihood's gradient as it is.
//!
//! Consumes a run at the end of the search; produces the covariance of the gradient in place of the white M,
//!     W = sum_ij S_i'R^-1 R_vv(i - j) R^-1 S_j = 1/F sum_f A(f)* P(f) A(f),   Sigma = M^-1 W M^-1    (1)
//! with A the transform of R^-1 S over one run and P that of the residuals' covariance R_vv(l), all outputs with all others,
//! under a window that is 1 up to half of its width and falls to 0 from there. The width is that of what the residuals show:
//! twice the lag after which [`QUIET`] correlations in a row stay below 2 sqrt(log10 N/N), at most a quarter of the run.
//! White residuals give W = M but for chance.
//! Source of (1): E. A. Morelli and V. Klein, J. Guidance 20(1), 1997; of the window: D. N. Politis, J. Nonparametric
//! Statistics 15(4-5), 2003.
//! Numerics: F is longer than run and window together, so that nothing comes round. The window can make a power negative where
//! there is next to none: it is held above [`LEAST_POWER`] of its mean, and a cross power below the two powers' product.

use super::dense::Dense;
use super::information::Linear;
use super::own::Own;
use super::simulated::{Run, Simulated};
use super::spectrum::{Complex, Transform};

/// Correlations in a row that have to be small for a residual to have forgotten.
pub const QUIET: usize = 5;
/// Least power over the mean power.
pub const LEAST_POWER: f64 = 1e-3;

/// Covariances of two residuals at lags 0, 1, ... (first at k + l, second at k), by pairs that were sampled.
fn covariances(transform: &Transform, sums: (&Complex, &Complex), counts: &[f64], lags: usize) -> (Vec<f64>, Vec<f64>) {
    let (a, b) = sums;
    let mut product = Complex::zeros(a.re.len());
    for f in 0..a.re.len() {
        product.re[f] = a.re[f] * b.re[f] + a.im[f] * b.im[f];
        product.im[f] = a.im[f] * b.re[f] - a.re[f] * b.im[f];
    }
    let series = transform.back(&product);
    let length = transform.length();
    let at = |place: usize| {
        let pairs = counts.get(place).copied().unwrap_or(0.0);
        if pairs > 0.5 { series.get(place).copied().unwrap_or(0.0) / pairs } else { 0.0 }
    };
    let ahead = (0..=lags).map(at).collect();
    let behind = (0..=lags).map(|lag| at((length - lag) % length)).collect();
    (ahead, behind)
}

/// Width of the window for covariances at lags 0, 1, ...; `counts` are the pairs at each.
pub fn width(covariances: &[f64], counts: &[f64]) -> usize {
    let Some((&power, rest)) = covariances.split_first() else { return 0 };
    let pairs = counts.first().copied().unwrap_or(0.0).max(2.0);
    let small = 2.0 * libm::sqrt(libm::log10(pairs) / pairs) * power;
    let (mut last, mut quiet) = (0, 0);
    for (lag, covariance) in rest.iter().enumerate() {
        if counts.get(lag + 1).is_none_or(|&pairs| pairs < 0.5) {
            continue;
        }
        if covariance.abs() < small {
            quiet += 1;
        } else {
            (last, quiet) = (lag + 1, 0);
        }
        if quiet == QUIET {
            break;
        }
    }
    (2 * last).max(1).min(covariances.len().saturating_sub(1))
}

/// 1 up to half of the width, then falling to 0.
fn window(lag: usize, width: usize) -> f64 {
    let part = lag as f64 / (width + 1) as f64;
    (2.0 * (1.0 - part)).clamp(0.0, 1.0)
}

/// Powers of residuals, by pair of outputs a <= b, at frequencies 0 to F/2.
struct Powers {
    outputs: usize,
    pairs: Vec<Complex>,
}

impl Powers {
    fn at(&self, a: usize, b: usize, f: usize) -> (f64, f64) {
        let (low, high, sign) = if a <= b { (a, b, 1.0) } else { (b, a, -1.0) };
        let place = low * self.outputs - low * (low + 1) / 2 + high;
        (self.pairs[place].re[f], sign * self.pairs[place].im[f])
    }

    fn of(run: &Run, residuals: &[f64], outputs: usize, transform: &Transform, lags: usize, scale: f64) -> Self {
        let column = |o: usize| -> Vec<f64> {
            let values = residuals.iter().skip(o).step_by(outputs);
            values.map(|v| if v.is_finite() { *v } else { 0.0 }).collect()
        };
        let sampled = |o: usize| -> Vec<f64> {
            residuals.iter().skip(o).step_by(outputs).map(|v| f64::from(u8::from(v.is_finite()))).collect()
        };
        let spectra: Vec<(Complex, Complex)> = (0..outputs).map(|o| transform.of_two(&column(o), &sampled(o))).collect();
        let whole = run.counts.iter().all(|&count| count == run.samples);
        let pairs_of = |a: usize, b: usize| -> Vec<f64> {
            let length = transform.length();
            if whole {
                let apart = |place: usize| place.min(length - place);
                return (0..length).map(|place| run.samples.saturating_sub(apart(place)) as f64).collect();
            }
            let mut product = Complex::zeros(length / 2 + 1);
            for f in 0..product.re.len() {
                let (x, y) = (&spectra[a].1, &spectra[b].1);
                product.re[f] = x.re[f] * y.re[f] + x.im[f] * y.im[f];
                product.im[f] = x.im[f] * y.re[f] - x.re[f] * y.im[f];
            }
            transform.back(&product)
        };
        let mut widths = vec![0; outputs];
        let mut known: Vec<Vec<(Vec<f64>, Vec<f64>)>> = vec![Vec::new(); outputs];
        for a in 0..outputs {
            for b in a..outputs {
                let counts = pairs_of(a, b);
                let both = covariances(transform, (&spectra[a].0, &spectra[b].0), &counts, lags);
                if a == b {
                    widths[a] = width(&both.0, &counts);
                }
                known[a].push(both);
            }
        }
        let mut pairs = Vec::new();
        for a in 0..outputs {
            for b in a..outputs {
                let (ahead, behind) = &known[a][b - a];
                let wide = widths[a].max(widths[b]);
                let mut series = Complex::zeros(transform.length());
                for lag in 0..=wide.min(lags) {
                    let weight = scale * window(lag, wide);
                    series.re[lag] = weight * ahead[lag];
                    if lag > 0 {
                        series.re[transform.length() - lag] = weight * behind[lag];
                    }
                }
                transform.forward(&mut series);
                series.re.truncate(transform.length() / 2 + 1);
                series.im.truncate(transform.length() / 2 + 1);
                pairs.push(series);
            }
        }
        let mut powers = Powers { outputs, pairs };
        powers.hold_positive();
        powers
    }

    /// Powers above their least, cross powers below the powers' product.
    fn hold_positive(&mut self) {
        let place = |a: usize, b: usize, outputs: usize| a * outputs - a * (a + 1) / 2 + b;
        let count = self.pairs.first().map_or(0, |pair| pair.re.len());
        for a in 0..self.outputs {
            let own = &mut self.pairs[place(a, a, self.outputs)];
            let mean = own.re.iter().sum::<f64>() / count.max(1) as f64;
            for (re, im) in own.re.iter_mut().zip(&mut own.im) {
                *re = re.max(LEAST_POWER * mean);
                *im = 0.0;
            }
        }
        for a in 0..self.outputs {
            for b in a + 1..self.outputs {
                for f in 0..count {
                    let most = self.at(a, a, f).0 * self.at(b, b, f).0;
                    let pair = &mut self.pairs[place(a, b, self.outputs)];
                    let squared = pair.re[f] * pair.re[f] + pair.im[f] * pair.im[f];
                    if squared > most {
                        let scale = libm::sqrt(most / squared);
                        pair.re[f] *= scale;
                        pair.im[f] *= scale;
                    }
                }
            }
        }
    }
}

/// W of one run, (1), over theta and the run's own. `inverse_cov` is R^-1; `scale` makes good what the fit took from the residuals.
pub fn gradient_cov(linear: &Linear<'_>, run: &Run, simulated: &Simulated, own: &Own, inverse_cov: &Dense, scale: f64) -> Dense {
    let layout = &linear.prepared.layout;
    let (outputs, stride, columns) = (layout.outputs, layout.stride(), layout.columns());
    let lags = (run.samples / 4).max(1);
    let transform = Transform::at_least(run.samples + lags + 1);
    let powers = Powers::of(run, &simulated.residuals, outputs, &transform, lags, scale);
    // R^-1 S, by output and column.
    let mut series = vec![vec![0.0; run.samples]; outputs * columns];
    linear.pass(run, simulated, own, |k, rows| {
        for (b, row) in rows.chunks_exact(stride).enumerate() {
            if !row[columns].is_finite() {
                continue;
            }
            for a in 0..outputs {
                let factor = inverse_cov[(a, b)];
                if factor != 0.0 {
                    for (column, &x) in row[..columns].iter().enumerate() {
                        series[a * columns + column][k] += factor * x;
                    }
                }
            }
        }
    });
    let half = transform.length() / 2 + 1;
    let width = outputs * columns;
    let mut re = vec![0.0; half * width];
    let mut im = vec![0.0; half * width];
    let empty = Vec::new();
    let used: Vec<usize> = (0..width).filter(|&i| series[i].iter().any(|&x| x != 0.0)).collect();
    for two in used.chunks(2) {
        let second = two.get(1).map_or(&empty, |&i| &series[i]);
        let (first, other) = transform.of_two(&series[two[0]], second);
        for (place, spectrum) in two.iter().zip([first, other]) {
            for f in 0..half {
                re[f * width + place] = spectrum.re[f];
                im[f * width + place] = spectrum.im[f];
            }
        }
    }
    let mut sums = vec![0.0; columns * columns];
    let (mut turned_re, mut turned_im) = (vec![0.0; columns], vec![0.0; columns]);
    for f in 0..half {
        let weight = if f == 0 || f + 1 == half { 1.0 } else { 2.0 } / transform.length() as f64;
        let (re, im) = (&re[f * width..(f + 1) * width], &im[f * width..(f + 1) * width]);
        for a in 0..outputs {
            turned_re.fill(0.0);
            turned_im.fill(0.0);
            for b in 0..outputs {
                let (p, q) = powers.at(a, b, f);
                let (p, q) = (weight * p, weight * q);
                for j in 0..columns {
                    let (x, y) = (re[b * columns + j], im[b * columns + j]);
                    turned_re[j] += p * x - q * y;
                    turned_im[j] += p * y + q * x;
                }
            }
            for i in 0..columns {
                let (x, y) = (re[a * columns + i], im[a * columns + i]);
                let line = &mut sums[i * columns..(i + 1) * columns];
                for ((sum, u), v) in line.iter_mut().zip(&turned_re).zip(&turned_im) {
                    *sum += x * u + y * v;
                }
            }
        }
    }
    Dense::from_fn(columns, columns, |i, j| 0.5 * (sums[i * columns + j] + sums[j * columns + i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_is_as_wide_as_the_residuals_remember() {
        let pairs: Vec<f64> = (0..200).map(|l| 1000.0 - f64::from(l)).collect();
        let forgetting: Vec<f64> = (0..200).map(|l| libm::pow(0.9, f64::from(l))).collect();
        let wide = width(&forgetting, &pairs);
        assert!((38..=50).contains(&wide), "{wide}");
        let white: Vec<f64> = (0..200).map(|l| f64::from(u8::from(l == 0))).collect();
        assert_eq!(width(&white, &pairs), 1);
    }
}
