//! The regression stage: six equations from smoothed signals, at a cost that does not grow with the record.
//!
//! Consumes the run's trim once and a [`SmoothedRecord`] an instant of the grid; produces a [`DerivativesRecord`] whenever
//! asked, with a status where there is no number.

mod coupling;
mod equation;
mod in_band;
mod instruments;
mod joint;
mod publication;

use super::candidate::{self, BIAS, REGRESSORS, SIGNALS, regressor};
use super::config::RegressionConfig;
use super::curvature::Curvature;
use super::excitation::Excitation;
use super::frequency::estimate::Shared;
use super::frequency::transforms::Transforms;
use super::information::{Information, LAGS};
use super::instrumental::Instruments;
use super::record::{
    DerivativesRecord, EquationRecord, FrequencyTerm, Reason, RegressionEvent, SixAxisDerivatives, Status, TermRecord,
};
use super::status::Settling;
use super::stepwise::Fit;
use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::setting::ConfigError;
use crate::realtime::estimation::record::{Confirmation, Instrumentation, SmoothedRecord, TrimRecord};
use heapless::Vec;

/// Events that one publication can bring.
pub const EVENTS: usize = AXES + 6;

/// Silence of an instrument after which the equations that need it are not identifiable, s.
const PATIENCE_S: f64 = 2.0;
/// Silence of the rates after which the states are no longer those of before, and time that they then take to settle, s.
const SILENT_S: f64 = 0.5;
const SETTLING_S: f64 = 1.5;

/// The regression stage.
#[derive(Clone, Debug)]
pub struct Recursive {
    config: RegressionConfig,
    trim: Option<TrimRecord>,
    information: Information<SIGNALS>,
    curvature: Curvature,
    transforms: Transforms,
    excitation: Excitation,
    excited: bool,
    excited_s: f64,
    quiet_s: f64,
    newest_s: Option<f64>,
    /// Until then the states settle after a silence, s.
    settled_at_s: f64,
    /// Interval of the grid, s.
    interval_s: f64,
    /// Time without a record, s.
    silent_s: f64,
    age_s: f64,
    settling: [Settling; AXES],
    statuses: [Status; AXES],
    six_axis: Option<SixAxisDerivatives>,
    curvature_std: [[f32; VARIABLES]; AXES],
    /// What is known about sign and unit, by `Confirmation::CHANNELS`, as of the last excitation.
    confirmations: [Confirmation; Confirmation::CHANNELS.len()],
    /// Axes in which another method of estimation gives other numbers.
    contradicted: [bool; AXES],
    /// Instrumental variables of the record up to `instruments_of_s` of excited time; `None` where there are none.
    instruments: Option<Instruments>,
    instruments_of_s: f64,
    /// Channels whose absence has been reported, a bit each.
    reported: u32,
    events: Vec<RegressionEvent, EVENTS>,
}

impl Recursive {
    /// A stage without data.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that cannot be used.
    pub fn new(config: RegressionConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        Ok(Recursive::of(config))
    }

    /// The same for a configuration that has been validated; at compile time too.
    pub(crate) const fn of(config: RegressionConfig) -> Self {
        Recursive {
            trim: None,
            information: Information::EMPTY,
            curvature: Curvature::EMPTY,
            transforms: Transforms::new(config.band, config.forgetting_s),
            excitation: Excitation::START,
            excited: false,
            excited_s: 0.0,
            quiet_s: 0.0,
            newest_s: None,
            settled_at_s: f64::NEG_INFINITY,
            interval_s: 0.0,
            silent_s: 0.0,
            age_s: 0.0,
            settling: [Settling::new(config.settled_s); AXES],
            statuses: [Status::Waiting; AXES],
            six_axis: None,
            curvature_std: [[f32::NAN; VARIABLES]; AXES],
            confirmations: [Confirmation::Doubted; Confirmation::CHANNELS.len()],
            contradicted: [false; AXES],
            instruments: None,
            instruments_of_s: f64::NEG_INFINITY,
            reported: 0,
            events: Vec::new(),
            config,
        }
    }

    /// The run's trim; signals before it are not used.
    pub fn begin(&mut self, trim: TrimRecord) {
        self.trim = Some(trim);
    }

