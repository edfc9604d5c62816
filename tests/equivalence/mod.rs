//! Two ways to the same answer: recursive and batch, sequential and joint, firmware and host, today and again.

mod determinism;
mod error_autocovariance;
mod filter_error;
mod frequency;
mod output_error;
mod recursive_batch;
mod replay;
mod sample_rates;
mod sequential_joint;
mod smoothed_file;
mod smoothers;
mod structure;
