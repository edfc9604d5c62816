//! Live: the pipeline together with the workers beside it, and where their records go.
//!
//! In: samples from any source. Out: every record of the pipeline, output error and findings at the end of each manoeuvre
//! (computed beside the sample path), to a publisher, a log and the sink that keeps the newest.

pub mod agreement;
pub mod diagnosis;
mod error_scale;
#[cfg(feature = "bus")]
pub mod estimate_publisher;
pub(crate) mod live_fit;
pub mod manoeuvre_buffer;
pub mod output_error;
pub mod output_error_config;
pub mod record_sink;
pub mod regression_report;
pub mod wiring;
pub mod worker;
