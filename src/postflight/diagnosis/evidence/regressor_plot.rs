//! The picture that would convince a sceptic: the residual over the regressor of its cause.
//!
//! Consumes the problem and where the search ended; produces for each cause, all others in the model, the residual of its axis
//! (or of its channel, where it is an instrument) without the cause and with it, over
//! - the cause's own regressor, where it is linear in its number theta: the line is e = theta x;
//! - else what the cause adds to the axis or the reading, x = F(with) - F(without): the line is e = x.
//!
//! Both are means over [`MEAN_S`], which takes most of the noise out of differenced gyros and leaves the line where it is.
//! A cause that moves several axes is shown on the one where it does most, over noise. Gusts have no such picture.

use super::residual_coherence::Signal;
use super::residual_series::FilteredRun;
use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::flight::effect::{Effect, PositionedSensor};
use crate::flight::term::Term;
use crate::postflight::diagnosis::data::run_data::{ALPHA_OUTPUT, BETA_OUTPUT, FORCE_OUTPUT, OUTPUT_CHANNELS};
use crate::postflight::diagnosis::likelihood::aircraft::Partials;
use crate::postflight::diagnosis::likelihood::parameter::output_of;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::search::forward_search::SearchResult;

/// Length of a mean, s.
pub const MEAN_S: f64 = 0.25;

/// What is along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Regressor {
    /// A deviation.
    Signal(Signal),
    /// A nonlinear term.
    Term(Term),
    /// The true value of the channel.
    True,
    /// What the cause adds.
    Added,
    /// Time, s: a bias correlates with nothing.
    Time,
}

/// What is along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ordinate {
    /// The residual of an axis.
    Axis(Axis),
    /// What a channel reads more than it would.
    Channel(Channel),
}

/// A cause's picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RegressorPlot {
    /// The cause.
    pub effect: Effect,
    /// What is along y.
    pub ordinate: Ordinate,
    /// What is along x.
    pub regressor: Regressor,
    /// The cause's line: value at x = 0, and slope.
    pub line: (f64, f64),
    /// Without the cause.
    pub before: Vec<(f64, f64)>,
    /// With it.
    pub after: Vec<(f64, f64)>,
}

/// By cause in the model, in the order of the search's point; `None` where a cause has no such picture.
pub fn regressor_plots(problem: &DiagnosisProblem, searched: &SearchResult) -> Vec<Option<RegressorPlot>> {
    (0..searched.point.hypotheses.len()).map(|place| of_cause(problem, searched, place)).collect()
}

/// x, without and with the cause, at nodes or steps, by run.
type Points = Vec<(f64, f64, f64)>;

