//! The published vocabulary of state estimation: state, innovation, smoothed regressors, events.

pub use super::aid_kind::{AIDS, Aid};
use super::config::Noise;
pub use super::screening::Doubt;
pub use super::screening::confirmation::Confirmation;
pub use super::screening::gross_error::GrossError;
use crate::flight::channel::Channel;

/// What one aid did at one sample. Log, diagnosis input and test surface in one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Time of the sample, s.
    pub time_s: f64,
    /// Which aid.
    pub aid: Aid,
    /// The measurement, in the aid's unit.
    pub observation: f64,
    /// Variance of the measurement's noise, unit squared.
    pub observation_var: f64,
    /// Measurement less prediction (angles wrapped to +-pi).
    pub innovation: f64,
    /// Predicted variance of the innovation, unit squared.
    pub innovation_var: f64,
    /// innovation^2 / (gate^2 innovation_var): above 1 it is rejected.
    pub test_ratio: f64,
    /// Whether it was fused.
    pub fused: bool,
}

/// The estimated state at one instant, at the centre of mass: filtered (from what came until then, no lag) or smoothed (from
/// what came afterwards too).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateRecord {
    /// Time that the state belongs to, s.
    pub time_s: f64,
    /// u v w, body velocity through the air, m/s.
    pub velocity: [f64; 3],
    /// Standard deviations of u v w, m/s.
    pub velocity_std: [f64; 3],
    /// p q r, body rates, rad/s.
    pub rates: [f64; 3],
    /// Standard deviations of p q r, rad/s.
    pub rates_std: [f64; 3],
    /// p-dot q-dot r-dot, rad/s^2.
    pub angular_acceleration: [f64; 3],
    /// Standard deviations of p-dot q-dot r-dot, rad/s^2.
    pub angular_acceleration_std: [f64; 3],
    /// Specific force at the centre of mass, m/s^2.
    pub specific_force: [f64; 3],
    /// Standard deviations of the specific force, m/s^2; large where no accelerometer measures it.
    pub specific_force_std: [f64; 3],
    /// phi theta psi, rad.
    pub attitude: [f64; 3],
    /// Standard deviations of phi theta psi, rad.
    pub attitude_std: [f64; 3],
    /// Altitude, m.
    pub altitude: f64,
    /// Standard deviation of altitude, m.
    pub altitude_std: f64,
    /// Accelerometer biases x y z, m/s^2.
    pub accelerometer_bias: [f64; 3],
    /// Standard deviations of the accelerometer biases, m/s^2.
    pub accelerometer_bias_std: [f64; 3],
    /// Gyro biases p q r, rad/s.
    pub gyro_bias: [f64; 3],
    /// Standard deviations of the gyro biases, rad/s.
    pub gyro_bias_std: [f64; 3],
    /// How many aids were fused at this sample.
    pub fused: u8,
}

/// A smoothed state: one of a while ago, estimated from everything until now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaggedRecord {
    /// The state, with the time that it belongs to; no count of fused aids.
    pub state: StateRecord,
    /// How much later the newest sample is that it rests on, s.
    pub lag_s: f64,
}

/// The noise statistics in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseRecord {
    /// Of the instruments.
    pub noise: Noise,
    /// Random walk of p-dot q-dot r-dot, rad/s^2 per sqrt(s).
    pub angular_acceleration_walk: [f64; 3],
    /// Random walk of the specific forces x y z, m/s^2 per sqrt(s).
    pub specific_force_walk: [f64; 3],
}

/// Which states the filter carries besides velocity, attitude, altitude, rates, angular accelerations and gyro biases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateSet {
    /// Specific force and accelerometer bias along x, y, z.
    pub specific_force: [bool; 3],
    /// Scale errors of airspeed, incidence and sideslip.
    pub scale_error: [bool; 3],
}

impl StateSet {
    /// A bit for each entry, in their order.
    pub fn code(self) -> u8 {
        let entries = self.specific_force.into_iter().chain(self.scale_error);
        entries.enumerate().fold(0, |code, (bit, entry)| code | u8::from(entry) << bit)
    }

