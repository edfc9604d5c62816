//! Several runs and one model: the cost of a point, its neighbourhood, and the way down.
//!
//! Consumes runs, the model and a point (hypotheses with their numbers, small errors of every derivative, each run's own offsets);
//! produces the normal equations of (3) of `filter` over all runs with the priors in them,
//!     A = sum_runs S'S + Lambda^-1     b = sum_runs S'e - Lambda^-1 (theta - theta_0)     theta <- theta + A^-1 b     (1)
//! and minus twice the logarithm of the evidence, after Laplace,
//!     E = cost + theta' Lambda^-1 theta + ln det A + ln det Lambda                                        (2)
//! The noise of forces and moments, and that of gusts where there are any, goes with it by its own scores, (4) of `filter`:
//!     ln q <- ln q - (d cost)/(d^2 cost)                                                              (3)
//! It is never less than what the noise of the recorded controls makes.

use super::aircraft::{Aircraft, Partials};
use super::column::Column;
use super::driven::Driven;
use super::filter::{Asked, NOISES, Noise, Passed, Posed, pass};
use super::record::{OUTPUT_CHANNELS, OUTPUTS, ROTOR, Record};
use crate::flight::control::CONTROLS;
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::effect::{Effect, PositionedSensor};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Offsets that each run has for itself: forces and moments, then accelerometers and gyros.
pub const OWN: usize = AXES + 6;
/// Standard deviations of a run's own forces and moments about the model's trim, m/s^2 and rad/s^2.
const CONSTANT_STD: [f64; AXES] = [0.02, 0.02, 0.02, 0.002, 0.002, 0.002];
/// Of a run's own biases of accelerometers and gyros.
const BIAS_STD: [f64; 6] = [0.03, 0.03, 0.03, 0.0005, 0.0005, 0.0005];
/// Least spectral density of forces and moments.
const LEAST_DENSITY: [f64; AXES] = [1e-6, 1e-6, 1e-6, 1e-8, 1e-8, 1e-8];
/// Where the density begins, before the innovations say better.
const FIRST_DENSITY: [f64; AXES] = [1e-2, 1e-2, 1e-2, 1e-4, 1e-4, 1e-4];
/// Most that the logarithm of a density changes at once.
const DENSITY_STEP: f64 = 3.0;
/// Least second derivative by a noise's logarithm.
const LEAST_CURVATURE: f64 = 0.3;
/// A control moves that goes through so many times its noise.
const STILL: f64 = 12.0;
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
}

/// An effect that is looked at, with what is known of its number beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// The effect with its number.
    pub effect: Effect,
    /// Standard deviation of the number about nothing being wrong.
    pub prior_std: f64,
}

/// Where everything stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What is in the model besides.
    pub hypotheses: Vec<Hypothesis>,
    /// Small errors of derivatives.
    pub small: Partials,
    /// Each run's own offsets.
    pub own: Vec<[f64; OWN]>,
    /// Noise, the same for all runs but the outputs'.
    pub force: [f64; AXES],
    /// Gusts: standard deviation, m/s, and time constant, s.
    pub gust: (f64, f64),
}

/// The neighbourhood of a point.
#[derive(Clone, Debug)]
pub struct Local {
    /// Cost with the priors.
    pub cost: f64,
    /// A of (1), its factor, and b.
    pub factor: Cholesky<f64, Dyn>,
    /// b of (1).
    pub pull: DVector<f64>,
    /// ln det A + ln det Lambda.
    pub volume: f64,
    /// Products of the kept columns with the candidates' [kept x candidates].
    pub cross: DMatrix<f64>,
    /// Of each candidate with itself.
    pub diagonal: Vec<f64>,
    /// Of each candidate with the innovations.
    pub candidate_pull: Vec<f64>,
    /// Root mean square force of each candidate's column.
    pub strength: Vec<f64>,
    /// Slope and second derivative of the cost by the logarithm of each noise, (3).
    pub noisier: [(f64, f64); NOISES],
    /// Every run.
    pub runs: Vec<Passed>,
}

