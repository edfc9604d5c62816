//! Published values, with their provenance: what we compute from the same data comes out the same.

mod attas;
mod attas_output_error;
mod level1_puma;
mod puma_matrices;
mod twin_otter;
