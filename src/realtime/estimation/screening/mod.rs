//! Screening of the instruments during the flight: gross errors (unit, sign, wiring), frozen, clipped and dead channels.
//!
//! In: every admitted sample. Out: what was found, as events; readings that stand still are taken out of the sample, and while
//! an instrument is suspected of a gross error the regression has no numbers.
//! Assumed: the kinematics of a rigid body in still air; gusts contradict them too, but no correction then explains it.

pub mod bin_means;
pub mod confirmation;
pub mod constant_readings;
pub mod gross_error;
pub mod gross_error_test;
pub mod kinematic_agreement;
pub mod kinematic_slope;
pub mod moved_by_others;

use self::bin_means::{BIN_S, BinMeans, SILENCE_S};
use self::confirmation::{AirspeedContradiction, Confirmation};
use self::constant_readings::ConstantReadings;
use self::gross_error::{GrossError, error_by_weight, weighs_g};
use self::gross_error_test::{GrossErrorTest, Suspicion};
use crate::flight::channel::{Channel, MOTION_CHANNELS};
use crate::flight::control::CONTROLS;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use core::f64::consts::PI;

/// Part of a channel beyond the limits from which its unit is in question, and least number of such readings.
const UNIT_PART: f64 = 0.05;
const UNIT_COUNT: u32 = 3;
/// Bank and pitch of upright flight, rad.
const UPRIGHT_RAD: f64 = 1.0;
/// Bins of az before its mean is taken for the weight.
const WEIGHED_BINS: u32 = 20;
/// Tests in a row, one each 0.1 s, that have to name the same error.
const NAMED_TESTS: u32 = 20;
/// Bins after a channel stood in which no gross error is named.
const AFTER_STANDING: i64 = 300;
/// Tests in a row from which on the unit of the airspeed is in doubt.
const DOUBTED_TESTS: u32 = 5;
/// Tests for which a suspicion lasts after the last one that has it: between two of them an error is no less there.
const SUSPECTED_TESTS: u32 = 20;

/// Largest reading of a gyro, rad/s, and of an accelerometer, m/s^2, up to which it has not moved yet: one that stands still on
/// the ground is in order.
const MOVED_LEAST: [f64; 2] = [0.02, 0.3];

/// Channels whose values are counted: of the motion, then the controls, as in [`Channel::ALL`]. What no equation rests on
/// silences none.
const SCREENED: usize = MOTION_CHANNELS + CONTROLS;

/// What the screening noticed at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScreeningEvent {
    /// This gross error explains the contradiction with the kinematics: R2 of the increments that show it, once it is corrected.
    GrossError(&'static GrossError, f64),
    /// A channel has begun to stand still.
    StandsStill(Channel),
}

/// Why no number can be relied on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// Some instrument, not known which.
    Unknown,
    /// Because of this gross error.
    GrossError(&'static GrossError),
    /// This channel: too many of its readings are beyond what any aircraft reaches, or its unit contradicts the kinematics.
    Channel(Channel),
}

impl Doubt {
    /// The first channel that it is of; `None` where it is not known which.
    pub fn channel(&self) -> Option<Channel> {
        match self {
            Doubt::Unknown => None,
            Doubt::GrossError(error) => error.channels().first().copied(),
            Doubt::Channel(channel) => Some(*channel),
        }
    }
}

/// Screening of one flight.
#[derive(Clone, Debug)]
pub struct Screening {
    means: [BinMeans; MOTION_CHANNELS],
    constant: ConstantReadings,
    test: GrossErrorTest,
    /// Number of the newest bin that has been tested.
    tested: Option<i64>,
    /// Channels that stand still, a bit each.
    standing: u32,
    /// Controls that have stood, a bit each.
    controls_stood: u32,
    /// Largest reading of each gyro, rad/s, and accelerometer, m/s^2, by `Channel::INERTIAL`, and whether it has stood since it
    /// moved.
    largest_reading: [f64; Channel::INERTIAL.len()],
    inertial_stood: [bool; Channel::INERTIAL.len()],
    /// Number of the bin in which one of the motion's stood last.
    stood_at: Option<i64>,
    /// Readings, and those beyond the limits.
    readings: [u32; SCREENED],
    beyond: [u32; SCREENED],
    doubt: Option<Doubt>,
    /// The error that was the only likely one at the last tests, and at how many.
    likely: Option<(&'static GrossError, u32)>,
    /// Sum of az over bins of upright flight, and their number.
    az: (f64, u32),
    /// By `Confirmation::CHANNELS`; what was confirmed stays so until an instrument is in doubt.
    confirmations: [Confirmation; Confirmation::CHANNELS.len()],
    /// How many of the last tests contradicted the airspeed's unit.
    airspeed_contradicted: u32,
    /// Tests for which the last suspicion still lasts.
    suspected: u32,
}

impl Screening {
    /// Before the first sample.
    pub const NEW: Screening = Screening {
        means: [BinMeans::EMPTY; MOTION_CHANNELS],
        constant: ConstantReadings::NEW,
        test: GrossErrorTest::NEW,
        tested: None,
        standing: 0,
        controls_stood: 0,
        largest_reading: [0.0; Channel::INERTIAL.len()],
        inertial_stood: [false; Channel::INERTIAL.len()],
        stood_at: None,
        readings: [0; SCREENED],
        beyond: [0; SCREENED],
        doubt: None,
        likely: None,
        az: (0.0, 0),
        confirmations: {
            use Confirmation::{Doubted, NotComparable};
            [Doubted, NotComparable, NotComparable, NotComparable, NotComparable]
        },
        airspeed_contradicted: 0,
        suspected: 0,
    };

