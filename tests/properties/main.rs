//! What must hold for every input: round trips, order, symmetry.

mod run_files;
