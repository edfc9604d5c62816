//! One equation from the information matrix: what is offered to it, its fit, and what belongs into the errors of that.
//!
//! Consumes the sums of the regression stage; produces an [`EquationRecord`] and its [`Fit`].

use super::{Recursive, joint};
use crate::flight::channel::Channel;
use crate::flight::derivative::{Axis, Variable};
use crate::realtime::estimation::record::Instrumentation;
use crate::realtime::regression::candidate::{
    REGRESSORS, SIGNALS, STILL, UNMOVED, is_primary, noise_variances, regressor, response,
};
use crate::realtime::regression::instrumental::Instruments;
use crate::realtime::regression::record::{EquationRecord, Reason, Status};
use crate::realtime::regression::required_aids::{accelerometer, needs, observed};
use crate::realtime::regression::stepwise::{Fit, Offer, Thresholds, fit};
use crate::realtime::regression::{coloured_errors, endogeneity};

/// Independent samples that an equation needs besides one for each term: with fewer the terms absorb any disturbance.
const LEFT_OVER: f64 = 1.0;
/// Independent samples in which a variable has to have moved before its term can be selected: with fewer it explains whatever
/// else happened meanwhile.
const MOVING_SAMPLES: f64 = 2.0;
/// Period of excited time in which the instruments of the equations are computed once, s.
const INSTRUMENTS_S: f64 = 0.5;

impl Recursive {
    /// The terms of an equation whose instruments are confirmed, or the reason why it has none; its fit for the joint
    /// derivatives.
    #[inline(never)]
    pub(super) fn confirmed_equation(
        &mut self,
        axis: Axis,
        time_s: f64,
        instruments: &Instrumentation,
        equation: &mut EquationRecord,
    ) -> Option<Fit> {
        if let Some(reason) = self.refusal(axis, instruments) {
            equation.status = Status::NotIdentifiable(reason);
            return None;
        }
        let (fitted, fit) = self.equation(axis, time_s, instruments);
        let doubtful = self.doubtful(axis, &fitted, instruments);
        *equation = match doubtful {
            Some(reason) => EquationRecord::empty(axis, Status::NotIdentifiable(reason)),
            None => fitted,
        };
        match doubtful {
            Some(joint::AX_NOT_CONFIRMED) => fit.map(joint::of_unconfirmed_ax),
            Some(_) => None,
            None if axis == Axis::Y => fit.map(|fit| joint::of_plausible_ay(fit, self.hidden_error_of(Channel::Ay))),
            None => fit,
        }
    }

    /// The terms of an equation.
    ///
    /// Without an input of its own a plane follows a few motions of the other, which many terms explain alike: the selection
    /// among them is arbitrary, so each that it leaves out counts as one that hardly moved does.
    ///
    /// # Errors
    /// Of such a plane an equation has no numbers where a motion of the fast modes (all but u) which belongs to it hardly moved:
    /// in a slow response other terms take its place.
    pub(super) fn offer(&self, axis: Axis, instruments: &Instrumentation) -> Result<Offer, Reason> {
        let mut offer = Offer::NONE;
        offer.noise_vars.copy_from_slice(&noise_variances(&instruments.noise)[..REGRESSORS]);
        let follows = self.excitation.response_s(axis.is_lateral()).is_none();
        offer.follows = follows;
        for variable in Variable::ALL {
            let place = regressor(variable);
            let deviation = self.information.deviation(place);
            let still = STILL[variable.index()];
            if !observed(variable, instruments) {
                continue;
            }
            let belongs = is_primary(axis, variable);
            let primary = belongs && deviation > still;
            if follows && belongs && !primary && !variable.is_control() && variable != Variable::U {
                return Err(Reason::NotExcited { axis, variable });
            }
            let moving = endogeneity::independent_samples(self.information.moving_samples(place), self.interval_s);
            let optional = !primary && deviation > UNMOVED * still && moving >= MOVING_SAMPLES;
            offer.belongs[place] = belongs && !variable.is_control() && variable != Variable::U;
            offer.primary[place] = primary;
            offer.optional[place] = optional;
            offer.undetermined[place] = !primary && (follows || !variable.is_control() || belongs && !optional);
        }
        Ok(offer)
    }

    /// The status of an equation whose motion was excited for too short a time yet: of its own plane, where an input has moved
    /// one of that plane's controls. A slow motion of the other plane that has gone on for long tells nothing of it.
    pub(super) fn too_short(&self, axis: Axis) -> Option<Status> {
        if self.excited_s <= 0.0 {
            return Some(Status::Waiting);
        }
        let excited_s = self.excitation.response_s(axis.is_lateral()).unwrap_or(self.excited_s);
        (excited_s < self.config.exciting_s).then_some(Status::Exciting)
    }

