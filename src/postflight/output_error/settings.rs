//! Settings of a fit by output error or filter error.

use crate::postflight::work_progress::Watch;

/// Form of the covariance R of the output noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseCovariance {
    /// Uncorrelated; outputs may be sampled at different times.
    #[default]
    Diagonal,
    /// Full; all outputs at the same times.
    Full,
}

/// Settings of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitSettings {
    /// Largest number of steps.
    pub iterations: usize,
    /// Length of a step below which the search ends, standard errors.
    pub tolerance: f64,
    /// Covariance of the noise.
    pub noise: NoiseCovariance,
    /// Whether delays are first tried from 0 to 200 ms; else they begin at their start.
    pub delay_grid: bool,
    /// Who watches the search, and may end it: `iterations` steps each time. One that was ended has not converged.
    pub watch: Watch,
}

impl Default for FitSettings {
    fn default() -> Self {
        FitSettings { iterations: 60, tolerance: 1e-3, noise: NoiseCovariance::Diagonal, delay_grid: true, watch: None }
    }
}
