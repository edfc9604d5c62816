//! Diagnosis: where a model and measured runs part, and what it would be worth to mend it.
//!
//! In: a model with effects (`simulation::flight_model`), runs as samples with their geometry. Out: free-run predictions
//! (`free_run`), and how much better one predicts than another (`gain`).
//! Assumed: body axes, SI; a run begins in its own trim; controls in straight lines between samples.
//! Refused: a run too short for its trim window, a control that the model answers to and the run lacks.

pub mod free_run;
pub mod gain;
