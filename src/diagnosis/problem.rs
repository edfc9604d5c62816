//! Several runs and one model: what the cost of a point is made of. Its neighbourhood is `linearise`, the way down `settle`.
//!
//! Consumes runs, the model and a point (hypotheses with their numbers, small errors of every derivative, each run's own
//! offsets); produces the normal equations of (3) of `filter` over all runs with the priors in them,
//!     A = sum_runs S'S + Lambda^-1     b = sum_runs S'e - Lambda^-1 (theta - theta_0)     theta <- theta + A^-1 b     (1)
//! and minus twice the logarithm of the evidence, after Laplace,
//!     E = cost + theta' Lambda^-1 theta + ln det A + ln det Lambda                                        (2)
//! The noise of forces and moments is never less than what the noise of the recorded controls makes.

use super::aircraft::{Aircraft, Partials};
use super::driven::Driven;
use super::linearise::With;
use super::point::{OWN, Point, nudged};
use super::run_record::{FELT, OUTPUT_CHANNELS, ROTOR, Record, input_channel};
use super::settle::Rounds;
use crate::estimation::compatibility::series::Series;
use crate::flight::channel::Channel;
use crate::flight::control::CONTROLS;
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::effect::Effect;
use crate::flight::model::Trim;

/// Least spectral density of forces and moments.
const LEAST_DENSITY: [f64; AXES] = [1e-6, 1e-6, 1e-6, 1e-8, 1e-8, 1e-8];
/// Where the density begins, before the innovations say better.
const FIRST_DENSITY: [f64; AXES] = [1e-2, 1e-2, 1e-2, 1e-4, 1e-4, 1e-4];
/// Where it begins on an axis that the model says nothing of: with an accelerometer, without one, and of moments.
const SILENT_DENSITY: (f64, f64, f64) = (1e-2, 1.0, 1e-2);
/// Standard deviation of what an accelerometer there is off by, m/s^2, and of a force and a moment that nothing says, m/s^2 and
/// rad/s^2.
const SILENT_STD: (f64, f64, f64) = (0.3, 3.0, 0.05);
/// Lags that the colour of innovations is looked for in.
const COLOUR_LAGS: usize = 40;
/// Innovations that scatter by more than this, of the variance that they should have, are of noisier instruments.
const NOISIER: f64 = 2.0;
/// Instruments are noisier than they seem where more than this part of all that the runs have is.
const NOISY_PART: f64 = 0.25;
/// Information on a small error, over what is known of it beforehand, below which it is as good as none.
const SHOWS: f64 = 0.02;
/// Times that their noise is taken anew.
const NOISE_ROUNDS: usize = 5;
/// Standard deviations of a run's own forces and moments where it begins in the model's trim, m/s^2 and rad/s^2.
const AT_TRIM_STD: [f64; AXES] = [0.02, 0.02, 0.02, 0.002, 0.002, 0.002];
/// And where it does not: the model then says how forces change, not what they are.
const OFF_TRIM_STD: [f64; AXES] = [2.0, 2.0, 2.0, 0.5, 0.5, 0.5];
/// So many channels are off the trim for one reason each; more are another trim.
const FEW: usize = 3;
/// Window at a run's start that is its trim, s.
const WINDOW_S: f64 = 1.0;
/// A channel is off the trim by more than this: m/s, and rad of attitude, flow and controls.
const OFF_SPEED: f64 = 1.0;
const OFF_ANGLE: f64 = 0.006;
/// An airspeed so far off, m/s, is another trim by itself: what the air does goes with its square.
const FAR_SPEED: f64 = 5.0;
/// Place of the airspeed among the outputs.
const TAS: usize = 9;
/// Of a uniform distribution, half width to standard deviation.
const UNIFORM: f64 = 0.577_350_269_189_625_8;

