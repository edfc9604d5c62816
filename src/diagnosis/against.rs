//! The picture that would convince a sceptic: the residual against what the cause says that it goes with.
//!
//! Consumes the problem and where the search ended; produces for each cause, all others in the model, the residual of its axis
//! (or of its channel, where it is an instrument) without the cause and with it, over
//! - the cause's own regressor, where it is linear in its number theta: the line is e = theta x;
//! - else what the cause adds to the axis or the reading, x = F(with) - F(without): the line is e = x.
//!
//! Both are means over [`MEAN_S`], which takes most of the noise out of differenced gyros and leaves the line where it is.
//! A cause that moves several axes is shown on the one where it does most, over noise. Gusts have no such picture.

use super::aircraft::Partials;
use super::companions::Signal;
use super::point::output_of;
use super::problem::Problem;
use super::residual_series::Flown;
use super::run_record::OUTPUT_CHANNELS;
use super::screen::axis_of;
use super::search::Searched;
use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::flight::effect::{Effect, PositionedSensor};
use crate::flight::term::Term;

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
    /// Time, s: a bias goes with nothing.
    Time,
}

/// What is along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum On {
    /// The residual of an axis.
    Axis(Axis),
    /// What a channel reads more than it would.
    Channel(Channel),
}

/// A cause's picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Against {
    /// The cause.
    pub effect: Effect,
    /// What is along y.
    pub on: On,
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
pub fn against(problem: &Problem, searched: &Searched) -> Vec<Option<Against>> {
    (0..searched.point.hypotheses.len()).map(|place| of_cause(problem, searched, place)).collect()
}

/// x, without and with the cause, at nodes or steps, by run.
type Points = Vec<(f64, f64, f64)>;

