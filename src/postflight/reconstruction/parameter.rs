//! Instrument errors: the parameters of the kinematic model with their priors, for healthy instruments and for faults.
//!
//! A reading is `factor * late(true) + bias`, late by a first-order lag or by a skew; accelerometers and vanes stand at a
//! place of their own. Every parameter is always estimated, with a prior of mean zero (scale: one): *normal*, the standard
//! deviation among healthy instruments, or once it is taken for a fault *free*. See `select`.

use super::record::InstrumentErrorKind;
use crate::flight::channel::Channel;
pub use crate::realtime::estimation::screening::kinematic_agreement::{OUTPUT_CHANNELS, OUTPUTS};

/// The inputs of the kinematics, in the order of their parameters.
pub const INPUT_CHANNELS: [Channel; 6] = [Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R];
/// Number of inputs.
pub const INPUTS: usize = INPUT_CHANNELS.len();
/// Inputs and outputs.
pub const MEASURED: usize = INPUTS + OUTPUTS;
/// All of them, inputs first.
pub const CHANNELS: [Channel; MEASURED] = {
    let mut all = [INPUT_CHANNELS[0]; MEASURED];
    let mut k = 0;
    while k < MEASURED {
        all[k] = if k < INPUTS { INPUT_CHANNELS[k] } else { OUTPUT_CHANNELS[k - INPUTS] };
        k += 1;
    }
    all
};
/// Number of parameters of one run.
pub const PARAMETERS: usize = 4 * MEASURED + 21;

/// Where the parameters of each kind begin.
pub const BIAS: usize = 0;
/// Parameters that belong to one run, the biases; the others hold over all runs.
pub const PER_RUN: usize = MEASURED;
/// Factors.
pub const SCALE: usize = PER_RUN;
/// Lag or skew.
pub const TIMING: usize = SCALE + MEASURED;
/// Place of the incidence vane alone, x y z.
pub const ALPHA_PLACE: usize = TIMING + MEASURED;
/// Place of the sideslip vane alone, x y z.
pub const BETA_PLACE: usize = ALPHA_PLACE + 3;
/// Place of both vanes, x y z.
pub const VANE_PLACE: usize = BETA_PLACE + 3;
/// Place of the accelerometers, x y z.
pub const ACCELEROMETER_PLACE: usize = VANE_PLACE + 3;
/// What sideslip does to the flow at the other sensors: incidence by beta and by beta^2, airspeed by beta^2.
pub const FLOW: usize = ACCELEROMETER_PLACE + 3;

/// How the gyros are turned against each other: p by q and r, q by p and r, r by p and q, rad.
pub const MISALIGNMENT: usize = FLOW + 3;
/// Biases that stand over all runs, beside each run's own; of one run alone there are none.
pub const SHARED_BIAS: usize = MISALIGNMENT + 6;

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstrumentError {
    /// Its place.
    pub index: usize,
    /// Its sort.
    pub kind: InstrumentErrorKind,
    /// The channel, as a place among [`CHANNELS`]; places have none.
    pub measured: Option<usize>,
}

/// The channel at a place among inputs, then outputs.
pub fn channel_at(measured: usize) -> Option<Channel> {
    CHANNELS.get(measured).copied()
}

impl InstrumentError {
    /// The parameter at that place.
    pub fn at(index: usize) -> InstrumentError {
        let (kind, measured) = match index {
            BIAS..SCALE => (InstrumentErrorKind::Bias, Some(index - BIAS)),
            SCALE..TIMING => (InstrumentErrorKind::Scale, Some(index - SCALE)),
            TIMING..ALPHA_PLACE => (InstrumentErrorKind::Timing, Some(index - TIMING)),
            ALPHA_PLACE..BETA_PLACE => (InstrumentErrorKind::AlphaPlace(index - ALPHA_PLACE), None),
            BETA_PLACE..VANE_PLACE => (InstrumentErrorKind::BetaPlace(index - BETA_PLACE), None),
            VANE_PLACE..ACCELEROMETER_PLACE => (InstrumentErrorKind::VanePlace(index - VANE_PLACE), None),
            SHARED_BIAS.. => (InstrumentErrorKind::Bias, Some(index - SHARED_BIAS)),
            MISALIGNMENT..SHARED_BIAS => (InstrumentErrorKind::Misalignment(index - MISALIGNMENT), None),
            FLOW..MISALIGNMENT => (InstrumentErrorKind::Flow(index - FLOW), None),
            _ => (InstrumentErrorKind::AccelerometerPlace(index - ACCELEROMETER_PLACE), None),
        };
        InstrumentError { index, kind, measured }
    }

