//! A damped sine fitted to several channels at once, each with its own amplitude, phase, offset and drift.
//!
//! Consumes channels on a mesh of bins (time from the start, s, and value); produces frequency and damping with standard errors.
//!     y_c(t) = a_c exp(-s t) cos(w t) + b_c exp(-s t) sin(w t) + o_c + d_c t                          (1)
//!     omega = sqrt(s^2 + w^2),  zeta = s / omega                                                      (2)
//! (s, w) are shared. For given (s, w) the others are linear, by orthogonal columns; (s, w) come from a grid search and then
//! Gauss-Newton steps on residuals projected off those columns (variable projection, Kaufman's approximation). Channels are
//! weighted by their residual, readings by Huber's weights. Covariance by the projected sensitivities U and autocorrelated
//! residuals v,
//!     M = U' W U,   cov = M^-1 [sum_ij U_i' W_i E(v_i v_j') W_j U_j] M^-1                             (3)
//! with tapered autocovariances of all channels to half a period, and at least the jackknife over the C channels, since other
//! modes contribute to each channel differently,
//!     var >= (C - 1)/C sum_c (x_(c) - mean x_(.))^2                                                   (4)
//! Source: G. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 1973; L. Kaufman, BIT 15, 1975; P. J. Huber, Ann. Math. Stat. 35,
//! 1964; (3) E. A. Morelli and V. Klein, J. Guidance 20(1), 1997; (4) B. Efron, SIAM CBMS 38, 1982.
//! Returns `None` for fewer than [`NODES_MIN`] bins, or where no oscillation fits.

use super::record::Measured;
use crate::num::cholesky;
use crate::num::product::dot;
use core::f64::consts::PI;

pub(crate) const NODES_MIN: usize = 24;
/// Huber's limit, in scales of the residual.
const HUBER: f64 = 2.5;
const COLUMNS: usize = 4;
/// Least pivot, over its diagonal entry.
const PIVOT: f64 = 1e-11;

