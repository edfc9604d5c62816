//! x

pub mod record;

#[cfg(feature = "std")]
pub mod mcap;
#[cfg(feature = "std")]
mod mcap_stream;
