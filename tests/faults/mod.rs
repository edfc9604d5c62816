//! The fault matrix: broken inputs give a clear end, never a panic and never a guess.

mod convert;
mod design;
mod examples;
mod flight_condition;
mod hostile_names;
mod inspect;
mod instrument_files;
mod level1_files;
mod mavlink;
mod model_files;
mod multirate;
mod raw_numbers;
mod replay;
mod run_files;
mod silence;
mod standing_files;
mod stopped_analyses;