/// Runs and a model.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The model.
    pub aircraft: Aircraft,
    /// What the model file says besides.
    pub fixed: Vec<Effect>,
    /// The runs.
    pub runs: Vec<Record>,
    /// Derivatives that may be off by a little: axis, variable, standard deviation.
    pub small: Vec<(Axis, Variable, f64)>,
    /// Noise of forces and moments that the controls' own noise makes.
    pub least: [f64; AXES],
    /// Axes that the model says nothing of.
    pub silent: [bool; AXES],
    /// What of each run does not begin in the model's trim.
    pub off_trim: Vec<Channel>,
    /// Whether that makes another trim.
    pub other_trim: bool,
    /// Standard deviations of a run's own forces and moments about the model's trim.
    pub constant_std: [f64; AXES],
}

impl Problem {
    /// Of runs and a model whose derivatives may each be off by so much of themselves, and by their standard errors.
    pub fn new(aircraft: Aircraft, fixed: Vec<Effect>, mut runs: Vec<Record>, tolerance: f64, stds: &Partials) -> Self {
        let silent = Axis::ALL.map(|axis| aircraft.is_silent(axis));
        for run in &mut runs {
            (0..3).filter(|&axis| silent[axis]).for_each(|axis| run.feel(axis));
        }
        let mut small = Vec::new();
        for axis in Axis::ALL {
            for variable in Variable::ALL {
                let relative = UNIFORM * tolerance * libm::fabs(aircraft.linear.derivative(axis, variable));
                let std = libm::hypot(relative, stds[axis.index()][variable.index()]);
                if std > 0.0 {
                    small.push((axis, variable, std));
                }
            }
        }
        let mut least = LEAST_DENSITY;
        for (axis, least) in Axis::ALL.into_iter().zip(&mut least) {
            for (place, variable) in Variable::CONTROLS.into_iter().enumerate() {
                let by = aircraft.linear.derivative(axis, variable);
                *least += by * by * input_density(&runs, place);
            }
        }
        let off_trim = off_trim(aircraft.trim(), &runs);
        let speed = aircraft.trim().airspeed();
        let far =
            runs.iter().filter_map(|run| begins(run.outputs[TAS].as_ref())).any(|mean| libm::fabs(mean - speed) > FAR_SPEED);
        let other_trim = far || off_trim.len() >= FEW;
        let mut constant_std = if other_trim { OFF_TRIM_STD } else { AT_TRIM_STD };
        for axis in (0..AXES).filter(|&axis| silent[axis]) {
            constant_std[axis] = of_silent(axis, is_felt(&runs, axis), SILENT_STD);
            if axis < 3 && is_felt(&runs, axis) {
                least[axis] += input_density(&runs, FELT + axis);
            }
        }
        Problem { aircraft, fixed, runs, small, least, silent, off_trim, other_trim, constant_std }
    }

    /// Without the small errors that these runs cannot show: with noise at its least they would be known hardly better than
    /// beforehand, and so what they do is nothing beside the noise.
    #[must_use]
    pub fn of_what_shows(mut self) -> Self {
        let mut least = self.zero();
        let said = least.force.iter_mut().zip(self.least).zip(self.silent).filter(|(_, silent)| !silent);
        said.for_each(|((force, least), _)| *force = least);
        let Some(local) = self.linearise(&least, &[], With::Slopes) else { return self };
        let factor = local.factor.l();
        let mut rows = factor.row_iter();
        self.small.retain(|(.., std)| rows.next().is_none_or(|row| row.norm_squared() * std * std > 1.0 + SHOWS));
        self
    }

    /// Nothing is wrong.
    pub fn zero(&self) -> Point {
        let first = |axis: usize| {
            if self.silent[axis] { of_silent(axis, is_felt(&self.runs, axis), SILENT_DENSITY) } else { FIRST_DENSITY[axis] }
        };
        let force = core::array::from_fn(|axis| first(axis).max(self.least[axis]));
        Point {
            hypotheses: Vec::new(),
            small: [[0.0; VARIABLES]; AXES],
            own: vec![[0.0; OWN]; self.runs.len()],
            force,
            gust: (0.0, 4.0),
        }
    }

    /// Every effect at a point: the model file's own, then the hypotheses'.
    pub fn effects(&self, point: &Point) -> Vec<Effect> {
        self.fixed.iter().copied().chain(point.effects()).collect()
    }

