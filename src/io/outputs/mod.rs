//! Outputs: MCAP log, JSON, tables, charts and pages, and the queue between the estimator and the writers.
//!
//! In: records of every stage, through a bounded queue that never blocks the estimator. Out: files and text.
//! Assumed: messages of one run in order of time. Refused: nothing; messages that cannot be written are counted and reported.

#[cfg(feature = "charts")]
pub mod charts;
pub mod event_ring;
pub mod html;
#[cfg(feature = "log")]
pub mod json;
#[cfg(feature = "log")]
pub mod log;
pub mod number;
pub mod queue;
pub mod record;
pub mod tables;
pub mod words;
