//! The data of a diagnosis: which runs are usable, and each run on the mesh of the filter.

pub mod blade_input;
pub(crate) mod blade_passing;
pub mod instrument_check;
pub(crate) mod rotor_speed_smoother;
pub mod run_data;
pub mod trim_difference;
pub(crate) mod unit_check;
pub(crate) mod usable_runs;
