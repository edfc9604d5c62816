//! Improvement of one model's predictions over another's, with bootstrap intervals.
//!
//! Consumes pairs of free runs of the same recordings, before and after a change of the model; produces for each channel, over
//! all runs, with the prediction error e, and measurement z and prediction y as deviations from the run's own trim, the measures
//! of `metrics` and the ratio of the rms after to that before; pooled over channels, each over its noise
//! standard deviation sigma,
//!     P = sqrt(mean over channels of mean e^2/sigma^2)                                                  (1)
//! and the ratio of P. Altitude and airspeed, whose errors accumulate with time, are pooled separately. A channel without noise
//! is not pooled. Where the change includes a bias of a channel, its errors are absolute, before and after.
//!
//! Intervals are by the moving-block bootstrap: blocks of [`BLOCK_S`], drawn with replacement from each run, which preserve the
//! autocorrelation of the errors, all channels of a block together. Bounds are the 2.5 and 97.5 per cent points of [`DRAWS`]
//! draws from a fixed seed. A ratio whose interval includes 1 is not an improvement.
//! Where one of a pair diverges, both are compared up to there. Statistics that are not defined are NaN.
//! Source: H. R. Kuensch, Ann. Stat. 17(3), 1989, for the blocks.

use super::free_run::{FreeRunPrediction, PredictedChannel};
use super::metrics::PredictionMoments;
use crate::flight::channel::Channel;
use crate::flight::effect::Effect;
use crate::num::random::NormalNoise;

/// Length of a block, s.
pub const BLOCK_S: f64 = 2.0;

/// Number of bootstrap draws of an interval.
pub const DRAWS: usize = 500;

/// Grid of the starts of blocks, s.
const CELL_S: f64 = 0.1;

const SEED: u64 = 1;

/// Relative change of the error below which it is negligible.
const NEGLIGIBLE: f64 = 0.02;

/// A number with its bootstrap interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntervalEstimate {
    /// Estimate from the whole sample.
    pub value: f64,
    /// Its 2.5 and 97.5 per cent points.
    pub interval: [f64; 2],
}

/// Verdict on a ratio of errors after to before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImprovementVerdict {
    /// The whole interval lies below 1.
    Gain,
    /// The interval includes 1.
    NoGain,
    /// The whole interval lies above 1.
    Loss,
}

impl IntervalEstimate {
    /// Whether a ratio of errors differs from one by less than two per cent.
    pub fn is_negligible(&self) -> bool {
        libm::fabs(self.value - 1.0) < NEGLIGIBLE
    }

    /// Whether a ratio of errors says that what was changed is wrong.
    pub fn is_refuted(&self) -> bool {
        self.verdict() == ImprovementVerdict::Loss && !self.is_negligible()
    }

    /// Verdict on a ratio of an error after to one before.
    pub fn verdict(&self) -> ImprovementVerdict {
        let [low, high] = self.interval;
        if high < 1.0 {
            ImprovementVerdict::Gain
        } else if low > 1.0 {
            ImprovementVerdict::Loss
        } else {
            ImprovementVerdict::NoGain
        }
    }
}

/// One channel over all runs; pairs are before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelImprovement {
    /// Channel.
    pub channel: Channel,
    /// Number of samples.
    pub samples: usize,
    /// Standard deviation of its instrument's noise, rms over the runs, the channel's unit.
    pub noise_std: f64,
    /// Whether errors are of absolute values.
    pub absolute: bool,
    /// Root mean square of the error, the channel's unit.
    pub rms: [IntervalEstimate; 2],
    /// Theil's inequality coefficient.
    pub theil: [IntervalEstimate; 2],
    /// Variance accounted for, at most 1; NaN where the measurement is constant.
    pub vaf: [IntervalEstimate; 2],
    /// rms after over rms before.
    pub ratio: IntervalEstimate,
    /// Root mean square of the change of the error, e after - e before, in standard deviations of the noise.
    pub change_rms: f64,
}

