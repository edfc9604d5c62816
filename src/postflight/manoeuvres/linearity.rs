//! Linearity: proportionality of the on-axis response to the control's amplitude.
//!
//! Consumes manoeuvres that differ in amplitude alone; for each of two responses (initial peak by the first pulse's level, span
//! by the travel) and each side (right, left, both) fits
//!     y = b x + c x |x|        and, from three sizes up,  y = a + b x        and, for both sides,  y = b x + d |x|     (1)
//! by weighted least squares, and tests c, a and d. Weights: noise and motion in trim of each response; where runs repeat an
//! amplitude, their scatter is pooled with [`PRIOR`] degrees of freedom of the stated errors. The limit of a test is Student's t
//! at a probability of 1 % over all tests of the same runs (Bonferroni), in calm air. In gusts the motion in trim underestimates
//! the errors (of 50 linear sets in gusts of 0.5 m/s, 33 were rejected), so where the on-axis rate moves in trim by more than
//! [`STILL`] times the noise of a smoothed reading, no line is fitted.
//! Source: ours; Student's quantile as in [`student_limit`].
//! Returns [`NotEstimable`] in gusts, and for amplitudes within [`SAME_AMPLITUDE`] of each other.

use super::channels::Rest;
use super::record::{LineTest, Linearity, MATERIAL, Manoeuvre, Measured, NotEstimable, Response, ResponseLine, on_axis};
use super::test_point::{RunManoeuvre, SAME_AMPLITUDE, alike, grouped};
use core::f64::consts::PI;

/// Probability of a false alarm over all tests of the same runs.
pub(crate) const FALSE_ALARM: f64 = 0.01;
/// Largest motion in trim of calm air, in noise of a smoothed reading.
const STILL: f64 = 3.0;
/// Degrees of freedom of the stated errors.
const PRIOR: f64 = 10.0;

/// One response at one amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AmplitudeResponse {
    /// Signed amplitude, rad.
    pub(crate) amplitude: f64,
    /// Response, and its standard error with the amplitude's own.
    pub(crate) response: Measured,
}

