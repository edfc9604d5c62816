//! A pilot who slowly holds the attitude, so that a long flight of an unstable aircraft stays near its trim.
//!
//! Consumes the true states so far; produces deviations of the controls, which add to the test input and are recorded with
//! it. With angle and rate a dead time ago, and P the control's own power (L_lat_cyclic, M_lon_cyclic, N_pedal):
//!     x = -(w^2 (angle - at trim) + 2 z w rate) / P                                      (1)
//!     tau y' = x - y                                                                     (2)
//! Bank and roll rate move the lateral cyclic, pitch attitude and pitch rate the longitudinal cyclic, and where he holds the
//! heading too, heading and yaw rate the pedal. He acts at the times of the samples, straight lines between, so a recording
//! at those times holds his controls exactly; the dead time makes the loop causal.
//! With [`Pilot::ATTITUDE`] 0.1 rad of bank of the 100 kn Puma is worth 1.1 mrad of lateral cyclic: a tenth of a usual test
//! input.
//! He holds an attitude, not a speed: in the hover the aircraft still drifts from its trim.
//! Refused: an aircraft whose control has no power.

use super::control_path::Lag;
use super::integrate::TrueState;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::Axis;
use crate::flight::model::LinearModel;

/// A pilot's habits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot {
    /// w of (1), rad/s.
    pub frequency: f64,
    /// z of (1).
    pub damping: f64,
    /// tau of (2), s.
    pub lag_s: f64,
    /// Time from what he sees to what his hand begins to do, s.
    pub dead_time_s: f64,
    /// Whether his feet hold the heading.
    pub heading: bool,
}

impl Pilot {
    /// Holds bank and pitch attitude.
    pub const ATTITUDE: Pilot = Pilot { frequency: 0.5, damping: 0.7, lag_s: 0.3, dead_time_s: 0.15, heading: false };

    /// Holds the heading as well.
    pub const ATTITUDE_AND_HEADING: Pilot = Pilot { heading: true, ..Pilot::ATTITUDE };

    /// When he acts: the given times, and more between any two that are further apart than his dead time.
    pub(crate) fn acts_s(&self, times_s: &[f64], last_s: f64) -> Vec<f64> {
        let mut acts = Vec::with_capacity(times_s.len());
        let mut before = times_s.first().copied().unwrap_or(last_s);
        for &time_s in times_s.iter().skip(1).chain([&last_s]).filter(|&&time_s| time_s <= last_s) {
            let parts = libm::ceil((time_s - before) / self.dead_time_s).max(1.0) as usize;
            acts.extend((1..parts).map(|part| before + (time_s - before) * (part as f64 / parts as f64)));
            if time_s > before {
                acts.push(time_s);
            }
            before = time_s;
        }
        acts
    }
}

#[derive(Clone, Copy, Debug)]
struct Loop {
    control: Control,
    axis: usize,
    power: f64,
    at_trim: f64,
    lag: Lag,
}

#[derive(Clone, Debug)]
pub(crate) struct PilotAtWork {
    pilot: Pilot,
    start_s: f64,
    loops: Vec<Loop>,
}

impl PilotAtWork {
    /// Takes hold of an aircraft with this linear model, in its trim at that heading; the control without power otherwise.
    pub(crate) fn of(pilot: Pilot, model: &LinearModel, heading: f64, start_s: f64) -> Result<Self, Control> {
        let ways = [
            (Control::LatCyclic, Axis::L, model.trim.phi),
            (Control::LonCyclic, Axis::M, model.trim.theta),
            (Control::Pedal, Axis::N, heading),
        ];
        let mut loops = Vec::new();
        for (axis, (control, moment, at_trim)) in ways.into_iter().enumerate().take(if pilot.heading { 3 } else { 2 }) {
            let power = model.derivative(moment, control.variable());
            if !(power.is_finite() && libm::fabs(power) > 1e-9) {
                return Err(control);
            }
            let mut lag = Lag::new(pilot.lag_s);
            lag.step(start_s, 0.0);
            loops.push(Loop { control, axis, power, at_trim, lag });
        }
        Ok(PilotAtWork { pilot, start_s, loops })
    }

    /// Deviations of the controls at his next act, no later than a dead time after the last of the states.
    pub(crate) fn act(&mut self, time_s: f64, states: &[TrueState]) -> [f64; CONTROLS] {
        let mut moved = [0.0; CONTROLS];
        let seen_s = time_s - self.pilot.dead_time_s;
        let (w, z) = (self.pilot.frequency, self.pilot.damping);
        for held in &mut self.loops {
            let demand = match seen(states, seen_s) {
                Some((before, after, share)) if seen_s >= self.start_s => {
                    let between = |of: fn(&TrueState) -> [f64; 3]| {
                        let pick = |state: &TrueState| of(state).get(held.axis).copied().unwrap_or_default();
                        pick(before) + share * (pick(after) - pick(before))
                    };
                    let (angle, rate) = (between(|state| state.motion.attitude), between(|state| state.motion.rates));
                    -(w * w * (angle - held.at_trim) + 2.0 * z * w * rate) / held.power
                }
                _ => 0.0,
            };
            moved[held.control.index()] = held.lag.step(time_s, demand);
        }
        moved
    }
}

/// The states on either side of a time, and how far between them it lies.
fn seen(states: &[TrueState], time_s: f64) -> Option<(&TrueState, &TrueState, f64)> {
    let place = states.partition_point(|state| state.time_s <= time_s);
    let before = states.get(place.checked_sub(1)?)?;
    let after = states.get(place).unwrap_or(before);
    let apart = after.time_s - before.time_s;
    Some((before, after, if apart > 0.0 { (time_s - before.time_s) / apart } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn he_acts_with_the_samples_and_often_enough() {
        let pilot = Pilot { dead_time_s: 0.25, ..Pilot::ATTITUDE };
        assert_eq!(pilot.acts_s(&[0.0, 0.125, 0.25, 1.0], 1.0), [0.125, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(pilot.acts_s(&[0.0, 0.25], 0.375), [0.25, 0.375]);
        assert_eq!(pilot.acts_s(&[2.0], 2.0), Vec::<f64>::new());
    }

    #[test]
    fn a_control_without_power_is_refused() {
        let model = LinearModel::default();
        assert_eq!(PilotAtWork::of(Pilot::ATTITUDE, &model, 0.0, 0.0).unwrap_err(), Control::LatCyclic);
    }
}
