//! A flight flown leg by leg: the whole of it at once, or from one act of a pilot to his next.
//!
//! Consumes a flight's model, air and the times that its mesh must hold; produces the true states. Between two acts the controls
//! are known beforehand, so each leg has a mesh that holds every bend of what drives it, with a pilot or without.

use super::control_path::ControlPath;
use super::fly::Flight;
use super::integrate::{IntegrationState, Level1Motion, MotionDrive, TrueState, nodes};
use super::level1::internal_states::INNER;
use super::motion::Motion;
use super::pilot::PilotAtWork;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::model::LinearModel;
use crate::flight::signal::piecewise_linear::History;

/// What a flight is flown through.
pub(crate) struct FlightSegments<'f> {
    pub(crate) flight: &'f Flight,
    /// The model with its effects.
    pub(crate) model: &'f LinearModel,
    pub(crate) level1: Option<Level1Motion<'f>>,
    pub(crate) air: Option<&'f [History; 3]>,
    /// Times that the mesh must hold, increasing, s; the first is the start.
    pub(crate) wanted_s: &'f [f64],
    pub(crate) step_s: f64,
}

/// What is carried from leg to leg.
struct Passage {
    now: IntegrationState,
    path: ControlPath,
    states: Vec<TrueState>,
}

impl FlightSegments<'_> {
    /// The inputs alone: one leg to the end. True states, and when the motion diverged, where it did.
    pub(crate) fn fly(&self, start: Motion, last_s: f64) -> (Vec<TrueState>, Option<f64>) {
        let mut passage = self.ready(start);
        let controls = Control::ALL.map(|control| self.flight.inputs.controls[control.index()].until(last_s));
        let diverged_at_s = self.leg(&mut passage, controls, self.start_s(), last_s);
        (passage.states, diverged_at_s)
    }

    /// With a pilot who acts at these times after the start.
    pub(crate) fn fly_held(&self, start: Motion, acts_s: &[f64], mut pilot: PilotAtWork) -> (Vec<TrueState>, Option<f64>) {
        if acts_s.is_empty() {
            return self.fly(start, self.start_s());
        }
        let mut passage = self.ready(start);
        let mut from = (self.start_s(), [0.0; CONTROLS]);
        for (leg, &act_s) in acts_s.iter().enumerate() {
            let (from_s, moved) = from;
            let moves = pilot.act(act_s, &passage.states);
            let controls = Control::ALL.map(|control| {
                let place = control.index();
                let input = &self.flight.inputs.controls[place];
                let input = if leg == 0 { input.until(act_s) } else { input.within(from_s, act_s) };
                let (x0, x1) = (moved[place], moves[place]);
                input
                    .bent_by(|time_s| if time_s <= from_s { x0 } else { x0 + (x1 - x0) * ((time_s - from_s) / (act_s - from_s)) })
            });
            if let Some(time_s) = self.leg(&mut passage, controls, from_s, act_s) {
                return (passage.states, Some(time_s));
            }
            from = (act_s, moves);
        }
        (passage.states, None)
    }

    fn start_s(&self) -> f64 {
        self.wanted_s.first().copied().unwrap_or_default()
    }

    fn ready(&self, start: Motion) -> Passage {
        let inner = self.level1.map_or([0.0; INNER], |level1| level1.trimmed.inner.to_vector());
        Passage {
            now: IntegrationState { motion: start.to_vector(), inner, memory: 0.0 },
            path: ControlPath::new(&self.flight.effects),
            states: Vec::new(),
        }
    }

    /// Flies from one time to another with these controls, absolute values; when the motion diverged, where it did.
    fn leg(&self, passage: &mut Passage, controls: [History; CONTROLS], from_s: f64, to_s: f64) -> Option<f64> {
        let at_trim = self.flight.model.trim.controls;
        passage.path.extend(&Control::ALL.map(|control| controls[control.index()].clone().shifted(-at_trim[control.index()])));
        let first = self.wanted_s.partition_point(|&time_s| time_s < from_s);
        let mut wanted: Vec<f64> = self.wanted_s.iter().skip(first).copied().take_while(|&time_s| time_s <= to_s).collect();
        wanted.extend([from_s, to_s]);
        wanted.extend(passage.path.bends(from_s, to_s));
        let nodes_s = nodes(wanted, self.step_s);
        let blade = passage.path.blade(&nodes_s);
        let drive = MotionDrive {
            model: self.model,
            level1: self.level1,
            nodes_s: &nodes_s,
            blade: &blade,
            controls: &controls,
            gusts: self.air,
            rotor_speed: self.flight.inputs.rotor_speed.as_ref(),
            unmodelled: self.flight.unmodelled.as_ref(),
        };
        drive.fly(&mut passage.now, &mut passage.states)
    }
}