/// Lines over all groups of manoeuvres that differ in amplitude alone.
pub(crate) fn linearity(all: &[RunManoeuvre<'_>]) -> Vec<Linearity> {
    grouped(all, alike).iter().flat_map(|group| of_group(group)).collect()
}

fn of_group(group: &[RunManoeuvre<'_>]) -> Vec<Linearity> {
    let Some(first) = group.first().map(|one| one.manoeuvre) else { return Vec::new() };
    let channel = on_axis(first.control);
    let mut sets: Vec<(Response, i8, Vec<AmplitudeResponse>)> = Vec::new();
    for response in [Response::Initial, Response::Span] {
        let points: Vec<AmplitudeResponse> = group.iter().filter_map(|one| point(one.manoeuvre, response)).collect();
        let of_side = |side: i8| -> Vec<AmplitudeResponse> {
            points.iter().copied().filter(|point| point.amplitude * f64::from(side) > 0.0).collect()
        };
        let (right, left) = (of_side(1), of_side(-1));
        let both = !right.is_empty() && !left.is_empty();
        for (side, points) in [(1, right), (-1, left)] {
            if sizes(&points) >= 2 || (!both && !points.is_empty()) {
                sets.push((response, side, points));
            }
        }
        if both {
            sets.push((response, 0, points));
        }
    }
    let disturbance = group.iter().filter_map(disturbance).fold(0.0, f64::max);
    let tests = sets.iter().map(|(_, side, points)| tests_of(*side, points)).sum::<usize>().max(1);
    let line_of = |(response, side, points): (Response, i8, Vec<AmplitudeResponse>)| {
        let least = points.iter().map(|point| point.amplitude.abs()).fold(f64::INFINITY, f64::min);
        let most = points.iter().map(|point| point.amplitude.abs()).fold(0.0, f64::max);
        Linearity {
            control: first.control,
            shape: first.shape.clone(),
            channel,
            response,
            side,
            amplitudes: (least, most),
            runs: points.len(),
            line: if disturbance > STILL {
                Err(NotEstimable::Disturbed(disturbance))
            } else {
                line(&points, FALSE_ALARM / tests as f64)
            },
        }
    };
    sets.into_iter().map(line_of).collect()
}

/// Motion of the on-axis rate in trim over the noise of a smoothed reading of it.
fn disturbance(one: &RunManoeuvre<'_>) -> Option<f64> {
    let trim = one.manoeuvre.trim.as_ref().ok()?;
    let rest = Rest::of(one.channels.get(on_axis(one.manoeuvre.control))?, trim.from_s, trim.to_s)?;
    Some(rest.motion / rest.smooth)
}

fn tests_of(side: i8, points: &[AmplitudeResponse]) -> usize {
    match sizes(points) {
        0 | 1 => 0,
        2 => 1 + usize::from(side == 0),
        _ => 2,
    }
}

fn point(manoeuvre: &Manoeuvre, response: Response) -> Option<AmplitudeResponse> {
    let channel = on_axis(manoeuvre.control);
    let initial = manoeuvre.sensitivities.iter().find(|one| one.channel == channel)?;
    let (amplitude, value) = match response {
        Response::Initial => (manoeuvre.amplitude, initial.peak),
        // Both signs take part: only the size is known, and the first pulse's sign says which way it went.
        Response::Span => {
            let side = libm::copysign(1.0, manoeuvre.amplitude);
            let span = manoeuvre.span?;
            let answer = libm::copysign(1.0, initial.peak.value);
            (side * manoeuvre.travel, Measured { value: answer * span.value, std: span.std })
        }
    };
    // A travel is the difference of two levels.
    let levels = if response == Response::Span { core::f64::consts::SQRT_2 } else { 1.0 };
    let by_amplitude = value.value / amplitude * manoeuvre.amplitude_std * levels;
    let std = libm::sqrt(value.std * value.std + by_amplitude * by_amplitude);
    (amplitude != 0.0 && std > 0.0).then_some(AmplitudeResponse { amplitude, response: Measured { value: value.value, std } })
}

/// Number of distinct sizes of amplitude.
fn sizes(points: &[AmplitudeResponse]) -> usize {
    let mut all: Vec<f64> = points.iter().map(|point| point.amplitude.abs()).collect();
    all.sort_by(f64::total_cmp);
    let (mut count, mut smallest) = (0, 0.0);
    for size in all {
        if count == 0 || size > smallest * (1.0 + SAME_AMPLITUDE) {
            (count, smallest) = (count + 1, size);
        }
    }
    count
}

/// The line through points of one or both sides, with each test at that level.
///
/// # Errors
/// [`NotEstimable`] where there are fewer than two points or they are of one size.
pub(crate) fn line(points: &[AmplitudeResponse], level: f64) -> Result<ResponseLine, NotEstimable> {
    let least = points.iter().map(|point| point.amplitude.abs()).fold(f64::INFINITY, f64::min);
    let most = points.iter().map(|point| point.amplitude.abs()).fold(0.0, f64::max);
    if points.len() < 2 {
        return Err(NotEstimable::TooFewRuns(points.len(), 2));
    }
    let both = points.iter().any(|p| p.amplitude > 0.0) && points.iter().any(|p| p.amplitude < 0.0);
    let (repeats, inflation) = repeated(points);
    let freedom = PRIOR + repeats;
    let limit = student_limit(level, freedom);
    let tested = |column: &dyn Fn(f64) -> f64| {
        let (found, cov) = two(points, most, column)?;
        let cov = cov.map(|row| row.map(|entry| entry * inflation));
        Some((found, cov))
    };
    let distinct = sizes(points);
    if distinct < 2 {
        return Err(NotEstimable::OneAmplitude(least, most));
    }
    let ([b, c], cov) = tested(&|u| u * u.abs()).ok_or(NotEstimable::OneAmplitude(least, most))?;
    let ([sb, sc], small) = ([libm::sqrt(cov[0][0]), libm::sqrt(cov[1][1])], least / most);
    // Growth is (b + c)/(b + c small): its derivatives by b and c.
    let base = b + c * small;
    let by = [(c * small - c) / (base * base), (b - b * small) / (base * base)];
    let growth_var = by[0] * by[0] * cov[0][0] + 2.0 * by[0] * by[1] * cov[0][1] + by[1] * by[1] * cov[1][1];
    let growth = Measured { value: (b + c) / base, std: libm::sqrt(growth_var) };
    let score = c / sc;
    let curvature = LineTest { found: Measured { value: growth.value - 1.0, std: growth.std }, score, limit };
    let nonlinear = curvature.significant() && (growth.value - 1.0).abs() > MATERIAL;
    let relative = |found: [f64; 2], cov: [[f64; 2]; 2]| {
        let std = libm::sqrt(cov[1][1]);
        LineTest { found: Measured { value: found[1] / found[0], std: std / found[0].abs() }, score: found[1] / std, limit }
    };
    let offset = (distinct >= 3 && !both).then(|| tested(&|_| 1.0)).flatten().map(|(found, cov)| relative(found, cov));
    let asymmetry = both.then(|| tested(&|u: f64| u.abs())).flatten().map(|(found, cov)| {
        let half = relative(found, cov);
        // b + d to the right, b - d to the left.
        let d = half.found.value;
        let found = Measured { value: (1.0 + d) / (1.0 - d) - 1.0, std: 2.0 * half.found.std / ((1.0 - d) * (1.0 - d)) };
        LineTest { found, ..half }
    });
    let slope = if nonlinear {
        Measured { value: b / most, std: sb / most }
    } else {
        let (sxx, sxy) = points.iter().fold((0.0, 0.0), |(a, b), p| {
            let weight = 1.0 / (p.response.std * p.response.std);
            (a + weight * p.amplitude * p.amplitude, b + weight * p.amplitude * p.response.value)
        });
        Measured { value: sxy / sxx, std: libm::sqrt(inflation / sxx) }
    };
    Ok(ResponseLine { slope, growth, curvature, offset, asymmetry, nonlinear })
}

/// Least squares of y on u = x/most and a second column of u.
fn two(points: &[AmplitudeResponse], most: f64, column: &dyn Fn(f64) -> f64) -> Option<([f64; 2], [[f64; 2]; 2])> {
    let (mut m, mut y) = ([[0.0; 2]; 2], [0.0; 2]);
    for point in points {
        let u = point.amplitude / most;
        let row = [u, column(u)];
        let weight = 1.0 / (point.response.std * point.response.std);
        for i in 0..2 {
            for j in 0..2 {
                m[i][j] += weight * row[i] * row[j];
            }
            y[i] += weight * row[i] * point.response.value;
        }
    }
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    if !(determinant > 1e-6 * m[0][0] * m[1][1]) {
        return None;
    }
    let cov = [[m[1][1] / determinant, -m[0][1] / determinant], [-m[1][0] / determinant, m[0][0] / determinant]];
    Some(([cov[0][0] * y[0] + cov[0][1] * y[1], cov[1][0] * y[0] + cov[1][1] * y[1]], cov))
}

/// Degrees of freedom of repeated amplitudes with [`PRIOR`], and the pooled ratio of variances to those stated.
fn repeated(points: &[AmplitudeResponse]) -> (f64, f64) {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
    let (mut freedom, mut squares) = (0.0, 0.0);
    for group in sorted.chunk_by(|a, b| (b.amplitude - a.amplitude).abs() <= SAME_AMPLITUDE * b.amplitude.abs()) {
        if group.len() < 2 {
            continue;
        }
        // Repeats are compared by their gain: their amplitudes differ a little.
        let gains = group.iter().map(|p| (p.response.value / p.amplitude, p.response.std / p.amplitude));
        let (weights, sum) =
            gains.clone().fold((0.0, 0.0), |(w, s), (gain, std)| (w + 1.0 / (std * std), s + gain / (std * std)));
        squares += gains.map(|(gain, std)| (gain - sum / weights) / std).map(|score| score * score).sum::<f64>();
        freedom += (group.len() - 1) as f64;
    }
    (freedom, ((PRIOR + squares) / (PRIOR + freedom)).max(1.0))
}

/// Two-sided limit of Student's t with that probability, of three degrees of freedom or more.
///
/// Source: G. W. Hill, Algorithm 396, Comm. ACM 13 (1970), asymptotic branch; within 0.1 % from 5 degrees up.
pub(crate) fn student_limit(chance: f64, freedom: f64) -> f64 {
    let n = freedom;
    let a = 1.0 / (n - 0.5);
    let b = 48.0 / (a * a);
    let c = ((20700.0 * a / b - 98.0) * a - 16.0) * a + 96.36;
    let d = ((94.5 / (b + c) - 3.0) / b + 1.0) * libm::sqrt(a * PI / 2.0) * n;
    let x = d * chance;
    let y = libm::pow(x, 2.0 / n);
    let y = if y > 0.05 + a {
        let z = -normal_limit(chance);
        let square = z * z;
        let c = if n < 5.0 { c + 0.3 * (n - 4.5) * (z + 0.6) } else { c };
        let c = (((0.05 * d * z - 5.0) * z - 7.0) * z - 2.0) * z + b + c;
        let t = (((((0.4 * square + 6.3) * square + 36.0) * square + 94.5) / c - square - 3.0) / b + 1.0) * z;
        libm::expm1(a * t * t)
    } else {
        ((1.0 / (((n + 6.0) / (n * y) - 0.089 * d - 0.822) * (n + 2.0) * 3.0) + 0.5 / (n + 4.0)) * y - 1.0) * (n + 1.0)
            / (n + 2.0)
            + 1.0 / y
    };
    libm::sqrt(n * y)
}

/// Two-sided limit of a normal variable with that probability, by bisection of the error function.
fn normal_limit(chance: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if libm::erfc(middle / core::f64::consts::SQRT_2) > chance { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::NormalNoise;

    fn points(law: impl Fn(f64) -> f64, amplitudes: &[f64], std: f64, seed: u64) -> Vec<AmplitudeResponse> {
        let mut noise = NormalNoise::new(seed, 3);
        let point = |&x: &f64| AmplitudeResponse { amplitude: x, response: Measured { value: law(x) + std * noise.draw(), std } };
        amplitudes.iter().map(point).collect()
    }

    #[test]
    fn students_limits_are_those_of_the_tables() {
        for (chance, freedom, table) in [
            (0.05, 10.0, 2.228_14),
            (0.01, 10.0, 3.169_27),
            (0.001, 10.0, 4.586_89),
            (0.01, 30.0, 2.750_0),
            (0.002, 12.0, 3.929_6),
        ] {
            let found = student_limit(chance, freedom);
            assert!((found / table - 1.0).abs() < 1e-3, "{chance} {freedom}: {found} for {table}");
        }
    }

    #[test]
    fn saturation_is_detected_with_its_size() {
        let law = |x: f64| 10.0 * x - 250.0 * x * x.abs();
        let found = line(&points(law, &[0.01, 0.02, 0.04], 1e-4, 1), 0.01).unwrap();
        // 0.04 gives 0 and 0.01 predicts 0.3.
        assert!(found.nonlinear && found.growth.value.abs() < 0.01, "{found:?}");
        let law = |x: f64| 10.0 * x - 100.0 * x * x.abs();
        let found = line(&points(law, &[0.01, 0.02], 1e-4, 1), 0.01).unwrap();
        assert!(found.nonlinear && (found.growth.value - 8.0 / 9.0).abs() < 3.0 * found.growth.std, "{found:?}");
    }

    #[test]
    fn left_and_right_differ_and_a_dead_zone_is_an_offset() {
        let law = |x: f64| if x > 0.0 { 11.0 * x } else { 10.0 * x };
        let found = line(&points(law, &[0.01, 0.02, -0.01, -0.02], 1e-4, 2), 0.01).unwrap();
        let asymmetry = found.asymmetry.unwrap();
        assert!(asymmetry.significant() && (asymmetry.found.value - 0.1).abs() < 3.0 * asymmetry.found.std, "{found:?}");
        assert!(!found.nonlinear);
        let found = line(&points(|x| 10.0 * (x - 0.002), &[0.01, 0.02, 0.03, 0.04], 1e-4, 2), 0.01).unwrap();
        let offset = found.offset.unwrap();
        assert!(offset.significant() && (offset.found.value + 0.05).abs() < 0.005, "{offset:?}");
    }

    #[test]
    fn a_linear_response_is_rarely_rejected() {
        let mut called = 0;
        for seed in 0..2000 {
            let amplitudes = [0.01, 0.01, 0.01, 0.02, 0.02, 0.02, 0.04];
            let found = line(&points(|x| 10.0 * x, &amplitudes, 0.01, seed), FALSE_ALARM / 2.0).unwrap();
            called += u32::from(found.curvature.significant() || found.offset.unwrap().significant());
        }
        // 1 % of 2000 is 20 +- 4.4; the prior makes it fewer.
        assert!(called <= 33, "{called}");
        assert!(matches!(line(&points(|x| x, &[0.01, 0.0105], 0.1, 1), 0.01), Err(NotEstimable::OneAmplitude(..))));
        assert!(matches!(line(&points(|x| x, &[0.01], 0.1, 1), 0.01), Err(NotEstimable::TooFewRuns(1, 2))));
    }
}
