//! Consistency: errors are as large as the filter says, over many seeded flights.

mod filter;
mod gusts;
mod instruments;
mod output_error;
