//! What crosses the border: telemetry in, shared memory, outputs.

#[cfg(feature = "bus")]
pub mod bus;
pub mod outputs;
pub mod telemetry;