    /// The set of that code; higher bits do not count.
    pub fn from_code(code: u8) -> Self {
        let entry = |bit: usize| code >> bit & 1 == 1;
        StateSet { specific_force: core::array::from_fn(entry), scale_error: core::array::from_fn(|place| entry(3 + place)) }
    }
}

/// Signals at one instant of the regression grid: every entry has been through the same zero-phase kernel, or through the same
/// causal filter, so a linear relation between them is the one between the signals themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothedRecord {
    /// Time that the signals belong to (the centre of the kernel; the filter's delay ago), s.
    pub time_s: f64,
    /// Interval of the instants, s: the grid's, or a multiple where the gyros come more slowly than that.
    pub interval_s: f64,
    /// u v w at the centre of mass, m/s.
    pub velocity: [f64; 3],
    /// p q r as measured, rad/s.
    pub rates: [f64; 3],
    /// phi theta, rad.
    pub attitude: [f64; 2],
    /// ax ay az at the centre of mass, as measured, m/s^2.
    pub specific_force: [f64; 3],
    /// p-dot q-dot r-dot, rad/s^2.
    pub angular_acceleration: [f64; 3],
    /// Controls in the order of `Channel::CONTROLS`, rad; zero where not carried by the run.
    pub controls: [f64; 4],
    /// Which controls the run carries.
    pub controls_present: [bool; 4],
}

/// The run's trim: means over its trim window, about which perturbations are taken (PERTURB of Padfield et al. 1987).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrimRecord {
    /// u v w at the centre of mass, m/s.
    pub velocity: [f64; 3],
    /// Their standard deviations, m/s.
    pub velocity_std: [f64; 3],
    /// p q r as measured, rad/s.
    pub rates: [f64; 3],
    /// phi theta, rad.
    pub attitude: [f64; 2],
    /// ax ay az as measured, m/s^2; NaN where not sampled in the window.
    pub specific_force: [f64; 3],
    /// Controls in the order of `Channel::CONTROLS`, rad; NaN where not sampled in the window.
    pub controls: [f64; 4],
}

/// Standard deviations of what the instruments' white noise leaves in a [`SmoothedRecord`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalNoise {
    /// Of u v w, m/s.
    pub velocity: [f64; 3],
    /// Of p q r, rad/s.
    pub rates: [f64; 3],
    /// Of ax ay az, m/s^2.
    pub specific_force: [f64; 3],
    /// Of p-dot q-dot r-dot, rad/s^2.
    pub angular_acceleration: [f64; 3],
}

impl SignalNoise {
    /// No noise, or none known yet.
    pub const NONE: SignalNoise =
        SignalNoise { velocity: [0.0; 3], rates: [0.0; 3], specific_force: [0.0; 3], angular_acceleration: [0.0; 3] };
}

/// Which instruments the estimator found, and what that leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instrumentation {
    /// Whether the state is being estimated: rates, airspeed and attitude are there.
    pub running: bool,
    /// Rate of the gyros, Hz; 0 before two samples.
    pub rate_hz: f64,
    /// Whether p q r have been seen together.
    pub gyros: bool,
    /// Whether ax ay az are there.
    pub accelerometers: [bool; 3],
    /// Whether each aid is there, by `Aid::index()`.
    pub aids: [bool; AIDS],
    /// Whether each aid is fused most of the time, by `Aid::index()`; one that is missing counts as trusted.
    pub trusted: [bool; AIDS],
    /// Whether each aid's innovations are as large as expected, by `Aid::index()`.
    pub as_expected: [bool; AIDS],
    /// Whether the incidence and the sideslip vane have been found to disagree with the kinematics.
    pub vanes_disagree: [bool; 2],
    /// Whether they move against the kinematics, as a vane with its sign reversed does.
    pub vanes_contradict: [bool; 2],
    /// Whether each control has stood, clipped or frozen, in the order of `Channel::CONTROLS`.
    pub controls_stood: [bool; 4],
    /// Whether each gyro and accelerometer has stood after it moved, clipped or frozen, in the order of `Channel::INERTIAL`.
    pub inertial_stood: [bool; Channel::INERTIAL.len()],
    /// What is known about sign and unit, by `Confirmation::CHANNELS`.
    pub confirmations: [Confirmation; Confirmation::CHANNELS.len()],
    /// Noise of the smoothed signals, as of the last instant of the grid.
    pub noise: SignalNoise,
    /// Why no instrument can be relied on, where the screening has found a reason.
    pub doubt: Option<Doubt>,
}