    /// The channel that it belongs to.
    pub fn channel(self) -> Option<Channel> {
        self.measured.and_then(channel_at)
    }

    /// Whether it can be reported as a fault: the flow about the airframe and a degree between gyros are none, and what static
    /// pressure and rising air do to an altitude resembles errors of its instrument.
    pub fn can_be_fault(self) -> bool {
        !matches!(self.kind, InstrumentErrorKind::Flow(_) | InstrumentErrorKind::Misalignment(_))
            && self.channel() != Some(Channel::Altitude)
            && self.priors().is_some()
    }

    /// Standard deviation among healthy instruments, and of what a fault may be; SI. `None` where it is never separable:
    /// biases of heading and altitude (their start is free), factors of the same (only their changes count).
    pub fn priors(self) -> Option<(f64, f64)> {
        use Channel::{Alpha, Altitude, Ax, Ay, Az, Beta, Phi, Psi, Tas, Theta};
        Some(match (self.kind, self.channel()) {
            (InstrumentErrorKind::Bias, Some(Ax | Ay | Az)) => (0.04, 2.0),
            (InstrumentErrorKind::Bias, Some(Tas)) => (0.7, 10.0),
            (InstrumentErrorKind::Bias, Some(Alpha | Beta | Phi | Theta)) => (0.004, 0.2),
            (InstrumentErrorKind::Bias, Some(Psi | Altitude) | None) => return None,
            (InstrumentErrorKind::Bias, Some(_)) => (0.001, 0.1),
            (InstrumentErrorKind::Scale, Some(Altitude)) => (0.5, 0.5),
            (InstrumentErrorKind::Timing, Some(Altitude)) => (0.1, 0.1),
            // One percent of an accelerometer's reading of gravity would be a large bias.
            (InstrumentErrorKind::Scale, Some(Ax | Ay | Az)) => (0.004, 0.3),
            (InstrumentErrorKind::Scale, _) => (0.008, 0.3),
            // Attitude comes late out of a platform, airspeed through tubes.
            (InstrumentErrorKind::Timing, Some(Phi | Theta | Psi)) => (0.01, 0.3),
            (InstrumentErrorKind::Timing, Some(Tas)) => (0.06, 0.5),
            (InstrumentErrorKind::Timing, _) => (0.004, 0.3),
            (InstrumentErrorKind::VanePlace(0) | InstrumentErrorKind::BetaPlace(0), _) => (0.1, 8.0),
            (InstrumentErrorKind::AccelerometerPlace(_), _) => (0.1, 1.5),
            (InstrumentErrorKind::AlphaPlace(_) | InstrumentErrorKind::BetaPlace(_) | InstrumentErrorKind::VanePlace(_), _) => {
                (0.1, 2.5)
            }
            (InstrumentErrorKind::Flow(0), _) => (0.03, 0.03),
            (InstrumentErrorKind::Flow(_), _) => (0.5, 0.5),
            (InstrumentErrorKind::Misalignment(_), _) => (0.02, 0.02),
        })
    }