impl Local {
    /// (2).
    pub fn evidence(&self) -> f64 {
        self.cost + self.volume
    }

    /// Standard deviation of a parameter.
    pub fn std(&self, place: usize) -> f64 {
        let order = self.pull.len();
        let mut unit = DVector::zeros(order);
        if let Some(entry) = unit.get_mut(place) {
            *entry = 1.0;
        }
        libm::sqrt(self.factor.solve(&unit).get(place).copied().unwrap_or(f64::NAN))
    }
}

/// A candidate: its column, and where that changes what reaches the blades, for every run how.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What it acts on.
    pub column: Column,
    /// Changes of what reaches the blades, by run, per unit.
    pub moved: Vec<Driven>,
}

/// A step of a number for differences.
fn nudged(effect: &Effect, by: f64) -> Effect {
    let mut effect = *effect;
    match &mut effect {
        Effect::ActuatorLag { tau: x, .. }
        | Effect::TransportDelay { delay: x, .. }
        | Effect::RateLimit { rate: x, .. }
        | Effect::DeadZone { half_width: x, .. }
        | Effect::CrossFeed { gain: x, .. }
        | Effect::SensorBias { value: x, .. }
        | Effect::SensorScale { factor: x, .. }
        | Effect::SensorLag { tau: x, .. }
        | Effect::SensorDelay { delay: x, .. }
        | Effect::Derivative { delta: x, .. }
        | Effect::Nonlinear { coefficient: x, .. }
        | Effect::ControlEffectiveness { factor: x, .. }
        | Effect::RotorSpeed { coefficient: x, .. }
        | Effect::FlightPath { slope: x, .. }
        | Effect::Turbulence { sigma: x, .. } => *x += by,
        Effect::SensorPosition { .. } | Effect::None | Effect::Unknown { .. } => {}
    }
    effect
}

/// The place of a channel among the outputs.
pub fn output_of(effect: &Effect) -> Option<usize> {
    let channel = effect.sensor_channel()?;
    OUTPUT_CHANNELS.iter().position(|&output| output == channel)
}

/// Whether an effect changes what reaches the blades.
pub fn moves_blades(effect: &Effect) -> bool {
    match effect {
        Effect::ActuatorLag { .. }
        | Effect::TransportDelay { .. }
        | Effect::RateLimit { .. }
        | Effect::DeadZone { .. }
        | Effect::CrossFeed { .. } => true,
        _ => effect.sensor_channel().is_some() && output_of(effect).is_none(),
    }
}

/// What an effect is when nothing is wrong, as its number.
pub fn nothing(effect: &Effect) -> f64 {
    match effect {
        Effect::ControlEffectiveness { .. } | Effect::SensorScale { .. } => 1.0,
        _ => 0.0,
    }
}

