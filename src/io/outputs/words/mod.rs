//! Words for people, made from data: one sentence for each event, status, reason and cause.

pub mod cause_sentence;
pub mod control_scale;
pub(crate) mod estimation_sentence;
pub mod event_text;
pub mod finding_text;
pub mod instrument_words;
pub mod manoeuvre_sentences;
pub mod noise_text;
pub mod output_error_text;
pub mod printable;
pub mod set_aside;
pub mod stability_text;
pub mod status_text;
pub mod trim_difference;
