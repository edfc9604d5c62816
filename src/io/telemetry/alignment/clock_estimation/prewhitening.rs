//! Two records on equal bins of time, without their trends, made white by one common filter.
//!
//! Consumes samples; each bin of width D holds the mean of the line through them, or nothing where there was no sample in it or
//! next to it. A line is taken out of each record, each is divided by its standard deviation, and the coefficients of
//!     e_i = x_i - sum_(j = 1 .. p) a_j x_(i-j)                                                         (1)
//! are fitted to both by least squares. One filter for both keeps their delay, and white noise has no correlation of its own
//! that could be taken for a relation. What is larger than three medians is limited to that, so that one event does not
//! outweigh the rest of the record.
//! Source: G. E. P. Box and G. M. Jenkins, Time Series Analysis, 1970, prewhitening before cross-correlation.

use crate::flight::signal::series::Series;
use crate::num::dense::Dense;

/// p, where there are bins enough.
const ORDER: usize = 12;
/// Bins for each coefficient at least.
const BINS_PER_COEFFICIENT: usize = 20;
/// Largest size that counts, medians.
const LIMIT: f64 = 3.0;
/// A gap is so many usual intervals long.
const GAP_INTERVALS: f64 = 3.5;

/// Means of bins; `None` where a gap is.
#[derive(Clone, Debug)]
pub(super) struct BinnedRecord {
    pub(super) from_s: f64,
    pub(super) bins: Vec<Option<f64>>,
}

impl BinnedRecord {
    /// Bins of that width from so late on, without their trend, of unit variance; `None` of a signal that does not move.
    pub(super) fn of(series: &Series, width_s: f64, late_s: f64) -> Option<Self> {
        let (from_s, to_s) = series.range_s()?;
        let from_s = from_s + late_s;
        let count = libm::floor((to_s - from_s) / width_s) as usize;
        let mut bins: Vec<Option<f64>> =
            (0..count).map(|i| Some(series.mean(from_s + i as f64 * width_s, from_s + (i + 1) as f64 * width_s))).collect();
        for (gap_from_s, gap_to_s) in series.gaps(from_s - late_s, (GAP_INTERVALS * series.interval_s()?).max(width_s)) {
            let first = libm::floor((gap_from_s - from_s) / width_s).max(0.0) as usize;
            let last = (libm::ceil((gap_to_s - from_s) / width_s).max(0.0) as usize).min(count);
            bins.get_mut(first..last)?.fill(None);
        }
        without_trend(&mut bins)?;
        Some(BinnedRecord { from_s, bins })
    }
}

/// Takes the line of least squares out and divides by the standard deviation.
fn without_trend(bins: &mut [Option<f64>]) -> Option<()> {
    let mut sums = [0.0; 5];
    let middle = 0.5 * bins.len() as f64;
    for (i, x) in bins.iter().enumerate().filter_map(|(i, bin)| Some((i as f64 - middle, (*bin)?))) {
        for (sum, term) in sums.iter_mut().zip([1.0, i, i * i, x, i * x]) {
            *sum += term;
        }
    }
    let [n, i, ii, x, ix] = sums;
    let determinant = n * ii - i * i;
    if !(determinant > 0.0) {
        return None;
    }
    let (slope, mean) = ((n * ix - i * x) / determinant, (ii * x - i * ix) / determinant);
    let mut square = 0.0;
    for (i, bin) in bins.iter_mut().enumerate() {
        if let Some(x) = bin {
            *x -= mean + slope * (i as f64 - middle);
            square += *x * *x;
        }
    }
    let std = libm::sqrt(square / n);
    // What rounding leaves of a constant is no signal.
    if !(std > 1e-12 * libm::fabs(mean)) || !(std > 0.0) {
        return None;
    }
    bins.iter_mut().flatten().for_each(|x| *x /= std);
    Some(())
}

/// (1) of both, zero where a bin that it needs is empty.
#[derive(Clone, Debug)]
pub(super) struct WhitePair {
    pub(super) ours: Vec<f64>,
    pub(super) theirs: Vec<f64>,
    /// p of (1).
    pub(super) order: usize,
    /// What the correlation that is left in each makes of the variance of a sum of their products, at least 1.
    pub(super) inflation: f64,
}

/// Fits and applies (1); `None` of records that are too short.
pub(super) fn whitened(ours: &BinnedRecord, theirs: &BinnedRecord) -> Option<WhitePair> {
    let filled = |record: &BinnedRecord| record.bins.iter().flatten().count();
    let order = ORDER.min(filled(ours).min(filled(theirs)) / BINS_PER_COEFFICIENT);
    if order == 0 {
        return None;
    }
    let (mut normal, mut right) = (Dense::zeros(order, order), Dense::zeros(order, 1));
    for record in [ours, theirs] {
        // Both count alike, whatever their lengths.
        let weight = 1.0 / filled(record).max(1) as f64;
        for window in record.bins.windows(order + 1).filter_map(whole) {
            for j in 0..order {
                right[(j, 0)] += weight * window[order] * window[order - 1 - j];
                for k in 0..order {
                    normal[(j, k)] += weight * window[order - 1 - j] * window[order - 1 - k];
                }
            }
        }
    }
    // A noise floor of one part in a million of the power keeps very smooth signals solvable.
    for j in 0..order {
        normal[(j, j)] *= 1.0 + 1e-6;
    }
    let coefficients = normal.cholesky()?.solve_factored(&right);
    let white = |record: &BinnedRecord| -> Vec<f64> {
        let mut out = vec![0.0; record.bins.len()];
        for (e, window) in out.iter_mut().skip(order).zip(record.bins.windows(order + 1)) {
            if let Some(x) = whole(window) {
                *e = x[order] - (0..order).map(|j| coefficients[(j, 0)] * x[order - 1 - j]).sum::<f64>();
            }
        }
        out
    };
    let (ours, theirs) = (limited(white(ours)), limited(white(theirs)));
    let lags = (3 * order).min(ours.len().min(theirs.len()) / 4);
    let inflation = 1.0 + 2.0 * (1..=lags).map(|lag| autocorrelation(&ours, lag) * autocorrelation(&theirs, lag)).sum::<f64>();
    Some(WhitePair { ours, theirs, order, inflation: inflation.max(1.0) })
}

/// Limits what is far from usual, so that one event does not outweigh the rest of the record.
fn limited(mut x: Vec<f64>) -> Vec<f64> {
    let mut sizes: Vec<f64> = x.iter().map(|x| libm::fabs(*x)).filter(|size| *size > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    if let Some(median) = sizes.get(sizes.len() / 2) {
        let limit = LIMIT * median;
        x.iter_mut().for_each(|x| *x = x.clamp(-limit, limit));
    }
    x
}

fn whole(window: &[Option<f64>]) -> Option<[f64; ORDER + 1]> {
    let mut out = [0.0; ORDER + 1];
    for (x, bin) in out.iter_mut().zip(window) {
        *x = (*bin)?;
    }
    Some(out)
}

fn autocorrelation(x: &[f64], lag: usize) -> f64 {
    let square: f64 = x.iter().map(|x| x * x).sum();
    if square > 0.0 { x.iter().zip(x.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>() / square } else { 0.0 }
}