/// A channel's bins: time from the start of the stretch, s, and value, where there is one.
pub(crate) type Bins = Vec<Option<(f64, f64)>>;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DampedSine {
    /// Undamped frequency, rad/s.
    pub(crate) omega: Measured,
    pub(crate) zeta: Measured,
    /// Decay s, 1/s.
    pub(crate) decay: f64,
    /// Damped frequency w, rad/s.
    pub(crate) damped: f64,
    pub(crate) channels: Vec<ChannelFit>,
    /// Weighted part of the variance about the drift that the sine explains.
    pub(crate) explained: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ChannelFit {
    /// a, b, offset, drift of (1).
    pub(crate) coefficients: [f64; COLUMNS],
    /// Robust root mean square of the residual.
    pub(crate) residual: f64,
}

impl ChannelFit {
    /// Amplitude at the start.
    pub(crate) fn size(&self) -> f64 {
        let [a, b, _, _] = self.coefficients;
        libm::sqrt(a * a + b * b)
    }
}

/// Bins of one channel with their weights.
struct Lane {
    bins: Bins,
    weights: Vec<f64>,
    scale: f64,
}

/// Projected sensitivities of one channel to s and w, and its residual, at every bin; `None` of an empty one.
type Rows = Vec<Option<([f64; 2], f64)>>;

fn basis(s: f64, w: f64, t: f64, length_s: f64) -> [f64; COLUMNS] {
    let (sin, cos) = libm::sincos(w * t);
    let envelope = libm::exp(-s * t);
    [envelope * cos, envelope * sin, 1.0, t / length_s - 0.5]
}

/// Solves the small symmetric system; `None` where it is singular to working accuracy.
fn solve<const N: usize>(mut m: [[f64; N]; N], mut y: [f64; N]) -> Option<[f64; N]> {
    cholesky::factor(m.as_flattened_mut(), N, PIVOT).ok()?;
    cholesky::solve(m.as_flattened(), N, &mut y);
    Some(y)
}

impl Lane {
    fn cells(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        self.bins.iter().zip(&self.weights).filter_map(|(bin, weight)| bin.map(|(t, x)| (t, x, *weight)))
    }

    fn count(&self) -> f64 {
        self.bins.iter().flatten().count() as f64
    }

    /// Linear coefficients for (s, w) and the weighted sum of squared residuals; offset and drift alone where `None`.
    fn linear(&self, sw: Option<(f64, f64)>, length_s: f64) -> Option<([f64; COLUMNS], f64)> {
        let (mut m, mut y, mut total) = ([[0.0; COLUMNS]; COLUMNS], [0.0; COLUMNS], 0.0);
        for (t, x, weight) in self.cells() {
            let row = match sw {
                Some((s, w)) => basis(s, w, t, length_s),
                None => [0.0, 0.0, 1.0, t / length_s - 0.5],
            };
            for (line, &a) in m.iter_mut().zip(&row) {
                for (entry, &b) in line.iter_mut().zip(&row) {
                    *entry += weight * a * b;
                }
            }
            for (entry, &a) in y.iter_mut().zip(&row) {
                *entry += weight * a * x;
            }
            total += weight * x * x;
        }
        if sw.is_none() {
            m[0][0] = 1.0;
            m[1][1] = 1.0;
        }
        let found = solve(m, y)?;
        let left = total - found.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        Some((found, left.max(0.0)))
    }

    /// Sensitivities projected off the linear columns, and residuals.
    fn rows(&self, s: f64, w: f64, length_s: f64) -> Option<(Rows, [f64; COLUMNS])> {
        let (found, _) = self.linear(Some((s, w)), length_s)?;
        let [a, b, _, _] = found;
        let slopes = |t: f64, row: &[f64; COLUMNS]| {
            let [c, d, _, _] = *row;
            [-t * (a * c + b * d), t * (b * c - a * d)]
        };
        let project = |which: usize| {
            let lane = Lane {
                bins: self.bins.iter().map(|bin| bin.map(|(t, _)| (t, slopes(t, &basis(s, w, t, length_s))[which]))).collect(),
                weights: self.weights.clone(),
                scale: 1.0,
            };
            lane.linear(Some((s, w)), length_s).map(|(found, _)| found)
        };
        let (by_s, by_w) = (project(0)?, project(1)?);
        let rows = self.bins.iter().map(|bin| {
            bin.map(|(t, x)| {
                let row = basis(s, w, t, length_s);
                let [ds, dw] = slopes(t, &row);
                ([ds - dot(&row, &by_s), dw - dot(&row, &by_w)], x - dot(&row, &found))
            })
        });
        Some((rows.collect(), found))
    }
}

/// The damped sine that fits best with a damped frequency in the range, rad/s; `None` where there is too little to fit, or
/// the channels hold none.
pub(crate) fn fit(channels: &[Bins], slowest: f64, fastest: f64) -> Option<DampedSine> {
    let nodes = channels.iter().map(Vec::len).max().unwrap_or(0);
    let length_s = channels.iter().flatten().flatten().map(|(t, _)| *t).fold(0.0, f64::max);
    if nodes < NODES_MIN || !(fastest > slowest) || !(length_s > 0.0) {
        return None;
    }
    let mut lanes: Vec<Lane> = channels
        .iter()
        .map(|bins| Lane { bins: bins.clone(), weights: vec![1.0; bins.len()], scale: 1.0 })
        .filter(|lane| lane.count() >= NODES_MIN as f64)
        .collect();
    if lanes.len() < channels.len() {
        return None;
    }
    let mut still = 0.0;
    for lane in &mut lanes {
        let (_, left) = lane.linear(None, length_s)?;
        still += f64::from(left > 0.0);
        lane.scale = libm::sqrt(left / lane.count()).max(f64::MIN_POSITIVE);
        lane.weights.fill(1.0 / (lane.scale * lane.scale));
    }
    if still < lanes.len() as f64 {
        return None;
    }
    let mut at = search(&lanes, slowest, fastest, length_s)?;
    for round in 0..4 {
        at = refine(&lanes, at, length_s, 0.5 * slowest, 1.3 * fastest)?;
        if round == 0 {
            // The grid search is repeated with the new weights: another minimum may be the lowest.
            reweigh(&mut lanes, at, length_s)?;
            let again = search(&lanes, slowest, fastest, length_s)?;
            if cost(&lanes, again, length_s) < cost(&lanes, at, length_s) {
                at = again;
            }
        } else {
            reweigh(&mut lanes, at, length_s)?;
        }
    }
    result(&lanes, at, length_s)
}

fn cost(lanes: &[Lane], sw: (f64, f64), length_s: f64) -> f64 {
    lanes.iter().map(|lane| lane.linear(Some(sw), length_s).map_or(f64::INFINITY, |(_, left)| left)).sum()
}

fn search(lanes: &[Lane], slowest: f64, fastest: f64, length_s: f64) -> Option<(f64, f64)> {
    let mut best: Option<(f64, (f64, f64))> = None;
    // Minima are as wide as one over the record's length.
    let step = (PI / (3.0 * length_s)).max((fastest - slowest) / 150.0);
    let mut w = slowest;
    while w <= fastest {
        for zeta in [-0.15, -0.03, 0.03, 0.1, 0.2, 0.35, 0.55, 0.75] {
            let s = zeta / libm::sqrt(1.0 - zeta * zeta) * w;
            if s * length_s > -4.0 {
                let left = cost(lanes, (s, w), length_s);
                if left.is_finite() && best.is_none_or(|(least, _)| left < least) {
                    best = Some((left, (s, w)));
                }
            }
        }
        w += step;
    }
    best.map(|(_, sw)| sw)
}

/// Normal matrix and right-hand side of a Gauss-Newton step.
type Normal = ([[f64; 2]; 2], [f64; 2]);

fn normal<'a>(lanes: impl IntoIterator<Item = &'a Lane>, sw: (f64, f64), length_s: f64) -> Option<Normal> {
    let (mut m, mut y) = ([[0.0; 2]; 2], [0.0; 2]);
    for lane in lanes {
        let (rows, _) = lane.rows(sw.0, sw.1, length_s)?;
        for (row, weight) in rows.iter().zip(&lane.weights) {
            let Some((u, residual)) = row else { continue };
            for (i, a) in u.iter().enumerate() {
                for (j, b) in u.iter().enumerate() {
                    m[i][j] += weight * a * b;
                }
                y[i] += weight * a * residual;
            }
        }
    }
    Some((m, y))
}

