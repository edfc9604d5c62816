//! The pipeline: the only wiring of the stages. A sample in, everything that it brought out.
//!
//! No clock, no I/O, no allocation: live, replay and firmware run this very code.

use super::estimation::config::{ConfigError, EstimationConfig};
use super::estimation::estimator::{EVENTS as ESTIMATION_EVENTS, Estimator};
use super::estimation::record::{AIDS, EstimationEvent, Innovation, LaggedRecord, StateRecord};
use super::modes::persistence::Persistence;
use super::modes::record::ModesRecord;
use super::modes::stage;
use super::regression::config::RegressionConfig;
use super::regression::record::{DerivativesRecord, RegressionEvent};
use super::regression::recursive::{EVENTS as REGRESSION_EVENTS, Recursive};
use crate::flight::derivative::AXES;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use heapless::Vec;

/// Derivatives and modes are published at the last sample that is no more than this later than the last publication, s: 10 Hz
/// or faster for every rate of samples that is.
const PUBLISH_S: f64 = 0.1 + 1e-6;

/// Configuration of every stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PipelineConfig {
    /// Of the state estimation.
    pub estimation: EstimationConfig,
    /// Of the regression.
    pub regression: RegressionConfig,
}

impl PipelineConfig {
    /// Instruments of flight-test quality.
    pub const DEFAULT: PipelineConfig =
        PipelineConfig { estimation: EstimationConfig::DEFAULT, regression: RegressionConfig::DEFAULT };

    /// Checks every setting once.
    ///
    /// # Errors
    /// [`ConfigError`] names the first setting that is out of its range.
    pub const fn check(self) -> Result<CheckedConfig, ConfigError> {
        match (self.estimation.validate(), self.regression.validate()) {
            (Err(error), _) | (Ok(()), Err(error)) => Err(error),
            (Ok(()), Ok(())) => Ok(CheckedConfig(self)),
        }
    }
}

/// A configuration whose every setting has been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedConfig(PipelineConfig);

/// What one sample brought.
#[derive(Clone, Debug, Default)]
pub struct Tick {
    /// The filtered state.
    pub state: Option<StateRecord>,
    /// The smoothed state of a while ago, where one came of age.
    pub smoothed: Option<LaggedRecord>,
    /// What the aids did.
    pub innovations: Vec<Innovation, AIDS>,
    /// The derivatives, at each publication.
    pub derivatives: Option<DerivativesRecord>,
    /// The modes, at each publication.
    pub modes: Option<ModesRecord>,
    /// What the estimation noticed.
    pub estimation_events: Vec<EstimationEvent, ESTIMATION_EVENTS>,
    /// What the regression noticed.
    pub regression_events: Vec<RegressionEvent, REGRESSION_EVENTS>,
}

impl Tick {
    const EMPTY: Tick = Tick {
        state: None,
        smoothed: None,
        innovations: Vec::new(),
        derivatives: None,
        modes: None,
        estimation_events: Vec::new(),
        regression_events: Vec::new(),
    };
}

/// The stages, wired.
#[derive(Clone, Debug)]
pub struct Pipeline {
    estimator: Estimator,
    recursive: Recursive,
    persistence: Persistence,
    published_s: Option<f64>,
    /// Time of the sample before, s.
    before_s: f64,
    tick: Tick,
}

impl Pipeline {
    /// A pipeline for a run with that geometry.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that cannot be used.
    pub fn new(config: &PipelineConfig, geometry: RunGeometry) -> Result<Self, ConfigError> {
        Ok(Pipeline::of(&config.check()?, geometry))
    }

    /// The same from a configuration that has been checked; at compile time too, for a pipeline in a `static`.
    pub const fn of(config: &CheckedConfig, geometry: RunGeometry) -> Self {
        let CheckedConfig(config) = config;
        Pipeline {
            estimator: Estimator::of(config.estimation, geometry),
            recursive: Recursive::of(config.regression),
            persistence: Persistence::START,
            published_s: None,
            before_s: 0.0,
            tick: Tick::EMPTY,
        }
    }

    /// The estimation stage.
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// The regression stage.
    pub fn regression(&self) -> &Recursive {
        &self.recursive
    }

    /// Marks the axes in which output error, which runs beside the pipeline, gives other numbers.
    pub fn set_contradicted(&mut self, axes: [bool; AXES]) {
        self.recursive.set_contradicted(axes);
    }

    /// One sample.
    pub fn step(&mut self, sample: &Sample) -> &Tick {
        let output = self.estimator.step(sample);
        self.tick.state = output.state;
        self.tick.smoothed = output.lagged;
        self.tick.innovations.clone_from(&output.innovations);
        self.tick.estimation_events.clone_from(&output.events);
        self.tick.derivatives = None;
        self.tick.modes = None;
        self.tick.regression_events.clear();
        if let Some(trim) = output.trim {
            self.recursive.begin(trim);
        }
        for smoothed in &output.smoothed {
            self.recursive.step(smoothed);
        }
        let due = match self.published_s {
            // A clock that was set back counts as due.
            Some(published_s) => {
                let next_s = sample.time_s + (sample.time_s - self.before_s).max(0.0);
                next_s - published_s > PUBLISH_S || sample.time_s < published_s
            }
            None => true,
        };
        if sample.time_s.is_finite() {
            self.before_s = sample.time_s;
        }
        if due && sample.time_s.is_finite() {
            self.publish(sample.time_s);
        }
        &self.tick
    }

    /// The last word at the end of a run: derivatives and modes from everything that came of age.
    pub fn finish(&mut self) -> &Tick {
        self.tick = Tick::default();
        if let Some(published_s) = self.published_s {
            self.publish(published_s);
        }
        &self.tick
    }

    /// Derivatives and modes from the band of frequencies alone, as everything that came of age tells them.
    pub fn in_band(&self) -> (DerivativesRecord, ModesRecord) {
        let derivatives = self.recursive.in_band(self.published_s.unwrap_or(0.0), &self.estimator.instrumentation());
        let modes = stage::step(&derivatives, None, self.recursive.trim_pitch_std());
        (derivatives, modes)
    }

    fn publish(&mut self, time_s: f64) {
        let elapsed_s = self.published_s.map_or(0.0, |published_s| (time_s - published_s).max(0.0));
        self.published_s = Some(time_s);
        let derivatives = self.recursive.record(time_s, elapsed_s, &self.estimator.instrumentation());
        self.tick.regression_events = self.recursive.take_events();
        let mut modes = stage::step(&derivatives, self.recursive.six_axis(), self.recursive.trim_pitch_std());
        self.persistence.step(&mut modes);
        self.tick.modes = Some(modes);
        self.tick.derivatives = Some(derivatives);
    }
}
