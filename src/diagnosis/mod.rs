//! What a model gets wrong, and why: the cause named, the model extended, the gain measured on runs that it did not see.
//!
//! `record` and `driven` say what was flown, `aircraft` what the model makes of it, `filter` compares the two along a run;
//! `problem` joins several runs, `library` holds the hypotheses.

pub mod aircraft;
mod blade_passing;
pub mod column;
pub mod driven;
pub mod filter;
pub mod library;
pub mod problem;
pub mod record;
pub mod screen;
pub mod search;
