//! The evidence beside a cause: residuals, their spectra and the regressors that they correlate with.

pub(crate) mod cause_size;
pub mod flight_path;
pub mod regressor_plot;
pub mod reliance;
pub mod residual;
pub mod residual_coherence;
pub(crate) mod residual_series;
pub(crate) mod size_error;
