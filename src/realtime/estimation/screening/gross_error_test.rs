//! Test of a flight for gross errors of instruments, while it goes on.
//!
//! Consumes every channel's bin means; produces the likeliest gross error by `kinematic_agreement` (2), from windows of
//! `WINDOW_S` that are forgotten over `MEMORY_S`. A window counts where some output moves by more than its noise. The windows
//! of one correction begin 4 bins apart; the corrections take turns, those of one channel together, each beside the windows as
//! recorded that begin with its own.

use super::bin_means::{BIN_S, BinMeans};
use super::confirmation::{AirspeedContradiction, Confirmation, InstrumentSlopes};
use super::gross_error::{GROSS_ERRORS, GrossError};
use super::kinematic_agreement::{
    AGREES, AGREES_PARTLY, Agreement, COMPARED, CorrectionGain, Increments, OUTPUT_CHANNELS, OUTPUTS, OutputRates, SIDESLIP,
    SIGNAL, THRESHOLD, acceleration_increments, by_arm, compared_increments, compared_output, contradicts, correction_gain,
    likeliest, output_rates,
};
use super::moved_by_others::moved_by_others;
use crate::flight::channel::{CHANNELS, Channel, MOTION_CHANNELS};
use crate::flight::run::RunGeometry;

/// Relative rounding of the mean of equal readings.
const ROUNDED: f64 = 1e-9;
/// Time constant of forgetting, s of windows that count.
const MEMORY_S: f64 = 30.0;
/// Windows of one correction begin so many bins apart, half of their length.
const STRIDE: usize = 4;
/// Bins from the first to the last of a window.
const LENGTH: usize = 2 * STRIDE;
/// Fewer windows say nothing.
const WINDOWS_MIN: f32 = 5.0;
/// Windows in a row, one each 0.1 s, after which a channel that stands while others move it does so for good.
const STOOD_WINDOWS: u8 = 8;
/// Gain from which on an error is suspected.
const SUSPECTED: f64 = 5.0;

/// Part of the variance of bank or pitch that the gyros leave, above which the instruments contradict each
/// other; of motion so many times the variance of its noise.
const CONTRADICTED: f64 = 0.9;
const MOVES: f64 = 10.0;
/// Windows in a row, one each 0.1 s, in which they have to.
const CONTRADICTED_WINDOWS: u8 = 20;
/// Part of a sideslip's variance that the kinematics leave, below which it agrees with them as a whole.
const SIDESLIP_LEFT: f64 = 0.1;
/// By how much the correction of an accelerometer must lower that part of the output it contributes to.
const WHOLE_IMPROVES: f64 = 3.0;
/// Part of the variance that the correction of an error that is named leaves at most: one that leaves more, such as a unit of ay
/// for a yaw gyro that is late, explains too little.
const NAMED: f64 = 0.15;
/// Difference of gains within which two errors of different channels cannot be distinguished in flight.
const RIVAL_IN_FLIGHT: f64 = 10.0;

/// What the readings of a flight are suspected of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Suspicion {
    /// One of several errors, which these data do not tell apart, or one that is not certain yet.
    Unknown,
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
    slopes: InstrumentSlopes,
    /// Windows in a row in which bank or pitch contradicted the gyros.
    attitude_contradicted: u8,
    /// Windows in a row in which a channel stood while the kinematics moved it.
    stood: [u8; MOTION_CHANNELS],
}

impl GrossErrorTest {
    /// Without windows.
    pub const NEW: GrossErrorTest = {
        const ZERO: OutputMoments = [Moments { count: 0.0, m: 0.0, mm: 0.0, d: 0.0, dd: 0.0 }; COMPARED];
        GrossErrorTest {
            as_recorded: [ZERO; STRIDE],
            corrected: [ZERO; GROSS_ERRORS],
            gains: [None; GROSS_ERRORS],
            slopes: InstrumentSlopes::NEW,
            attitude_contradicted: 0,
            stood: [0; MOTION_CHANNELS],
        }
    };

