//! What crosses the border: telemetry in, shared memory, outputs, a ground station.

#[cfg(feature = "bus")]
pub mod bus;
#[cfg(feature = "mavlink")]
pub mod ground_station;
pub mod outputs;
pub mod telemetry;
pub mod text_file;
