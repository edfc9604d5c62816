//! Every run at a point: the normal equations over all of them, with the priors in.
//!
//! Consumes the problem, a point and candidates; produces the cost, A and b of (1) of `problem`, ln det A + ln det Lambda of its
//! (2), and of each candidate its products with all parameters, with itself and with the innovations.

use super::column::Column;
use super::driven::Driven;
use super::filter::{Asked, NOISES, Noise, Passed, pass};
use super::point::{OWN, Point, moves_blades, output_of};
use super::posed::Posed;
use super::problem::Problem;
use super::run_record::{OUTPUTS, Record};
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::flight::effect::{Effect, PositionedSensor};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Standard deviations of a run's own biases of accelerometers and gyros.
const BIAS_STD: [f64; 6] = [0.03, 0.03, 0.03, 0.0005, 0.0005, 0.0005];

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

/// How much is made of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum With {
    /// The cost alone.
    Cost,
    /// And its slopes by the noises.
    Noises,
    /// Sensitivities.
    Slopes,
    /// Sensitivities, states and innovations.
    Traces,
}

impl Problem {
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
            Effect::RotorReaction { reaction } => Column::Reaction(libm::copysign(1.0, reaction)),
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
    pub fn linearise(&self, point: &Point, candidates: &[&Candidate], with: With) -> Option<Local> {
        let effects = self.effects(point);
        let model = self.aircraft.changed(&effects, &point.small);
        let sloped = matches!(with, With::Slopes | With::Traces);
        let (own_columns, own_moved) = if sloped { self.own_columns(point) } else { (Vec::new(), Vec::new()) };
        let (order, shared) = self.layout(point);
        let mut columns: Vec<Column> = Vec::new();
        if sloped {
            columns.extend(&own_columns);
            columns.extend(self.small.iter().map(|&(axis, variable, _)| Column::Derivative(axis, variable)));
            columns.extend(Axis::ALL.map(Column::Constant));
            columns.extend((0..6).map(Column::Bias));
        }
        let kept = columns.len();
        let mut moving = own_moved.len();
        columns.extend(candidates.iter().map(|candidate| match candidate.column {
            Column::Moved(_) => {
                moving += 1;
                Column::Moved(moving - 1)
            }
            column => column,
        }));
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
            let moved: Vec<&Driven> = own_moved
                .iter()
                .filter_map(|by_run| by_run.get(number))
                .chain(candidates.iter().filter(|c| matches!(c.column, Column::Moved(_))).filter_map(|c| c.moved.get(number)))
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
            let asked = Asked { columns: &columns, kept, noises: with != With::Cost, traces: with == With::Traces };
            let passed = pass(&posed, &self.noise(record, point), asked)?;
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
            if sloped {
                information[(place, place)] += weight;
                pull[place] -= value * weight;
            }
            log_priors += 2.0 * libm::log(std);
        };
        let places = point.places();
        for (place, &key) in places.iter().enumerate() {
            let Some(hypothesis) = point.hypotheses.get(key.0) else { continue };
            hold(place, point.number(key) - hypothesis.beforehand(key.1), hypothesis.prior_std);
        }
        for (k, &(axis, variable, std)) in self.small.iter().enumerate() {
            hold(places.len() + k, point.small[axis.index()][variable.index()], std);
        }
        for (number, own) in point.own.iter().enumerate() {
            for (k, (value, std)) in own.iter().zip(self.constant_std.iter().chain(&BIAS_STD)).enumerate() {
                hold(shared + number * OWN + k, *value, *std);
            }
        }
        if !sloped {
            information = DMatrix::identity(order, order);
        }
        information.fill_lower_triangle_with_upper_triangle();
        let factor = Cholesky::new(information)?;
        let volume = log_priors + 2.0 * factor.l_dirty().diagonal().iter().map(|entry| libm::log(*entry)).sum::<f64>();
        Some(Local { cost, factor, pull, volume, cross, diagonal, candidate_pull, strength, noisier, runs })
    }
}