    /// The same runs on a mesh of another rate.
    pub fn on_mesh_of(&self, rate_hz: f64) -> Problem {
        let mut finer = self.clone();
        for run in &mut finer.runs {
            run.lay_mesh(rate_hz);
        }
        finer
    }

    /// How many parameters a point has, and where those of its runs begin.
    pub(super) fn layout(&self, point: &Point) -> (usize, usize) {
        let shared = point.places().len() + self.small.len();
        (shared + self.runs.len() * OWN, shared)
    }

    /// The blades' motion of a run under these effects.
    pub(super) fn driven(&self, run: &Record, effects: &[Effect]) -> Driven {
        Driven::of(run, self.aircraft.trim(), effects)
    }

    /// Change of what reaches the blades for each run, a unit of the effect's number.
    pub fn slope_of(&self, effects: &[Effect], place: usize) -> Vec<Driven> {
        let Some(effect) = effects.get(place) else { return Vec::new() };
        let number = effect.main_number().unwrap_or(0.0);
        let step = (0.02 * libm::fabs(number)).max(match effect {
            Effect::RateLimit { .. } | Effect::DeadZone { .. } => 1e-7,
            _ => 1e-4,
        });
        let with = |by: f64| {
            let mut effects = effects.to_vec();
            if let Some(effect) = effects.get_mut(place) {
                *effect = nudged(effect, by);
            }
            effects
        };
        // A time cannot go below zero: its slope there is one-sided.
        let down = match effect {
            Effect::ActuatorLag { .. } | Effect::TransportDelay { .. } | Effect::SensorLag { .. } => -step.min(number),
            _ => -step,
        };
        let (above, below) = (with(step), with(down));
        self.runs.iter().map(|run| self.driven(run, &above).less(&self.driven(run, &below), step - down)).collect()
    }

    /// The least noise of forces at a point: where the rotor reacts, what the noise of its acceleration makes is in it.
    pub fn least_at(&self, point: &Point) -> [f64; AXES] {
        let changed = self.aircraft.changed(&self.effects(point), &point.small);
        let by = changed.reaction() * changed.share_of_yaw();
        let density = self.runs.iter().map(|run| run.rotor_rate_density).fold(0.0, f64::max);
        let mut least = self.least;
        least[Axis::N.index()] += by * by * density;
        least
    }

    /// What each axis's noise beyond the least is worth: how much the cost rises without it.
    pub fn unexplained(&self, point: &Point) -> Option<[f64; AXES]> {
        let least = self.least_at(point);
        let here = self.linearise(point, &[], With::Cost)?.cost;
        let mut rises = [0.0; AXES];
        for (axis, rise) in rises.iter_mut().enumerate().filter(|(axis, _)| !self.silent[*axis]) {
            let mut without = point.clone();
            without.force[axis] = least[axis];
            *rise = self.linearise(&without, &[], With::Cost).map_or(f64::INFINITY, |there| there.cost - here);
        }
        Some(rises)
    }

    /// The same with each output of each run as noisy as it is about a point: its innovations e, whitened by the noise that was
    /// taken, scatter by more or are coloured, so that n of them count as fewer. The variance is multiplied by
    ///     mean e^2 (1 + 2 sum rho_k)                                                                (4)
    /// with rho_k their autocorrelation up to where it is first not positive, until that is nowhere much more than one. `None`
    /// where it is much more on a few only: a force that the model lacks is seen by these, noisy instruments are all alike.
    pub fn with_noise_about(&self, point: &Point) -> Option<Problem> {
        let mut noisier = self.clone();
        let mut point = point.clone();
        for round in 0..NOISE_ROUNDS {
            let local = noisier.linearise(&point, &[], With::Traces)?;
            let (mut much, mut all) = (0.0, 0.0);
            for (run, passed) in noisier.runs.iter_mut().zip(&local.runs) {
                let seen = run.output_noise.iter_mut().zip(&run.outputs).enumerate().filter(|(_, (_, series))| series.is_some());
                for (output, (noise, _)) in seen {
                    let of = passed.innovations.iter().filter(|(_, place, _)| *place == output);
                    let by = scatter(&of.map(|(_, _, e)| *e).collect::<Vec<f64>>());
                    all += 1.0;
                    if by > NOISIER {
                        *noise *= libm::sqrt(by);
                        much += 1.0;
                    }
                }
            }
            if round == 0 && !(much > NOISY_PART * all) {
                return None;
            }
            if much == 0.0 {
                break;
            }
            (point, _) = noisier.settle(point, Rounds::SETTLED)?;
        }
        Some(noisier)
    }

