//! What the instruments leave without a number: whole equations, and terms of an equation.
//!
//! Consumes which instruments there are and how they are; produces the reason of an equation that has no numbers, and the terms
//! that are not published.

use super::{PATIENCE_S, Recursive};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::unit::STANDARD_GRAVITY;
use crate::realtime::estimation::record::{Aid, Confirmation, Instrumentation};
use crate::realtime::regression::candidate::{REGRESSORS, STILL, is_primary, regressor};
use crate::realtime::regression::record::{EquationRecord, Reason, TermRecord};
use crate::realtime::regression::required_aids::{accelerometer, needs, observed};

/// Standard errors of Y_v above zero from which on the side force is along the sideslip.
const ALONG_SIDESLIP: f64 = 2.0;

impl Recursive {
    /// Why the axis can have no number from these instruments.
    pub(super) fn refusal(&self, axis: Axis, instruments: &Instrumentation) -> Option<Reason> {
        if self.age_s < PATIENCE_S {
            return None;
        }
        if let Some(doubt) = instruments.doubt {
            return Some(Reason::InstrumentDoubted { channel: doubt.channel() });
        }
        if !instruments.gyros || instruments.rate_hz <= 0.0 {
            return Some(Reason::NoRates);
        }
        if instruments.rate_hz > 0.0 && instruments.rate_hz < self.config.rate_min_hz {
            return Some(Reason::RateTooLow { hz: instruments.rate_hz, needed_hz: self.config.rate_min_hz });
        }
        if !instruments.aids[Aid::Airspeed.index()] {
            return Some(Reason::Unobserved { variable: Variable::U, missing: Channel::Tas });
        }
        if axis.is_force() && !instruments.accelerometers[axis.index()] {
            return Some(Reason::NoAccelerometer { channel: Channel::ACCELEROMETERS[axis.index()] });
        }
        if axis.is_force() && self.trim.is_some_and(|trim| !trim.specific_force[axis.index()].is_finite()) {
            return Some(Reason::NoTrim { channel: Channel::ACCELEROMETERS[axis.index()] });
        }
        let (needed, vane) = if axis.is_lateral() { (Variable::V, Aid::Sideslip) } else { (Variable::W, Aid::Incidence) };
        if !observed(needed, instruments) {
            return Some(Reason::Unobserved { variable: needed, missing: vane.channel() });
        }
        if instruments.vanes_contradict[usize::from(axis.is_lateral())] {
            return Some(Reason::AidRejected { channel: vane.channel() });
        }
        let rejected = needs(axis).into_iter().find(|aid| !instruments.trusted[aid.index()]);
        if let Some(aid) = rejected {
            return Some(Reason::AidRejected { channel: aid.channel() });
        }
        let no_control = self.trim.is_some_and(|trim| trim.controls.iter().all(|control| !control.is_finite()));
        no_control.then_some(Reason::NoControl)
    }

    /// Takes up what the kinematics tell about sign and unit. Without excitation gusts alone speak, which may confirm but do not
    /// put in doubt.
    pub(super) fn judge_confirmations(&mut self, instruments: &Instrumentation) {
        let by_input = self.excitation.response_s(true).is_some();
        for ((known, now), channel) in self.confirmations.iter_mut().zip(instruments.confirmations).zip(Confirmation::CHANNELS) {
            match now {
                // Sideways motion that no lateral input caused is of gusts, which hide what ay reads.
                Confirmation::Plausible { .. } | Confirmation::NotComparable if channel == Channel::Ay && !by_input => {
                    *known = Confirmation::Doubted
                }
                _ if self.excited || now.tells_more_than(*known) => *known = now,
                _ => {}
            }
        }
    }

