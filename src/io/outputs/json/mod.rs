//! Records as JSON.

pub mod derivatives_json;
pub mod document_schema;
pub mod effect_json;
pub(crate) mod finding_json;
pub mod json_schema;
pub mod manoeuvre_json;
pub(crate) mod message_json;
pub(crate) mod modes_json;
pub(crate) mod output_error_json;
