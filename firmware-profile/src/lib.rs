//! The estimation pipeline as a flight computer carries it: one block of memory of known size, no heap.
//!
//! In: samples. Out: what each brought. The pipeline is the very one that runs live and in replay. Its sizes are held
//! within `budget.toml`: a build that exceeds one of them fails.
#![no_std]

#[cfg(feature = "hosted")]
extern crate std;

pub mod budget;
pub mod c_interface;
pub mod fingerprint;
pub mod manoeuvre;

use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::pipeline::{CheckedConfig, Pipeline, PipelineConfig, Tick};

/// The settings that the profile flies with. One out of its range does not compile.
pub const SETTINGS: CheckedConfig = match PipelineConfig::DEFAULT.check() {
    Ok(checked) => checked,
    Err(_) => panic!("a setting of the profile is out of its range"),
};

/// The one place of a pipeline: made at compile time, so that a `static` of it is all the memory that there is, and no
/// stack is needed to start.
#[derive(Debug)]
pub struct Profile {
    pipeline: Pipeline,
}

impl Profile {
    /// The pipeline for a run with that geometry, ready for its first sample.
    pub const fn new(settings: &CheckedConfig, geometry: RunGeometry) -> Self {
        Profile { pipeline: Pipeline::of(settings, geometry) }
    }

    /// One sample: everything that it brought.
    pub fn step(&mut self, sample: &Sample) -> &Tick {
        self.pipeline.step(sample)
    }

    /// The last word at the end of a run.
    pub fn finish(&mut self) -> &Tick {
        self.pipeline.finish()
    }
}

#[cfg(test)]
mod tests;