    /// Marks the axes in which another method of estimation, from the same flight, gives other numbers: they publish
    /// [`Status::Disagree`] until this is called again.
    pub fn set_contradicted(&mut self, axes: [bool; AXES]) {
        self.contradicted = axes;
    }

    /// The information matrix.
    pub fn information(&self) -> &Information<SIGNALS> {
        &self.information
    }

    /// Events since the last call.
    pub fn take_events(&mut self) -> Vec<RegressionEvent, EVENTS> {
        core::mem::take(&mut self.events)
    }

    fn notice(&mut self, event: RegressionEvent) {
        let _ = self.events.push(event);
    }

    /// One instant of the grid.
    pub fn step(&mut self, record: &SmoothedRecord) {
        let Some(trim) = self.trim else { return };
        // Instants without smoothed signals (silence, a gap under the kernel) are gaps in the lagged products too.
        let missed = match self.newest_s.replace(record.time_s) {
            Some(newest_s) if record.time_s > newest_s => libm::round((record.time_s - newest_s) / record.interval_s) - 1.0,
            Some(_) => LAGS as f64,
            None => 0.0,
        };
        if missed > 0.0 {
            self.excitation.skip(missed * record.interval_s);
        }
        if missed * record.interval_s > SILENT_S {
            self.settled_at_s = record.time_s + SETTLING_S;
        }
        for _ in 0..missed.clamp(0.0, LAGS as f64) as usize {
            self.information.skip();
            self.transforms.hole();
        }
        self.silent_s = 0.0;
        self.untrimmed(record, &trim);
        let settling = record.time_s < self.settled_at_s && self.settled_at_s <= record.time_s + SETTLING_S;
        let Some(z) = candidate::signals(record, &trim).filter(|_| !settling) else {
            self.information.skip();
            self.transforms.hole();
            self.excitation.skip(record.interval_s);
            self.quiet_s += record.interval_s;
            if !settling {
                self.missing(record, &trim);
            }
            return;
        };
        let interval_s = record.interval_s;
        self.interval_s = interval_s;
        let excited = self.excitation.step(&z, interval_s);
        if excited != self.excited {
            self.excited = excited;
            self.notice(if excited { RegressionEvent::ExcitationBegan } else { RegressionEvent::ExcitationEnded });
        }
        if excited {
            let forget = libm::exp(-interval_s / self.config.forgetting_s);
            self.information.add(&z, forget);
            self.curvature.add(&z, forget);
            self.transforms.add(&z, interval_s);
            self.excited_s += interval_s;
            self.quiet_s = 0.0;
        } else {
            self.information.skip();
            self.transforms.hole();
            self.quiet_s += interval_s;
        }
    }

    /// One event for each channel that was silent at an instant of the grid.
    fn missing(&mut self, record: &SmoothedRecord, trim: &TrimRecord) {
        for (i, channel) in Channel::ACCELEROMETERS.into_iter().enumerate() {
            if trim.specific_force[i].is_finite() && !record.specific_force[i].is_finite() {
                self.report_once(channel, RegressionEvent::SignalMissing { channel });
            }
        }
        for (i, channel) in Channel::CONTROLS.into_iter().enumerate() {
            if trim.controls[i].is_finite() && !record.controls_present[i] {
                self.report_once(channel, RegressionEvent::SignalMissing { channel });
            }
        }
    }

    /// One event for each control without a trim.
    fn untrimmed(&mut self, record: &SmoothedRecord, trim: &TrimRecord) {
        for (i, channel) in Channel::CONTROLS.into_iter().enumerate() {
            if record.controls_present[i] && !trim.controls[i].is_finite() {
                self.report_once(channel, RegressionEvent::NoTrim { channel });
            }
        }
    }

    fn report_once(&mut self, channel: Channel, event: RegressionEvent) {
        let mark = 1 << channel.index();
        // Room is left for the other events of a publication; an event without room is repeated at the next instant.
        if self.reported & mark == 0 && self.events.len() < EVENTS - AXES - 2 {
            self.reported |= mark;
            self.notice(event);
        }
    }

