//! Errors of the bus, each with one sentence for people.

use std::path::PathBuf;

/// Why the bus cannot be used.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum BusError {
    #[error("{}: {what}", path.display())]
    Root { path: PathBuf, what: String },
    #[error("{}: {what}", path.display())]
    Busy { path: PathBuf, what: String },
    #[error("{}: {holder} has the role `{role}` already: expected one of each, stop it or take another --root", path.display())]
    RoleTaken { path: PathBuf, role: &'static str, holder: String },
    #[error(
        "{}: service {service}: expected the schema {expected}, found another: programs of two versions share this root; \
         stop them all or take another --root",
        path.display()
    )]
    Schema { path: PathBuf, service: &'static str, expected: &'static str },
    #[error("{}: {doing}: {what}", path.display())]
    Middleware { path: PathBuf, doing: String, what: String },
    #[error("{schema}: {field}: expected {expected}, found {found}")]
    Payload { schema: &'static str, field: &'static str, expected: &'static str, found: u64 },
}
