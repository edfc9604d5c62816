//! What can be wrong with instruments: the parameters of the kinematic model, how large they normally are and how large they
//! may get.
//!
//! A reading is `factor * late(true) + bias`, late by a first-order lag or by a skew; accelerometers and vanes stand at a
//! place of their own. Every parameter is always estimated, with a prior of mean zero (scale: one): *normal*, the standard
//! deviation among healthy instruments, or once it is taken for a fault *free*. See `select`.

use crate::flight::channel::Channel;

/// The inputs of the kinematics, in the order of their parameters.
pub const INPUT_CHANNELS: [Channel; 6] = [Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R];
/// The outputs of the kinematics, in the order of their parameters.
pub const OUTPUT_CHANNELS: [Channel; 7] =
    [Channel::Tas, Channel::Alpha, Channel::Beta, Channel::Phi, Channel::Theta, Channel::Psi, Channel::Altitude];
/// Number of inputs.
pub const INPUTS: usize = INPUT_CHANNELS.len();
/// Number of outputs.
pub const OUTPUTS: usize = OUTPUT_CHANNELS.len();
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
pub const OWN: usize = MEASURED;
/// Factors.
pub const SCALE: usize = OWN;
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
pub const TURNED: usize = FLOW + 3;
/// Biases that stand over all runs, beside each run's own; of one run alone there are none.
pub const STANDING: usize = TURNED + 6;

/// Which sort of error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Reads that much more.
    Bias,
    /// Reads that many times the truth.
    Scale,
    /// Reads late: by a lag or by a skew.
    Timing,
    /// The incidence vane stands elsewhere, along this axis.
    AlphaPlace(usize),
    /// The sideslip vane stands elsewhere, along this axis.
    BetaPlace(usize),
    /// Both vanes stand elsewhere, along this axis.
    VanePlace(usize),
    /// The accelerometers stand elsewhere, along this axis.
    AccelerometerPlace(usize),
    /// Not an instrument's error: how the airframe bends the flow.
    Flow(usize),
    /// A gyro feels a little of another axis.
    Turned(usize),
}

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its place.
    pub index: usize,
    /// Its sort.
    pub kind: Kind,
    /// The channel, as a place among [`CHANNELS`]; places have none.
    pub measured: Option<usize>,
}

/// The channel at a place among inputs, then outputs.
pub fn channel_at(measured: usize) -> Option<Channel> {
    CHANNELS.get(measured).copied()
}

impl Parameter {
    /// The parameter at that place.
    pub fn at(index: usize) -> Parameter {
        let (kind, measured) = match index {
            BIAS..SCALE => (Kind::Bias, Some(index - BIAS)),
            SCALE..TIMING => (Kind::Scale, Some(index - SCALE)),
            TIMING..ALPHA_PLACE => (Kind::Timing, Some(index - TIMING)),
            ALPHA_PLACE..BETA_PLACE => (Kind::AlphaPlace(index - ALPHA_PLACE), None),
            BETA_PLACE..VANE_PLACE => (Kind::BetaPlace(index - BETA_PLACE), None),
            VANE_PLACE..ACCELEROMETER_PLACE => (Kind::VanePlace(index - VANE_PLACE), None),
            STANDING.. => (Kind::Bias, Some(index - STANDING)),
            TURNED..STANDING => (Kind::Turned(index - TURNED), None),
            FLOW..TURNED => (Kind::Flow(index - FLOW), None),
            _ => (Kind::AccelerometerPlace(index - ACCELEROMETER_PLACE), None),
        };
        Parameter { index, kind, measured }
    }

    /// Whether the parameter is one run's own.
    pub fn is_own(self) -> bool {
        self.index < OWN
    }

    /// The channel that it belongs to.
    pub fn channel(self) -> Option<Channel> {
        self.measured.and_then(channel_at)
    }

    /// Whether it can be told as a fault: the flow about the airframe and a degree between gyros are none, and what static
    /// pressure and rising air do to an altitude looks like errors of its instrument.
    pub fn can_be_fault(self) -> bool {
        !matches!(self.kind, Kind::Flow(_) | Kind::Turned(_))
            && self.channel() != Some(Channel::Altitude)
            && self.priors().is_some()
    }

