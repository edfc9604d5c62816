//! Test of a flight for gross errors of instruments, while it goes on.
//!
//! Consumes every channel's bin means; produces the likeliest gross error by `kinematic_agreement` (2), from windows of
//! `WINDOW_S` that are forgotten over `MEMORY_S`. A window counts where some output moves by more than its noise. The windows
//! of one correction begin 4 bins apart; the corrections take turns, those of one channel together, each beside the windows as
//! recorded that begin with its own.

use super::bin_means::{BIN_S, BinMeans};
use super::gross_error::{GROSS_ERRORS, GrossError};
use super::kinematic_agreement::{
    AGREES, AGREES_PARTLY, Agreement, COMPARED, CorrectionGain, Increments, OUTPUT_CHANNELS, OUTPUTS, OutputRates, SIGNAL,
    THRESHOLD, by_arm, compared_increments, compared_output, contradicts, correction_gain, likeliest, output_rates,
};
use super::kinematic_slope::{Confirmation, KinematicSlope};
use crate::flight::channel::{CHANNELS, Channel, MOTION_CHANNELS};
use crate::flight::run::RunGeometry;

/// Time constant of forgetting, s of windows that count.
const MEMORY_S: f64 = 30.0;
/// Windows of one correction begin so many bins apart, half of their length.
const STRIDE: usize = 4;
/// Bins from the first to the last of a window.
const LENGTH: usize = 2 * STRIDE;
/// Fewer windows say nothing.
const WINDOWS_MIN: f32 = 5.0;
/// Gain from which on an error is suspected.
const SUSPECTED: f64 = 5.0;

/// The compared outputs of which the slope is computed: airspeed, and the shares of ax and ay.
const SLOPES_OF: [usize; 3] = [0, OUTPUTS, OUTPUTS + 1];

/// What the readings of a flight are suspected of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Suspicion {
    /// One of several errors, which these data do not tell apart, or one that is not certain yet.
    Unknown,
    /// An error of these channels, not certain yet or not known which.
    Of(&'static GrossError),
    /// This one.
    Named(&'static GrossError, CorrectionGain),
}

/// Moments of the increments of one output: measured m and m less kinematic d.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    count: f32,
    m: f32,
    mm: f32,
    d: f32,
    dd: f32,
}

impl Moments {
    fn add(&mut self, measured: f64, kinematic: f64, kept: f32) {
        let (m, d) = (measured as f32, (measured - kinematic) as f32);
        self.count = kept * self.count + 1.0;
        self.m = kept * self.m + m;
        self.mm = kept * self.mm + m * m;
        self.d = kept * self.d + d;
        self.dd = kept * self.dd + d * d;
    }

    /// a, where the measured increments exceed their noise.
    fn a(&self, noise_var: f64) -> Option<f64> {
        if self.count < WINDOWS_MIN {
            return None;
        }
        let signal = f64::from(self.mm - self.m * self.m / self.count);
        let difference = f64::from(self.dd - self.d * self.d / self.count);
        (signal > SIGNAL * noise_var * f64::from(self.count) && signal > 0.0).then(|| difference.max(0.0) / signal)
    }
}

type OutputMoments = [Moments; COMPARED];

/// The test.
#[derive(Clone, Debug)]
pub struct GrossErrorTest {
    /// As recorded, by the phase of the windows.
    as_recorded: [OutputMoments; STRIDE],
    corrected: [OutputMoments; GROSS_ERRORS],
    gains: [Option<CorrectionGain>; GROSS_ERRORS],
    slopes: [KinematicSlope; SLOPES_OF.len()],
}

impl GrossErrorTest {
    /// Without windows.
    pub const NEW: GrossErrorTest = {
        const ZERO: OutputMoments = [Moments { count: 0.0, m: 0.0, mm: 0.0, d: 0.0, dd: 0.0 }; COMPARED];
        GrossErrorTest {
            as_recorded: [ZERO; STRIDE],
            corrected: [ZERO; GROSS_ERRORS],
            gains: [None; GROSS_ERRORS],
            slopes: [KinematicSlope::ZERO; SLOPES_OF.len()],
        }
    };

