//! The estimation pipeline as a flight computer carries it: one block of memory of known size, no heap.
//!
//! In: samples. Out: what each brought. The pipeline is the very one that runs live and in replay. Its sizes are held
//! within `budget.toml`: a build that exceeds one of them fails.
#![no_std]

pub mod budget;
pub mod fingerprint;
pub mod manoeuvre;

use sideslip::estimation::config::ConfigError;
use sideslip::flight::run::RunGeometry;
use sideslip::pipeline::{Config, Pipeline, Tick};
use sideslip::telemetry::record::Sample;

/// The one place of a pipeline: made at compile time, so that a `static` of it is all the memory there is.
#[derive(Debug)]
pub struct Profile {
    pipeline: Option<Pipeline>,
}

impl Default for Profile {
    fn default() -> Self {
        Profile::new()
    }
}

impl Profile {
    /// The place, with no pipeline in it yet.
    pub const fn new() -> Self {
        Profile { pipeline: None }
    }

    /// Puts a pipeline for a run with that geometry into the place; one that stood there is gone.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that cannot be used; the place is then as it was.
    pub fn start(&mut self, config: &Config, geometry: RunGeometry) -> Result<(), ConfigError> {
        self.pipeline = Some(Pipeline::new(config, geometry)?);
        Ok(())
    }

    /// One sample: everything that it brought; `None` before [`Profile::start`].
    pub fn step(&mut self, sample: &Sample) -> Option<&Tick> {
        self.pipeline.as_mut().map(|pipeline| pipeline.step(sample))
    }

    /// The last word at the end of a run; `None` before [`Profile::start`].
    pub fn finish(&mut self) -> Option<&Tick> {
        self.pipeline.as_mut().map(Pipeline::finish)
    }
}

#[cfg(test)]
mod tests;
