//! What a ULog reader found: counts by kind, dropouts, damage, and the definitions that are wrong.
//!
//! Complaints about definitions are kept up to [`COMPLAINTS_MAX`]; beyond that they are counted only.

use super::error::UlogError;

/// Complaints that are kept.
pub const COMPLAINTS_MAX: usize = 64;

/// The message that the end of the log cuts short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UlogTruncation {
    /// Where it began, bytes from the start.
    pub at: u64,
    /// Its kind, if that is still there.
    pub kind: Option<u8>,
    /// Bytes that are there.
    pub found: usize,
    /// Bytes that it has by its header; 0 where that is cut too.
    pub expected: usize,
}

/// What was found so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UlogTally {
    /// Whole messages by their kind (`D`, `F`, ...), in the order of the alphabet; refused ones among them.
    pub kinds: [u64; 26],
    /// Messages of kinds that are not known: skipped.
    pub unknown_kinds: u64,
    /// Lost by the logger: how often it says so.
    pub dropouts: u64,
    /// Lost by the logger, ms in all.
    pub dropout_ms: u64,
    /// Flags that do not stand behind the header, where alone they count.
    pub misplaced_flags: u64,
    /// Data of ids that nothing is subscribed to: skipped.
    pub unsubscribed: u64,
    /// Messages whose size contradicts their kind or format: skipped.
    pub wrong_size: u64,
    /// Other messages that contradict what they should contain: skipped.
    pub refused: u64,
    /// Messages in step that nothing plausible follows: not handed on, their bytes are searched.
    pub doubtful: u64,
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
    /// Data earlier than the one of the same subscription before.
    pub backward: u64,
    /// Sections of appended data that were reached.
    pub appended_sections: u64,
    /// Messages that the start of appended data cuts short.
    pub cut_at_section: u64,
    /// The message that the end cut short.
    pub truncated: Option<UlogTruncation>,
    /// What is wrong with definitions, in order; the first [`COMPLAINTS_MAX`].
    pub complaints: Vec<UlogError>,
    /// How many complaints there were.
    pub complaints_total: u64,
}

impl UlogTally {
    /// Whole messages of a kind.
    pub fn of(&self, kind: u8) -> u64 {
        kind.checked_sub(b'A').and_then(|place| self.kinds.get(usize::from(place))).copied().unwrap_or_default()
    }

    /// Whole messages of known kinds.
    pub fn messages(&self) -> u64 {
        self.kinds.iter().sum()
    }

    pub(super) fn count(&mut self, kind: u8) {
        if let Some(count) = kind.checked_sub(b'A').and_then(|place| self.kinds.get_mut(usize::from(place))) {
            *count += 1;
        }
    }

    pub(super) fn complain(&mut self, error: UlogError) {
        self.complaints_total += 1;
        if self.complaints.len() < COMPLAINTS_MAX {
            self.complaints.push(error);
        }
    }
}
