//! Outputs: MCAP log, terminal table, JSON, and the queue that feeds them.
//!
//! In: the records of every stage, through a bounded queue that never holds the estimator up. Out: files and text.
//! Assumed: messages of one run in order of time. Refused: nothing; what cannot be written is counted and said.

mod estimation_sentence;
pub mod event_ring;
pub mod record;
pub mod text;

#[cfg(feature = "std")]
pub mod chart;
#[cfg(feature = "std")]
pub mod derivatives_json;
#[cfg(feature = "std")]
pub mod effect_json;
#[cfg(feature = "std")]
mod finding_json;
#[cfg(feature = "std")]
pub mod finding_text;
#[cfg(feature = "std")]
pub mod json_schema;
#[cfg(feature = "std")]
pub mod log_thread;
#[cfg(feature = "std")]
pub mod mcap_log;
#[cfg(feature = "std")]
mod message_json;
#[cfg(feature = "std")]
mod modes_json;
#[cfg(feature = "std")]
pub mod noise;
#[cfg(feature = "std")]
mod output_error_json;
#[cfg(feature = "std")]
pub mod output_error_text;
#[cfg(feature = "std")]
pub mod page;
#[cfg(feature = "std")]
pub mod queue;
#[cfg(feature = "std")]
pub mod state_file;
#[cfg(feature = "std")]
pub mod terminal;