    /// The window whose last bin but one is of that number; `steps` are the smallest changes of every channel's readings.
    pub fn window(
        &mut self,
        number: i64,
        means: &[BinMeans; MOTION_CHANNELS],
        steps: &[f64; MOTION_CHANNELS],
        geometry: &RunGeometry,
    ) {
        let phase = number.rem_euclid(STRIDE as i64) as usize;
        let window = Window::of(number.saturating_sub(LENGTH as i64), means, geometry);
        let Some((measured, kinematic)) = window.increments(None) else { return };
        let increments = compared_increments(measured, &kinematic);
        for (channel, stood) in Channel::ALL.into_iter().zip(&mut self.stood) {
            let moved = window.stands(channel) && moved_by_others(channel, &increments, steps, |k| window.noise_var(k, None));
            *stood = if moved { stood.saturating_add(1) } else { 0 };
        }
        self.slopes.window(&increments, acceleration_increments(measured, &kinematic));
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
        self.attitude_contradicted =
            if self.attitude_is_contradicted(means) { self.attitude_contradicted.saturating_add(1) } else { 0 };
        for ((error, moments), gain) in GrossError::ALL.iter().zip(&mut self.corrected).zip(&mut self.gains) {
            if error.channels().first().is_none_or(|first| first.index() % STRIDE != phase) {
                continue;
            }
            let Some((measured, kinematic)) = window.increments(Some(error)) else { continue };
            let increments = compared_increments(measured, &kinematic);
            let corrected = taken(moments, &increments, kept, |k| window.noise_var(k, Some(error)));
            // A response to gusts opposes them: a weak agreement with a reversed sign is no evidence in moving air.
            let found = contradicted.then(|| correction_gain(error, &as_recorded, &corrected, windows)).flatten();
            *gain = found.filter(|found| {
                found.a[1] < AGREES
                    && attitude_agrees(&corrected)
                    && each_shows(error, &as_recorded, &corrected, means)
                    && whole_improves(error, &as_recorded, &corrected)
                    && self.slopes.shows(error)
            });
        }
    }

    /// Whether the channel has stood for long while the kinematics moved it.
    pub fn stood_while_moved(&self, channel: Channel) -> bool {
        self.stood.get(channel.index()).is_some_and(|windows| *windows >= STOOD_WINDOWS)
    }

    /// What the kinematics confirm of ax and ay.
    pub fn accelerometers(&self) -> [Confirmation; 2] {
        let sideslip = self.as_recorded.iter().filter_map(|outputs| outputs.get(SIDESLIP)?.a(0.0));
        self.slopes.accelerometers(sideslip.fold(0.0, f64::max) < SIDESLIP_LEFT)
    }

    /// What the kinematics confirm of the incidence.
    pub fn incidence(&self) -> Confirmation {
        self.slopes.incidence()
    }

    /// What the kinematics confirm of the airspeed, and whether they contradict it.
    pub fn airspeed(&self) -> (Confirmation, Option<AirspeedContradiction>) {
        (self.slopes.airspeed(), self.slopes.airspeed_contradiction())
    }

    /// By how much the airspeed reads too much or too little, relative to the truth, where still air shows it.
    pub fn airspeed_scale_error(&self) -> Option<f64> {
        self.slopes.airspeed_scale_error()
    }

    /// What the flight is suspected of; `None` where the kinematics hold, or only those of air that may move do not. After an
    /// error was `named` only the same of more or fewer channels can be. Where the weight is right (`weighs_g`) the unit of
    /// az is; and the altitude is suspected alone only where the airspeed, from which the climb is computed, is known to be
    /// right.
    pub fn suspicion(&self, named: Option<&'static GrossError>, weighs_g: bool) -> Option<Suspicion> {
        let gains = GrossError::ALL.iter().zip(self.gains).filter_map(|(error, gain)| Some((error, gain?)));
        let testable = |error: &GrossError| named.is_none_or(|named| error.is_part_of(named) || named.is_part_of(error));
        let gains = gains.filter(|(error, _)| testable(error));
        let best =
            likeliest::<GROSS_ERRORS>(gains.filter(|(error, _)| !(weighs_g && error.is_unit_of_weight())), RIVAL_IN_FLIGHT);
        if let Some(kept) = best.iter().find(|(other, found)| Some(*other) == named && found.gain > THRESHOLD) {
            return Some(Suspicion::Named(kept.0, kept.1));
        }
        let contradicted = self.attitude_contradicted >= CONTRADICTED_WINDOWS;
        let Some(&(likeliest, found)) = best.first() else {
            return contradicted.then_some(Suspicion::Unknown);
        };
        // Where all of them are one error of more or fewer channels, that of the fewest is certain.
        let fewest = best.iter().min_by_key(|(error, _)| error.channels().len())?;
        let nested = best.iter().all(|(error, _)| fewest.0.is_part_of(error));
        match found.gain {
            above if above > SUSPECTED && likeliest.channels() == [Channel::Altitude] && !self.slopes.airspeed_is_right() => {
                Some(Suspicion::Unknown)
            }
            above if above > THRESHOLD && nested && fewest.1.a[1] < NAMED => Some(Suspicion::Named(fewest.0, fewest.1)),
            above if above > SUSPECTED || contradicted => Some(Suspicion::Unknown),
            _ => None,
        }
    }