    /// Whether gusts feign it: accelerations answer the gust that moves the vanes, and velocities drift with it; a bias of bank
    /// or pitch shows by the part of gravity that it turns into them.
    pub fn mimicked_by_gusts(self) -> bool {
        let air = matches!(self.channel(), Some(Channel::Tas | Channel::Alpha | Channel::Beta));
        let force = matches!(self.channel(), Some(Channel::Ax | Channel::Ay | Channel::Az));
        let level = matches!(self.channel(), Some(Channel::Phi | Channel::Theta));
        match self.kind {
            InstrumentErrorKind::Bias => air || force || level,
            InstrumentErrorKind::Timing | InstrumentErrorKind::Scale => air || force,
            InstrumentErrorKind::AlphaPlace(_)
            | InstrumentErrorKind::BetaPlace(_)
            | InstrumentErrorKind::VanePlace(_)
            | InstrumentErrorKind::AccelerometerPlace(_) => true,
            InstrumentErrorKind::Flow(_) | InstrumentErrorKind::Misalignment(_) => false,
        }
    }

    /// Smaller errors are not called a fault: s of timing (at least most of a sample), parts of one, m.
    pub fn matters(self, value: f64, sample_s: f64) -> bool {
        let least = match self.kind {
            InstrumentErrorKind::Timing => (0.75 * sample_s).max(0.025),
            InstrumentErrorKind::Scale => 0.025,
            InstrumentErrorKind::AlphaPlace(_)
            | InstrumentErrorKind::BetaPlace(_)
            | InstrumentErrorKind::VanePlace(_)
            | InstrumentErrorKind::AccelerometerPlace(_) => 0.5,
            _ => 0.0,
        };
        value.abs() >= least
    }

    /// The least error that one should be able to find: where even that would drown, the parameter is not observable.
    pub fn worth_finding(self) -> f64 {
        use Channel::{Alpha, Ax, Ay, Az, Beta, Phi, Tas, Theta};
        match (self.kind, self.channel()) {
            (InstrumentErrorKind::Bias, Some(Ax | Ay | Az)) => 0.3,
            (InstrumentErrorKind::Bias, Some(Tas)) => 5.0,
            (InstrumentErrorKind::Bias, Some(Alpha | Beta | Phi | Theta)) => 0.03,
            (InstrumentErrorKind::Bias, _) => 0.01,
            (InstrumentErrorKind::Scale | InstrumentErrorKind::Timing, _) => 0.05,
            _ => 1.0,
        }
    }
}

/// Values of all parameters of a run, SI; a factor as what exceeds one. Timing is a skew, or where `lag` says so a lag, s.
#[derive(Clone, Debug, PartialEq)]
pub struct Theta {
    /// By place.
    pub values: [f64; PARAMETERS],
    /// By channel: whether its timing is a first-order lag.
    pub lag: [bool; MEASURED],
}

impl Theta {
    /// Instruments without error.
    pub const NONE: Theta = Theta { values: [0.0; PARAMETERS], lag: [false; MEASURED] };

    /// Bias of a channel.
    pub fn bias(&self, measured: usize) -> f64 {
        self.values[BIAS + measured] + self.values[SHARED_BIAS + measured]
    }

    /// Factor of a channel.
    pub fn factor(&self, measured: usize) -> f64 {
        1.0 + self.values[SCALE + measured]
    }

    /// Skew of a channel, s.
    pub fn skew_s(&self, measured: usize) -> f64 {
        if self.lag[measured] { 0.0 } else { self.values[TIMING + measured] }
    }

    /// Lag of a channel, s.
    pub fn lag_s(&self, measured: usize) -> f64 {
        if self.lag[measured] { self.values[TIMING + measured].max(0.0) } else { 0.0 }
    }

    /// Which other gyro the k-th of [`MISALIGNMENT`] feels, and by which: inputs' places.
    pub fn misaligned_axes(k: usize) -> (usize, usize) {
        let felt_by = 3 + k / 2;
        let other = [4, 5, 3, 5, 3, 4][k % 6];
        (felt_by, other)
    }

    /// Three values that begin there.
    pub fn place(&self, from: usize) -> [f64; 3] {
        [self.values[from], self.values[from + 1], self.values[from + 2]]
    }
}
