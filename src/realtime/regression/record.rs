//! The published vocabulary of regression: derivatives with their standard errors, and how far they can be trusted.

use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::model::{LinearModel, Trim};
use heapless::Vec;
#[cfg(feature = "bus")]
use iceoryx2::prelude::ZeroCopySend;

/// Terms that one equation can hold: the bias and every variable.
pub const TERMS: usize = VARIABLES + 1;

/// Why there is no number, and none to come from these data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// The three rates were not sampled together.
    NoRates,
    /// No accelerometer on that axis.
    NoAccelerometer {
        /// `Ax`, `Ay` or `Az`.
        channel: Channel,
    },
    /// An accelerometer that was not sampled in the trim window.
    NoTrim {
        /// `Ax`, `Ay` or `Az`.
        channel: Channel,
    },
    /// Rates come too slowly for derivatives.
    RateTooLow {
        /// Their rate, Hz.
        hz: f64,
        /// What is needed, Hz.
        needed_hz: f64,
    },
    /// Nothing observes that velocity: its aid is missing.
    Unobserved {
        /// The velocity.
        variable: Variable,
        /// The channel that would make it observable.
        missing: Channel,
    },
    /// An aid is rejected most of the time: filter and instrument disagree, and nobody knows which is right.
    AidRejected {
        /// The aid's channel.
        channel: Channel,
    },
    /// An instrument reads in a wrong unit, with the wrong sign or what no aircraft reaches; `None` where it is not known which.
    InstrumentDoubted {
        /// The first of its channels.
        channel: Option<Channel>,
    },
    /// The kinematics do not confirm sign and unit of an instrument: too noisy, too little motion, moving air, or they are wrong.
    NotConfirmed {
        /// `Ax`, `Ay` or `Tas`; the weight confirms those of az.
        channel: Channel,
    },
    /// The regressors cannot be told apart in these data.
    Collinear {
        /// Largest condition index.
        condition_index: f64,
    },
    /// A derivative that this answer needs is in no equation: its variable did not move, or did not matter.
    NotExcited {
        /// Axis of the derivative.
        axis: Axis,
        /// Its variable.
        variable: Variable,
    },
    /// The standard error is as large as the value, or does not tell a stable mode from an unstable one.
    Unresolved,
    /// No input moved this plane of motion, and it is not known to follow from the other plane: the air may move it.
    NoInput,
    /// No control was sampled by the time of the trim: an input is not told from gusts.
    NoControl,
    /// Another equation that this answer needs has no number.
    Equation {
        /// Which.
        axis: Axis,
    },
}

impl Reason {
    /// Its number wherever it stands as one: on the bus and in the C interface of the firmware profile.
    pub const fn code(&self) -> u32 {
        match self {
            Reason::NoRates => 0,
            Reason::NoAccelerometer { .. } => 1,
            Reason::RateTooLow { .. } => 2,
            Reason::Unobserved { .. } => 3,
            Reason::Collinear { .. } => 4,
            Reason::NotExcited { .. } => 5,
            Reason::Equation { .. } => 6,
            Reason::NoTrim { .. } => 7,
            Reason::AidRejected { .. } => 8,
            Reason::Unresolved => 9,
            Reason::InstrumentDoubted { .. } => 10,
            Reason::NotConfirmed { .. } => 11,
            Reason::NoInput => 12,
            Reason::NoControl => 13,
        }
    }

    /// Whether an instrument is why: missing, doubted, not confirmed. What rests on its readings has no number by any method.
    pub const fn is_of_an_instrument(&self) -> bool {
        match self {
            Reason::NoRates
            | Reason::NoAccelerometer { .. }
            | Reason::NoTrim { .. }
            | Reason::NoControl
            | Reason::Unobserved { .. }
            | Reason::AidRejected { .. }
            | Reason::InstrumentDoubted { .. }
            | Reason::NotConfirmed { .. } => true,
            Reason::RateTooLow { .. }
            | Reason::Collinear { .. }
            | Reason::NotExcited { .. }
            | Reason::Unresolved
            | Reason::NoInput
            | Reason::Equation { .. } => false,
        }
    }
}

/// How far along an answer is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// Nothing has happened yet that could be learned from.
    Waiting,
    /// The aircraft is being excited, or has been; too little for a number.
    Exciting,
    /// There are numbers; they still move or are still uncertain.
    Converging,
    /// The numbers have settled within their standard errors.
    Converged,
    /// There are numbers; the frequency domain, or output error, gives others, further away than both standard errors allow.
    Disagree,
    /// There are numbers, of this amplitude of motion: they shift with it by more than their standard errors.
    DependsOnAmplitude,
    /// There are numbers, from before: nothing new has come for a while.
    Stale,
    /// There will be no number from these data, because ...
    NotIdentifiable(Reason),
}

