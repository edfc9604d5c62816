//! Several recordings of one flight, and disordered samples of one, on one axis of time.
//!
//! In: samples of a channel that two recordings share; rows of both; samples as they arrived with their time stamps.
//! Out: the relation of two clocks with its standard errors ([`clock_relation`], estimated by [`clock_estimation`]); rows of both
//! in order of time ([`merge`]); one monotone axis with a table of what is missing ([`reorder`]), and by it rows whose channels
//! were stamped with latencies of their own ([`row_alignment`], of a recording [`aligned_recording`]).
//! Assumed: clocks run at constant rates. Refused: a relation that the signals do not determine, with the reason.

#[cfg(all(feature = "log", feature = "mavlink"))]
pub mod aligned_recording;
pub mod clock_estimation;
pub mod clock_relation;
pub mod dropout;
pub mod merge;
pub mod reorder;
pub mod row_alignment;
