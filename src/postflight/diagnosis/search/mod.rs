//! The search for causes: faults of the recording, the list of hypotheses, the score test of all, forward search and re-test.

pub mod forward_search;
pub(crate) mod gusts;
pub mod hypotheses;
pub mod joint_derivatives;
pub mod next_cause;
pub(crate) mod recording_faults;
pub(crate) mod retest;
pub mod score_test;
pub(crate) mod substitution;