impl Status {
    /// How far along: none to come 0, waiting 1, exciting 2, and with numbers: stale 3, depends on amplitude 4, disagree 5,
    /// converging 6, converged 7.
    pub const fn rank(&self) -> u8 {
        match self {
            Status::NotIdentifiable(_) => 0,
            Status::Waiting => 1,
            Status::Exciting => 2,
            Status::Stale => 3,
            Status::DependsOnAmplitude => 4,
            Status::Disagree => 5,
            Status::Converging => 6,
            Status::Converged => 7,
        }
    }
}

/// A term as the band of frequencies tells it, beside least squares over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyTerm {
    /// The derivative, SI and radians.
    pub value: f64,
    /// Standard error, for an equation error that is white in the band.
    pub std: f64,
}

/// One term of an equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TermRecord {
    /// The variable; `None` is the bias `_0`.
    pub variable: Option<Variable>,
    /// The derivative, SI and radians.
    pub value: f64,
    /// Standard error corrected for coloured residuals.
    pub std: f64,
    /// Standard error for white residuals: Padfield et al. 1987, (19).
    pub std_white: f64,
    /// Step of the selection at which it entered, from 1; 0 for the bias.
    pub step: u8,
    /// Whether it belongs to the equation whatever its F (a primary term) or was selected.
    pub primary: bool,
    /// The second estimate, from the frequency domain, where there is one.
    pub frequency: Option<FrequencyTerm>,
}

impl TermRecord {
    /// Partial F ratio on the corrected standard error: (value/std)^2.
    pub fn partial_f(&self) -> f64 {
        (self.value / self.std) * (self.value / self.std)
    }

    /// Partial F ratio for white residuals: Padfield et al. 1987, (22).
    pub fn partial_f_white(&self) -> f64 {
        (self.value / self.std_white) * (self.value / self.std_white)
    }

    /// The second estimate less the first, in combined standard errors; both come from the same flight, so where nothing
    /// is wrong it is smaller than that of independent ones.
    pub fn disagreement(&self) -> Option<f64> {
        let second = self.frequency?;
        Some((second.value - self.value) / libm::sqrt(second.std * second.std + self.std * self.std))
    }
}

/// One axis' equation.
#[derive(Clone, Debug, PartialEq)]
pub struct EquationRecord {
    /// Which axis.
    pub axis: Axis,
    /// How far it is.
    pub status: Status,
    /// Its terms, bias first, then in the order of entry. Empty where there is no number.
    pub terms: Vec<TermRecord, TERMS>,
    /// Multiple correlation coefficient squared, about the mean; (20).
    pub r_squared: f64,
    /// Total F ratio; (21).
    pub f_total: f64,
    /// Samples that it rests on (effective number where old ones are forgotten).
    pub samples: f64,
    /// Standard deviation of the residual, m/s^2 or rad/s^2.
    pub residual_std: f64,
    /// Largest condition index of the regressors (unit-length columns).
    pub condition_index: f64,
    /// Variables in the equation whose derivative has no number, because its standard error is as large as itself and
    /// not small beside the response: a bit each, by `Variable::index()`.
    pub unresolved: u16,
}

impl EquationRecord {
    /// Combined standard errors by which time and frequency domain may differ and still agree.
    pub const AGREE_WITHIN: f64 = 3.0;

    /// An equation without numbers.
    pub fn empty(axis: Axis, status: Status) -> Self {
        EquationRecord {
            axis,
            status,
            terms: Vec::new(),
            r_squared: 0.0,
            f_total: 0.0,
            samples: 0.0,
            residual_std: 0.0,
            condition_index: 0.0,
            unresolved: 0,
        }
    }

    /// The variables of [`EquationRecord::unresolved`].
    pub fn unresolved_variables(&self) -> impl Iterator<Item = Variable> {
        let marked = self.unresolved;
        Variable::ALL.into_iter().filter(move |variable| marked & (1 << variable.index()) != 0)
    }

    /// The term of that variable, where it is in the equation.
    pub fn term(&self, variable: Variable) -> Option<&TermRecord> {
        self.terms.iter().find(|term| term.variable == Some(variable))
    }

    /// Where time and frequency domain disagree most: the variable, and by how many combined standard errors. The bias is
    /// left out: the band does not reach down to it.
    pub fn disagreement(&self) -> Option<(Variable, f64)> {
        let told = self.terms.iter().filter_map(|term| Some((term.variable?, term.disagreement()?)));
        told.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))
    }
}

/// The lateral derivatives, in the order of [`LateralDerivatives::NAMES`].
pub const LATERAL: usize = 9;

