//! Results of the preliminary interpretation: manoeuvres, trims, modes, sensitivities, coupling, repeatability, linearity.
//!
//! Numbers are SI and radians, each with its standard error; what is not estimable is an [`NotEstimable`] with its reason.

use crate::flight::channel::{Channel, ControlNames};
use crate::flight::control::Control;
use std::fmt;

/// A number and its standard error, in the same unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub std: f64,
}

/// Why a quantity is not estimable.
#[derive(Clone, Debug, PartialEq)]
pub enum NotEstimable {
    /// None of the channels that show it was recorded.
    NoChannel(&'static str),
    /// No free response long enough: the control that moves, and the longest time without a motion, s.
    StillMoves(Control, f64),
    /// The free response is too short for an oscillation: number of cycles.
    TooFewCycles(f64),
    /// No oscillation above noise and drift: part of the variance that the best damped sine explains, and its amplitude over the
    /// residual.
    NoOscillation(f64, f64),
    /// Too large standard errors: frequency, rad/s, and damping ratio.
    Uncertain(Measured, Measured),
    /// Too few runs: found, needed.
    TooFewRuns(usize, usize),
    /// The runs differ too little in amplitude: smallest and largest, rad.
    OneAmplitude(f64, f64),
    /// Gusts, or a trim that is not held: motion in trim over the noise of a smoothed reading.
    Disturbed(f64),
    /// The response does not exceed the motion of the channel in trim.
    BelowNoise,
    /// The record begins too shortly before the control moves to give a trim.
    NoTrim,
}

impl fmt::Display for NotEstimable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotEstimable::NoChannel(which) => write!(f, "no {which}"),
            NotEstimable::StillMoves(_, longest_s) => write!(f, "control still moves (still for {longest_s:.1} s at most)"),
            NotEstimable::TooFewCycles(cycles) => write!(f, "too few cycles ({cycles:.1})"),
            NotEstimable::NoOscillation(explained, ratio) => {
                write!(f, "no oscillation: a damped sine explains {:.0} %, {ratio:.1} times the rest", 100.0 * explained)
            }
            NotEstimable::Uncertain(omega, zeta) => write!(
                f,
                "too uncertain (omega {:.2} +- {:.2} rad/s, zeta {:.2} +- {:.2})",
                omega.value, omega.std, zeta.value, zeta.std
            ),
            NotEstimable::TooFewRuns(found, needed) => write!(f, "too few runs: {found}, of {needed} or more"),
            NotEstimable::OneAmplitude(least, most) => write!(f, "one amplitude only ({least:.4} to {most:.4} rad)"),
            NotEstimable::Disturbed(ratio) => write!(f, "the air or the trim is not steady ({ratio:.0} times the noise)"),
            NotEstimable::BelowNoise => f.write_str("not above the motion in trim"),
            NotEstimable::NoTrim => f.write_str("no still stretch before it"),
        }
    }
}

/// Which plane of motion a control belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// Pitch and heave.
    Longitudinal,
    /// Roll and yaw.
    Lateral,
}

impl Plane {
    /// The plane that the control is there for.
    pub const fn of(control: Control) -> Plane {
        match control {
            Control::LonCyclic | Control::Collective => Plane::Longitudinal,
            Control::LatCyclic | Control::Pedal => Plane::Lateral,
        }
    }

    /// Channels that show its oscillation.
    pub const fn channels(self) -> [Channel; 3] {
        match self {
            Plane::Longitudinal => [Channel::Q, Channel::Alpha, Channel::Az],
            Plane::Lateral => [Channel::R, Channel::P, Channel::Beta],
        }
    }

    /// In a word.
    pub const fn word(self) -> &'static str {
        match self {
            Plane::Longitudinal => "longitudinal",
            Plane::Lateral => "lateral",
        }
    }
}

/// The channel that a control is there to move.
pub const fn on_axis(control: Control) -> Channel {
    match control {
        Control::LonCyclic => Channel::Q,
        Control::LatCyclic => Channel::P,
        Control::Pedal => Channel::R,
        Control::Collective => Channel::Az,
    }
}

/// One pulse of a control: away from where it was before the manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// When it passes half its level, s.
    pub start_s: f64,
    /// When it is back at half its level, s; the end of the record where it does not come back.
    pub end_s: f64,
    /// Its level: the median deviation, rad.
    pub level: f64,
    /// Whether it comes back.
    pub ended: bool,
}