    /// Whether the model speaks of every axis. Where it does not, noise stands for motion as it was measured, and its density is
    /// no number to be found.
    pub fn says_all(&self) -> bool {
        !self.silent.iter().any(|silent| *silent)
    }

    /// Whether any control moves by more than its noise.
    pub fn moves(&self) -> bool {
        self.runs.iter().any(|run| (0..CONTROLS).any(|control| run.moves(control)))
    }

    /// Whether a control or the rotor's speed is recorded.
    pub fn has_input(&self, place: usize) -> bool {
        let trimmed = place < CONTROLS || (place == ROTOR && self.aircraft.trim().rotor_speed.is_some());
        trimmed && self.runs.iter().any(|run| run.inputs.get(place).is_some_and(Option::is_some))
    }
}

/// (4) of whitened innovations in order of time.
fn scatter(e: &[f64]) -> f64 {
    if e.len() < COLOUR_LAGS {
        return 1.0;
    }
    let product = |lag: usize| e.iter().zip(e.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>() / e.len() as f64;
    let power = product(0);
    if !(power > 0.0) {
        return 1.0;
    }
    let coloured: f64 = (1..COLOUR_LAGS).map(|lag| product(lag) / power).take_while(|rho| *rho > 0.0).sum();
    power * (1.0 + 2.0 * coloured)
}

/// Whether every run has what an accelerometer felt along an axis that the model says nothing of.
fn is_felt(runs: &[Record], axis: usize) -> bool {
    runs.iter().all(|run| run.inputs.get(FELT + axis).is_some_and(Option::is_some))
}

/// The largest density of an input's own noise over the runs, its unit squared times s.
fn input_density(runs: &[Record], place: usize) -> f64 {
    let density = runs.iter().filter_map(|run| {
        let noise = run.input_noise.get(place)?;
        Some(noise * noise * run.inputs.get(place)?.as_ref()?.interval_s()?)
    });
    density.fold(0.0, f64::max)
}

/// Of an axis that the model says nothing of: a force that is felt, one that is not, a moment.
fn of_silent(axis: usize, felt: bool, (felt_one, force, moment): (f64, f64, f64)) -> f64 {
    match axis {
        0..3 if felt => felt_one,
        0..3 => force,
        _ => moment,
    }
}

/// Mean over a channel's first second.
fn begins(series: Option<&Series>) -> Option<f64> {
    let series = series?;
    let (from_s, _) = series.range_s()?;
    Some(series.mean(from_s, from_s + WINDOW_S))
}

/// Channels that do not begin where the model's trim has them, in any run.
fn off_trim(trim: &Trim, runs: &[Record]) -> Vec<Channel> {
    let airspeed = trim.airspeed().max(1.0);
    let outputs = [
        (6, trim.phi, OFF_ANGLE),
        (7, trim.theta, OFF_ANGLE),
        (TAS, airspeed, OFF_SPEED),
        (10, libm::atan2(trim.w, trim.u), OFF_ANGLE),
        (11, libm::asin((trim.v / airspeed).clamp(-1.0, 1.0)), OFF_ANGLE),
    ];
    let mut off = Vec::new();
    for (output, at_trim, most) in outputs {
        if runs.iter().filter_map(|run| begins(run.outputs.get(output)?.as_ref())).any(|mean| libm::fabs(mean - at_trim) > most) {
            off.push(OUTPUT_CHANNELS[output]);
        }
    }
    for (input, at_trim) in trim.controls.into_iter().enumerate() {
        if runs
            .iter()
            .filter_map(|run| begins(run.inputs.get(input)?.as_ref()))
            .any(|mean| libm::fabs(mean - at_trim) > OFF_ANGLE)
        {
            off.push(input_channel(input));
        }
    }
    off
}