/// What the lateral subsystem is made of, with the joint covariance of all its derivatives (equations share residuals
/// and regressors, so they are not independent); the bus carries it as it stands.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bus", derive(ZeroCopySend), type_name("sideslip.Lateral.1"))]
pub struct LateralDerivatives {
    /// Y_v Y_p Y_r L_v L_p L_r N_v N_p N_r; zero where a term is not in its equation.
    pub values: [f64; LATERAL],
    /// Their covariance, corrected for coloured residuals; zero rows where a term is not in its equation.
    pub cov: [[f64; LATERAL]; LATERAL],
    /// Trim velocity u along body x, m/s.
    pub u0: f64,
    /// Trim velocity w along body z, m/s.
    pub w0: f64,
    /// Trim bank angle, rad.
    pub phi0: f64,
    /// Trim pitch attitude, rad.
    pub theta0: f64,
    /// Standard deviations of u0 and w0, m/s.
    pub trim_std: [f64; 2],
}

impl LateralDerivatives {
    /// Those without which there are no modes: were one taken as zero, roots would come out that the aircraft does not have.
    pub const NEEDED: [(Axis, Variable); 5] =
        [(Axis::N, Variable::V), (Axis::N, Variable::R), (Axis::L, Variable::V), (Axis::L, Variable::P), (Axis::Y, Variable::V)];

    /// Axis and variable of each entry.
    pub const NAMES: [(Axis, Variable); LATERAL] = [
        (Axis::Y, Variable::V),
        (Axis::Y, Variable::P),
        (Axis::Y, Variable::R),
        (Axis::L, Variable::V),
        (Axis::L, Variable::P),
        (Axis::L, Variable::R),
        (Axis::N, Variable::V),
        (Axis::N, Variable::P),
        (Axis::N, Variable::R),
    ];

    /// Those of a model, exactly.
    pub fn of(model: &LinearModel) -> Self {
        let Trim { u, w, phi, theta, .. } = model.trim;
        LateralDerivatives {
            values: Self::NAMES.map(|(axis, variable)| model.derivative(axis, variable)),
            cov: [[0.0; LATERAL]; LATERAL],
            u0: u,
            w0: w,
            trim_std: [0.0; 2],
            phi0: phi,
            theta0: theta,
        }
    }
}

/// Variables of the motion: u v w p q r, the first of [`Variable::ALL`].
pub const MOTION: usize = 6;

/// The derivatives of all six equations with respect to the motion, for the modes of the whole aircraft.
#[derive(Clone, Debug, PartialEq)]
pub struct SixAxisDerivatives {
    /// By axis and variable; zero where a term is not in its equation.
    pub values: [[f64; MOTION]; AXES],
    /// Covariance within each equation, corrected for coloured residuals; zero rows where a term is not in it.
    pub cov: [[[f64; MOTION]; MOTION]; AXES],
    /// Trim velocity v along body y, m/s.
    pub v0: f64,
    /// Its standard deviation, m/s.
    pub v0_std: f64,
}

impl SixAxisDerivatives {
    /// Those besides the lateral subsystem's own without which the coupling cannot be told.
    pub const NEEDED: [(Axis, Variable); 3] = [(Axis::Z, Variable::W), (Axis::M, Variable::W), (Axis::M, Variable::Q)];

    /// Those of a model, exactly.
    pub fn of(model: &LinearModel) -> Self {
        let row = |axis: Axis| core::array::from_fn(|i| model.derivative(axis, Variable::ALL[i]));
        let cov = [[[0.0; MOTION]; MOTION]; AXES];
        SixAxisDerivatives { values: Axis::ALL.map(row), cov, v0: model.trim.v, v0_std: 0.0 }
    }
}

/// All equations at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivativesRecord {
    /// Time of the newest sample that they rest on, s.
    pub time_s: f64,
    /// One equation an axis, in the order of `Axis::ALL`.
    pub equations: [EquationRecord; AXES],
    /// For the modes; `None` until Y, L and N all have the numbers that these need.
    pub lateral: Option<LateralDerivatives>,
    /// Whether the aircraft is being excited now.
    pub excited: bool,
}

/// What the regression noticed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RegressionEvent {
    /// Excitation began.
    ExcitationBegan,
    /// Excitation ended.
    ExcitationEnded,
    /// A channel that the trim knows was silent: the regression leaves those instants out. Said once a channel.
    SignalMissing {
        /// Which.
        channel: Channel,
    },
    /// A control that was not sampled in the trim window: the regression leaves it out. Said once a channel.
    NoTrim {
        /// Which.
        channel: Channel,
    },
    /// An equation's status changed.
    StatusChanged {
        /// Which equation.
        axis: Axis,
        /// Its new status.
        status: Status,
    },
}