impl Instrumentation {
    /// Whether sign and unit of a channel are confirmed, or need no confirmation.
    pub fn is_confirmed(&self, channel: Channel) -> bool {
        let known = Confirmation::place(channel).and_then(|place| self.confirmations.get(place));
        known.is_none_or(|confirmation| *confirmation == Confirmation::Confirmed)
    }
}

/// What the estimator noticed. Repeats are counted by whoever keeps them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "variants are what their names say")]
pub enum EstimationEvent {
    /// A channel gave NaN or infinity; it counts as not sampled.
    NotFinite { channel: Channel },
    /// A channel gave a number that no aircraft reaches (wrong unit?); it counts as not sampled.
    OutOfRange {
        channel: Channel,
        /// The number, SI.
        value: f64,
    },
    /// A channel stands still while the aircraft moves (frozen, clipped or dead); such readings count as not sampled.
    StandsStill { channel: Channel },
    /// Wrong unit, reversed sign or wiring: correcting it makes the increments agree with the kinematics.
    GrossError {
        error: &'static GrossError,
        /// Coefficient of determination of the increments that show it, once it is corrected.
        r_squared: f64,
    },
    /// The time of a sample is not finite; the sample is dropped.
    TimeNotFinite,
    /// A second sample with the same time; it is dropped.
    DuplicateTime,
    /// Time went back; the sample is dropped.
    TimeWentBack {
        /// By how much, s.
        by_s: f64,
    },
    /// Nothing came for that long; the filter starts again, the derivatives keep what they have.
    Gap {
        /// How long, s.
        seconds: f64,
    },
    /// Samples came, but for so long none with p, q and r together; the filter starts again with the next one.
    RatesSilent {
        /// How long, s.
        seconds: f64,
    },
    /// Time kept running on from an earlier instant: a new segment begins.
    SegmentRestart,
    /// The filter has a state from here on.
    Initialised,
    /// Which states the filter carries, by what is instrumented.
    StatesChosen { set: StateSet },
    /// The blades' passing and its double are taken out of every channel.
    LinesNotched {
        /// Frequency of the passing, Hz.
        passing_hz: f64,
    },
    /// Sampling folds the blades' passing, or its double, into the flight's own frequencies in some channel: it is left there.
    LineFolded,
    /// No accelerometer on this axis: its specific force is taken to balance gravity, with a large uncertainty.
    NoAccelerometer {
        /// `Ax`, `Ay` or `Az`.
        channel: Channel,
    },
    /// The run brings no such aid; what it alone makes observable stays unknown.
    AidMissing { aid: Aid },
    /// An aid began to be rejected by its innovation gate.
    AidRejected { aid: Aid, test_ratio: f64 },
    /// An aid is fused again.
    AidAccepted { aid: Aid },
    /// The measured flow angle does not move as the kinematics say it must.
    KinematicsDisagree {
        /// `Incidence` or `Sideslip`.
        aid: Aid,
        /// Coefficient of determination of the flow-angle rate by the kinematics.
        r_squared: f64,
    },
    /// The innovations are larger than the filter expects: mean normalised innovation squared over the last seconds.
    InnovationsTooLarge {
        aid: Aid,
        /// Mean of innovation^2 / innovation_var; 1 is as expected.
        mean_nis: f64,
    },
    /// The aircraft was not steady in its trim window: perturbations are about an instant that was no trim.
    TrimNotSteady {
        /// Largest rms body rate in the window, rad/s.
        rate_rms: f64,
    },
    /// The numbers broke down (a variance that is not positive, a state that is not finite); the filter starts again.
    NumericBreakdown,
}