/// A guess of what was flown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Moved and held.
    Step,
    /// Moved and brought back.
    Pulse,
    /// Two pulses of opposite sign and like length.
    Doublet,
    /// Pulses of alternating sign whose lengths are whole clocks, 3211 for one.
    Multistep(Vec<u8>),
    /// So many pulses of no pattern.
    Other(usize),
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::Step => f.write_str("step"),
            Shape::Pulse => f.write_str("pulse"),
            Shape::Doublet => f.write_str("doublet"),
            Shape::Multistep(digits) => digits.iter().try_for_each(|digit| write!(f, "{digit}")),
            Shape::Other(pulses) => write!(f, "other ({pulses} pulses)"),
        }
    }
}

/// The state before a manoeuvre, and how steady it was.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimState {
    /// The window, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
    /// True airspeed, m/s; the error is that of the mean.
    pub tas: Option<Measured>,
    /// Change of airspeed, m/s^2.
    pub acceleration: Option<Measured>,
    /// Density, kg/m^3.
    pub rho: Option<f64>,
    /// Pressure altitude, m.
    pub altitude: Option<f64>,
    /// Rate of climb by the altitude, m/s.
    pub climb: Option<Measured>,
    /// Root mean square of p, q, r in the window, rad/s.
    pub rates: [Option<f64>; 3],
    /// Why it is not steady; empty where it is.
    pub unsteady: Vec<String>,
}

/// The dominant oscillation of a free response.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeOscillation {
    /// Undamped frequency, rad/s.
    pub omega: Measured,
    /// Damping ratio.
    pub zeta: Measured,
    /// From when on no control moves, s.
    pub from_s: f64,
    /// Until when, s.
    pub to_s: f64,
    /// Cycles in which it stands above the rest.
    pub cycles: f64,
    /// How much of the motion about its drift it explains, 0 to 1.
    pub explained: f64,
    /// Channels it was seen in, with its size at `from_s`, in the channel's unit.
    pub channels: Vec<(Channel, f64)>,
    /// Peak to peak motion of the control meanwhile, over the manoeuvre's own.
    pub control_motion: f64,
    /// Frequency and damping ratio by the logarithmic decrement of the clearest channel.
    pub decrement: Option<(Measured, Measured)>,
    /// Whether the start was put off because an earlier one gave another answer: that start, and the zeta it gave.
    pub earlier: Option<(f64, Measured)>,
}

/// Initial response of one channel to a control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// The channel: p, q, r, or az for a collective.
    pub channel: Channel,
    /// Largest rate of change of it in the first pulse, over the pulse's level; for az the change of az itself.
    pub acceleration: Option<Measured>,
    /// Largest change of it in the first pulse, over the pulse's level.
    pub rate: Measured,
    /// That change itself, in the channel's unit.
    pub peak: Measured,
    /// From the control's half level to that peak, s.
    pub after_s: f64,
    /// Whether it stands above three standard errors.
    pub significant: bool,
}

/// What an axis does that the control is not there for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// The other channel: p, q or r.
    pub channel: Channel,
    /// Its root mean square over that of the on-axis channel, the noise's part taken out.
    pub ratio: Measured,
    /// Whether it stands above what the channel does in trim.
    pub significant: bool,
    /// When it first passes [`COUPLING_LEVEL`] of the on-axis peak, s after the control's start.
    pub exceeds_after_s: Option<f64>,
}

/// The level of [`Coupling::exceeds_after_s`], of the on-axis peak.
pub const COUPLING_LEVEL: f64 = 0.25;

