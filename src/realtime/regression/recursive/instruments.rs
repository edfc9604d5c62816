//! What the instruments leave without a number: whole equations, and terms of an equation.
//!
//! Consumes which instruments there are and how they are; produces the reason of an equation that has no numbers, and the terms
//! that are not published.

use super::{PATIENCE_S, Recursive};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::realtime::estimation::record::{Aid, Confirmation, Instrumentation};
use crate::realtime::regression::candidate::{REGRESSORS, STILL, is_primary, regressor};
use crate::realtime::regression::record::{EquationRecord, Reason};
use crate::realtime::regression::required_aids::{needs, observed};

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
        let rejected = needs(axis).into_iter().find(|aid| !instruments.trusted[aid.index()])?;
        Some(Reason::AidRejected { channel: rejected.channel() })
    }

    /// Takes up what the kinematics tell about the accelerometers. Without excitation gusts alone speak, which may confirm but do
    /// not put in doubt.
    pub(super) fn judge_accelerometers(&mut self, instruments: &Instrumentation) {
        for (doubted, confirmation) in self.doubted.iter_mut().zip(instruments.confirmations) {
            match confirmation {
                Confirmation::Confirmed => *doubted = false,
                Confirmation::Plausible | Confirmation::Doubted if self.excited => {
                    *doubted = confirmation == Confirmation::Doubted
                }
                Confirmation::Plausible | Confirmation::Doubted => {}
            }
        }
    }

    /// Why a force that would have numbers has none after all: its accelerometer may be reversed, or in another unit. A moment
    /// has no accelerometer.
    pub(super) fn not_confirmed(&self, axis: Axis, equation: &EquationRecord) -> Option<Reason> {
        let (&doubted, &channel) = self.doubted.get(axis.index()).zip(Channel::ACCELEROMETERS.get(axis.index()))?;
        let has_numbers = equation.terms.iter().any(|term| term.variable.is_some());
        (doubted && has_numbers).then_some(Reason::NotConfirmed { channel })
    }

    /// Whether an unobserved velocity must have moved: its terms are in no equation and bias the others.
    pub(super) fn unobserved_motion(&self, instruments: &Instrumentation) -> bool {
        let moved = |variable: Variable| self.information.deviation(regressor(variable)) > STILL[variable.index()];
        !observed(Variable::V, instruments) && (moved(Variable::P) || moved(Variable::R))
            || !observed(Variable::W, instruments) && moved(Variable::Q)
    }

    /// Terms that get no number: of controls that no input has moved (they answer the motion, and the two are told apart by noise
    /// alone), and of the other plane's motion where its velocity, v or w, is not observed.
    pub(super) fn withheld(&self, axis: Axis, instruments: &Instrumentation) -> [bool; REGRESSORS] {
        let mut withheld = [false; REGRESSORS];
        for control in Control::ALL {
            withheld[regressor(control.variable())] = !self.excitation.has_moved(control);
        }
        if !observed(if axis.is_lateral() { Variable::W } else { Variable::V }, instruments) {
            for variable in Variable::ALL {
                withheld[regressor(variable)] |= !is_primary(axis, variable);
            }
        }
        withheld
    }
}