    /// Why an equation that would have numbers has none after all: a control, a rate or an accelerometer that it rests on has
    /// stood; its accelerometer may be reversed or in another unit; or the airspeed, which every velocity is made of, or the
    /// incidence. A side force along the sideslip, which no aircraft has, is one of a reversed ay.
    pub(super) fn doubtful(&self, axis: Axis, equation: &EquationRecord, instruments: &Instrumentation) -> Option<Reason> {
        if !equation.terms.iter().any(|term| term.variable.is_some()) {
            return None;
        }
        let has =
            |variable: Variable| equation.term(variable).is_some() || equation.unresolved_variables().any(|one| one == variable);
        let stood =
            Control::ALL.into_iter().zip(instruments.controls_stood).find(|(control, stood)| *stood && has(control.variable()));
        if let Some((control, _)) = stood {
            return Some(Reason::InstrumentDoubted { channel: Some(control.channel()) });
        }
        // A rate or its derivative is in the equation; an accelerometer is its response, or carries its velocity.
        let rests_on = |channel: Channel| match channel {
            Channel::P => axis == Axis::L || has(Variable::P),
            Channel::Q => axis == Axis::M || has(Variable::Q),
            Channel::R => axis == Axis::N || has(Variable::R),
            Channel::Ax => axis == Axis::X,
            Channel::Ay => axis.is_lateral(),
            _ => axis == Axis::Z || axis == Axis::M,
        };
        let mut inertial = Channel::INERTIAL.into_iter().zip(instruments.inertial_stood);
        if let Some((channel, _)) = inertial.find(|(channel, stood)| *stood && rests_on(*channel)) {
            return Some(Reason::InstrumentDoubted { channel: Some(channel) });
        }
        let along_sideslip = |term: &TermRecord| term.value > ALONG_SIDESLIP * term.std;
        if axis == Axis::Y && equation.term(Variable::V).is_some_and(along_sideslip) {
            return Some(Reason::NotConfirmed { channel: Channel::Ay });
        }
        // The sideways velocity follows ay between the readings of the vane, and the derivatives of Y, L and N with it.
        let carries = if axis.is_lateral() { Some(Channel::Ay) } else { accelerometer(axis) };
        let incidence = (!axis.is_lateral()).then_some(Channel::Alpha);
        let needed = [carries, Some(Channel::Tas), incidence];
        let doubted = needed.into_iter().flatten().find(|&channel| self.is_doubted(channel));
        doubted.map(|channel| Reason::NotConfirmed { channel })
    }

    fn confirmation(&self, channel: Channel) -> Option<Confirmation> {
        Confirmation::place(channel).and_then(|place| self.confirmations.get(place)).copied()
    }

    fn is_doubted(&self, channel: Channel) -> bool {
        self.confirmation(channel) == Some(Confirmation::Doubted)
    }

    /// By how much the term may be wrong because moving air hides an error of ay, which a side force follows, or of the
    /// airspeed, which every velocity is made of. Modes have no part of the latter: the product of a velocity's derivative and
    /// the speed, which they rest on, is right all the same.
    pub(super) fn hidden_error(&self, axis: Axis, variable: Variable, value: f64) -> f64 {
        let by_force = if axis == Axis::Y { self.hidden_error_of(Channel::Ay) * value } else { 0.0 };
        let is_velocity = matches!(variable, Variable::U | Variable::V | Variable::W);
        let by_speed = if is_velocity { self.hidden_error_of(Channel::Tas) * value } else { 0.0 };
        libm::hypot(by_force, by_speed)
    }

    /// The relative error of the channel that moving air hides.
    pub(super) fn hidden_error_of(&self, channel: Channel) -> f64 {
        match self.confirmation(channel) {
            Some(Confirmation::Plausible { relative_error }) => relative_error,
            _ => 0.0,
        }
    }

    /// The standard error of the pitch attitude in trim, rad: how far ax is from what gravity, the attitude and the rates of
    /// the trim have along it,
    ///     |ax - (g sin(theta0) + q0 w0 - r0 v0)|/g.
    /// One of ax and theta is wrong by that, or the run did not begin in steady flight. None without ax.
    pub fn trim_pitch_std(&self) -> f64 {
        let Some(trim) = self.trim else { return 0.0 };
        let ([_, v, w], [_, q, r], [ax, ..]) = (trim.velocity, trim.rates, trim.specific_force);
        let apart = ax - (STANDARD_GRAVITY * libm::sin(trim.attitude[1]) + q * w - r * v);
        if apart.is_finite() { libm::fabs(apart) / STANDARD_GRAVITY } else { 0.0 }
    }

    /// Whether an unobserved velocity must have moved: its terms are in no equation and bias the others.
    pub(super) fn unobserved_motion(&self, instruments: &Instrumentation) -> bool {
        let moved = |variable: Variable| self.information.deviation(regressor(variable)) > STILL[variable.index()];
        !observed(Variable::V, instruments) && (moved(Variable::P) || moved(Variable::R))
            || !observed(Variable::W, instruments) && moved(Variable::Q)
    }

    /// Terms that get no number: of controls that no input has moved (they answer the motion, and the two are told apart by noise
    /// alone), and of the other plane's motion where its velocity, v or w, is not observed or its vane is rejected.
    pub(super) fn withheld(&self, axis: Axis, instruments: &Instrumentation) -> [bool; REGRESSORS] {
        let mut withheld = [false; REGRESSORS];
        for control in Control::ALL {
            withheld[regressor(control.variable())] = !self.excitation.has_moved(control);
        }
        withheld[regressor(Variable::W)] = self.is_doubted(Channel::Alpha);
        let (velocity, vane) = if axis.is_lateral() { (Variable::W, Aid::Incidence) } else { (Variable::V, Aid::Sideslip) };
        let contradicts = instruments.vanes_contradict[usize::from(!axis.is_lateral())] || !instruments.trusted[vane.index()];
        if !observed(velocity, instruments) || contradicts {
            for variable in Variable::ALL {
                withheld[regressor(variable)] |= !is_primary(axis, variable);
            }
        }
        withheld
    }
}