    /// The window whose last bin but one is of that number; `measured` are the channels of the run.
    pub fn window(&mut self, number: i64, means: &[BinMeans; MOTION_CHANNELS], geometry: &RunGeometry) {
        let phase = number.rem_euclid(STRIDE as i64) as usize;
        let window = Window::of(number.saturating_sub(LENGTH as i64), means, geometry);
        let Some(increments) = window.increments(None) else { return };
        for (slope, k) in self.slopes.iter_mut().zip(SLOPES_OF) {
            slope.window(increments[k], MEMORY_S);
        }
        let moves = increments.iter().enumerate().any(|(k, increment)| {
            increment.is_some_and(|(measured, _)| measured * measured > 2.0 * SIGNAL * window.noise_var(k, None))
        });
        if !moves {
            return;
        }
        let kept = libm::exp(-(STRIDE as f64) * BIN_S / MEMORY_S) as f32;
        let Some(moments) = self.as_recorded.get_mut(phase) else { return };
        let as_recorded = taken(moments, &increments, kept, |k| window.noise_var(k, None));
        let windows = f64::from(moments.iter().map(|one| one.count).fold(0.0, f32::max)) * STRIDE as f64 / LENGTH as f64;
        let contradicted = contradicts(&as_recorded);
        for ((error, moments), gain) in GrossError::ALL.iter().zip(&mut self.corrected).zip(&mut self.gains) {
            if error.channels().first().is_none_or(|first| first.index() % STRIDE != phase) {
                continue;
            }
            let Some(increments) = window.increments(Some(error)) else { continue };
            let corrected = taken(moments, &increments, kept, |k| window.noise_var(k, Some(error)));
            // A response to gusts opposes them: a weak agreement with a reversed sign is no evidence in moving air.
            let found = contradicted.then(|| correction_gain(&as_recorded, &corrected, windows)).flatten();
            *gain = found.filter(|found| found.a[1] < AGREES && each_agrees(error, &corrected));
        }
    }

    /// What the shares of ax and ay in airspeed and sideslip tell about their sign and unit. Without confirmation ax is doubted:
    /// it hardly moves the airspeed, and nothing else shows its errors. ay is where its share contradicts.
    pub fn confirmations(&self) -> [Confirmation; 2] {
        let [_, ax, ay] = &self.slopes;
        [
            if ax.confirms() { Confirmation::Confirmed } else { Confirmation::Doubted },
            match (ay.confirms(), ay.contradicts()) {
                (true, _) => Confirmation::Confirmed,
                (_, true) => Confirmation::Doubted,
                _ => Confirmation::Plausible,
            },
        ]
    }

    /// What the flight is suspected of; `None` where the kinematics hold, or no error explains why they do not. An error that
    /// was `named` stays so until another is clearly likelier. Where the weight is right (`weighs_g`) the unit of all
    /// accelerometers is; and the altitude is suspected alone only where the airspeed, from which the climb is computed, is
    /// known to be right.
    pub fn suspicion(&self, named: Option<&'static GrossError>, weighs_g: bool) -> Option<Suspicion> {
        let gains = GrossError::ALL.iter().zip(self.gains).filter_map(|(error, gain)| Some((error, gain?)));
        let best = likeliest::<GROSS_ERRORS>(gains.filter(|(error, _)| !(weighs_g && error.is_unit_of_forces())));
        let (error, found) = *best.first()?;
        if let Some(kept) = best.iter().find(|(other, found)| Some(*other) == named && found.gain > THRESHOLD) {
            return Some(Suspicion::Named(kept.0, kept.1));
        }
        let same = best.iter().all(|(other, _)| other.channels() == error.channels());
        let [airspeed, ..] = &self.slopes;
        match found.gain {
            above if above > SUSPECTED && error.channels() == [Channel::Altitude] && !airspeed.is_one() => {
                Some(Suspicion::Unknown)
            }
            above if above > THRESHOLD && best.len() == 1 => Some(Suspicion::Named(error, found)),
            above if above > SUSPECTED && same => Some(Suspicion::Of(error)),
            above if above > SUSPECTED => Some(Suspicion::Unknown),
            _ => None,
        }
    }
}