fn of_cause(problem: &Problem, searched: &Searched, place: usize) -> Option<Against> {
    let effect = searched.point.hypotheses.get(place)?.effect;
    let with = problem.effects(&searched.point);
    let mut without = with.clone();
    without.remove(problem.fixed.len() + place);
    let small = &searched.point.small;
    let flown: Vec<Flown<'_>> = (0..problem.runs.len()).filter_map(|number| Flown::of(problem, searched, number)).collect();
    let outputs: &[usize] = match effect {
        Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, .. } => &[0, 1, 2],
        Effect::SensorPosition { sensor: PositionedSensor::Vane, .. } => &[10, 11],
        _ => &[],
    };
    let own = output_of(&effect);
    let candidates: Vec<(On, Vec<Points>)> = match own.as_slice() {
        [] if outputs.is_empty() => on_axes(&flown, &effect, [&without, &with], small),
        [] => outputs.iter().filter_map(|&output| on_channel(&flown, output, [&without, &with], small)).collect(),
        one => one.iter().filter_map(|&output| on_channel(&flown, output, [&without, &with], small)).collect(),
    };
    let noise = |on: &On| {
        let output = match on {
            On::Axis(axis) => axis.index(),
            On::Channel(channel) => OUTPUT_CHANNELS.iter().position(|one| one == channel).unwrap_or(0),
        };
        problem.runs.iter().filter_map(|run| run.output_noise.get(output)).copied().fold(1e-12, f64::max)
    };
    // What it does is the difference of the residuals.
    let does = |on: &On, runs: &[Points]| {
        let (sum, count) = runs
            .iter()
            .flatten()
            .fold((0.0, 0.0), |(sum, count), (_, before, after)| (sum + (before - after) * (before - after), count + 1.0));
        libm::sqrt(sum / f64::max(count, 1.0)) / noise(on)
    };
    let (on, runs) = candidates.into_iter().max_by(|a, b| does(&a.0, &a.1).total_cmp(&does(&b.0, &b.1)))?;
    let (regressor, line) = regressor(problem, &effect);
    let mut picture = Against { effect, on, regressor, line, before: Vec::new(), after: Vec::new() };
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
fn regressor(problem: &Problem, effect: &Effect) -> (Regressor, (f64, f64)) {
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
fn on_axes(flown: &[Flown<'_>], effect: &Effect, [without, with]: [&[Effect]; 2], small: &Partials) -> Vec<(On, Vec<Points>)> {
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
    let axes: Vec<Axis> = axis_of(effect).map_or(Axis::ALL.to_vec(), |axis| vec![axis]);
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
        (On::Axis(axis), runs.iter().map(points).collect())
    };
    axes.into_iter().map(of).collect()
}

/// Errors of a channel.
fn on_channel(
    flown: &[Flown<'_>],
    output: usize,
    [without, with]: [&[Effect]; 2],
    small: &Partials,
) -> Option<(On, Vec<Points>)> {
    let channel = OUTPUT_CHANNELS.get(output).copied()?;
    let runs = flown.iter().map(|flown| -> Points {
        let time_s = |k: usize| flown.record().mesh.time_s(k);
        let (before, after) = (flown.readings(output, without, small), flown.readings(output, with, small));
        let scaled = with.iter().any(|effect| matches!(effect, Effect::SensorScale { channel: c, .. } if *c == channel));
        let points = before.iter().zip(&after).enumerate();
        points.map(|(k, ((z, plain), (_, read)))| (if scaled { *plain } else { time_s(k) }, z - plain, z - read)).collect()
    });
    Some((On::Channel(channel), runs.collect()))
}

impl Against {
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
    use crate::diagnosis::aircraft::Aircraft;
    use crate::diagnosis::run_record::Record;
    use crate::diagnosis::search::{Settings, search};
    use crate::flight::control::Control;
    use crate::flight::derivative::VARIABLES;
    use crate::flight::model_file::ModelFile;
    use crate::flight::run::RunGeometry;
    use crate::simulation::flight_model::{Asked, FlightModel};
    use crate::simulation::fly::{Flight, Inputs, uniform_times};
    use crate::simulation::input::InputSpec;
    use crate::simulation::instrument::Instruments;

    /// Slope through the origin, by least squares.
    fn slope(points: &[(f64, f64)]) -> f64 {
        points.iter().map(|(x, y)| x * y).sum::<f64>() / points.iter().map(|(x, _)| x * x).sum::<f64>()
    }

    /// The built-in aircraft with a stronger yaw damping, or a late gyro, than the model has.
    fn found(hidden: Effect) -> (Problem, Searched) {
        let puma = FlightModel::puma(&Asked::default()).unwrap();
        let text = ModelFile { linear: puma.linear().clone(), ..puma.file }.to_toml();
        let model = FlightModel::parse(&text, &Asked::default()).unwrap();
        let times_s = uniform_times(0.0, 14.0, 128.0).unwrap();
        let mut inputs = Inputs::at_trim(model.linear());
        let history = &mut inputs.controls[Control::Pedal.index()];
        *history = history.plus(1.0, &InputSpec::parse("pedal:3211:0.02:0.5:1").unwrap().deviation(0.5));
        let flight = Flight {
            inputs: inputs.sampled(&times_s),
            instruments: Instruments::flight_quality(1.0),
            effects: vec![hidden],
            times_s,
            seed: 4,
            ..Flight::of(model.linear().clone())
        };
        let record = Record::of("one", &flight.fly().unwrap().samples, RunGeometry::DEFAULT).unwrap();
        let problem = Problem::new(Aircraft::of(&model), Vec::new(), vec![record], 0.0, &[[0.0; VARIABLES]; AXES]);
        let searched = search(&problem, &[], &Settings { causes: 1, ..Settings::default() }).unwrap();
        (problem, searched)
    }

    #[test]
    fn a_residual_lies_on_the_line_of_its_cause_and_on_none_with_it() {
        let (problem, searched) = found(Effect::Derivative { axis: Axis::N, variable: Variable::R, delta: -0.6 });
        let pictures = against(&problem, &searched);
        let [Some(picture)] = pictures.as_slice() else { panic!("{:?}", searched.rivals) };
        assert_eq!((picture.on, picture.variable()), (On::Axis(Axis::N), Some(Variable::R)));
        let (before, after) = (slope(&picture.before), slope(&picture.after));
        assert!((before - picture.line.1).abs() < 0.1 && (picture.line.1 + 0.6).abs() < 0.1, "{before} {:?}", picture.line);
        assert!(after.abs() < 0.1, "{after}");
        assert_eq!(picture.before.len(), problem.runs[0].mesh.nodes.saturating_sub(1) / 8);
    }

    #[test]
    fn a_late_gyro_is_shown_on_what_it_reads() {
        let (problem, searched) = found(Effect::SensorDelay { channel: Channel::R, delay: 0.1 });
        let pictures = against(&problem, &searched);
        let [Some(picture)] = pictures.as_slice() else { panic!("{:?}", searched.rivals) };
        assert_eq!((picture.on, picture.regressor), (On::Channel(Channel::R), Regressor::Added));
        assert!((slope(&picture.before) - 1.0).abs() < 0.1 && slope(&picture.after).abs() < 0.1);
        // And the axis's own residual is gone with it.
        let with = problem.effects(&searched.point);
        let flown = Flown::of(&problem, &searched, 0).unwrap();
        let square = |effects: &[Effect]| {
            let yaw = &flown.residuals(effects, &[[0.0; VARIABLES]; AXES])[Axis::N.index()];
            yaw.iter().map(|e| e * e).sum::<f64>() / yaw.len() as f64
        };
        assert!(square(&with) < 0.9 * square(&[]), "{} {}", square(&with), square(&[]));
    }
}
