//! Published values, with their provenance: what we compute from the same data comes out the same.

mod puma_matrices;

#[path = "../support/puma.rs"]
mod puma;
