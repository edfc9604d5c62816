//! What must hold for every input: round trips, order, symmetry.
#![allow(clippy::float_cmp, reason = "bits are compared")]

mod admission;
mod any_sample;
mod covariance;
mod filter_covariance;
mod kernel;
mod mavlink_frames;
mod missing;
mod pipeline;
mod run_files;