    /// Standard deviation among healthy instruments, and of what a fault may be; SI. `None` where it is never told apart:
    /// biases of heading and altitude (their start is free), factors of the same (only their changes count).
    pub fn priors(self) -> Option<(f64, f64)> {
        use Channel::{Alpha, Altitude, Ax, Ay, Az, Beta, Phi, Psi, Tas, Theta};
        Some(match (self.kind, self.channel()) {
            (Kind::Bias, Some(Ax | Ay | Az)) => (0.04, 2.0),
            (Kind::Bias, Some(Tas)) => (0.7, 10.0),
            (Kind::Bias, Some(Alpha | Beta | Phi | Theta)) => (0.004, 0.2),
            (Kind::Bias, Some(Psi | Altitude) | None) => return None,
            (Kind::Bias, Some(_)) => (0.001, 0.1),
            (Kind::Scale, Some(Altitude)) => (0.5, 0.5),
            (Kind::Timing, Some(Altitude)) => (0.1, 0.1),
            // One percent of an accelerometer's reading of gravity would be a large bias.
            (Kind::Scale, Some(Ax | Ay | Az)) => (0.004, 0.3),
            (Kind::Scale, _) => (0.008, 0.3),
            // Attitude comes late out of a platform, airspeed through tubes.
            (Kind::Timing, Some(Phi | Theta | Psi)) => (0.01, 0.3),
            (Kind::Timing, Some(Tas)) => (0.06, 0.5),
            (Kind::Timing, _) => (0.004, 0.3),
            (Kind::VanePlace(0) | Kind::BetaPlace(0), _) => (0.1, 8.0),
            (Kind::AccelerometerPlace(_), _) => (0.1, 1.5),
            (Kind::AlphaPlace(_) | Kind::BetaPlace(_) | Kind::VanePlace(_), _) => (0.1, 2.5),
            (Kind::Flow(0), _) => (0.03, 0.03),
            (Kind::Flow(_), _) => (0.5, 0.5),
            (Kind::Turned(_), _) => (0.02, 0.02),
        })
    }

    /// Whether gusts feign it: accelerations answer the gust that moves the vanes, and velocities drift with it; a bias of bank
    /// or pitch shows by the part of gravity that it turns into them.
    pub fn is_feigned_by_gusts(self) -> bool {
        let air = matches!(self.channel(), Some(Channel::Tas | Channel::Alpha | Channel::Beta));
        let force = matches!(self.channel(), Some(Channel::Ax | Channel::Ay | Channel::Az));
        let level = matches!(self.channel(), Some(Channel::Phi | Channel::Theta));
        match self.kind {
            Kind::Bias => air || force || level,
            Kind::Timing | Kind::Scale => air || force,
            Kind::AlphaPlace(_) | Kind::BetaPlace(_) | Kind::VanePlace(_) | Kind::AccelerometerPlace(_) => true,
            Kind::Flow(_) | Kind::Turned(_) => false,
        }
    }

    /// Smaller errors are not called a fault: s of timing (at least most of a sample), parts of one, m.
    pub fn matters(self, value: f64, sample_s: f64) -> bool {
        let least = match self.kind {
            Kind::Timing => (0.75 * sample_s).max(0.025),
            Kind::Scale => 0.025,
            Kind::AlphaPlace(_) | Kind::BetaPlace(_) | Kind::VanePlace(_) | Kind::AccelerometerPlace(_) => 0.5,
            _ => 0.0,
        };
        value.abs() >= least
    }

    /// The least error that one should be able to find: where even that would drown, the parameter is not observable.
    pub fn worth_finding(self) -> f64 {
        use Channel::{Alpha, Ax, Ay, Az, Beta, Phi, Tas, Theta};
        match (self.kind, self.channel()) {
            (Kind::Bias, Some(Ax | Ay | Az)) => 0.3,
            (Kind::Bias, Some(Tas)) => 5.0,
            (Kind::Bias, Some(Alpha | Beta | Phi | Theta)) => 0.03,
            (Kind::Bias, _) => 0.01,
            (Kind::Scale | Kind::Timing, _) => 0.05,
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
        self.values[BIAS + measured] + self.values[STANDING + measured]
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

    /// Which other gyro the k-th of [`TURNED`] feels, and by which: inputs' places.
    pub fn turned(k: usize) -> (usize, usize) {
        let felt_by = 3 + k / 2;
        let other = [4, 5, 3, 5, 3, 4][k % 6];
        (felt_by, other)
    }

    /// Three values that begin there.
    pub fn place(&self, from: usize) -> [f64; 3] {
        [self.values[from], self.values[from + 1], self.values[from + 2]]
    }
}
