//! What can go wrong between processes, as one sentence each.

use std::path::PathBuf;

/// Why the bus cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The root directory cannot be made or used.
    #[error("{}: {what}", path.display())]
    Root {
        /// Which.
        path: PathBuf,
        /// What was expected and what was found.
        what: String,
    },
    /// Another process stands in the way for now.
    #[error("{}: {what}", path.display())]
    Busy {
        /// The root.
        path: PathBuf,
        /// Who, and of what.
        what: String,
    },
    /// Another process has that role already.
    #[error("{}: {holder} has the role `{role}` already: expected one of each, stop it or take another --root", path.display())]
    RoleTaken {
        /// The root.
        path: PathBuf,
        /// `telemetry`, `estimator` or `supervisor`.
        role: &'static str,
        /// `process 4711`.
        holder: String,
    },
    /// A service of that name has another schema.
    #[error(
        "{}: service {service}: expected the schema {expected}, found another: programs of two versions share this root; \
         stop them all or take another --root",
        path.display()
    )]
    Schema {
        /// The root.
        path: PathBuf,
        /// The service.
        service: &'static str,
        /// Its schema here.
        expected: &'static str,
    },
    /// The middleware refused.
    #[error("{}: {doing}: {what}", path.display())]
    Middleware {
        /// The root.
        path: PathBuf,
        /// What was being done.
        doing: String,
        /// What it said.
        what: String,
    },
    /// A payload holds what no version of this program writes.
    #[error("{schema}: {field}: expected {expected}, found {found}")]
    Payload {
        /// The schema.
        schema: &'static str,
        /// The field.
        field: &'static str,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: u64,
    },
}