/// Adds the increments of a window; a of every output.
fn taken(moments: &mut OutputMoments, increments: &Increments, kept: f32, noise_var: impl Fn(usize) -> f64) -> Agreement {
    core::array::from_fn(|k| {
        let (one, (measured, kinematic)) = (moments.get_mut(k)?, (*increments.get(k)?)?);
        one.add(measured, kinematic, kept);
        one.a(2.0 * noise_var(k))
    })
}

/// Of several reversed signs each has to bear itself out: one that does would take along another that gusts oppose.
fn each_agrees(error: &GrossError, corrected: &Agreement) -> bool {
    let agrees = |channel: &Channel| {
        let output = OUTPUT_CHANNELS.iter().position(|output| output == channel);
        output.and_then(|output| *corrected.get(output)?).is_none_or(|a| a < AGREES_PARTLY)
    };
    !matches!(error, GrossError::Turned(_)) || error.channels().iter().all(agrees)
}

/// Whose reading a channel's is, by index, and times what, with an error corrected.
type Corrections = [(usize, f64); CHANNELS];

fn correction(channel: Channel, error: Option<&GrossError>) -> (usize, f64) {
    let (whose, factor) = error.map_or((channel, 1.0), |error| error.corrected_by(channel));
    (whose.index(), factor)
}

/// `LENGTH` + 1 bins, with one more at either end for the growth of the rates.
struct Window<'a> {
    readings: [[Option<f64>; MOTION_CHANNELS]; LENGTH + 3],
    means: &'a [BinMeans; MOTION_CHANNELS],
    geometry: &'a RunGeometry,
}

impl<'a> Window<'a> {
    /// From the bin of number `first` on.
    fn of(first: i64, means: &'a [BinMeans; MOTION_CHANNELS], geometry: &'a RunGeometry) -> Self {
        let readings = core::array::from_fn(|place| {
            let number = first.saturating_add(place as i64 - 1);
            core::array::from_fn(|channel| means[channel].mean(number))
        });
        Window { readings, means, geometry }
    }

    /// Every channel in a bin, at the centre of mass.
    fn at_centre(&self, corrections: &Corrections, place: usize) -> [Option<f64>; MOTION_CHANNELS] {
        // A reading in a bin, by place in `readings`.
        let raw = |channel: Channel, place: usize| {
            let (whose, factor) = corrections.get(channel.index())?;
            Some(factor * (*self.readings.get(place)?.get(*whose)?)?)
        };
        let rates = |place: usize| {
            let three = [Channel::P, Channel::Q, Channel::R].map(|gyro| raw(gyro, place));
            let [Some(p), Some(q), Some(r)] = three else { return None };
            Some([p, q, r])
        };
        let now = rates(place).unwrap_or([0.0; 3]);
        let speed = raw(Channel::Tas, place).unwrap_or(f64::INFINITY);
        let (vane, accelerometer) = (self.geometry.vane_position_m, self.geometry.accelerometer_position_m);
        let off_centre = accelerometer.iter().any(|place| *place != 0.0);
        let growth = match off_centre.then(|| (rates(place - 1), rates(place + 1))) {
            Some((Some(before), Some(after))) => core::array::from_fn(|i| (after[i] - before[i]) / (2.0 * BIN_S)),
            _ => [0.0; 3],
        };
        let mut all = [None; MOTION_CHANNELS];
        for channel in Channel::ALL.into_iter().take(MOTION_CHANNELS) {
            if let Some(centred) = all.get_mut(channel.index()) {
                let arm = || by_arm(channel, now, growth, speed, vane, accelerometer);
                *centred = raw(channel, place).map(|reading| reading - arm());
            }
        }
        // One that is silent for a while is not zero, as it is taken where there is none at all.
        const AIR_DATA: [Channel; 3] = [Channel::Tas, Channel::Alpha, Channel::Beta];
        let silent =
            |channel: Channel| all[channel.index()].is_none() && self.means.get(channel.index()).is_some_and(BinMeans::has_begun);
        if AIR_DATA.into_iter().any(silent) {
            AIR_DATA.into_iter().for_each(|channel| all[channel.index()] = None);
        }
        all
    }