    /// A reading beyond what any aircraft reaches, which admission has taken out.
    pub fn out_of_range(&mut self, channel: Channel) {
        if let Some(count) = self.beyond.get_mut(channel.index()) {
            *count = count.saturating_add(1);
        }
    }

    /// Takes readings that stand still out of the sample and tests the others; events go to `notice`.
    pub fn step(&mut self, sample: &mut Sample, geometry: &RunGeometry, mut notice: impl FnMut(ScreeningEvent)) {
        let motion = Channel::ALL.into_iter().take(MOTION_CHANNELS);
        for channel in motion.chain(Channel::CONTROLS) {
            let Some(value) = sample.get(channel) else { continue };
            let mark = 1 << channel.index();
            let stands = self.constant.take(channel, sample.time_s, value);
            self.note_standing(channel, value, stands);
            if stands {
                if self.standing & mark == 0 {
                    self.standing |= mark;
                    notice(ScreeningEvent::StandsStill(channel));
                }
                sample.clear(channel);
                if channel.index() < MOTION_CHANNELS {
                    self.stood_at = self.tested;
                } else {
                    self.controls_stood |= mark;
                }
                continue;
            }
            self.standing &= !mark;
            let turn = matches!(channel, Channel::Phi | Channel::Psi).then_some(2.0 * PI);
            if let Some(count) = self.readings.get_mut(channel.index()) {
                *count = count.saturating_add(1);
            }
            if let Some(means) = self.means.get_mut(channel.index()) {
                means.take(sample.time_s, value, turn);
            }
        }
        // The bin after the window is complete too.
        let newest = (libm::floor((sample.time_s - SILENCE_S) / BIN_S) as i64).saturating_sub(2);
        if self.tested.is_none_or(|tested| newest != tested) {
            self.tested = Some(newest);
            let mean = |channel: Channel| self.means.get(channel.index()).and_then(|means| means.mean(newest));
            if let Some(az) = mean(Channel::Az) {
                // Inverted flight weighs the other way, and so would an attitude in another unit.
                let is_upright = |channel: Channel| mean(channel).is_none_or(|angle| angle.abs() < UPRIGHT_RAD);
                if is_upright(Channel::Phi) && is_upright(Channel::Theta) {
                    self.az = (self.az.0 + az, self.az.1.saturating_add(1));
                }
            }
            self.test.window(newest, &self.means, &self.constant.steps(), geometry);
            for channel in Channel::ALL.into_iter().take(MOTION_CHANNELS).filter(|one| self.test.stood_while_moved(*one)) {
                self.constant.declare(channel);
            }
            self.judge(notice);
        }
    }

    /// Notes a gyro or an accelerometer that stands still after it has moved.
    fn note_standing(&mut self, channel: Channel, value: f64, stands: bool) {
        let least = MOVED_LEAST[usize::from(Channel::ACCELEROMETERS.contains(&channel))];
        let inertial = Channel::INERTIAL.into_iter().zip(self.largest_reading.iter_mut().zip(&mut self.inertial_stood));
        for (_, (largest, stood)) in inertial.filter(|(one, _)| *one == channel) {
            *largest = largest.max(value.abs());
            *stood |= stands && *largest > least;
        }
    }

