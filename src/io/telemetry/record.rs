//! The published vocabulary of recordings: a row, what was skipped and why, why a recording cannot be read.

use crate::flight::file::run_file::RunFileError;
use crate::flight::sample::Sample;
use std::path::PathBuf;

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum RecordingError {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}:{place}", path.display())]
    Place { path: PathBuf, place: RunFileError },
    #[error("{}: {what}", path.display())]
    Whole { path: PathBuf, what: String },
}

/// One row: what was measured at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingRow {
    /// Line of a text, number of the message in a log; from 1.
    pub number: u64,
    /// Time and known channels, SI.
    pub sample: Sample,
    /// The other columns in their order, as they came; `None` where not sampled.
    pub others: Vec<Option<f64>>,
}

/// Why a row was skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkipReason {
    /// More or fewer cells than the header has.
    CellCount,
    /// A cell that is no number.
    NotANumber,
    /// No time.
    NoTime,
    /// A damaged or cut record of a log.
    Damaged,
}

impl SkipReason {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            SkipReason::CellCount => "wrong number of cells",
            SkipReason::NotANumber => "a cell that is no number",
            SkipReason::NoTime => "no time",
            SkipReason::Damaged => "damaged or cut short",
        }
    }
}

/// The rows skipped for one reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkippedRows {
    /// Why.
    pub reason: SkipReason,
    /// How many.
    pub rows: u64,
    /// The first one: line of a text, number of the message in a log.
    pub first: u64,
    /// What was expected and found at the first one.
    pub example: String,
}

/// Every row that was skipped, by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SkippedByReason {
    reasons: Vec<SkippedRows>,
}

impl SkippedByReason {
    /// Counts one row; `example` is asked for the first of its reason only.
    pub fn count(&mut self, reason: SkipReason, number: u64, example: impl FnOnce() -> String) {
        match self.reasons.iter_mut().find(|skipped| skipped.reason == reason) {
            Some(skipped) => skipped.rows += 1,
            None => self.reasons.push(SkippedRows { reason, rows: 1, first: number, example: example() }),
        }
    }

    /// Adds those of one of several files.
    pub fn join(&mut self, other: &SkippedByReason, file: &str) {
        for rows in &other.reasons {
            match self.reasons.iter_mut().find(|own| own.reason == rows.reason) {
                Some(own) => own.rows += rows.rows,
                None => self.reasons.push(SkippedRows { example: format!("{} (of {file})", rows.example), ..rows.clone() }),
            }
        }
    }

    /// The reasons in the order of their first row.
    pub fn reasons(&self) -> &[SkippedRows] {
        &self.reasons
    }

    /// How many rows in all.
    pub fn rows(&self) -> u64 {
        self.reasons.iter().map(|skipped| skipped.rows).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skipped_rows_are_counted_by_reason_with_the_first_of_each() {
        let mut skipped = SkippedByReason::default();
        skipped.count(SkipReason::NoTime, 7, || "first".into());
        skipped.count(SkipReason::CellCount, 8, || "cells".into());
        skipped.count(SkipReason::NoTime, 9, || "second".into());
        assert_eq!(skipped.rows(), 3);
        let no_time = SkippedRows { reason: SkipReason::NoTime, rows: 2, first: 7, example: "first".into() };
        assert_eq!(skipped.reasons().first(), Some(&no_time));
    }
}