    /// All equations as they stand; `elapsed_s` since the last time, for what depends on time alone.
    pub fn record(&mut self, time_s: f64, elapsed_s: f64, instruments: &Instrumentation) -> DerivativesRecord {
        self.age_s += elapsed_s;
        self.silent_s += elapsed_s;
        self.judge_confirmations(instruments);
        let mut fits: [Option<Fit>; AXES] = [const { None }; AXES];
        let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Waiting));
        for (axis, (equation, fit)) in Axis::ALL.into_iter().zip(equations.iter_mut().zip(&mut fits)) {
            *fit = self.confirmed_equation(axis, time_s, instruments, equation);
        }
        for lateral in [false, true] {
            if self.is_plane_excited(lateral, &equations) {
                continue;
            }
            for (equation, fit) in equations.iter_mut().zip(&mut fits).filter(|(one, _)| one.axis.is_lateral() == lateral) {
                let has_not_moved = matches!(equation.status, Status::NotIdentifiable(Reason::NotExcited { .. }));
                if has_not_moved || !equation.terms.is_empty() {
                    let status = Status::NotIdentifiable(Reason::NoInput);
                    (*equation, *fit) = (EquationRecord::empty(equation.axis, status), None);
                }
            }
        }
        self.add_frequency_estimates(&mut equations, &fits);
        for (equation, contradicted) in equations.iter_mut().zip(self.contradicted) {
            let apart = |(_, standard_errors): (Variable, f64)| standard_errors.abs() > EquationRecord::AGREE_WITHIN;
            if (contradicted || equation.disagreement().is_some_and(apart)) && equation.status.rank() > Status::Disagree.rank() {
                equation.status = Status::Disagree;
            }
        }
        for (i, axis) in Axis::ALL.into_iter().enumerate() {
            let status = equations[i].status;
            if core::mem::discriminant(&status) != core::mem::discriminant(&self.statuses[i]) {
                self.notice(RegressionEvent::StatusChanged { axis, status });
            }
            self.statuses[i] = status;
        }
        for (stds, fit) in self.curvature_std.iter_mut().zip(&fits) {
            *stds = Variable::ALL.map(|variable| match fit {
                Some(fit) if fit.order.contains(&regressor(variable)) => {
                    libm::sqrt(fit.curvature_var[regressor(variable)]) as f32
                }
                _ => f32::NAN,
            });
        }
        let lateral = self.trim.as_ref().and_then(|trim| joint::lateral(&self.information, trim, &fits));
        self.six_axis = self.trim.as_ref().and_then(|trim| joint::six_axis(trim, &fits, &equations));
        DerivativesRecord { time_s, equations, lateral, excited: self.excited }
    }

    /// Adds the frequency-domain estimates of the terms of every equation.
    #[inline(never)]
    fn add_frequency_estimates(&self, equations: &mut [EquationRecord; AXES], fits: &[Option<Fit>; AXES]) {
        let mut wanted = [false; REGRESSORS];
        let place = |term: &TermRecord| term.variable.map_or(BIAS, regressor);
        equations.iter().flat_map(|equation| &equation.terms).for_each(|term| wanted[place(term)] = true);
        if !wanted.contains(&true) {
            return;
        }
        let shared = Shared::new(&self.transforms, &wanted);
        for equation in equations {
            let order: Vec<usize, REGRESSORS> = equation.terms.iter().map(place).collect();
            let Some(estimate) = shared.fit(&self.transforms, equation.axis, &order) else { continue };
            let bias_var = fits[equation.axis.index()].as_ref().map_or([0.0; REGRESSORS], |fit| fit.bias_var);
            for term in &mut equation.terms {
                let place = place(term);
                // Biased as least squares over time is; and a part of the data tells no more than all of it.
                let std = libm::sqrt(estimate.std[place] * estimate.std[place] + bias_var[place]).max(term.std);
                term.frequency = Some(FrequencyTerm { value: estimate.theta[place], std });
            }
        }
    }

    /// Standard errors that curvature of the forces and moments contributes to those of the last record, by axis and variable;
    /// NaN of a term that is in no equation. Every method that fits a linear model to the same motion has them.
    pub fn curvature_std(&self) -> &[[f32; VARIABLES]; AXES] {
        &self.curvature_std
    }

    /// The derivatives of all six equations as of the last record, where all have numbers.
    pub fn six_axis(&self) -> Option<&SixAxisDerivatives> {
        self.six_axis.as_ref()
    }
}
