//! The MCAP log and the thread that writes it.

mod log_clock;
pub mod log_thread;
pub mod mcap_log;
pub mod state_file;
mod whole_chunks;