/// Channels pooled, each over its noise.
#[derive(Clone, Debug, PartialEq)]
pub struct PooledImprovement {
    /// Pooled channels.
    pub channels: Vec<Channel>,
    /// (1) before and after.
    pub rms: [IntervalEstimate; 2],
    /// After over before.
    pub ratio: IntervalEstimate,
    /// (1) of the change of the error, e after - e before.
    pub change_rms: f64,
}

impl ChannelImprovement {
    /// The ratio of the errors where the change of the predictions is right.
    pub fn expected_ratio(&self) -> f64 {
        expected_ratio(self.change_rms * self.noise_std, self.rms[0].value)
    }
}

impl PooledImprovement {
    /// The ratio of the errors where the change of the predictions is right.
    pub fn expected_ratio(&self) -> f64 {
        expected_ratio(self.change_rms, self.rms[0].value)
    }

    /// Whether the runs do not tell: the interval holds 1, and what the ratio would be if the change were right.
    pub fn is_not_seen(&self) -> bool {
        self.ratio.verdict() == ImprovementVerdict::NoGain && self.expected_ratio() >= self.ratio.interval[0]
    }
}

/// Where the change d of the predictions is right, it is in the error before and in nothing else, so that
/// E after^2 = E before^2 - mean d^2.
fn expected_ratio(change_rms: f64, before_rms: f64) -> f64 {
    let part = change_rms / before_rms;
    libm::sqrt((1.0 - part * part).max(0.0))
}

/// Improvement over some runs.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields are what their names say")]
pub struct Improvement {
    pub channels: Vec<ChannelImprovement>,
    /// All but altitude and airspeed; `None` where no channel has noise to divide by.
    pub pooled: Option<PooledImprovement>,
    pub airspeed: Option<PooledImprovement>,
    pub altitude: Option<PooledImprovement>,
}

/// Sums over the samples of one channel in some time.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    z: f64,
    zz: f64,
    noise: f64,
    e: [f64; 2],
    ee: [f64; 2],
    yy: [f64; 2],
    /// Of e^2 over the noise's variance.
    whitened: [f64; 2],
    /// Of (e after - e before)^2 over the noise's variance.
    whitened_change: f64,
}

impl Sums {
    fn plus(mut self, other: &Sums, sign: f64) -> Self {
        self.count += sign * other.count;
        self.z += sign * other.z;
        self.zz += sign * other.zz;
        self.noise += sign * other.noise;
        self.whitened_change += sign * other.whitened_change;
        for which in 0..2 {
            self.e[which] += sign * other.e[which];
            self.ee[which] += sign * other.ee[which];
            self.yy[which] += sign * other.yy[which];
            self.whitened[which] += sign * other.whitened[which];
        }
        self
    }

    fn moments(&self, which: usize) -> PredictionMoments {
        // A difference of sums may fall below zero by rounding; of no samples there is no mean.
        let square = |xx: f64| if self.count > 0.0 { (xx / self.count).max(0.0) } else { f64::NAN };
        let variance = |x: f64, xx: f64| xx / self.count - (x / self.count) * (x / self.count);
        PredictionMoments {
            error_square: square(self.ee[which]),
            measured_square: square(self.zz),
            predicted_square: square(self.yy[which]),
            error_variance: variance(self.e[which], self.ee[which]),
            measured_variance: variance(self.z, self.zz),
        }
    }
}

/// One pair's sums: for each channel, those of all cells before each cell.
struct Cells {
    /// By channel place, then cell; one more than there are cells.
    before: Vec<Vec<Sums>>,
    cells: usize,
}

