//! Several runs and one model: what the cost of a point is made of. Its neighbourhood is `normal_equations`, the way down
//! `maximise`.
//!
//! Consumes runs, the model and a point (hypotheses with their numbers, small errors of every derivative, each run's own
//! offsets); produces the normal equations of (3) of `filter` over all runs with the priors in them,
//!     A = sum_runs S'S + Lambda^-1     b = sum_runs S'e - Lambda^-1 (theta - theta_0)     theta <- theta + A^-1 b     (1)
//! and minus twice the logarithm of the evidence, after Laplace,
//!     E = cost + theta' Lambda^-1 theta + ln det A + ln det Lambda                                        (2)
//! The noise of forces and moments is never less than what the noise of the recorded controls makes.

use super::aircraft::{Aircraft, Partials};
use super::parameter::{RUN_OFFSETS, difference_steps, output_of, with_number_changed};
use super::parameter_set::ParameterSet;
use crate::flight::channel::Channel;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::effect::Effect;
use crate::flight::unit::STANDARD_GRAVITY;
use crate::postflight::diagnosis::data::blade_input::BladeInput;
use crate::postflight::diagnosis::data::run_data::{MEASURED_FORCE, ROTOR, RunData};
use crate::postflight::diagnosis::data::trim_difference::trim_differences;
use crate::postflight::diagnosis::record::TrimDifference;

/// Least spectral density of forces and moments.
const LEAST_DENSITY: [f64; AXES] = [1e-6, 1e-6, 1e-6, 1e-8, 1e-8, 1e-8];
/// Where the density begins, before the innovations say better.
const FIRST_DENSITY: [f64; AXES] = [1e-2, 1e-2, 1e-2, 1e-4, 1e-4, 1e-4];
/// Where it begins on an axis without a model: with an accelerometer, without one, and of moments.
const UNMODELLED_DENSITY: (f64, f64, f64) = (1e-2, 1.0, 1e-2);
/// Standard deviation of what an accelerometer there is off by, m/s^2, and of a force and a moment that nothing says, m/s^2 and
/// rad/s^2.
const UNMODELLED_STD: (f64, f64, f64) = (0.3, 3.0, 0.05);
/// Standard deviations of a run's own forces and moments where it begins in the model's trim, m/s^2 and rad/s^2.
const AT_TRIM_STD: [f64; AXES] = [0.02, 0.02, 0.02, 0.002, 0.002, 0.002];
/// Where it does not, so many times what the model makes of each difference: the model says how forces change, not what they
/// are.
const OF_TRIM_DIFFERENCE: f64 = 2.0;
/// Of a uniform distribution, half width to standard deviation.
const UNIFORM: f64 = 0.577_350_269_189_625_8;

/// Runs and a model.
#[derive(Clone, Debug)]
pub struct DiagnosisProblem {
    /// The model.
    pub aircraft: Aircraft,
    /// What the model file says besides.
    pub fixed: Vec<Effect>,
    /// The runs.
    pub runs: Vec<RunData>,
    /// Derivatives that may be off by a little: axis, variable, standard deviation.
    pub derivative_tolerances: Vec<(Axis, Variable, f64)>,
    /// Noise of forces and moments that the controls' own noise makes.
    pub noise_floor: [f64; AXES],
    /// Axes without a model.
    pub unmodelled: [bool; AXES],
    /// Where runs do not begin in the model's trim.
    pub trim_differences: Vec<TrimDifference>,
    /// Standard deviations of a run's own forces and moments about the model's trim.
    pub constant_std: [f64; AXES],
}