    /// Measured and kinematic increments from the middle of the first bin to that of the last, these by the trapezoidal rule.
    fn increments(&self, error: Option<&GrossError>) -> Option<Increments> {
        let corrections = Channel::ALL.map(|channel| correction(channel, error));
        let mut ends = [[None; MOTION_CHANNELS]; 2];
        let mut kinematic = OutputRates::ZERO;
        for part in 0..=LENGTH {
            let readings = self.at_centre(&corrections, part + 1);
            let rates = output_rates(|channel| readings.get(channel.index()).copied().flatten())?;
            kinematic.integrate(&rates, if part == 0 || part == LENGTH { 0.5 * BIN_S } else { BIN_S });
            match part {
                0 => ends[0] = readings,
                LENGTH => ends[1] = readings,
                _ => {}
            }
        }
        let measured = OUTPUT_CHANNELS.map(|channel| {
            let end = |end: usize| ends[end].get(channel.index()).copied().flatten();
            Some(end(1)? - end(0)?)
        });
        Some(compared_increments(measured, &kinematic))
    }

    /// Variance of the noise of the reading that shows a compared output.
    fn noise_var(&self, k: usize, error: Option<&GrossError>) -> f64 {
        let channel = compared_output(k);
        let (whose, factor) = correction(channel, error);
        self.means.get(whose).map_or(0.0, |means| factor * factor * means.noise_var())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a rolling motion of 10 s is suspected of, with these factors on p and phi.
    fn suspected(p: f64, phi: f64) -> Option<Suspicion> {
        let mut means = [BinMeans::EMPTY; MOTION_CHANNELS];
        let mut test = GrossErrorTest::NEW;
        for k in 0..500 {
            let time_s = 0.02 * f64::from(k);
            let angle = 0.2 * libm::sin(1.1 * time_s) + 0.1 * libm::sin(2.3 * time_s);
            let rate = 0.22 * libm::cos(1.1 * time_s) + 0.23 * libm::cos(2.3 * time_s);
            let values = [(Channel::P, p * rate), (Channel::Q, 0.0), (Channel::R, 0.0), (Channel::Phi, phi * angle)];
            for (channel, value) in values.into_iter().chain([(Channel::Theta, 0.0)]) {
                means[channel.index()].take(time_s, value, None);
            }
            if k % 5 == 0 && k > 80 {
                test.window(i64::from(k / 5 - 4), &means, &RunGeometry::default());
            }
        }
        test.suspicion(None, false)
    }

    #[test]
    fn a_reversed_rate_and_a_wrong_unit_are_suspected_and_a_right_one_is_not() {
        assert_eq!(suspected(1.0, 1.0), None);
        // Of p and phi alone nothing tells which of the two is reversed.
        assert_eq!(suspected(-1.0, 1.0), Some(Suspicion::Unknown));
        let degrees = 180.0 / core::f64::consts::PI;
        assert!(matches!(suspected(degrees, 1.0), Some(Suspicion::Unknown | Suspicion::Of(_))));
    }

    #[test]
    fn a_factor_that_is_no_unit_is_not_explained() {
        assert_eq!(suspected(3.0, 1.0), None);
    }
}
