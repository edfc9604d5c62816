//! Recordings as the commands read and write them.

pub(crate) mod chosen_runs;
pub(crate) mod flown_inputs;
pub(crate) mod free_run_curves;
pub(crate) mod provenance;
pub(crate) mod recording_losses;
pub(crate) mod run_condition;
pub(crate) mod run_controls;
pub(crate) mod run_head;
pub(crate) mod run_input;
pub(crate) mod run_log;
pub(crate) mod run_names;
pub(crate) mod run_result;
pub(crate) mod simulated_run;