fn of_cause(problem: &DiagnosisProblem, searched: &SearchResult, place: usize) -> Option<RegressorPlot> {
    let effect = searched.point.hypotheses.get(place)?.effect;
    let with = problem.effects(&searched.point);
    let mut without = with.clone();
    without.remove(problem.fixed.len() + place);
    let small = &searched.point.derivative_errors;
    let flown: Vec<FilteredRun<'_>> =
        (0..problem.runs.len()).filter_map(|number| FilteredRun::of(problem, searched, number)).collect();
    let outputs: &[usize] = match effect {
        Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, .. } => {
            &[FORCE_OUTPUT, FORCE_OUTPUT + 1, FORCE_OUTPUT + 2]
        }
        Effect::SensorPosition { sensor: PositionedSensor::Vane, .. } => &[ALPHA_OUTPUT, BETA_OUTPUT],
        _ => &[],
    };
    let own = output_of(&effect);
    let candidates: Vec<(Ordinate, Vec<Points>)> = match own.as_slice() {
        [] if outputs.is_empty() => on_axes(&flown, &effect, [&without, &with], small),
        [] => outputs.iter().filter_map(|&output| on_channel(&flown, output, [&without, &with], small)).collect(),
        one => one.iter().filter_map(|&output| on_channel(&flown, output, [&without, &with], small)).collect(),
    };
    let noise = |on: &Ordinate| {
        let output = match on {
            Ordinate::Axis(axis) => axis.index(),
            Ordinate::Channel(channel) => OUTPUT_CHANNELS.iter().position(|one| one == channel).unwrap_or(0),
        };
        problem.runs.iter().filter_map(|run| run.output_noise.get(output)).copied().fold(1e-12, f64::max)
    };
    // What it does is the difference of the residuals.
    let does = |on: &Ordinate, runs: &[Points]| {
        let (sum, count) = runs
            .iter()
            .flatten()
            .fold((0.0, 0.0), |(sum, count), (_, before, after)| (sum + (before - after) * (before - after), count + 1.0));
        libm::sqrt(sum / f64::max(count, 1.0)) / noise(on)
    };
    let (on, runs) = candidates.into_iter().max_by(|a, b| does(&a.0, &a.1).total_cmp(&does(&b.0, &b.1)))?;
    let (regressor, line) = regressor(problem, &effect);
    let mut picture = RegressorPlot { effect, ordinate: on, regressor, line, before: Vec::new(), after: Vec::new() };
    for (flown, points) in flown.iter().zip(&runs) {
        let several = (libm::round(MEAN_S / flown.step_s()) as usize).max(1);
        for points in points.chunks_exact(several) {
            let mean = |of: &dyn Fn(&(f64, f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / several as f64;
            let (before, after) = (mean(&|point| point.1), mean(&|point| point.2));
            let x = if regressor == Regressor::Added { before - after } else { mean(&|point| point.0) };
            if x.is_finite() && before.is_finite() && after.is_finite() {
                picture.before.push((x, before));
                picture.after.push((x, after));
            }
        }
    }
    (!picture.before.is_empty()).then_some(picture)
}

/// What stands along x, and the line there.
fn regressor(problem: &DiagnosisProblem, effect: &Effect) -> (Regressor, (f64, f64)) {
    match *effect {
        Effect::Derivative { variable, delta, .. } => (Regressor::Signal(Signal::Of(variable)), (0.0, delta)),
        Effect::FlightPath { variable, slope, .. } => {
            (Regressor::Signal(Signal::Of(variable)), (0.0, slope * problem.aircraft.trim().flight_path_angle()))
        }
        Effect::Nonlinear { term: Term::Linear(variable), coefficient, .. } => {
            (Regressor::Signal(Signal::Of(variable)), (0.0, coefficient))
        }
        Effect::Nonlinear { term, coefficient, .. } => (Regressor::Term(term), (0.0, coefficient)),
        Effect::RotorSpeed { coefficient, .. } => (Regressor::Signal(Signal::Read(Channel::RotorSpeed)), (0.0, coefficient)),
        Effect::SensorBias { value, .. } if output_of(effect).is_some() => (Regressor::Time, (value, 0.0)),
        Effect::SensorScale { factor, .. } if output_of(effect).is_some() => (Regressor::True, (0.0, factor - 1.0)),
        _ => (Regressor::Added, (0.0, 1.0)),
    }
}

/// Residuals of the axes that the cause may act on.
fn on_axes(
    flown: &[FilteredRun<'_>],
    effect: &Effect,
    [without, with]: [&[Effect]; 2],
    small: &Partials,
) -> Vec<(Ordinate, Vec<Points>)> {
    let runs: Vec<_> = flown
        .iter()
        .map(|flown| {
            let x: Vec<f64> = flown
                .motion(with)
                .iter()
                .map(|(deviations, _, rotor)| match *effect {
                    Effect::Derivative { variable, .. } | Effect::FlightPath { variable, .. } => deviations[variable.index()],
                    Effect::Nonlinear { term, .. } => term.value(deviations),
                    Effect::RotorSpeed { .. } => *rotor,
                    _ => 0.0,
                })
                .collect();
            (x, flown.residuals(without, small), flown.residuals(with, small))
        })
        .collect();
    let axes: Vec<Axis> = effect.axis().map_or(Axis::ALL.to_vec(), |axis| vec![axis]);
    let of = |axis: Axis| {
        let place = axis.index();
        let points = |(x, before, after): &(Vec<f64>, [Vec<f64>; AXES], [Vec<f64>; AXES])| -> Points {
            // A moment's stands in the middle of a step.
            let at = |k: usize| {
                let here = x.get(k).copied().unwrap_or(f64::NAN);
                if axis.is_force() { here } else { 0.5 * (here + x.get(k + 1).copied().unwrap_or(here)) }
            };
            before[place].iter().zip(&after[place]).enumerate().map(|(k, (before, after))| (at(k), *before, *after)).collect()
        };
        (Ordinate::Axis(axis), runs.iter().map(points).collect())
    };
    axes.into_iter().map(of).collect()
}

fn on_channel(
    flown: &[FilteredRun<'_>],
    output: usize,
    [without, with]: [&[Effect]; 2],
    small: &Partials,
) -> Option<(Ordinate, Vec<Points>)> {
    let channel = OUTPUT_CHANNELS.get(output).copied()?;
    let runs = flown.iter().map(|flown| -> Points {
        let time_s = |k: usize| flown.record().mesh.time_s(k);
        let (before, after) = (flown.readings(output, without, small), flown.readings(output, with, small));
        let scaled = with.iter().any(|effect| matches!(effect, Effect::SensorScale { channel: c, .. } if *c == channel));
        let points = before.iter().zip(&after).enumerate();
        points.map(|(k, ((z, plain), (_, read)))| (if scaled { *plain } else { time_s(k) }, z - plain, z - read)).collect()
    });
    Some((Ordinate::Channel(channel), runs.collect()))
}

impl RegressorPlot {
    /// The variable whose unit x has.
    pub fn variable(&self) -> Option<Variable> {
        match self.regressor {
            Regressor::Signal(Signal::Of(variable)) => Some(variable),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::control::Control;
    use crate::flight::derivative::VARIABLES;
    use crate::flight::file::model_file::ModelFile;
    use crate::flight::run::RunGeometry;
    use crate::postflight::diagnosis::data::run_data::RunData;
    use crate::postflight::diagnosis::likelihood::aircraft::Aircraft;
    use crate::postflight::diagnosis::search::forward_search::search;
    use crate::postflight::diagnosis::search::next_cause::SearchSettings;
    use crate::simulation::flight_model::{FlightModel, FlightRequest};
    use crate::simulation::fly::{Flight, Inputs, uniform_times};
    use crate::simulation::input::InputSpec;
    use crate::simulation::instrument::InstrumentSet;

    /// Slope through the origin, by least squares.
    fn slope(points: &[(f64, f64)]) -> f64 {
        points.iter().map(|(x, y)| x * y).sum::<f64>() / points.iter().map(|(x, _)| x * x).sum::<f64>()
    }

    /// The built-in aircraft with a stronger yaw damping, or a late gyro, than the model has.
    fn found(hidden: Effect) -> (DiagnosisProblem, SearchResult) {
        let puma = FlightModel::puma(&FlightRequest::default()).unwrap();
        let text = ModelFile { linear: puma.linear().clone(), ..puma.file }.to_toml();
        let model = FlightModel::parse(&text, &FlightRequest::default()).unwrap();
        let times_s = uniform_times(0.0, 14.0, 128.0).unwrap();
        let mut inputs = Inputs::at_trim(model.linear());
        let history = &mut inputs.controls[Control::Pedal.index()];
        *history = history.plus(1.0, &InputSpec::parse("pedal:3211:0.02:0.5:1").unwrap().deviation(0.5));
        let flight = Flight {
            inputs: inputs.sampled(&times_s),
            instruments: InstrumentSet::flight_quality(1.0),
            effects: vec![hidden],
            times_s,
            seed: 4,
            ..Flight::of(model.linear().clone())
        };
        let record = RunData::of("one", &flight.fly().unwrap().samples, RunGeometry::DEFAULT).unwrap();
        let problem = DiagnosisProblem::new(Aircraft::of(&model), Vec::new(), vec![record], 0.0, &[[0.0; VARIABLES]; AXES]);
        let searched = search(&problem, &[], &SearchSettings { causes: 1, ..SearchSettings::default() }).unwrap();
        (problem, searched)
    }

    #[test]
    fn a_residual_lies_on_the_line_of_its_cause_and_on_none_with_it() {
        let (problem, searched) = found(Effect::Derivative { axis: Axis::N, variable: Variable::R, delta: -0.6 });
        let pictures = regressor_plots(&problem, &searched);
        let [Some(picture)] = pictures.as_slice() else { panic!("{:?}", searched.rivals) };
        assert_eq!((picture.ordinate, picture.variable()), (Ordinate::Axis(Axis::N), Some(Variable::R)));
        let (before, after) = (slope(&picture.before), slope(&picture.after));
        assert!((before - picture.line.1).abs() < 0.1 && (picture.line.1 + 0.6).abs() < 0.1, "{before} {:?}", picture.line);
        assert!(after.abs() < 0.1, "{after}");
        assert_eq!(picture.before.len(), problem.runs[0].mesh.nodes.saturating_sub(1) / 8);
    }

    #[test]
    fn a_late_gyro_is_shown_on_what_it_reads() {
        let (problem, searched) = found(Effect::SensorDelay { channel: Channel::R, delay: 0.1 });
        let pictures = regressor_plots(&problem, &searched);
        let [Some(picture)] = pictures.as_slice() else { panic!("{:?}", searched.rivals) };
        assert_eq!((picture.ordinate, picture.regressor), (Ordinate::Channel(Channel::R), Regressor::Added));
        assert!((slope(&picture.before) - 1.0).abs() < 0.1 && slope(&picture.after).abs() < 0.1);
        // And the axis's own residual is gone with it.
        let with = problem.effects(&searched.point);
        let flown = FilteredRun::of(&problem, &searched, 0).unwrap();
        let square = |effects: &[Effect]| {
            let yaw = &flown.residuals(effects, &[[0.0; VARIABLES]; AXES])[Axis::N.index()];
            yaw.iter().map(|e| e * e).sum::<f64>() / yaw.len() as f64
        };
        assert!(square(&with) < 0.9 * square(&[]), "{} {}", square(&with), square(&[]));
    }
}
