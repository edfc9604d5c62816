//! The slow part: the relation of two clocks over many simulated pairs.

mod clock_coverage;
mod clock_pairs;
