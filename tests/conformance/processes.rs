//! The part with processes that are killed.

#[allow(dead_code, reason = "each binary uses its part")]
mod example;
mod killed;
mod killed_program;
