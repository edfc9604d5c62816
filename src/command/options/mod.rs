//! Options that several commands share.

pub(crate) mod estimation_options;
pub(crate) mod fitted_runs;
pub(crate) mod flight_condition;
pub(crate) mod instrument_input;
pub(crate) mod live_diagnosis_options;
pub(crate) mod mapping_input;
pub(crate) mod mavlink_out_options;
pub(crate) mod replace_option;
pub(crate) mod run_parts;
pub(crate) mod signing_input;
pub(crate) mod telemetry_source;