impl Point {
    /// Effects in it.
    pub fn effects(&self) -> impl Iterator<Item = Effect> + '_ {
        self.hypotheses.iter().map(|hypothesis| hypothesis.effect)
    }

    /// Places of the hypotheses' parameters: hypothesis and component.
    fn places(&self) -> Vec<(usize, usize)> {
        let mut places = Vec::new();
        for (number, hypothesis) in self.hypotheses.iter().enumerate() {
            let components = if matches!(hypothesis.effect, Effect::SensorPosition { .. }) { 3 } else { 1 };
            places.extend((0..components).map(|component| (number, component)));
        }
        places
    }

    /// First place of a hypothesis's parameters.
    pub fn place_of(&self, hypothesis: usize) -> usize {
        self.places().iter().position(|&(number, _)| number == hypothesis).unwrap_or(0)
    }

    /// The place of a hypothesis's main number.
    pub fn main_place_of(&self, hypothesis: usize) -> usize {
        let first = self.place_of(hypothesis);
        match self.hypotheses.get(hypothesis).map(|hypothesis| hypothesis.effect) {
            Some(Effect::SensorPosition { offset_m: [x, y, z], .. }) => {
                let [x, y, z] = [x, y, z].map(libm::fabs);
                first
                    + if x >= y && x >= z {
                        0
                    } else if y >= z {
                        1
                    } else {
                        2
                    }
            }
            _ => first,
        }
    }

    fn number(&self, (hypothesis, component): (usize, usize)) -> f64 {
        match self.hypotheses.get(hypothesis).map(|hypothesis| hypothesis.effect) {
            Some(Effect::SensorPosition { offset_m, .. }) => offset_m.get(component).copied().unwrap_or(0.0),
            Some(effect) => effect.main_number().unwrap_or(0.0),
            None => 0.0,
        }
    }

    fn change(&mut self, (hypothesis, component): (usize, usize), by: f64, run_s: f64) {
        let Some(Hypothesis { effect, prior_std }) = self.hypotheses.get_mut(hypothesis) else { return };
        // One step goes no further than this prior allows.
        let by = by.clamp(-1.5 * *prior_std, 1.5 * *prior_std);
        if let Effect::SensorPosition { offset_m, .. } = effect {
            if let Some(offset) = offset_m.get_mut(component) {
                *offset += by;
            }
            return;
        }
        let now = effect.main_number().unwrap_or(0.0);
        let target = match effect {
            Effect::ActuatorLag { .. } | Effect::SensorLag { .. } => (now + by).clamp((0.3 * now).max(1e-3), 0.1 * run_s),
            Effect::TransportDelay { .. } => (now + by).clamp(0.0, 0.1 * run_s),
            Effect::SensorDelay { .. } => (now + by).clamp(-0.1 * run_s, 0.1 * run_s),
            Effect::RateLimit { .. } => (now + by).clamp(0.4 * now, 2.5 * now),
            Effect::DeadZone { .. } => (now + by).clamp(0.4 * now, 2.5 * now).max(1e-6),
            Effect::SensorScale { .. } | Effect::ControlEffectiveness { .. } => (now + by).max(0.05),
            _ => now + by,
        };
        *effect = nudged(effect, target - now);
    }
}

impl Problem {
    /// Of runs and a model whose derivatives may each be off by so much of themselves.
    pub fn new(aircraft: Aircraft, fixed: Vec<Effect>, runs: Vec<Record>, tolerance: f64) -> Self {
        let mut small = Vec::new();
        for axis in Axis::ALL {
            for variable in Variable::ALL {
                let std = UNIFORM * tolerance * libm::fabs(aircraft.linear.derivative(axis, variable));
                if std > 0.0 {
                    small.push((axis, variable, std));
                }
            }
        }
        let mut least = LEAST_DENSITY;
        for (axis, least) in Axis::ALL.into_iter().zip(&mut least) {
            for (place, variable) in Variable::CONTROLS.into_iter().enumerate() {
                let by = aircraft.linear.derivative(axis, variable);
                let density = runs.iter().filter_map(|run| {
                    let noise = run.input_noise.get(place)?;
                    Some(noise * noise * run.inputs.get(place)?.as_ref()?.interval_s()?)
                });
                *least += by * by * density.fold(0.0, f64::max);
            }
        }
        Problem { aircraft, fixed, runs, small, least }
    }