impl DiagnosisProblem {
    /// Of runs and a model whose derivatives may each be off by so much of themselves, and by their standard errors.
    ///
    /// Where effects of the model file turn the sign of a channel or control, or exchange two, `runs` are as they should have
    /// been recorded.
    pub fn new(aircraft: Aircraft, fixed: Vec<Effect>, mut runs: Vec<RunData>, tolerance: f64, stds: &Partials) -> Self {
        let fixed = as_it_should_be_recorded(&aircraft, fixed, &mut runs);
        let unmodelled = Axis::ALL.map(|axis| aircraft.is_unmodelled(axis));
        for run in &mut runs {
            (0..3).filter(|&axis| unmodelled[axis]).for_each(|axis| run.use_measured_force(axis));
        }
        let mut derivative_tolerances = Vec::new();
        for axis in Axis::ALL {
            for variable in Variable::ALL {
                let relative = UNIFORM * tolerance * libm::fabs(aircraft.linear.derivative(axis, variable));
                let std = libm::hypot(relative, stds[axis.index()][variable.index()]);
                if std > 0.0 {
                    derivative_tolerances.push((axis, variable, std));
                }
            }
        }
        let mut noise_floor = LEAST_DENSITY;
        for (axis, noise_floor) in Axis::ALL.into_iter().zip(&mut noise_floor) {
            for (place, variable) in Variable::CONTROLS.into_iter().enumerate() {
                let by = aircraft.linear.derivative(axis, variable);
                *noise_floor += by * by * input_density(&runs, place);
            }
        }
        let trim_differences = trim_differences(aircraft.trim(), &runs);
        let mut constant_std = about_trim(&aircraft, &trim_differences);
        for axis in (0..AXES).filter(|&axis| unmodelled[axis]) {
            constant_std[axis] = of_unmodelled(axis, has_measured_force(&runs, axis), UNMODELLED_STD);
            if axis < 3 && has_measured_force(&runs, axis) {
                noise_floor[axis] += input_density(&runs, MEASURED_FORCE + axis);
            }
        }
        DiagnosisProblem { aircraft, fixed, runs, derivative_tolerances, noise_floor, unmodelled, trim_differences, constant_std }
    }

    /// Nothing is wrong.
    pub fn null_hypothesis(&self) -> ParameterSet {
        let first = |axis: usize| {
            if self.unmodelled[axis] {
                of_unmodelled(axis, has_measured_force(&self.runs, axis), UNMODELLED_DENSITY)
            } else {
                FIRST_DENSITY[axis]
            }
        };
        let force = core::array::from_fn(|axis| first(axis).max(self.noise_floor[axis]));
        ParameterSet {
            hypotheses: Vec::new(),
            derivative_errors: [[0.0; VARIABLES]; AXES],
            run_offsets: vec![[0.0; RUN_OFFSETS]; self.runs.len()],
            force_density: force,
            gust: (0.0, 4.0),
        }
    }

    /// Every effect at a point: the model file's own, then the hypotheses'.
    pub fn effects(&self, point: &ParameterSet) -> Vec<Effect> {
        self.fixed.iter().copied().chain(point.effects()).collect()
    }

    /// The same runs on a mesh of another rate.
    pub fn with_mesh_rate(&self, rate_hz: f64) -> DiagnosisProblem {
        let mut finer = self.clone();
        for run in &mut finer.runs {
            run.lay_mesh(rate_hz);
        }
        finer
    }

    /// How many parameters a point has, and where those of its runs begin.
    pub(crate) fn layout(&self, point: &ParameterSet) -> (usize, usize) {
        let shared = point.places().len() + self.derivative_tolerances.len();
        (shared + self.runs.len() * RUN_OFFSETS, shared)
    }

    /// The blades' motion of a run under these effects.
    pub(crate) fn blade_input(&self, run: &RunData, effects: &[Effect]) -> BladeInput {
        BladeInput::of(run, self.aircraft.trim(), effects)
    }

    /// Change of what reaches the blades for each run, a unit of the effect's number.
    pub fn blade_input_slope(&self, effects: &[Effect], place: usize) -> Vec<BladeInput> {
        let Some(effect) = effects.get(place) else { return Vec::new() };
        let number = effect.main_number().unwrap_or(0.0);
        let (step, down) = difference_steps(effect, number);
        let with = |by: f64| {
            let mut effects = effects.to_vec();
            if let Some(effect) = effects.get_mut(place) {
                *effect = with_number_changed(effect, by);
            }
            effects
        };
        let (above, below) = (with(step), with(down));
        self.runs
            .iter()
            .map(|run| self.blade_input(run, &above).difference(&self.blade_input(run, &below), step - down))
            .collect()
    }

    /// The least noise of forces at a point: where the rotor reacts, what the noise of its acceleration makes is in it.
    pub fn noise_floor_at(&self, point: &ParameterSet) -> [f64; AXES] {
        let changed = self.aircraft.changed(&self.effects(point), &point.derivative_errors);
        let by = changed.reaction() * changed.share_of_yaw();
        let density = self.runs.iter().map(|run| run.rotor_rate_density).fold(0.0, f64::max);
        let mut least = self.noise_floor;
        least[Axis::N.index()] += by * by * density;
        least
    }