fn refine(lanes: &[Lane], start: (f64, f64), length_s: f64, slowest: f64, fastest: f64) -> Option<(f64, f64)> {
    let mut at = start;
    let mut least = cost(lanes, at, length_s);
    for _ in 0..40 {
        let (m, y) = normal(lanes, at, length_s)?;
        let [ds, dw] = solve(m, y)?;
        let mut factor = 1.0;
        let mut moved = false;
        while factor > 1e-3 {
            let next = (at.0 + factor * ds, at.1 + factor * dw);
            let left = cost(lanes, next, length_s);
            if (slowest..=fastest).contains(&next.1) && next.0 * length_s > -6.0 && left < least {
                (at, least, moved) = (next, left, true);
                break;
            }
            factor *= 0.5;
        }
        if !moved || factor * (ds.abs() + dw.abs()) < 1e-9 {
            break;
        }
    }
    Some(at)
}

/// Weights by each channel's residual and Huber's rule.
fn reweigh(lanes: &mut [Lane], at: (f64, f64), length_s: f64) -> Option<()> {
    for lane in lanes {
        let (rows, _) = lane.rows(at.0, at.1, length_s)?;
        let mut sizes: Vec<f64> = rows.iter().flatten().map(|(_, residual)| residual.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let count = sizes.len() as f64;
        let freedom = count / (count - COLUMNS as f64 - 1.0).max(1.0);
        let squares = sizes.iter().map(|size| size * size).sum::<f64>() / count;
        let middle = crate::flight::signal::trace::median_of_sorted(&sizes) / 0.6745;
        // The median is no scale of coarsely quantised readings.
        let scale = libm::sqrt(freedom) * if middle > 0.0 { middle.max(0.5 * libm::sqrt(squares)) } else { libm::sqrt(squares) };
        lane.scale = scale.max(1e-12 * lane.scale).max(f64::MIN_POSITIVE);
        for (weight, row) in lane.weights.iter_mut().zip(&rows) {
            let size = row.map_or(0.0, |(_, residual)| residual.abs());
            *weight = (HUBER * lane.scale / size.max(f64::MIN_POSITIVE)).min(1.0) / (lane.scale * lane.scale);
        }
    }
    Some(())
}

fn result(lanes: &[Lane], at: (f64, f64), length_s: f64) -> Option<DampedSine> {
    let (s, w) = at;
    let (m, _) = normal(lanes, at, length_s)?;
    let mut scored: Vec<Rows> = Vec::new();
    let mut channels = Vec::new();
    let (mut with, mut without) = (0.0, 0.0);
    for lane in lanes {
        let (rows, found) = lane.rows(s, w, length_s)?;
        let freedom = lane.count() / (lane.count() - COLUMNS as f64 - 2.0 / lanes.len() as f64).max(1.0);
        let weighted = |row: &Option<([f64; 2], f64)>, weight: &f64| {
            row.map(|(u, residual)| (u.map(|entry| entry * weight), residual * libm::sqrt(freedom)))
        };
        scored.push(rows.iter().zip(&lane.weights).map(|(row, weight)| weighted(row, weight)).collect());
        let [a, b, offset, drift] = found;
        let coefficients = [a, b, offset - 0.5 * drift, drift / length_s];
        channels.push(ChannelFit { coefficients, residual: lane.scale });
        with += lane.linear(Some(at), length_s)?.1;
        without += lane.linear(None, length_s)?.1;
    }
    let nodes = scored.iter().map(Vec::len).max()?;
    let lags = ((PI / w / length_s * nodes as f64) as usize).clamp(1, nodes / 6);
    // The fit has absorbed the residuals' power at its own frequency; their spectrum there, smoothed over these lags, is too
    // small by about this factor.
    let taken = 1.0 / (1.0 - 2.5 * lags as f64 / nodes as f64);
    let middle = autocorrelated(&scored, lags).map(|row| row.map(|entry| entry * taken));
    let inverse = [solve(m, [1.0, 0.0])?, solve(m, [0.0, 1.0])?];
    let cov = |i: usize, j: usize| -> f64 {
        let pairs = (0..2).flat_map(|k| (0..2).map(move |l| (k, l)));
        pairs.map(|(k, l)| inverse[i][k] * middle[k][l] * inverse[l][j]).sum()
    };
    // At least that of white residuals: a negative correlation by chance does not lower it.
    let floor = |i: usize, j: usize| inverse[i][j];
    let omega = libm::sqrt(s * s + w * w);
    let by = |ds: f64, dw: f64| {
        let coloured = ds * ds * cov(0, 0) + 2.0 * ds * dw * cov(0, 1) + dw * dw * cov(1, 1);
        let white = ds * ds * floor(0, 0) + 2.0 * ds * dw * floor(0, 1) + dw * dw * floor(1, 1);
        libm::sqrt(coloured.max(white).max(0.0))
    };
    let cube = omega * omega * omega;
    let [omega_apart, zeta_apart] = jackknife_std(lanes, at, length_s);
    Some(DampedSine {
        omega: Measured { value: omega, std: by(s / omega, w / omega).max(omega_apart) },
        zeta: Measured { value: s / omega, std: by(w * w / cube, -s * w / cube).max(zeta_apart) },
        decay: s,
        damped: w,
        channels,
        explained: 1.0 - with / without,
    })
}

/// Root of (4) for omega and zeta, each channel omitted by one Gauss-Newton step from the joint fit; zero of one channel.
fn jackknife_std(lanes: &[Lane], at: (f64, f64), length_s: f64) -> [f64; 2] {
    let without = |c: usize| -> Option<[f64; 2]> {
        let rest = lanes.iter().enumerate().filter(|(place, _)| *place != c).map(|(_, lane)| lane);
        let (m, y) = normal(rest, at, length_s)?;
        let [ds, dw] = solve(m, y)?;
        let (s, w) = (at.0 + ds, at.1 + dw);
        let omega = libm::sqrt(s * s + w * w);
        Some([omega, s / omega])
    };
    let found: Vec<[f64; 2]> = (0..lanes.len()).filter(|_| lanes.len() > 1).filter_map(without).collect();
    let count = found.len() as f64;
    [0, 1].map(|which| {
        let mean = found.iter().map(|one| one[which]).sum::<f64>() / count;
        let squares = found.iter().map(|one| (one[which] - mean) * (one[which] - mean)).sum::<f64>();
        if found.len() > 1 { libm::sqrt(squares * (count - 1.0) / count) } else { 0.0 }
    })
}

/// The inner sum of (3), lags of all channels against all.
fn autocorrelated(scored: &[Rows], lags: usize) -> [[f64; 2]; 2] {
    let mut sum = [[0.0; 2]; 2];
    for (c, one) in scored.iter().enumerate() {
        for (d, other) in scored.iter().enumerate() {
            for lag in 0..=lags {
                let pairs = || one.iter().zip(other.iter().skip(lag)).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
                let (count, products) = pairs().fold((0.0, 0.0), |(n, sum), (a, b)| (n + 1.0, sum + a.1 * b.1));
                if count < 8.0 || (lag == 0 && d < c) {
                    continue;
                }
                let taper = 1.0 - lag as f64 / (lags + 1) as f64;
                let covariance = taper * products / count;
                // Every pair of different bins or channels counts both ways.
                let once = lag == 0 && c == d;
                for ((u, _), (v, _)) in pairs() {
                    for (i, line) in sum.iter_mut().enumerate() {
                        for (j, entry) in line.iter_mut().enumerate() {
                            *entry += covariance * if once { u[i] * v[j] } else { u[i] * v[j] + v[i] * u[j] };
                        }
                    }
                }
            }
        }
    }
    sum
}