    /// Nothing is wrong.
    pub fn zero(&self) -> Point {
        let force = core::array::from_fn(|axis| FIRST_DENSITY[axis].max(self.least[axis]));
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
    fn layout(&self, point: &Point) -> (usize, usize) {
        let shared = point.places().len() + self.small.len();
        (shared + self.runs.len() * OWN, shared)
    }

    /// The blades' motion of a run under these effects.
    fn driven(&self, run: &Record, effects: &[Effect]) -> Driven {
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

    /// The columns of a point's hypotheses.
    fn own_columns(&self, point: &Point) -> (Vec<Column>, Vec<Vec<Driven>>) {
        let effects = self.effects(point);
        let mut moved: Vec<Vec<Driven>> = Vec::new();
        let mut columns = Vec::new();
        for (hypothesis, component) in point.places() {
            let place = self.fixed.len() + hypothesis;
            let Some(effect) = effects.get(place) else { continue };
            columns.push(if moves_blades(effect) {
                moved.push(self.slope_of(&effects, place));
                Column::Moved(moved.len() - 1)
            } else {
                self.column_of(effect, component)
            });
        }
        (columns, moved)
    }

    /// The column of an effect that does not change what reaches the blades.
    pub fn column_of(&self, effect: &Effect, component: usize) -> Column {
        match *effect {
            Effect::Derivative { axis, variable, .. } | Effect::FlightPath { axis, variable, .. } => {
                Column::Derivative(axis, variable)
            }
            Effect::Nonlinear { axis, term, .. } => Column::Term(axis, term),
            Effect::ControlEffectiveness { control, .. } => Column::Effectiveness(control.index()),
            Effect::RotorSpeed { axis, .. } => Column::RotorSpeed(axis),
            Effect::SensorPosition { sensor, .. } => Column::Place(sensor, component),
            _ => {
                let output = output_of(effect).unwrap_or(0);
                match effect {
                    Effect::SensorScale { .. } => Column::Scale(output),
                    Effect::SensorDelay { .. } => Column::Timing(output),
                    Effect::SensorLag { .. } => Column::Lag,
                    _ => Column::Bias(output),
                }
            }
        }
    }

    /// Noise of a run at a point.
    fn noise(&self, run: &Record, point: &Point) -> Noise {
        let mut output = run.output_noise.map(|std| std * std);
        // An accelerometer feels the blades at once, so that the recorded controls' noise is in what it is compared with.
        for (axis, variance) in Axis::ALL.into_iter().zip(output.iter_mut().take(3)) {
            for (variable, noise) in Variable::CONTROLS.into_iter().zip(run.input_noise) {
                let by = self.aircraft.linear.derivative(axis, variable) * noise;
                *variance += by * by;
            }
        }
        Noise { force: point.force, gust: point.gust, output }
    }

    /// Every run at a point, with sensitivities to its parameters and to the candidates, or the cost alone.
    pub fn linearise(&self, point: &Point, candidates: &[Candidate], with: With) -> Option<Local> {
        let effects = self.effects(point);
        let model = self.aircraft.changed(&effects, &point.small);
        let (own_columns, own_moved) = if with == With::Cost { (Vec::new(), Vec::new()) } else { self.own_columns(point) };
        let (order, shared) = self.layout(point);
        let mut columns: Vec<Column> = Vec::new();
        if with != With::Cost {
            columns.extend(&own_columns);
            columns.extend(self.small.iter().map(|&(axis, variable, _)| Column::Derivative(axis, variable)));
            columns.extend(Axis::ALL.map(Column::Constant));
            columns.extend((0..6).map(Column::Bias));
        }
        let kept = columns.len();
        for candidate in candidates {
            columns.push(match candidate.column {
                Column::Moved(_) => Column::Moved(
                    own_moved.len()
                        + candidates
                            .iter()
                            .take_while(|other| !core::ptr::eq(*other, candidate))
                            .filter(|other| matches!(other.column, Column::Moved(_)))
                            .count(),
                ),
                column => column,
            });
        }
        let mut information = DMatrix::<f64>::zeros(order, order);
        let mut pull = DVector::<f64>::zeros(order);
        let mut cross = DMatrix::<f64>::zeros(order, candidates.len());
        let mut diagonal = vec![0.0; candidates.len()];
        let mut candidate_pull = vec![0.0; candidates.len()];
        let mut strength = vec![0.0; candidates.len()];
        let (mut cost, mut runs) = (0.0, Vec::new());
        let mut noisier = [(0.0, 0.0); NOISES];
        for (number, record) in self.runs.iter().enumerate() {
            let driven = self.driven(record, &effects);
            let moved: Vec<Driven> = own_moved
                .iter()
                .filter_map(|by_run| by_run.get(number))
                .chain(candidates.iter().filter(|c| matches!(c.column, Column::Moved(_))).filter_map(|c| c.moved.get(number)))
                .cloned()
                .collect();
            let own = point.own.get(number).copied().unwrap_or([0.0; OWN]);
            let (mut bias, mut factor, mut late, mut lag) = ([0.0; OUTPUTS], [1.0; OUTPUTS], [0.0; OUTPUTS], None);
            bias[..6].copy_from_slice(&own[AXES..]);
            let mut accelerometer_m = record.geometry.accelerometer_position_m;
            let mut vane_m = record.geometry.vane_position_m;
            for effect in &effects {
                if let Effect::SensorPosition { sensor, offset_m } = effect {
                    let place = match sensor {
                        PositionedSensor::Accelerometer => &mut accelerometer_m,
                        PositionedSensor::Vane => &mut vane_m,
                    };
                    place.iter_mut().zip(offset_m).for_each(|(place, offset)| *place += offset);
                }
                let Some(output) = output_of(effect) else { continue };
                match *effect {
                    Effect::SensorBias { value, .. } => bias[output] += value,
                    Effect::SensorScale { factor: by, .. } => factor[output] *= by,
                    Effect::SensorDelay { delay, .. } => late[output] += delay,
                    Effect::SensorLag { tau, .. } => lag = Some((output, tau)),
                    _ => {}
                }
            }
            let readings = record.readings(&late);
            let mut constant = [0.0; AXES];
            constant.copy_from_slice(&own[..AXES]);
            let posed = Posed {
                record,
                model: &model,
                trim: self.aircraft.trim(),
                driven: &driven,
                moved: &moved,
                readings: &readings,
                constant,
                bias,
                factor,
                accelerometer_m,
                vane_m,
                lag,
            };
            let passed =
                pass(&posed, &self.noise(record, point), Asked { columns: &columns, kept, traces: with == With::Traces })?;
            cost += passed.cost;
            let width = columns.len();
            let global = |local: usize| if local < shared { local } else { local + number * OWN };
            for i in 0..kept {
                let row = &passed.information[i * width..(i + 1) * width];
                pull[global(i)] += passed.pull[i];
                for j in i..kept {
                    information[(global(i), global(j))] += row[j];
                }
                for (c, value) in row[kept..].iter().enumerate() {
                    cross[(global(i), c)] += value;
                }
            }
            for c in 0..candidates.len() {
                diagonal[c] += passed.diagonal[kept + c];
                candidate_pull[c] += passed.pull[kept + c];
                strength[c] = f64::max(strength[c], passed.strength[kept + c]);
            }
            for (sum, (slope, curvature)) in noisier.iter_mut().zip(passed.noisier) {
                sum.0 += slope;
                sum.1 += curvature;
            }
            runs.push(passed);
        }
        let mut log_priors = 0.0;
        let mut hold = |place: usize, value: f64, std: f64| {
            let weight = 1.0 / (std * std);
            cost += value * value * weight;
            if with != With::Cost {
                information[(place, place)] += weight;
                pull[place] -= value * weight;
            }
            log_priors += 2.0 * libm::log(std);
        };
        let places = point.places();
        for (place, &key) in places.iter().enumerate() {
            let Some(hypothesis) = point.hypotheses.get(key.0) else { continue };
            hold(place, point.number(key) - nothing(&hypothesis.effect), hypothesis.prior_std);
        }
        for (k, &(axis, variable, std)) in self.small.iter().enumerate() {
            hold(places.len() + k, point.small[axis.index()][variable.index()], std);
        }
        for (number, own) in point.own.iter().enumerate() {
            for (k, (value, std)) in own.iter().zip(CONSTANT_STD.iter().chain(&BIAS_STD)).enumerate() {
                hold(shared + number * OWN + k, *value, *std);
            }
        }
        if with == With::Cost {
            information = DMatrix::identity(order, order);
        }
        information.fill_lower_triangle_with_upper_triangle();
        let factor = Cholesky::new(information)?;
        let volume = log_priors + 2.0 * factor.l_dirty().diagonal().iter().map(|entry| libm::log(*entry)).sum::<f64>();
        Some(Local { cost, factor, pull, volume, cross, diagonal, candidate_pull, strength, noisier, runs })
    }

    /// The noises after a step (3).
    fn renewed(&self, point: &Point, noisier: &[(f64, f64); NOISES]) -> ([f64; AXES], f64) {
        let by = |of: usize| {
            let (slope, curvature) = noisier[of];
            libm::exp((-slope / curvature.max(LEAST_CURVATURE)).clamp(-DENSITY_STEP, DENSITY_STEP))
        };
        let force = core::array::from_fn(|axis| (point.force[axis] * by(axis)).max(self.least[axis]));
        // The gusts' density goes with the square of their standard deviation.
        (force, point.gust.0 * libm::sqrt(by(AXES)))
    }

    /// What each axis's noise beyond the least is worth: how much the cost rises without it.
    pub fn unexplained(&self, point: &Point) -> Option<[f64; AXES]> {
        let here = self.linearise(point, &[], With::Cost)?.cost;
        let mut rises = [0.0; AXES];
        for (axis, rise) in rises.iter_mut().enumerate() {
            let mut without = point.clone();
            without.force[axis] = self.least[axis];
            *rise = self.linearise(&without, &[], With::Cost).map_or(f64::INFINITY, |there| there.cost - here);
        }
        Some(rises)
    }

    /// Goes down from a point until nothing changes any more.
    pub fn settle(&self, mut point: Point, rounds: usize) -> Option<(Point, Local)> {
        let mut local = self.linearise(&point, &[], With::Slopes)?;
        for _ in 0..rounds {
            let (force, gust) = self.renewed(&point, &local.noisier);
            // What the change of the noises is worth, as that of the parameters.
            let moved = force
                .iter()
                .zip(&point.force)
                .zip(&local.noisier)
                .map(|((a, b), (slope, _))| libm::fabs(slope * libm::log(a / b)));
            let moved = moved.fold(0.0, f64::max);
            let step = local.factor.solve(&local.pull);
            let gain = step.dot(&local.pull);
            let mut next = self.stepped(&point, &step, 1.0);
            (next.force, next.gust.0) = (force, gust);
            let mut there = self.linearise(&next, &[], With::Slopes);
            if there.is_none() {
                next = self.stepped(&point, &step, 0.3);
                (next.force, next.gust.0) = (force, gust);
                there = self.linearise(&next, &[], With::Slopes);
            }
            (point, local) = (next, there?);
            if gain < 0.3 && moved < 0.5 {
                break;
            }
        }
        Some((point, local))
    }

    /// A part of the step (1).
    fn stepped(&self, point: &Point, step: &DVector<f64>, part: f64) -> Point {
        let mut next = point.clone();
        let run_s = self.runs.iter().map(Record::length_s).fold(f64::INFINITY, f64::min);
        let at = |place: usize| part * step.get(place).copied().unwrap_or(0.0);
        let places = point.places();
        for (place, &key) in places.iter().enumerate() {
            next.change(key, at(place), run_s);
        }
        for (k, &(axis, variable, _)) in self.small.iter().enumerate() {
            next.small[axis.index()][variable.index()] += at(places.len() + k);
        }
        let shared = places.len() + self.small.len();
        for (number, own) in next.own.iter_mut().enumerate() {
            for (k, value) in own.iter_mut().enumerate() {
                *value += at(shared + number * OWN + k);
            }
        }
        next
    }

    /// Whether any control moves by more than its noise.
    pub fn moves(&self) -> bool {
        self.runs.iter().any(|run| {
            run.inputs.iter().zip(run.input_noise).take(CONTROLS).flat_map(|(series, noise)| Some((series.as_ref()?, noise))).any(
                |(series, noise)| {
                    let (least, most) =
                        series.samples().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, x)| (a.min(x), b.max(x)));
                    most - least > STILL * noise.max(1e-6)
                },
            )
        })
    }

    /// Whether a control or the rotor's speed is recorded.
    pub fn has_input(&self, place: usize) -> bool {
        let trimmed = place < CONTROLS || (place == ROTOR && self.aircraft.trim().rotor_speed.is_some());
        trimmed && self.runs.iter().any(|run| run.inputs.get(place).is_some_and(Option::is_some))
    }
}

/// How much is made of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum With {
    /// The cost alone.
    Cost,
    /// Sensitivities.
    Slopes,
    /// Sensitivities, states and innovations.
    Traces,
}
