//! Excitation: whether the present motion carries information about the derivatives.
//!
//! Consumes z on the regression grid; produces whether the aircraft is being excited by its controls. Motion alone is not
//! enough: in gusts the motion correlates with the disturbance of the equations, and so do controls that a pilot or an
//! augmentation system moves to oppose it. Such feedback is smooth on the scale of the grid, and answers the rates; test inputs
//! have edges that answer nothing. The sign of an input is therefore what neither extrapolation of the control's own past nor
//! the rates before it predict: its third difference over `SPACING` instants, less what `feedback` explains of it:
//!     e_k = d_k - 3 d_(k-s) + 3 d_(k-2s) - d_(k-3s) - K'x,   s2 <- (1 - g)(s2 + g e_k^2)                     (1)
//! The response to an input carries information while it lasts, for `RESPONSE_S` at most, and while some regressor deviates
//! from its recent mean by more than one at rest does:
//!     m <- m + g (z - m),   s2 <- (1 - g)(s2 + g (z - m)^2)                                          (2)
//! Other instants are not added, and nothing is forgotten in them.
//! Source: ours. Largest root of (1) without K within a flight, rad: of the Puma, 3211 of 20 mrad 7e-3, doublet of 10 mrad
//! 1.5e-3, a pilot who holds attitude and heading in gusts of 1.5 m/s 2e-4, rate and attitude feedback at 1.5 rad/s in gusts of
//! 1 m/s 6e-4; of a light aircraft with that feedback 1e-3 and more: it answers gusts faster.

use super::candidate::{SIGNALS, STILL, regressor};
use super::feedback::Feedback;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::{VARIABLES, Variable};

/// Time constant of (1) and (2), s.
const MEMORY_S: f64 = 1.0;
/// Time that excitation continues after the last deviation, s.
const HOLD_S: f64 = 1.0;
/// Longest time after an input in which the motion counts as the response to it, s.
const RESPONSE_S: f64 = 12.0;
/// s of (1), instants of the grid.
const SPACING: usize = 2;
/// Instants that (1) reaches back.
const SPAN: usize = 3 * SPACING;
/// Controls and rates.
const FOLLOWED: usize = CONTROLS + 3;
/// Root of s2 in (1) above which a control is being moved by an input, rad.
const INPUT_RAD: f64 = 4e-4;

/// Recent mean and variance of every regressor, and recent innovations of the controls.
#[derive(Clone, Debug)]
pub struct Excitation {
    mean: [f64; VARIABLES],
    var: [f64; VARIABLES],
    started: bool,
    quiet_s: f64,
    /// Controls of the last instants, newest first.
    past: [[f64; FOLLOWED]; SPAN],
    feedback: Feedback,
    /// Instants in a row that `past` holds.
    filled: usize,
    innovation_var: [f64; CONTROLS],
    /// Whether an input has moved the control, rather than an answer to the motion.
    moved: [bool; CONTROLS],
    /// Time since a control was last moved by an input, s.
    since_input_s: f64,
    /// Excited time since an input first moved a control of the longitudinal and of the lateral motion, s.
    response_s: [Option<f64>; 2],
}

impl Excitation {
    /// Before the first instant.
    pub const START: Excitation = Excitation {
        mean: [0.0; VARIABLES],
        var: [0.0; VARIABLES],
        started: false,
        quiet_s: f64::INFINITY,
        past: [[0.0; FOLLOWED]; SPAN],
        feedback: Feedback::NEW,
        filled: 0,
        innovation_var: [0.0; CONTROLS],
        moved: [false; CONTROLS],
        since_input_s: f64::INFINITY,
        response_s: [None; 2],
    };

    /// One instant of the grid; whether the aircraft is excited.
    pub fn step(&mut self, z: &[f64; SIGNALS], interval_s: f64) -> bool {
        let gain = 1.0 - libm::exp(-interval_s / MEMORY_S);
        self.inputs(z, gain, interval_s);
        let mut moves = false;
        for i in 0..VARIABLES {
            if !self.started {
                self.mean[i] = z[1 + i];
                continue;
            }
            let deviation = z[1 + i] - self.mean[i];
            self.mean[i] += gain * deviation;
            self.var[i] = (1.0 - gain) * (self.var[i] + gain * deviation * deviation);
            moves |= self.var[i] > STILL[i] * STILL[i];
        }
        self.started = true;
        self.quiet_s = if moves { 0.0 } else { self.quiet_s + interval_s };
        let excited = self.quiet_s <= HOLD_S && self.since_input_s <= RESPONSE_S;
        for response_s in self.response_s.iter_mut().flatten().filter(|_| excited) {
            *response_s += interval_s;
        }
        excited
    }