    /// Whether the model speaks of every axis. Where it does not, noise stands for motion as it was measured, and its density is
    /// no number to be found.
    pub fn models_all_axes(&self) -> bool {
        !self.unmodelled.iter().any(|unmodelled| *unmodelled)
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

/// Turns the sign of what is recorded with it turned, and exchanges what is exchanged: the effects that remain are neither.
fn as_it_should_be_recorded(aircraft: &Aircraft, mut effects: Vec<Effect>, runs: &mut [RunData]) -> Vec<Effect> {
    // The last that happened to the record is undone first.
    for effect in effects.iter_mut().rev() {
        let output = output_of(effect);
        match (effect, output) {
            (Effect::SensorScale { factor, .. }, Some(output)) if *factor < 0.0 => {
                *factor = -*factor;
                runs.iter_mut().for_each(|run| run.turn_output(output));
            }
            (Effect::ControlEffectiveness { control, factor }, _) if *factor < 0.0 => {
                *factor = -*factor;
                let place = control.index();
                let at_trim = aircraft.trim().controls.get(place).copied().unwrap_or(0.0);
                runs.iter_mut().for_each(|run| run.turn_input(place, at_trim));
            }
            (Effect::Exchanged { channels }, _) => runs.iter_mut().for_each(|run| run.exchange(*channels)),
            _ => {}
        }
    }
    effects.retain(|effect| match *effect {
        Effect::Exchanged { .. } => false,
        Effect::SensorScale { factor, .. } | Effect::ControlEffectiveness { factor, .. } => factor.total_cmp(&1.0).is_ne(),
        _ => true,
    });
    effects
}

/// Whether every run has what an accelerometer felt along an axis without a model.
fn has_measured_force(runs: &[RunData], axis: usize) -> bool {
    runs.iter().all(|run| run.inputs.get(MEASURED_FORCE + axis).is_some_and(Option::is_some))
}

/// The largest density of an input's own noise over the runs, its unit squared times s.
fn input_density(runs: &[RunData], place: usize) -> f64 {
    let density = runs.iter().filter_map(|run| {
        let noise = run.input_noise.get(place)?;
        Some(noise * noise * run.inputs.get(place)?.as_ref()?.interval_s()?)
    });
    density.fold(0.0, f64::max)
}

/// Of an axis without a model: a force that is felt, one that is not, a moment.
fn of_unmodelled(axis: usize, felt: bool, (felt_one, force, moment): (f64, f64, f64)) -> f64 {
    match axis {
        0..3 if felt => felt_one,
        0..3 => force,
        _ => moment,
    }
}

/// Standard deviations of a run's own forces and moments, by what the model makes of the runs' differences of trim:
///     sigma_a^2 = s_a^2 + sum_j (k F_aj d_j)^2
/// with s = [`AT_TRIM_STD`], k = [`OF_TRIM_DIFFERENCE`], F the model's derivatives, weight's along X and Y by attitude among
/// them, and d_j the largest difference of a variable. Without a cliff: a small difference widens them by a little.
fn about_trim(aircraft: &Aircraft, differences: &[TrimDifference]) -> [f64; AXES] {
    let of = |channel: Channel| differences.iter().find(|one| one.channel == channel).map_or(0.0, |one| one.largest);
    let trim = aircraft.trim();
    let speed = trim.airspeed();
    let mut by_variable = vec![
        (Variable::U, libm::hypot(of(Channel::Tas), of(Channel::Alpha) * trim.w)),
        (Variable::V, speed * of(Channel::Beta)),
        (Variable::W, libm::hypot(speed * of(Channel::Alpha), of(Channel::Tas) * libm::sin(trim.incidence()))),
    ];
    by_variable.extend(Control::ALL.into_iter().map(|control| (control.variable(), of(control.channel()))));
    let weight = |axis: Axis| match axis {
        Axis::X => STANDARD_GRAVITY * of(Channel::Theta),
        Axis::Y => STANDARD_GRAVITY * of(Channel::Phi),
        _ => 0.0,
    };
    let mut stds = AT_TRIM_STD;
    for (axis, std) in Axis::ALL.into_iter().zip(&mut stds) {
        let by = by_variable.iter().map(|(variable, difference)| aircraft.linear.derivative(axis, *variable) * difference);
        let squares = by.chain([weight(axis)]).map(|force| force * force).sum::<f64>();
        *std = libm::hypot(*std, OF_TRIM_DIFFERENCE * libm::sqrt(squares));
    }
    stds
}
