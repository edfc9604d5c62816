//! The published vocabulary of the check of instruments: why a run is fit or not, which errors its motion does not show, and what
//! distinguishes two explanations. The words for people are made in `io/outputs/words/instrument_words.rs`.

use crate::flight::channel::Channel;
use crate::realtime::estimation::screening::gross_error::GrossError;

/// Which sort of error an instrument has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstrumentErrorKind {
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
    Misalignment(usize),
}

/// An error of an instrument by its kind and, where it is of one channel, that channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelError {
    /// Its kind.
    pub kind: InstrumentErrorKind,
    /// Its channel; positions have none.
    pub channel: Option<Channel>,
}

/// A wiring error of channels that hardly move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WiringError {
    /// This channel reads with the opposite sign.
    Turned(Channel),
    /// ax and ay are recorded under each other's names.
    Exchanged,
}

/// How a wiring error explains a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WiringFinding {
    /// Far better than errors of instruments do.
    Better(WiringError),
    /// As well as errors of instruments do.
    AsWell(WiringError),
    /// It would make the bias that was found of this channel.
    MakesBias(WiringError, Channel),
}

/// An accelerometer whose mean contradicts attitude, turn and flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanForceContradiction {
    /// The accelerometer.
    pub channel: Channel,
    /// Its mean, m/s^2.
    pub mean: f64,
    /// The attitude angle that the expected mean depends on.
    pub attitude: Channel,
    /// The expected mean, m/s^2.
    pub expected: f64,
    /// Whether a reversed sign explains it.
    pub reversed: bool,
}

/// What the agreement of a run's instruments was tested on.
#[derive(Clone, Debug, PartialEq)]
pub enum AgreementScope {
    /// All channels.
    Whole,
    /// Attitude and rates: others are not measured.
    AttitudeAndRates,
    /// Attitude and rates: the air is too rough for the rest, but for the means of these accelerometers.
    RoughAir(Vec<MeanForceContradiction>),
}

/// Why a run is fit, fit once corrected, or not fit for identification.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "variants are what their names say")]
pub enum VerdictReason {
    /// The run, or what is left of it, is short.
    TooShort {
        length_s: f64,
        /// The least that is needed, s.
        least_s: f64,
        /// A channel that stands still, whose samples were taken out.
        frozen: Option<Channel>,
    },
    /// These angular rates are not recorded.
    NoRates(Vec<Channel>),
    /// Time goes back.
    ClockBackwards {
        /// At so many samples.
        backwards: usize,
        /// Of so many.
        samples: usize,
    },
    /// Angular rates are sampled too seldom.
    RateTooLow {
        rate_hz: f64,
        /// The least that is needed, Hz.
        least_hz: f64,
    },
    /// The mean of az is not near that of level flight, m/s^2.
    MeanNormalForce(f64),
    /// Neither attitude nor air data are recorded.
    NoOutputs,
    /// No stretch between gaps is long enough.
    Gaps {
        /// How many gaps.
        count: usize,
        /// In so long a run, s.
        length_s: f64,
        /// A channel that stands still, whose samples were taken out.
        frozen: Option<Channel>,
    },
    /// The largest rms of an angular rate, rad/s, is too small.
    NoExcitation(f64),
    /// A sign, a unit or names are wrong.
    Gross {
        /// The errors that explain it, any one of them.
        either: Vec<&'static GrossError>,
        /// The channel that then follows from the others.
        shown: Channel,
        /// Its R2 as recorded.
        before: f64,
        /// Its R2 corrected.
        after: f64,
    },
    /// A channel jumps.
    Jump {
        channel: Channel,
        /// When, s.
        time_s: f64,
        /// By how much, in the channel's SI unit.
        by: f64,
    },
    /// A channel is beyond what any aircraft reaches, in this part of its samples.
    OutOfRange(Channel, f64),
    /// The kinematics cannot follow the motion.
    NotFollowed,
    /// A wiring error explains the run.
    Wiring(WiringFinding),
    /// The scale factor that fits best is none that an instrument has.
    ImplausibleScale(Channel, f64),
    /// The rate of a flow angle contradicts accelerometers and gyros: its R2.
    FlowAngleContradicted(Channel, f64),
    /// The rate of a flow angle does not follow from accelerometers and gyros: its R2.
    FlowAngleNotFollowed(Channel, f64),
    /// The instruments agree with each other.
    Agree(AgreementScope),
    /// So many errors of instruments were found.
    ErrorsFound(usize),
    /// The run is an outlier, checked apart from the others.
    Outlier {
        /// Whether no other run agrees with it.
        alone: bool,
        /// Whether no error of an instrument explains it.
        unexplained: bool,
        /// The reason of its own verdict.
        reason: Box<VerdictReason>,
    },
}

/// Why an estimate that would improve the fit is not reported as a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnreportedReason {
    /// Its axis has this part of the motion of the busiest one.
    InsufficientMotion(f64),
    /// With a bias of the same accelerometer it may be a misalignment.
    Misalignment,
    /// Gusts have the same effect.
    Gusts,
    /// No instrument has such a scale factor.
    ImplausibleScale,
}

/// What cannot be known of a run's instruments.
#[derive(Clone, Debug, PartialEq)]
pub enum NotObservable {
    /// These channels are not measured.
    NotMeasured(Vec<Channel>),
    /// The velocity is not determined: accelerometers (true) or the airspeed (false) are not measured.
    VelocityUndetermined(bool),
    /// An estimate that is not reported as a fault.
    Unreported {
        /// The error.
        error: ChannelError,
        /// Its value in SI; of a scale factor the factor.
        value: f64,
        /// Its standard error.
        std: f64,
        /// Why it is not reported.
        reason: UnreportedReason,
    },
    /// The motion does not excite it.
    NotExcited(ChannelError),
    /// Its axis moves too little compared with the others.
    InsufficientMotion(ChannelError),
    /// Errors below this detection limit, in SI, are not detected.
    BelowLimit(ChannelError, f64),
    /// Gusts have the effect of errors of air data, accelerometers and positions.
    Gusts,
    /// The initial heading is unknown.
    HeadingBias,
    /// Vertical wind and static pressure have the effect of errors of the altitude.
    Altitude,
    /// No kinematic equation contains a control.
    Controls,
}

/// What distinguishes two explanations of one error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separation {
    /// Lag or skew of one channel.
    LagOrSkew,
    /// Positions of vanes or of accelerometers.
    VaneOrAccelerometers,
    /// A position or a delay.
    PositionOrDelay,
    /// Scale factors of two channels.
    ScaleOrScale,
    /// Biases of two channels.
    BiasOrBias,
    /// A bias or a scale factor.
    BiasOrScale,
    /// Any other pair.
    OtherInput,
}
