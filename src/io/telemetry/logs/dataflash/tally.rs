//! What a dataflash reader found: counts, the damage, and the definitions that are wrong.
//!
//! Complaints about definitions are kept up to [`COMPLAINTS_MAX`]; beyond that they are counted only.

use super::error::DataflashError;

/// Complaints that are kept.
pub const COMPLAINTS_MAX: usize = 64;

/// The message that the end of the log cuts short.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataflashTruncation {
    /// Where it began, bytes from the start.
    pub at: u64,
    /// Its type, if that is still there.
    pub kind: Option<u8>,
    /// Its name, if its type is known.
    pub name: String,
    /// Bytes that are there.
    pub found: usize,
    /// Bytes that it has by its definition; 0 where its type is not known.
    pub expected: usize,
}

/// What was found so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DataflashTally {
    /// Whole messages, definitions among them.
    pub messages: u64,
    /// Whole messages of a type whose definition contradicts itself: skipped.
    pub unreadable: u64,
    /// Messages in step that no header follows: not handed on, their bytes are searched.
    pub doubtful: u64,
    /// Headers in step whose type no FMT had defined.
    pub unknown_types: u64,
    /// Bytes that belong to no message.
    pub garbage_bytes: u64,
    /// How often the step was lost and found again.
    pub resynchronised: u64,
    /// Where the first damage began, bytes from the start.
    pub first_damage_at: Option<u64>,
    /// Definitions that repeat one that was there.
    pub repeated_formats: u64,
    /// Definitions that change one that was there.
    pub redefinitions: u64,
    /// Messages earlier than the one of the same type, and instrument, before.
    pub backward: u64,
    /// The message that the end cut short.
    pub truncated: Option<DataflashTruncation>,
    /// What is wrong with definitions, in order; the first [`COMPLAINTS_MAX`].
    pub complaints: Vec<DataflashError>,
    /// How many complaints there were.
    pub complaints_total: u64,
}

impl DataflashTally {
    /// Adds a complaint.
    pub(super) fn complain(&mut self, error: DataflashError) {
        self.complaints_total += 1;
        if self.complaints.len() < COMPLAINTS_MAX {
            self.complaints.push(error);
        }
    }
}
