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
}

impl Sums {
    fn plus(mut self, other: &Sums, sign: f64) -> Self {
        self.count += sign * other.count;
        self.z += sign * other.z;
        self.zz += sign * other.zz;
        self.noise += sign * other.noise;
        for which in 0..2 {
            self.e[which] += sign * other.e[which];
            self.ee[which] += sign * other.ee[which];
            self.yy[which] += sign * other.yy[which];
            self.whitened[which] += sign * other.whitened[which];
        }
        self
    }

    fn moments(&self, which: usize) -> PredictionMoments {
        let square = |xx: f64| (xx / self.count).max(0.0);
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
    });
    let pooled = |belongs: &dyn Fn(Channel) -> bool| {
        let places: Vec<usize> =
            (0..channels.len()).filter(|&place| belongs(channels[place]) && whole[place].whitened[0].is_finite()).collect();
        if places.is_empty() {
            return None;
        }
        let pool = |sums: &[Sums], which: usize| {
            // A channel without samples in a draw is not pooled there.
            let parts = places.iter().map(|&place| &sums[place]).filter(|sums| sums.count > 0.5);
            let (sum, count) =
                parts.fold((0.0, 0.0), |(sum, count), sums| (sum + sums.whitened[which] / sums.count, count + 1.0));
            libm::sqrt(f64::max(sum, 0.0) / count)
        };
        let estimate = |figure: &dyn Fn(&[Sums]) -> f64| IntervalEstimate {
            value: figure(&whole),
            interval: interval(draws.iter().map(|draw| figure(draw)).collect()),
        };
        Some(PooledImprovement {
            channels: places.iter().map(|&place| channels[place]).collect(),
            rms: [0, 1].map(|which| estimate(&|sums| pool(sums, which))),
            ratio: estimate(&|sums| ratio(pool(sums, 1), pool(sums, 0))),
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

/// after/before, 1 where both are zero.
fn ratio(after: f64, before: f64) -> f64 {
    if before > 0.0 || after > 0.0 { after / before } else { 1.0 }
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
        Sums {
            count: 1.0,
            z: self.z,
            zz: self.z * self.z,
            noise: variance,
            e: self.e,
            ee,
            yy: squared(self.y),
            whitened: ee.map(|ee| if variance > 0.0 { ee / variance } else { f64::INFINITY }),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A channel with these errors before and after, at 50 Hz; z = sin t.
    fn pair(channel: Channel, errors: [&dyn Fn(f64) -> f64; 2], seconds: f64) -> [FreeRunPrediction; 2] {
        let times_s: Vec<f64> = (0..=(50.0 * seconds) as usize).map(|place| 0.02 * place as f64).collect();
        errors.map(|error| {
            let measured: Vec<f64> = times_s.iter().map(|&time_s| libm::sin(time_s)).collect();
            let predicted = times_s.iter().zip(&measured).map(|(&time_s, z)| z - error(time_s)).collect();
            let one = PredictedChannel {
                channel,
                times_s: times_s.clone(),
                measured,
                predicted,
                offset: 0.0,
                at_trim: 0.0,
                noise_std: 0.1,
            };
            FreeRunPrediction {
                channels: vec![one],
                not_predicted: Vec::new(),
                effects: Vec::new(),
                diverged_at_s: None,
                range_s: [0.0, seconds],
            }
        })
    }

    #[test]
    fn figures_are_those_of_the_closed_form() {
        // Over whole turns: rms of sin is 1/sqrt 2; an error 0.2 sin t leaves 1 - 0.04 of the variance, y = 0.8 sin t.
        let turns = 8.0 * core::f64::consts::PI;
        let [before, after] = pair(Channel::R, [&|t| 0.2 * libm::sin(t), &|t| 0.02 * libm::sin(t)], turns);
        let gain = improvement(&[(&before, &after)]);
        let [one] = gain.channels.as_slice() else { panic!("{gain:?}") };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 2e-3, "{a} is not {b}");
        close(one.rms[0].value, 0.2 * core::f64::consts::FRAC_1_SQRT_2);
        close(one.theil[0].value, 0.2 / 1.8);
        close(one.vaf[0].value, 0.96);
        close(one.vaf[1].value, 1.0 - 0.0004);
        close(one.ratio.value, 0.1);
        // The errors go together, so every draw has the same ratio.
        close(one.ratio.interval[1] - one.ratio.interval[0], 0.0);
        assert_eq!((one.ratio.verdict(), one.samples), (ImprovementVerdict::Gain, before.channels[0].times_s.len()));
        let pooled = gain.pooled.unwrap();
        close(pooled.rms[0].value, 2.0 * core::f64::consts::FRAC_1_SQRT_2);
        assert_eq!(pooled.channels, [Channel::R]);
        assert!(gain.airspeed.is_none() && gain.altitude.is_none());
    }

    /// Errors that are the other's half a block later: no gain, however many samples there are.
    #[test]
    fn the_same_error_at_another_time_is_no_gain() {
        let wave = |t: f64| libm::sin(0.7 * t) + libm::sin(1.9 * t + 1.0);
        let [before, after] = pair(Channel::Tas, [&wave, &|t| wave(t + 5.0)], 40.0);
        let gain = improvement(&[(&before, &after)]);
        let ratio = gain.airspeed.unwrap().ratio;
        assert_eq!(ratio.verdict(), ImprovementVerdict::NoGain, "{ratio:?}");
        assert!(ratio.interval[1] - ratio.interval[0] > 0.05, "{ratio:?}");
        assert!(gain.pooled.is_none());
    }

    /// The interval of an rms of independent errors is that of chi-square: about 1 +- 1.96 / sqrt(2 N).
    #[test]
    fn the_interval_of_white_errors_is_as_wide_as_it_should_be() {
        let mut noise = NormalNoise::new(5, 0);
        let draws: Vec<f64> = (0..=5000).map(|_| noise.draw()).collect();
        let error = |t: f64| draws[libm::round(t * 50.0) as usize];
        let [before, after] = pair(Channel::P, [&error, &error], 100.0);
        let gain = improvement(&[(&before, &after)]);
        let rms = gain.channels[0].rms[0];
        let wanted = 2.0 * 1.96 * rms.value / libm::sqrt(2.0 * 5001.0);
        let found = rms.interval[1] - rms.interval[0];
        assert!((found / wanted - 1.0).abs() < 0.35, "{found} is not {wanted}");
        assert_eq!(gain.channels[0].ratio.verdict(), ImprovementVerdict::NoGain);
        assert!((gain.channels[0].ratio.value - 1.0).abs() < 1e-15);
    }

    #[test]
    fn both_are_taken_up_to_where_one_diverged_and_a_bias_is_absolute() {
        let [mut before, mut after] = pair(Channel::Phi, [&|_| 0.3, &|_| 0.1], 20.0);
        before.diverged_at_s = Some(10.0);
        after.effects.push(Effect::SensorBias { channel: Channel::Phi, value: 0.2 });
        (before.channels[0].offset, after.channels[0].offset) = (0.3, 0.1);
        let with = improvement(&[(&before, &after)]);
        assert!(with.channels[0].absolute && (with.channels[0].ratio.value - 1.0 / 3.0).abs() < 1e-9);
        assert_eq!(with.channels[0].samples, 501);
        after.effects.clear();
        let without = improvement(&[(&before, &after)]);
        assert!(without.channels[0].rms[0].value < 1e-9 && !without.channels[0].absolute);
    }
}