    /// Excited time since an input first moved a control of that motion, s; `None` where none has.
    pub fn response_s(&self, lateral: bool) -> Option<f64> {
        self.response_s[usize::from(lateral)]
    }

    /// Whether an input has moved the control so far.
    pub fn has_moved(&self, control: Control) -> bool {
        self.moved[control.index()]
    }

    /// An instant without signals: differences do not reach across it.
    pub fn skip(&mut self, interval_s: f64) {
        self.filled = 0;
        self.feedback.skip();
        self.since_input_s += interval_s;
    }

    /// (1) of every control.
    fn inputs(&mut self, z: &[f64; SIGNALS], gain: f64, interval_s: f64) {
        let rates = [Variable::P, Variable::Q, Variable::R].map(|rate| z[regressor(rate)]);
        let mut now = [0.0; FOLLOWED];
        now[..CONTROLS].copy_from_slice(&Control::ALL.map(|control| z[regressor(control.variable())]));
        now[CONTROLS..].copy_from_slice(&rates);
        self.since_input_s += interval_s;
        if self.filled == SPAN {
            let [once, twice, thrice] = [1, 2, 3].map(|n| self.past[n * SPACING - 1]);
            let third = |i: usize| now[i] - 3.0 * once[i] + 3.0 * twice[i] - thrice[i];
            let of_rates = core::array::from_fn(|i| third(CONTROLS + i));
            let inputs = self.feedback.unexplained(core::array::from_fn(third), of_rates, INPUT_RAD, interval_s);
            for (control, (var, innovation)) in self.innovation_var.iter_mut().zip(inputs).enumerate() {
                *var = (1.0 - gain) * (*var + gain * innovation * innovation);
                if *var > INPUT_RAD * INPUT_RAD {
                    self.since_input_s = 0.0;
                    self.moved[control] = true;
                    let lateral = Control::ALL[control].variable().is_lateral();
                    self.response_s[usize::from(lateral)].get_or_insert(0.0);
                }
            }
        }
        self.past.copy_within(..SPAN - 1, 1);
        self.past[0] = now;
        self.filled = (self.filled + 1).min(SPAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Excited at each of 600 instants of a flight in which v oscillates throughout and the pedal is as given.
    fn excited(pedal: impl Fn(f64) -> f64) -> [bool; 600] {
        let mut excitation = Excitation::START;
        core::array::from_fn(|k| {
            let time_s = 0.08 * k as f64;
            let mut z = [0.0; SIGNALS];
            z[regressor(Variable::V)] = 2.0 * libm::sin(1.5 * time_s);
            z[regressor(Variable::Pedal)] = pedal(time_s);
            excitation.step(&z, 0.08)
        })
    }

    #[test]
    fn motion_without_an_input_and_smooth_feedback_are_no_excitation() {
        assert!(!excited(|_| 0.0).contains(&true));
        assert!(!excited(|time_s| 0.002 * libm::sin(1.5 * time_s - 1.0)).contains(&true));
    }

    #[test]
    fn an_input_excites_and_its_response_for_a_while() {
        let doublet = |time_s: f64| match time_s {
            10.0..11.0 => 0.01,
            11.0..12.0 => -0.01,
            _ => 0.0,
        };
        let excited = excited(doublet);
        assert!(!excited[..120].contains(&true), "before the input");
        assert!(excited[130..275].iter().all(|&now| now), "the input and 10 s of its response");
        assert!(!excited[400..].contains(&true), "long after it the air moves the aircraft");
    }

    #[test]
    fn a_new_steady_state_is_no_excitation() {
        let mut excitation = Excitation::START;
        let mut z = [0.0; SIGNALS];
        let excited: [bool; 300] = core::array::from_fn(|k| {
            let moved = k >= 20;
            z[regressor(Variable::Pedal)] = if moved { 0.02 } else { 0.0 };
            z[regressor(Variable::V)] = if moved { 2.0 } else { 0.0 };
            excitation.step(&z, 0.08)
        });
        assert!(excited[21..60].iter().any(|&now| now));
        assert!(!excited[200], "it stands at 2 m/s and does not move");
    }
}