    /// Whether bank or pitch as recorded contradict the gyros, at every phase of the windows: no air moves these.
    fn attitude_is_contradicted(&self, means: &[BinMeans; MOTION_CHANNELS]) -> bool {
        // That of an increment of the noisier of the two.
        let noise_var = [Channel::Phi, Channel::Theta]
            .into_iter()
            .filter_map(|channel| means.get(channel.index()))
            .fold(0.0, |most, means| f64::max(most, 2.0 * means.noise_var()));
        let by = |output: Channel| {
            let place = OUTPUT_CHANNELS.iter().position(|other| *other == output);
            place.is_some_and(|place| {
                let of = |outputs: &OutputMoments| outputs.get(place).and_then(|moments| moments.a(MOVES * noise_var));
                self.as_recorded.iter().all(|outputs| of(outputs).is_some_and(|a| a > CONTRADICTED))
            })
        };
        by(Channel::Phi) || by(Channel::Theta)
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

/// Whether nothing contradicts the kinematics of the attitude, which no air moves, once an error is corrected: where something
/// does, the error does not explain the flight.
fn attitude_agrees(corrected: &Agreement) -> bool {
    let attitude = OUTPUT_CHANNELS
        .iter()
        .zip(corrected)
        .filter(|(output, _)| matches!(output, Channel::Phi | Channel::Theta | Channel::Psi));
    attitude.filter_map(|(_, a)| *a).all(|a| a < AGREES_PARTLY)
}

/// Of an error of several channels each that is measured has to contradict the kinematics in its own output, and to agree once it
/// is corrected: an instrument that agrees as recorded, or whose output does not move, has no part in it. A rate and its angle,
/// reversed together, agree with each other; the flow angles show them.
fn each_shows(error: &GrossError, as_recorded: &Agreement, corrected: &Agreement, means: &[BinMeans; MOTION_CHANNELS]) -> bool {
    let shown_by = |channel: &Channel| match channel {
        Channel::P => Channel::Phi,
        Channel::Q => Channel::Theta,
        Channel::R => Channel::Psi,
        other => *other,
    };
    let shows = |channel: &Channel| {
        let shown_by = shown_by(channel);
        let Some(output) = OUTPUT_CHANNELS.iter().position(|output| *output == shown_by) else { return true };
        let is_measured = means.get(shown_by.index()).is_some_and(BinMeans::has_begun);
        let of = |agreement: &Agreement| agreement.get(output).copied().flatten();
        !is_measured || of(as_recorded).is_some_and(|a| a > AGREES_PARTLY) && of(corrected).is_some_and(|a| a < AGREES_PARTLY)
    };
    let mut outputs = error.channels().iter().map(shown_by);
    let first = outputs.next();
    let is_of_one_output = outputs.all(|output| Some(output) == first);
    is_of_one_output || matches!(error, GrossError::Swapped(_)) || error.channels().iter().all(shows)
}

/// The share of ax or ay alone, which is small, says little where the place of a vane is not known: the correction has to make
/// the whole output agree better.
fn whole_improves(error: &GrossError, as_recorded: &Agreement, corrected: &Agreement) -> bool {
    let whole = match error {
        GrossError::Turned([Channel::Ax]) | GrossError::Unit([Channel::Ax], ..) => 0,
        GrossError::Turned([Channel::Ay])
        | GrossError::Unit([Channel::Ay], ..)
        | GrossError::Swapped([Channel::Ax, Channel::Ay]) => SIDESLIP,
        _ => return true,
    };
    let both = as_recorded.get(whole).copied().flatten().zip(corrected.get(whole).copied().flatten());
    both.is_some_and(|(before, after)| before > WHOLE_IMPROVES * after)
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

    /// Whether a channel has the same mean in every bin, to rounding.
    fn stands(&self, channel: Channel) -> bool {
        let mean = |place: usize| self.readings.get(place).and_then(|bin| *bin.get(channel.index())?);
        let Some(first) = mean(1) else { return false };
        (2..=LENGTH + 1).all(|place| mean(place).is_some_and(|mean| (mean - first).abs() <= ROUNDED * first.abs()))
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

    /// Measured increments of the outputs from the middle of the first bin to that of the last, and the integral of their
    /// kinematic rates by the trapezoidal rule.
    fn increments(&self, error: Option<&GrossError>) -> Option<([Option<f64>; OUTPUTS], OutputRates)> {
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
        Some((measured, kinematic))
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
                test.window(i64::from(k / 5 - 4), &means, &[0.0; MOTION_CHANNELS], &RunGeometry::default());
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
        assert!(suspected(degrees, 1.0) == Some(Suspicion::Unknown));
    }

    #[test]
    fn a_factor_that_is_no_unit_is_named_by_nobody_but_contradicts() {
        assert_eq!(suspected(3.0, 1.0), Some(Suspicion::Unknown));
    }
}
