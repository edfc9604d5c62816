//! Outputs: MCAP log, terminal table, JSON, and the queue that feeds them.
//!
//! In: the records of every stage, through a bounded queue that never holds the estimator up. Out: files and text.
//! Assumed: messages of one run in order of time. Refused: nothing; what cannot be written is counted and said.

pub mod record;
