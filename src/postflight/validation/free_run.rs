//! A free run: the model simulated on a run's measured controls, and the readings of its instruments.
//!
//! Consumes a model (linear or Level-1), effects, a run's samples and geometry; produces, for each channel at its own samples,
//! the measured z and the predicted y. Nothing is fitted to the run.
//!
//! Perturbations are deviations from the run's own trim, the mean over the trim window, so the model starts in its own trim and
//! its controls (and the rotor's speed, where the run has it) follow the measured deviations:
//!     c(t) = c_trim + z_c(t) - mean z_c                                                  (1)
//! linear between samples. Readings are predicted through the effects on instruments, at the positions that the run declares. The
//! offset of a channel is the mean over the window of z - y; the error is
//!     e = z - y - offset, or e = z - y where absolute values are asked for                (2)
//! (a bias of an instrument appears in the second only). Errors of the heading are wrapped to half a turn. A linear model without
//! any derivative of an axis does not model the channels which that axis moves first (X of `ax` and `tas`, M of `q` and `theta`,
//! and so on): those are not predicted. Gusts are not predicted either: turbulence is left out. Where the motion diverges, the
//! prediction ends there, at a reported time.
//! Source: proof of match, R. V. Jategaonkar, Flight Vehicle System Identification, 2006, ch. 11; (2) is ours.
//! Returns [`PredictionError`] for a run that is too short, out of order, or without a control that the model responds to.

use crate::dynamics::linear::with_effects;
use crate::flight::channel::Channel;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::Axis;
use crate::flight::effect::Effect;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::flight::signal::piecewise_linear::History;
use crate::flight::signal::series::Series;
use crate::simulation::flight_model::FlightModel;
use crate::simulation::fly::recorded_as;
use crate::simulation::fly::{Flight, Inputs, SimulationError};
use crate::simulation::instrument::{Instrument, InstrumentSet};
use core::f64::consts::PI;

/// The usual trim window: the first second.
pub const TRIM_WINDOW_S: f64 = 1.0;

/// Fewest rows of a run that can be predicted.
const FEWEST_ROWS: usize = 32;

/// A recorded run to be predicted.
#[derive(Clone, Copy, Debug)]
pub struct ValidationRun<'r> {
    /// Its samples, time increasing.
    pub samples: &'r [Sample],
    /// Positions of its instruments.
    pub geometry: &'r RunGeometry,
    /// Length of its trim window, s.
    pub trim_window_s: f64,
    /// Controls taken as constant where the run lacks them, by [`Control`] place.
    pub still: [bool; CONTROLS],
}

impl<'r> ValidationRun<'r> {
    /// A run with [`TRIM_WINDOW_S`] and every control recorded.
    pub fn of(samples: &'r [Sample], geometry: &'r RunGeometry) -> Self {
        ValidationRun { samples, geometry, trim_window_s: TRIM_WINDOW_S, still: [false; CONTROLS] }
    }
}

/// One channel, measured and predicted at the same times.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedChannel {
    /// Channel.
    pub channel: Channel,
    /// Times, s.
    pub times_s: Vec<f64>,
    /// Measured values, SI; a heading unwrapped.
    pub measured: Vec<f64>,
    /// Predicted readings, absolute, SI.
    pub predicted: Vec<f64>,
    /// Mean of measured less predicted over the trim window.
    pub offset: f64,
    /// Mean of the predicted readings over the trim window.
    pub at_trim: f64,
    /// Standard deviation of the instrument's white noise, estimated from the record; zero where it has none.
    pub noise_std: f64,
}

impl PredictedChannel {
    /// Errors (2) at the times.
    pub fn errors(&self, absolute: bool) -> impl Iterator<Item = f64> + '_ {
        let offset = if absolute { 0.0 } else { self.offset };
        let turns = self.channel == Channel::Psi;
        self.measured.iter().zip(&self.predicted).map(move |(measured, predicted)| {
            let error = measured - predicted - offset;
            if turns { error - 2.0 * PI * libm::round(error / (2.0 * PI)) } else { error }
        })
    }
}

/// Predictions of a free run beside the measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeRunPrediction {
    /// The channels that were measured and can be predicted.
    pub channels: Vec<PredictedChannel>,
    /// Measured channels on whose axis the model has no derivative.
    pub not_predicted: Vec<Channel>,
    /// Effects of the simulation.
    pub effects: Vec<Effect>,
    /// When the motion diverged, s; nothing is predicted after it.
    pub diverged_at_s: Option<f64>,
    /// First and last time of the run, s.
    pub range_s: [f64; 2],
}

