//! The slow part: the smoother and instrument biases over many seeded flights.

mod biases;
mod signal_noise;
mod smoother;