/// One manoeuvre of a run.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields are what their names say")]
pub struct Manoeuvre {
    pub control: Control,
    /// When it starts to move (half the first pulse's level), s.
    pub start_s: f64,
    /// When the last pulse ends, s.
    pub end_s: f64,
    /// Level of the first pulse, signed, rad.
    pub amplitude: f64,
    /// The standard error of the amplitude, by the control's noise, rad.
    pub amplitude_std: f64,
    /// Greatest less least deviation, rad.
    pub travel: f64,
    /// What was flown.
    pub shape: Shape,
    pub pulses: Vec<Pulse>,
    /// Other controls that move meanwhile, with their travel, rad.
    pub others: Vec<(Control, f64)>,
    /// The state before it.
    pub trim: Result<TrimState, NotEstimable>,
    /// The oscillation after it.
    pub oscillation: Result<FreeOscillation, NotEstimable>,
    /// Initial responses by axis.
    pub sensitivities: Vec<Sensitivity>,
    /// Off-axis responses.
    pub couplings: Result<Vec<Coupling>, NotEstimable>,
    /// Span of the on-axis channel over the manoeuvre: greatest less least, in its unit.
    pub span: Option<Measured>,
}

/// Manoeuvres of one run, or the reason why there are none.
#[derive(Clone, Debug, PartialEq)]
pub struct RunInterpretation {
    /// Its name.
    pub run: String,
    /// How its controls are called.
    pub controls: ControlNames,
    /// Its manoeuvres in order of time.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Why there is none, where there is none.
    pub nothing: Option<String>,
}

/// Scatter of one channel between the runs of a test point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// The channel.
    pub channel: Channel,
    /// Standard deviation between runs over the root mean square of their mean response.
    pub scatter: Measured,
    /// What instrument noise alone gives.
    pub noise: f64,
}

/// Runs of the same trim, control, shape and amplitude (either sign).
#[derive(Clone, Debug, PartialEq)]
pub struct TestPoint {
    /// The control.
    pub control: Control,
    /// The shape.
    pub shape: Shape,
    /// Mean size of the amplitude, rad.
    pub amplitude: f64,
    /// Mean airspeed, m/s.
    pub tas: Option<f64>,
    /// Mean rate of climb, m/s.
    pub climb: Option<f64>,
    /// Which manoeuvres: run and place in it.
    pub members: Vec<(usize, usize)>,
    /// Scatter by channel.
    pub scatter: Result<Vec<Scatter>, NotEstimable>,
}

/// Runs that a test point takes.
pub const RUNS_A_POINT: usize = 3;

/// Which measure of the response a line was put through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Largest change in the first pulse, over the first pulse's level.
    Initial,
    /// Greatest less least over the manoeuvre, over the control's travel.
    Span,
}

/// A test of linearity and what it came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineTest {
    /// The number tested, and its standard error.
    pub found: Measured,
    /// Its size over its standard error.
    pub score: f64,
    /// The score above which chance explains it in fewer than 1 of 100 sets of runs (over all tests of the set).
    pub limit: f64,
}

impl LineTest {
    /// Whether chance does not explain it.
    pub fn significant(&self) -> bool {
        self.score.abs() > self.limit
    }
}

/// Linearity of the on-axis response with amplitude, over runs of one trim, control and shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearity {
    /// The control.
    pub control: Control,
    /// The shape.
    pub shape: Shape,
    /// The channel that responds.
    pub channel: Channel,
    /// What of the response.
    pub response: Response,
    /// Which sign of the first pulse: 1, -1, or 0 for both.
    pub side: i8,
    /// Smallest and largest size of the amplitude, rad.
    pub amplitudes: (f64, f64),
    /// How many runs.
    pub runs: usize,
    /// The line, or why there is none.
    pub line: Result<ResponseLine, NotEstimable>,
}

/// A line through responses, and tests of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseLine {
    /// Response a radian.
    pub slope: Measured,
    /// What the largest amplitude gives over what the smallest predicts, by the curve.
    pub growth: Measured,
    /// Curvature: what is lacking or in excess at the largest amplitude, as a part of the linear response.
    pub curvature: LineTest,
    /// Offset at no input, as a part of the response at the largest amplitude; estimated from three amplitudes up.
    pub offset: Option<LineTest>,
    /// Right over left slope less one; told for both sides together.
    pub asymmetry: Option<LineTest>,
    /// Whether the response is not in proportion: curvature beyond chance and more than [`MATERIAL`].
    pub nonlinear: bool,
}

/// Departure from proportion that matters.
pub const MATERIAL: f64 = 0.03;

/// The whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpretation {
    /// Run by run.
    pub runs: Vec<RunInterpretation>,
    /// Test points.
    pub points: Vec<TestPoint>,
    /// Lines over amplitudes.
    pub linearity: Vec<Linearity>,
}