    fn equation(&mut self, axis: Axis, time_s: f64, instruments: &Instrumentation) -> (EquationRecord, Option<Fit>) {
        if let Some(status) = self.too_short(axis) {
            return (EquationRecord::empty(axis, status), None);
        }
        // A response that is zero throughout is of an instrument that stands, not of an aircraft.
        if !(self.information.deviation(response(axis)) > 0.0) {
            return (EquationRecord::empty(axis, Status::Exciting), None);
        }
        let offer = match self.offer(axis, instruments) {
            Ok(offer) => offer,
            Err(reason) => return (EquationRecord::empty(axis, Status::NotIdentifiable(reason)), None),
        };
        let samples = self.information.effective_samples();
        let independent = endogeneity::independent_samples(samples, self.interval_s);
        let small_sample = |parameters: usize| coloured_errors::small_sample_factor(samples, independent, parameters as f64);
        let primary = 1 + offer.primary.iter().filter(|primary| **primary).count();
        let [f_enter, f_remove] = [self.config.f_enter, self.config.f_remove].map(|f| f * small_sample(primary));
        let thresholds = Thresholds { f_enter, f_remove };
        let Some(mut fit) = fit(&self.information, response(axis), &offer, &thresholds) else {
            return (EquationRecord::empty(axis, Status::Exciting), None);
        };
        if independent < fit.order.len() as f64 + LEFT_OVER {
            return (EquationRecord::empty(axis, Status::Exciting), None);
        }
        fit.scale_covariance(small_sample(fit.order.len()));
        let residual = coloured_errors::residual_covariance(&self.information, &fit.residual, &fit.residual, fit.order.len());
        let speed = self.trim.map_or(0.0, |trim| trim.velocity[0]);
        let depends_on_amplitude = self.curvature.account_for(axis, &mut fit, speed, residual[0]);
        let noise = noise_variances(&instruments.noise);
        endogeneity::account_for_attenuation(&mut fit, &noise, self.information.weight());
        self.account_for_disturbance(axis, &mut fit, residual[0], &noise);
        let mut equation = self.written(axis, &fit, &offer, residual[0], instruments);
        let doubtful = self.unobserved_motion(instruments)
            || instruments.vanes_disagree[usize::from(axis.is_lateral())]
            || !instruments.is_confirmed(Channel::Tas)
            || needs(axis).into_iter().any(|aid| !instruments.as_expected[aid.index()])
            || accelerometer(axis).is_some_and(|channel| !instruments.is_confirmed(channel));
        if equation.terms.iter().all(|term| term.variable.is_none()) {
            // A bias alone tells nothing of the aircraft.
            equation.terms.clear();
        }
        equation.status = match self.status(&equation, time_s) {
            // There is no answer that could be out of date either.
            Status::Converging | Status::Converged | Status::Stale if equation.terms.is_empty() => Status::Exciting,
            // Settled, about a motion that may not be the aircraft's.
            Status::Converged if doubtful => Status::Converging,
            Status::Converging | Status::Converged if depends_on_amplitude => Status::DependsOnAmplitude,
            status @ Status::NotIdentifiable(_) => return (EquationRecord::empty(axis, status), None),
            status => status,
        };
        (equation, Some(fit))
    }

    /// Least squares holds while the disturbance of the equation is the instruments' noise; what exceeds it may move the
    /// aircraft.
    fn account_for_disturbance(&mut self, axis: Axis, fit: &mut Fit, residual_var: f64, noise: &[f64; SIGNALS]) {
        let disturbance_var =
            endogeneity::disturbance_variance(fit, residual_var, noise, self.information.effective_samples(), self.interval_s);
        // At the same times whichever equation asks first.
        let period = |excited_s: f64| libm::floor(excited_s / INSTRUMENTS_S);
        if disturbance_var > 0.0 && period(self.excited_s) > period(self.instruments_of_s) {
            self.instruments = Instruments::new(&self.information);
            self.instruments_of_s = self.excited_s;
        }
        if !(disturbance_var > 0.0) {
            return;
        }
        let instruments = self.instruments.as_ref();
        let by_instruments = instruments.and_then(|one| one.estimate(&self.information, &fit.order, response(axis)));
        endogeneity::account_for(fit, self.information.weight(), by_instruments.as_ref(), disturbance_var);
    }
}