/// Improvement from the first of each pair to the second.
pub fn improvement(pairs: &[(&FreeRunPrediction, &FreeRunPrediction)]) -> Improvement {
    let mut channels: Vec<Channel> = Vec::new();
    for channel in Channel::ALL {
        let there = |prediction: &FreeRunPrediction| prediction.channels.iter().any(|one| one.channel == channel);
        if pairs.iter().any(|(before, after)| there(before) && there(after)) {
            channels.push(channel);
        }
    }
    let absolute: Vec<bool> = channels.iter().map(|&channel| pairs.iter().any(|(_, after)| biased(after, channel))).collect();
    let runs: Vec<Cells> = pairs.iter().map(|(before, after)| cells(&channels, &absolute, before, after)).collect();
    let whole: Vec<Sums> = (0..channels.len())
        .map(|place| {
            runs.iter().fold(Sums::default(), |sum, run| run.before[place].last().map_or(sum, |last| sum.plus(last, 1.0)))
        })
        .collect();
    let draws = draws(&runs, channels.len());
    let of_channel = |place: usize, figure: &dyn Fn(&Sums) -> f64| IntervalEstimate {
        value: figure(&whole[place]),
        interval: interval(draws.iter().map(|draw| figure(&draw[place])).collect()),
    };
    let gains = channels.iter().enumerate().map(|(place, &channel)| ChannelImprovement {
        channel,
        samples: whole[place].count as usize,
        noise_std: libm::sqrt(whole[place].noise / whole[place].count),
        absolute: absolute[place],
        rms: [0, 1].map(|which| of_channel(place, &|sums| sums.moments(which).rms())),
        theil: [0, 1].map(|which| of_channel(place, &|sums| sums.moments(which).theil())),
        vaf: [0, 1].map(|which| of_channel(place, &|sums| sums.moments(which).vaf())),
        ratio: of_channel(place, &|sums| ratio(sums.moments(1).rms(), sums.moments(0).rms())),
        change_rms: libm::sqrt((whole[place].whitened_change / whole[place].count).max(0.0)),
    });
    let pooled = |belongs: &dyn Fn(Channel) -> bool| {
        let places: Vec<usize> =
            (0..channels.len()).filter(|&place| belongs(channels[place]) && whole[place].whitened[0].is_finite()).collect();
        if places.is_empty() {
            return None;
        }
        let pool_of = |sums: &[Sums], whitened: &dyn Fn(&Sums) -> f64| {
            // A channel without samples in a draw is not pooled there.
            let parts = places.iter().map(|&place| &sums[place]).filter(|sums| sums.count > 0.5);
            let (sum, count) = parts.fold((0.0, 0.0), |(sum, count), sums| (sum + whitened(sums) / sums.count, count + 1.0));
            if count > 0.0 { libm::sqrt(f64::max(sum, 0.0) / count) } else { f64::NAN }
        };
        let pool = |sums: &[Sums], which: usize| pool_of(sums, &|sums| sums.whitened[which]);
        let estimate = |figure: &dyn Fn(&[Sums]) -> f64| IntervalEstimate {
            value: figure(&whole),
            interval: interval(draws.iter().map(|draw| figure(draw)).collect()),
        };
        Some(PooledImprovement {
            channels: places.iter().map(|&place| channels[place]).collect(),
            rms: [0, 1].map(|which| estimate(&|sums| pool(sums, which))),
            ratio: estimate(&|sums| ratio(pool(sums, 1), pool(sums, 0))),
            change_rms: pool_of(&whole, &|sums| sums.whitened_change),
        })
    };
    Improvement {
        pooled: pooled(&|channel| channel != Channel::Tas && channel != Channel::Altitude),
        airspeed: pooled(&|channel| channel == Channel::Tas),
        altitude: pooled(&|channel| channel == Channel::Altitude),
        channels: gains.collect(),
    }
}

fn biased(prediction: &FreeRunPrediction, wanted: Channel) -> bool {
    prediction.effects.iter().any(|effect| matches!(effect, Effect::SensorBias { channel, .. } if *channel == wanted))
}

/// after/before, 1 where both are zero, and none where one of them is none.
fn ratio(after: f64, before: f64) -> f64 {
    if before > 0.0 || after > 0.0 || before.is_nan() || after.is_nan() { after / before } else { 1.0 }
}

