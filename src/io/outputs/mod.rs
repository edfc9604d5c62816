//! Outputs: MCAP log, terminal table, JSON, and the queue that feeds them.
//!
//! In: the records of every stage, through a bounded queue that never holds the estimator up. Out: files and text.
//! Assumed: messages of one run in order of time. Refused: nothing; what cannot be written is counted and said.

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