/// Why a run cannot be predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum PredictionError {
    #[error("expected more than {needed_s} s and {FEWEST_ROWS} rows, found {rows} rows over {found_s:.2} s")]
    Short { needed_s: f64, found_s: f64, rows: usize },
    #[error("row {row}: expected a time after {before_s} s, found {time_s} s")]
    Time { row: usize, before_s: f64, time_s: f64 },
    #[error("expected a column `{0}`, a control that the model answers to, found none")]
    NoControl(&'static str),
    #[error("`{0}` has no value in the trim window, the first {1} s")]
    NoTrim(&'static str, f64),
    #[error("{0}")]
    Simulation(#[from] SimulationError),
}

/// The free run of a model with these effects (the file's own are to be among them) on a run's controls.
///
/// # Errors
/// [`PredictionError`] where the run or an effect cannot be simulated. A motion that diverges is no error.
pub fn predict(model: &FlightModel, effects: &[Effect], run: &ValidationRun<'_>) -> Result<FreeRunPrediction, PredictionError> {
    let range_s = range(run)?;
    let in_trim = model.flight();
    let effects: Vec<Effect> = effects.iter().copied().filter(can_be_flown).collect();
    let inputs = inputs(&in_trim, &effects, run, range_s[0])?;
    let may_be = Channel::ALL.into_iter().filter(|&channel| predictable(channel, &in_trim));
    let (channels, without): (Vec<Channel>, Vec<Channel>) =
        may_be.partition(|&channel| axis_of(channel).is_none_or(|axis| has_axis(axis, &in_trim, &effects)));
    let not_predicted = without.into_iter().filter(|&channel| finite(run.samples, channel).next().is_some()).collect();
    let instruments = InstrumentSet {
        channels: channels.iter().copied().map(Instrument::perfect).collect(),
        accelerometer_position_m: run.geometry.accelerometer_position_m,
        vane_position_m: run.geometry.vane_position_m,
        blades: None,
        dropouts: None,
    };
    let times_s: Vec<f64> = run.samples.iter().map(|sample| sample.time_s).collect();
    let flown = Flight { effects: effects.clone(), inputs, instruments, times_s, ..in_trim }.fly()?;
    let until_s = range_s[0] + run.trim_window_s;
    let channels = channels.into_iter().filter_map(|channel| predicted(channel, run, &flown.samples, until_s)).collect();
    Ok(FreeRunPrediction { channels, not_predicted, effects, diverged_at_s: flown.diverged_at_s, range_s })
}

/// Whether an effect is on the aircraft, its controls or its instruments, and not on the air.
fn can_be_flown(effect: &Effect) -> bool {
    !matches!(effect, Effect::None | Effect::Unknown { .. } | Effect::Turbulence { .. })
}

fn range(run: &ValidationRun<'_>) -> Result<[f64; 2], PredictionError> {
    for (row, pair) in run.samples.windows(2).enumerate() {
        if let [before, after] = pair
            && !(after.time_s > before.time_s)
        {
            return Err(PredictionError::Time { row: row + 2, before_s: before.time_s, time_s: after.time_s });
        }
    }
    let ends = run.samples.first().zip(run.samples.last()).map(|(first, last)| [first.time_s, last.time_s]);
    let [first_s, last_s] = ends.unwrap_or_default();
    let (needed_s, rows) = (2.0 * run.trim_window_s, run.samples.len());
    if !(last_s - first_s > needed_s && rows >= FEWEST_ROWS) {
        return Err(PredictionError::Short { needed_s, found_s: last_s - first_s, rows });
    }
    Ok([first_s, last_s])
}

/// Equation (1).
fn inputs(in_trim: &Flight, effects: &[Effect], run: &ValidationRun<'_>, start_s: f64) -> Result<Inputs, PredictionError> {
    let trim = &in_trim.model.trim;
    let mut inputs = Inputs::at_trim(&in_trim.model);
    let about = |channel: Channel, at_trim: f64| -> Result<Option<History>, PredictionError> {
        let points: Vec<(f64, f64)> = finite(run.samples, channel).collect();
        if points.is_empty() {
            return Ok(None);
        }
        let mean = mean(points.iter().filter(|(time_s, _)| *time_s <= start_s + run.trim_window_s).map(|&(_, value)| value));
        let name = channel.name(run.geometry.controls);
        let mean = mean.ok_or(PredictionError::NoTrim(name, run.trim_window_s))?;
        Ok(History::through(points).ok().map(|history| history.shifted(at_trim - mean)))
    };
    for control in Control::ALL {
        match about(recorded_as(control.channel(), effects), trim.of(control.variable()))? {
            Some(history) => inputs.controls[control.index()] = history,
            None if run.still[control.index()] || !answers_to(control, in_trim, effects) => {}
            None => return Err(PredictionError::NoControl(control.name(run.geometry.controls))),
        }
    }
    if let Some(at_trim) = trim.rotor_speed.filter(|_| !in_trim.is_governed()) {
        inputs.rotor_speed = about(Channel::RotorSpeed, at_trim)?;
    }
    Ok(inputs)
}

/// Whether the model responds to the control, or an effect feeds another control from it.
pub(crate) fn answers_to(control: Control, in_trim: &Flight, effects: &[Effect]) -> bool {
    let fed = |to: Control| {
        effects.iter().any(|effect| matches!(effect, Effect::CrossFeed { from, to: t, .. } if *from == control && *t == to))
    };
    let Ok(model) = with_effects(&in_trim.model, effects) else { return true };
    let moves = |control: Control| Axis::ALL.iter().any(|&axis| model.derivative(axis, control.variable()) != 0.0);
    in_trim.level1.is_some() || moves(control) || Control::ALL.into_iter().any(|to| fed(to) && moves(to))
}

/// Whether the simulation predicts a channel that is not one of its inputs.
fn predictable(channel: Channel, in_trim: &Flight) -> bool {
    let of_rotor = matches!(channel, Channel::Torque | Channel::Flap0 | Channel::Flap1c | Channel::Flap1s);
    let driving = Channel::CONTROLS.contains(&channel) || channel == Channel::RotorSpeed;
    !driving && channel != Channel::Rho && (in_trim.level1.is_some() || !of_rotor)
}

/// The axis of lowest order in a channel.
fn axis_of(channel: Channel) -> Option<Axis> {
    Some(match channel {
        Channel::Ax | Channel::Tas => Axis::X,
        Channel::Ay | Channel::Beta => Axis::Y,
        Channel::Az | Channel::Alpha | Channel::Altitude => Axis::Z,
        Channel::P | Channel::Phi => Axis::L,
        Channel::Q | Channel::Theta => Axis::M,
        Channel::R | Channel::Psi => Axis::N,
        _ => return None,
    })
}

/// Whether the model, with its effects, has a derivative on that axis.
fn has_axis(axis: Axis, in_trim: &Flight, effects: &[Effect]) -> bool {
    let Ok(model) = with_effects(&in_trim.model, effects) else { return true };
    in_trim.level1.is_some() || model.speaks_of(axis)
}

fn finite(samples: &[Sample], channel: Channel) -> impl Iterator<Item = (f64, f64)> + '_ {
    samples.iter().filter_map(move |sample| Some((sample.time_s, sample.get(channel).filter(|value| value.is_finite())?)))
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// Measured and predicted values of a channel at the same times; `None` where it was not measured, or not before the motion
/// diverged.
fn predicted(channel: Channel, run: &ValidationRun<'_>, flown: &[Sample], window_ends_s: f64) -> Option<PredictedChannel> {
    let series = Series::of(finite(run.samples, channel));
    let series = if channel == Channel::Psi { series.unwrapped() } else { series };
    let mut predictions = flown.iter().peekable();
    let (mut times_s, mut measured, mut predicted) = (Vec::new(), Vec::new(), Vec::new());
    for (time_s, value) in series.samples() {
        while predictions.next_if(|sample| sample.time_s < time_s).is_some() {}
        let there = predictions.peek().filter(|sample| sample.time_s <= time_s);
        if let Some(reading) = there.and_then(|sample| sample.get(channel)).filter(|reading| reading.is_finite()) {
            times_s.push(time_s);
            measured.push(value);
            predicted.push(reading);
        }
    }
    let window = times_s.partition_point(|&time_s| time_s <= window_ends_s);
    let offset = mean(measured.iter().zip(&predicted).take(window).map(|(z, y)| z - y))?;
    let at_trim = mean(predicted.iter().copied().take(window))?;
    Some(PredictedChannel { channel, times_s, measured, predicted, offset, at_trim, noise_std: series.noise_std() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::Variable;
    use crate::flight::file::model_file::ModelFile;
    use crate::flight::model::{LinearModel, Trim};
    use crate::simulation::flight_model::FlightRequest;

    /// Roll, and heave that does nothing to it: L_p = -2, L_lat_cyclic = 10, Z_w = -1, at 50 m/s.
    fn rolling(l_p: f64) -> FlightModel {
        let mut model = LinearModel::about(Trim { u: 50.0, controls: [0.0, 0.05, 0.0, 0.0], ..Trim::default() });
        *model.derivative_mut(Axis::L, Variable::P) = l_p;
        *model.derivative_mut(Axis::L, Variable::LatCyclic) = 10.0;
        *model.derivative_mut(Axis::Z, Variable::W) = -1.0;
        FlightModel::parse(&ModelFile::of("rolling", model).to_toml(), &FlightRequest::default()).unwrap()
    }

    /// A ramp of 0.01 rad/s from 2 s on, about another trim than the model's; p with a bias and in closed form:
    /// p = 10 s/2 (t - (1 - exp(-2 t))/2), t from the ramp's begin.
    fn ramp(with_control: bool) -> Vec<Sample> {
        let row = |place: u32| {
            let mut sample = Sample::new(7.0 + 0.05 * f64::from(place));
            let t = (0.05 * f64::from(place) - 2.0).max(0.0);
            if with_control {
                sample.set(Channel::LatCyclic, 0.2 + 0.01 * t);
            }
            sample.set(Channel::P, 0.03 + 0.05 * (t - 0.5 * (1.0 - libm::exp(-2.0 * t))));
            sample.set(Channel::Tas, 50.0);
            if place.is_multiple_of(2) {
                sample.set(Channel::Altitude, 300.0);
            }
            sample
        };
        (0..120).map(row).collect()
    }

    #[test]
    fn a_run_is_predicted_about_its_own_trim() {
        let (samples, geometry) = (ramp(true), RunGeometry::DEFAULT);
        let prediction = predict(&rolling(-2.0), &[], &ValidationRun::of(&samples, &geometry)).unwrap();
        let names: Vec<Channel> = prediction.channels.iter().map(|one| one.channel).collect();
        assert_eq!((names, prediction.not_predicted), (vec![Channel::P, Channel::Altitude], vec![Channel::Tas]));
        let p = &prediction.channels[0];
        assert!((p.offset - 0.03).abs() < 1e-12 && p.at_trim.abs() < 1e-12);
        assert!(p.errors(false).all(|error| error.abs() < 1e-9), "{:?}", p.errors(false).collect::<Vec<_>>());
        assert!(p.errors(true).all(|error| (error - 0.03).abs() < 1e-9));
        assert_eq!((p.times_s.len(), prediction.channels[1].times_s.len()), (120, 60));
        assert_eq!((prediction.diverged_at_s, prediction.range_s), (None, [7.0, 7.0 + 0.05 * 119.0]));
    }

    #[test]
    fn an_effect_on_an_instrument_is_read() {
        let (samples, geometry) = (ramp(true), RunGeometry::DEFAULT);
        let effects = [Effect::SensorBias { channel: Channel::P, value: 0.03 }, Effect::Turbulence { sigma: 1.0, length: 100.0 }];
        let prediction = predict(&rolling(-2.0), &effects, &ValidationRun::of(&samples, &geometry)).unwrap();
        assert!(prediction.channels[0].errors(true).all(|error| error.abs() < 1e-9));
        assert_eq!(prediction.effects, [effects[0]]);
    }

    #[test]
    fn a_diverging_prediction_ends_where_it_diverges() {
        let (samples, geometry) = (ramp(true), RunGeometry::DEFAULT);
        let prediction = predict(&rolling(8.0), &[], &ValidationRun::of(&samples, &geometry)).unwrap();
        let diverged_at_s = prediction.diverged_at_s.unwrap();
        let last_s = *prediction.channels[0].times_s.last().unwrap();
        assert!(last_s < diverged_at_s && diverged_at_s < 13.0 && last_s > 9.0, "{diverged_at_s} {last_s}");
    }

    #[test]
    fn a_run_that_cannot_be_predicted_is_refused() {
        let geometry = RunGeometry::DEFAULT;
        let refused = |samples: &[Sample]| predict(&rolling(-2.0), &[], &ValidationRun::of(samples, &geometry)).unwrap_err();
        assert_eq!(refused(&ramp(false)), PredictionError::NoControl("lat_cyclic"));
        let still = ValidationRun { still: [false, true, false, false], ..ValidationRun::of(&[], &geometry) };
        assert!(predict(&rolling(-2.0), &[], &ValidationRun { samples: &ramp(false), ..still }).is_ok());
        assert!(matches!(refused(&ramp(true)[..30]), PredictionError::Short { rows: 30, .. }));
        assert!(matches!(refused(&[]), PredictionError::Short { rows: 0, .. }));
        let mut back = ramp(true);
        back[50].time_s = back[49].time_s;
        assert!(matches!(refused(&back), PredictionError::Time { row: 51, .. }));
        let mut late = ramp(true);
        late.iter_mut().take(30).for_each(|sample| sample.clear(Channel::LatCyclic));
        assert_eq!(refused(&late), PredictionError::NoTrim("lat_cyclic", TRIM_WINDOW_S));
    }
}
