//! A flight in segments: one for the whole, or one between two control updates of a pilot.
//!
//! Consumes a flight's inputs, effects, model, air and the times that its mesh must hold; produces the true states. Between two
//! updates the controls are known beforehand, so the mesh of a segment holds every breakpoint of the inputs.

use super::control_path::ControlPath;
use super::integrate::{IntegrationState, Level1Motion, MotionDrive, TrueState, nodes};
use super::level1::internal_states::INNER;
use super::motion::Motion;
use super::pilot::PilotAtWork;
use super::unmodelled::Unmodelled;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::effect::Effect;
use crate::flight::model::LinearModel;
use crate::flight::signal::piecewise_linear::History;

/// What a flight is flown through.
pub(crate) struct FlightSegments<'f> {
    /// The pilot's controls, rad, absolute values.
    pub(crate) controls: &'f [History; CONTROLS],
    /// Rotor speed where it is an input, rad/s.
    pub(crate) rotor_speed: Option<&'f History>,
    pub(crate) effects: &'f [Effect],
    pub(crate) unmodelled: Option<&'f Unmodelled>,
    pub(crate) controls_at_trim: [f64; CONTROLS],
    /// The model with its effects.
    pub(crate) model: &'f LinearModel,
    pub(crate) level1: Option<Level1Motion<'f>>,
    pub(crate) air: Option<&'f [History; 3]>,
    /// Times that the mesh must hold, increasing, s; the first is the start.
    pub(crate) wanted_s: &'f [f64],
    pub(crate) step_s: f64,
}

/// What has been flown: motion and control path at its end, and the true states up to there.
struct FlownSegments {
    now: IntegrationState,
    path: ControlPath,
    states: Vec<TrueState>,
}

impl FlightSegments<'_> {
    /// The inputs alone: one segment to the end. True states, and when the motion diverged, where it did.
    pub(crate) fn fly(&self, start: Motion, last_s: f64) -> (Vec<TrueState>, Option<f64>) {
        let mut flown = self.at_start(start);
        let controls = Control::ALL.map(|control| self.controls[control.index()].until(last_s));
        let diverged_at_s = self.fly_segment(&mut flown, controls, self.start_s(), last_s);
        (flown.states, diverged_at_s)
    }

    /// With a pilot who acts at these times after the start.
    pub(crate) fn fly_with_pilot(&self, start: Motion, acts_s: &[f64], mut pilot: PilotAtWork) -> (Vec<TrueState>, Option<f64>) {
        if acts_s.is_empty() {
            return self.fly(start, self.start_s());
        }
        let mut flown = self.at_start(start);
        let mut from = (self.start_s(), [0.0; CONTROLS]);
        for (number, &act_s) in acts_s.iter().enumerate() {
            let (from_s, moved) = from;
            let moves = pilot.act(act_s, &flown.states);
            let controls = Control::ALL.map(|control| {
                let place = control.index();
                let input = &self.controls[place];
                let input = if number == 0 { input.until(act_s) } else { input.within(from_s, act_s) };
                let (x0, x1) = (moved[place], moves[place]);
                input
                    .bent_by(|time_s| if time_s <= from_s { x0 } else { x0 + (x1 - x0) * ((time_s - from_s) / (act_s - from_s)) })
            });
            if let Some(time_s) = self.fly_segment(&mut flown, controls, from_s, act_s) {
                return (flown.states, Some(time_s));
            }
            from = (act_s, moves);
        }
        (flown.states, None)
    }

    fn start_s(&self) -> f64 {
        self.wanted_s.first().copied().unwrap_or_default()
    }

    fn at_start(&self, start: Motion) -> FlownSegments {
        let inner = self.level1.map_or([0.0; INNER], |level1| level1.trimmed.inner.to_vector());
        FlownSegments {
            now: IntegrationState { motion: start.to_vector(), inner, memory: 0.0 },
            path: ControlPath::new(self.effects),
            states: Vec::new(),
        }
    }

    /// Flies from one time to another with these controls, absolute values; when the motion diverged, where it did.
    fn fly_segment(&self, flown: &mut FlownSegments, controls: [History; CONTROLS], from_s: f64, to_s: f64) -> Option<f64> {
        let at_trim = self.controls_at_trim;
        flown.path.extend(&Control::ALL.map(|control| controls[control.index()].clone().shifted(-at_trim[control.index()])));
        let first = self.wanted_s.partition_point(|&time_s| time_s < from_s);
        let mut wanted: Vec<f64> = self.wanted_s.iter().skip(first).copied().take_while(|&time_s| time_s <= to_s).collect();
        wanted.extend([from_s, to_s]);
        wanted.extend(flown.path.bends(from_s, to_s));
        let nodes_s = nodes(wanted, self.step_s);
        let blade = flown.path.blade(&nodes_s);
        let drive = MotionDrive {
            model: self.model,
            level1: self.level1,
            nodes_s: &nodes_s,
            blade: &blade,
            controls: &controls,
            gusts: self.air,
            rotor_speed: self.rotor_speed,
            unmodelled: self.unmodelled,
        };
        drive.fly(&mut flown.now, &mut flown.states)
    }
}
