//! Files of the flight vocabulary: run files, model files, effect tables, the head of a log.
//!
//! In: text. Out: the types of [`flight`](crate::flight). Refused: what does not parse, with line and
//! column, and the nearest known key.

pub mod effect_file;
pub mod log_head;
pub mod model_file;
pub mod run_file;
pub mod time_stamp;
pub mod toml_reader;
