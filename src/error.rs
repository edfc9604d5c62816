//! How a command fails: one line for a person, one exit status for a program.

use super::io::outputs::words::printable::printable;
use std::path::Path;

/// A command's failure. The line says which file, line and column, what was expected and what was found.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum Failure {
    #[error("{0}")]
    Input(String),
    #[error("{0}")]
    Running(String),
    /// The call was right, and the data give no answer.
    #[error("{0}")]
    NoAnswer(String),
}

impl Failure {
    /// The exit status of the process.
    pub fn exit_status(&self) -> u8 {
        match self {
            Failure::Input(_) => 2,
            Failure::Running(_) => 1,
            Failure::NoAnswer(_) => Outcome::NotGood.exit_status(),
        }
    }

    /// A wrong place in an input file.
    pub fn at(file: &Path, line: usize, column: usize, what: impl std::fmt::Display) -> Self {
        Failure::Input(format!("{}:{line}:{column}: {what}", shown(file)))
    }

    /// A wrong input file as a whole.
    pub fn file(file: &Path, what: impl std::fmt::Display) -> Self {
        Failure::Input(format!("{}: {what}", shown(file)))
    }

    /// Reading or writing failed.
    pub fn io(file: &Path, error: &std::io::Error) -> Self {
        Failure::Running(format!("{}: {error}", shown(file)))
    }
}

/// The name in one line, whatever is in it.
fn shown(file: &Path) -> String {
    printable(&file.display().to_string()).into_owned()
}

/// How a command ended that did its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done (exit status 0).
    Done,
    /// Done, with data lost or skipped, and it was said how much (exit status 3).
    DataLost,
    /// Done, and the answer is "not good" (exit status 4).
    NotGood,
}

impl Outcome {
    /// The exit status of the process.
    pub fn exit_status(self) -> u8 {
        match self {
            Outcome::Done => 0,
            Outcome::DataLost => 3,
            Outcome::NotGood => 4,
        }
    }
}

impl From<super::io::telemetry::record::RecordingError> for Failure {
    fn from(error: super::io::telemetry::record::RecordingError) -> Self {
        use super::io::telemetry::record::RecordingError;
        match error {
            RecordingError::Io { path, source } => Failure::io(&path, &source),
            wrong @ (RecordingError::Place { .. } | RecordingError::Whole { .. }) => Failure::Input(wrong.to_string()),
        }
    }
}

impl From<super::io::bus::error::BusError> for Failure {
    fn from(error: super::io::bus::error::BusError) -> Self {
        use super::io::bus::error::BusError;
        match error {
            BusError::Root { .. } | BusError::RoleTaken { .. } | BusError::Schema { .. } => Failure::Input(error.to_string()),
            BusError::Busy { .. } | BusError::Middleware { .. } | BusError::Payload { .. } => Failure::Running(error.to_string()),
        }
    }
}