    fn judge(&mut self, mut notice: impl FnMut(ScreeningEvent)) {
        let named = match self.doubt {
            Some(Doubt::GrossError(error)) => Some(error),
            _ => None,
        };
        let suspicion = self.test.suspicion(named, self.mean_az().is_some_and(weighs_g));
        let after_standing = self.tested.zip(self.stood_at).is_some_and(|(now, at)| now.saturating_sub(at) < AFTER_STANDING);
        // The last readings before an instrument was found to stand are among the increments; readings beyond the limits are not.
        let beyond = self.beyond_limits();
        let by_kinematics = self
            .certain(suspicion)
            .filter(|(error, _)| !after_standing && beyond.is_none_or(|channel| error.channels().contains(&channel)));
        let by_weight = self.error_of_weight().map(|error| (error, 1.0));
        // What has been named stays named while nothing else is.
        let found = by_weight.or(by_kinematics).or(named.map(|error| (error, 1.0)));
        let (airspeed, contradicted) = self.test.airspeed();
        self.airspeed_contradicted = if contradicted.is_some() { self.airspeed_contradicted.saturating_add(1) } else { 0 };
        self.suspected = if suspicion.is_some() { SUSPECTED_TESTS } else { self.suspected.saturating_sub(1) };
        self.doubt = match (found, beyond) {
            (Some((error, r_squared)), _) => {
                if named != Some(error) {
                    notice(ScreeningEvent::GrossError(error, r_squared));
                }
                Some(Doubt::GrossError(error))
            }
            (_, Some(channel)) => Some(Doubt::Channel(channel)),
            _ if self.suspected > 0 => Some(Doubt::Unknown),
            _ if self.airspeed_contradicted >= DOUBTED_TESTS => Some(match contradicted {
                Some(AirspeedContradiction::Airspeed) => Doubt::Channel(Channel::Tas),
                _ => Doubt::Unknown,
            }),
            _ => None,
        };
        let [ax, ay] = self.test.accelerometers();
        let az = if self.mean_az().is_some_and(weighs_g) { Confirmation::Confirmed } else { Confirmation::NotComparable };
        let found_wrong = self.doubt.is_some_and(|doubt| doubt != Doubt::Unknown);
        let scale_is_off = self.test.airspeed_scale_error().is_some();
        let now = [ax, ay, az, airspeed, self.test.incidence()];
        for ((kept, now), channel) in self.confirmations.iter_mut().zip(now).zip(Confirmation::CHANNELS) {
            // Sign and unit do not change in flight: once confirmed is enough, unless something is found to be wrong after all. A
            // suspicion that passes is none: in gusts there are such.
            // The factor of an airspeed in the right unit is known later than the unit.
            if *kept != Confirmation::Confirmed || found_wrong || channel == Channel::Tas && scale_is_off {
                *kept = now;
            }
        }
    }

    /// The error that the last tests all named, and its R2; counts this test.
    fn certain(&mut self, suspicion: Option<Suspicion>) -> Option<(&'static GrossError, f64)> {
        let Some(Suspicion::Named(error, gain)) = suspicion else {
            self.likely = None;
            return None;
        };
        let before = self.likely.filter(|(before, _)| *before == error).map_or(0, |(_, tests)| tests);
        self.likely = Some((error, before.saturating_add(1)));
        (before.saturating_add(1) >= NAMED_TESTS).then_some((error, 1.0 - gain.a[1]))
    }

    /// The error of az by its mean.
    fn error_of_weight(&self) -> Option<&'static GrossError> {
        self.mean_az().and_then(error_by_weight)
    }

    /// Mean of az, m/s^2, once it is one of long enough.
    fn mean_az(&self) -> Option<f64> {
        let (sum, bins) = self.az;
        (bins >= WEIGHED_BINS).then(|| sum / f64::from(bins))
    }

    /// A channel of which too many readings are beyond what any aircraft reaches.
    fn beyond_limits(&self) -> Option<Channel> {
        let counts = Channel::ALL.into_iter().zip(self.beyond.iter().zip(&self.readings));
        let mut beyond = counts.filter(|(_, (beyond, readings))| {
            let all = f64::from(**beyond) + f64::from(**readings);
            **beyond >= UNIT_COUNT && f64::from(**beyond) > UNIT_PART * all
        });
        beyond.next().map(|(channel, _)| channel)
    }

    /// Why no number can be relied on.
    pub fn doubt(&self) -> Option<Doubt> {
        self.doubt
    }

    /// Controls that have stood: clipped or frozen. The first readings of a clip are taken for motion, so it is remembered.
    pub fn controls_stood(&self) -> [bool; 4] {
        Channel::CONTROLS.map(|channel| self.controls_stood & (1 << channel.index()) != 0)
    }

    /// Gyros and accelerometers that have stood after they moved, clipped or frozen, in the order of `Channel::INERTIAL`: the
    /// last readings before it was noticed, and the rate of change across the gap, are wrong.
    pub fn inertial_stood(&self) -> [bool; Channel::INERTIAL.len()] {
        self.inertial_stood
    }

    /// What is known about sign and unit, by `Confirmation::CHANNELS`; the weight tells those of az.
    pub fn confirmations(&self) -> [Confirmation; Confirmation::CHANNELS.len()] {
        self.confirmations
    }

    /// Whether the channel stands still.
    pub fn stands_still(&self, channel: Channel) -> bool {
        self.standing & (1 << channel.index()) != 0
    }
}
