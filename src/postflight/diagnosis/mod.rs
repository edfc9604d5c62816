//! What a model gets wrong, and why: the cause named, the model extended, the improvement measured on hold-out runs.
//!
//! In: a model with effects (`simulation::flight_model`), runs as samples with their geometry.
//! - `data`: `usable_runs` and `instrument_check` choose the runs, `run_data` puts each on the mesh of the filter, `blade_input`
//!   says what reached the blades.
//! - `likelihood`: `aircraft` has the forces, `run_model` a run's f, F, h and H, `filter` its innovations (with `covariance`,
//!   `noise_score` and `sensitivity`); `problem` joins the runs, `normal_equations` linearises them about a `parameter_set`,
//!   `maximise` iterates, `adequacy` says what remains unexplained.
//! - `search`: `hypotheses` lists every effect, `score_test` tests all of them at once, `next_cause` fits the best,
//!   `forward_search` adds causes one by one, `retest` tests earlier causes with the later ones in place; where many derivatives
//!   are wrong `joint_derivatives` frees all at once, and `substitution` says what would replace each.
//! - `evidence`: residuals, their spectra and coherence with states and controls, the residual of a cause over its regressor.
//! - `holdout`: what the causes gain in predictions over a horizon, on runs that they were not found in.
//!
//! `diagnose` puts these together; `record` is the vocabulary that other rooms import.
//! Assumed: body axes, SI; controls in straight lines between samples; a run begins in its own trim.
//! Refused: a run without rates, one too short, a control that the model answers to and the run lacks, a time that goes back, a
//! channel in another unit than its header says (`unit_check`).

pub mod data;
pub mod diagnose;
pub mod evidence;
pub mod holdout;
pub mod likelihood;
pub mod record;
pub mod search;
