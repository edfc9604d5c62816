//! Preliminary interpretation: simulated flights whose answers are known, and real recordings with published ones.

mod flights;
mod recordings;
mod whole_flight;