/// The sums of a pair, cell by cell.
fn cells(channels: &[Channel], absolute: &[bool], before: &FreeRunPrediction, after: &FreeRunPrediction) -> Cells {
    let [start_s, last_s] = before.range_s;
    let until_s = [before, after].iter().filter_map(|one| one.diverged_at_s).fold(last_s, f64::min);
    let cells = (libm::ceil((until_s - start_s) / CELL_S) as usize).max(1);
    let sums = channels.iter().zip(absolute).map(|(&channel, &absolute)| {
        let find = |prediction: &FreeRunPrediction| prediction.channels.iter().find(|one| one.channel == channel).cloned();
        let mut own = vec![Sums::default(); cells];
        if let (Some(before), Some(after)) = (find(before), find(after)) {
            let variance = before.noise_std * before.noise_std;
            for row in rows(&before, &after, absolute).take_while(|row| row.time_s <= until_s) {
                let cell = (((row.time_s - start_s) / CELL_S) as usize).min(cells - 1);
                own[cell] = own[cell].plus(&row.sums(variance), 1.0);
            }
        }
        let mut sum = Sums::default();
        let mut up_to = vec![sum];
        up_to.extend(own.iter().map(|own| {
            sum = sum.plus(own, 1.0);
            sum
        }));
        up_to
    });
    Cells { before: sums.collect(), cells }
}

struct Row {
    time_s: f64,
    z: f64,
    e: [f64; 2],
    y: [f64; 2],
}

impl Row {
    fn sums(&self, variance: f64) -> Sums {
        let squared = |x: [f64; 2]| x.map(|x| x * x);
        let ee = squared(self.e);
        let over_variance = |square: f64| if variance > 0.0 { square / variance } else { f64::INFINITY };
        Sums {
            count: 1.0,
            z: self.z,
            zz: self.z * self.z,
            noise: variance,
            e: self.e,
            ee,
            yy: squared(self.y),
            whitened: ee.map(over_variance),
            whitened_change: over_variance((self.e[1] - self.e[0]) * (self.e[1] - self.e[0])),
        }
    }
}

/// Samples of both, which have the same times up to where one ends.
fn rows<'p>(before: &'p PredictedChannel, after: &'p PredictedChannel, absolute: bool) -> impl Iterator<Item = Row> + 'p {
    let measured_at_trim = before.at_trim + before.offset;
    let errors = before.errors(absolute).zip(after.errors(absolute));
    let measured = before.times_s.iter().zip(&before.measured);
    measured.zip(before.predicted.iter().zip(&after.predicted)).zip(errors).map(
        move |(((&time_s, &z), (&y_before, &y_after)), (e_before, e_after))| Row {
            time_s,
            z: z - measured_at_trim,
            e: [e_before, e_after],
            y: [y_before - before.at_trim, y_after - after.at_trim],
        },
    )
}

/// Sums by channel of each draw of blocks.
fn draws(runs: &[Cells], channels: usize) -> Vec<Vec<Sums>> {
    let mut noise = NormalNoise::new(SEED, 0);
    let block = (BLOCK_S / CELL_S) as usize;
    (0..DRAWS)
        .map(|_| {
            let mut sums = vec![Sums::default(); channels];
            for run in runs {
                let length = block.min(run.cells);
                for _ in 0..run.cells.div_ceil(length) {
                    let places = run.cells - length + 1;
                    let start = ((noise.uniform() * places as f64) as usize).min(places - 1);
                    for (sum, before) in sums.iter_mut().zip(&run.before) {
                        if let (Some(from), Some(to)) = (before.get(start), before.get(start + length)) {
                            *sum = sum.plus(to, 1.0).plus(from, -1.0);
                        }
                    }
                }
            }
            sums
        })
        .collect()
}

/// 2.5 and 97.5 per cent points of the finite values.
fn interval(mut values: Vec<f64>) -> [f64; 2] {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let place = libm::round(part * values.len().saturating_sub(1) as f64) as usize;
        values.get(place).copied().unwrap_or(f64::NAN)
    };
    [at(0.025), at(0.975)]
}
