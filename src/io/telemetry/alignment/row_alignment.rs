//! Rows of one source put in order of time, each channel at its own time.
//!
//! Consumes rows with the stamps of one clock, in order of arrival; produces rows in order of time. A value of a channel is of
//! the time (stamp - latency of the channel): values within [`SAME_S`] of each other are one row, and a channel whose latency
//! is no whole number of intervals has rows of its own between the others, for nothing is interpolated. Columns that are no
//! channels have no latency. How they are ordered, and what is dropped and counted, is that of [`super::reorder`]; a row is one
//! witness of a jump of the clock, however many channels it has.
//! Delay: window and largest latency, and to the next row. Memory: taken at the start; [`CAPACITY`] samples wait at most.

use super::reorder::config::{RawStamp, ReorderConfig, ReorderSettingError, StampUnit};
use super::reorder::events::ReorderTally;
use super::reorder::{Reorder, TimedValue};
use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::file::run_file::ChannelLatencies;
use crate::flight::sample::Sample;
use crate::io::telemetry::alignment::dropout::Dropout;
use crate::io::telemetry::record::RecordingRow;

/// Values nearer to each other than this are one row, s.
pub const SAME_S: f64 = 1e-6;
/// Rows of a recording may come so much later than newer ones, s.
pub const WINDOW_S: f64 = 1.0;
/// Samples that wait at most: a second of 24 channels at 10 kHz.
pub const CAPACITY: usize = 1 << 18;

/// The stage.
#[derive(Clone, Debug)]
pub struct RowAlignment {
    reorder: Reorder,
    row: RowAssembly,
}

/// The row that is being put together.
#[derive(Clone, Debug)]
struct RowAssembly {
    row: RecordingRow,
    is_begun: bool,
}

impl RowAssembly {
    fn take(&mut self, value: TimedValue, each: &mut impl FnMut(&RecordingRow)) {
        let is_there = |row: &RecordingRow| match Channel::ALL.get(value.channel) {
            Some(channel) => row.sample.get(*channel).is_some(),
            None => row.others.get(value.channel - CHANNELS).is_some_and(Option::is_some),
        };
        if self.is_begun && (value.time_s - self.row.sample.time_s > SAME_S || is_there(&self.row)) {
            self.end(each);
        }
        if !self.is_begun {
            self.is_begun = true;
            self.row.sample = Sample::new(value.time_s);
            self.row.others.fill(None);
        }
        match Channel::ALL.get(value.channel) {
            Some(channel) => self.row.sample.set(*channel, value.value),
            None => {
                if let Some(cell) = self.row.others.get_mut(value.channel - CHANNELS) {
                    *cell = Some(value.value);
                }
            }
        }
    }

    fn end(&mut self, each: &mut impl FnMut(&RecordingRow)) {
        if std::mem::take(&mut self.is_begun) {
            each(&self.row);
        }
    }
}

impl RowAlignment {
    /// Of rows with so many columns besides the channels, in any order within `window_s`.
    ///
    /// # Errors
    /// [`ReorderSettingError`] where the window is no length of time.
    pub fn new(latencies: &ChannelLatencies, others: usize, window_s: f64) -> Result<Self, ReorderSettingError> {
        let settings = ReorderConfig::new(CHANNELS + others, StampUnit::Seconds);
        let of_channels = Channel::ALL.iter().map(|channel| latencies.of(*channel));
        let reorder = Reorder::new(&ReorderConfig {
            window_s,
            back_s: settings.back_s.max(window_s),
            latencies_s: of_channels.chain(std::iter::repeat_n(0.0, others)).collect(),
            capacity: CAPACITY,
            ..settings
        })?;
        let row = RecordingRow { number: 0, sample: Sample::new(0.0), others: vec![None; others] };
        Ok(RowAlignment { reorder, row: RowAssembly { row, is_begun: false } })
    }

    /// Takes a row; `each` gets those that are due, numbered as the newest row that was taken.
    pub fn push(&mut self, number: u64, sample: &Sample, others: &[Option<f64>], each: &mut impl FnMut(&RecordingRow)) {
        let RowAlignment { reorder, row } = self;
        row.row.number = number;
        let channels = Channel::ALL.iter().filter_map(|channel| Some((channel.index(), sample.get(*channel)?)));
        let others = (CHANNELS..).zip(others).filter_map(|(place, value)| Some((place, (*value)?)));
        reorder.push_group(RawStamp::Seconds(sample.time_s), channels.chain(others), &mut |value| row.take(value, each));
        // What comes later is of no earlier time.
        if row.row.sample.time_s + SAME_S < reorder.released_s() {
            row.end(each);
        }
    }

    /// No more will come: what waits is handed on.
    pub fn finish(&mut self, each: &mut impl FnMut(&RecordingRow)) {
        let RowAlignment { reorder, row } = self;
        reorder.finish(&mut |value| row.take(value, each));
        row.end(each);
    }

    /// How far the axis is ahead of the clock, s: 0 until the clock has gone back.
    pub fn shift_s(&self) -> f64 {
        self.reorder.shift_s()
    }

    /// Counters, of samples of single channels.
    pub fn tally(&self) -> ReorderTally {
        self.reorder.tally()
    }

    /// The table of dropouts, complete after [`RowAlignment::finish`]; channels by [`Channel::index`], then the other columns.
    pub fn dropouts(&self) -> &[Dropout] {
        self.reorder.dropouts()
    }
}

impl ReorderTally {
    /// What was dropped because of its time, a phrase each.
    pub fn losses(&self) -> Vec<String> {
        self.phrases(&[
            (self.late, "came too late for their place in time"),
            (self.contradicting, "have the time of another one of their channel, with another value"),
            (self.strays, "have a time that contradicts those around them"),
            (self.no_time, "have no time"),
        ])
    }

    /// What was put right, and what else is worth knowing of the times, a phrase each.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.phrases(&[
            (self.reordered, "were put in order"),
            (self.repeated, "came twice"),
            (self.early, "were handed on before their time, for want of room"),
        ]);
        let counted = [
            (self.jumps_back, "the clock goes back"),
            (self.jumps_forward, "the clock goes forward, or is silent,"),
            (self.wraps, "the clock's counter begins again"),
        ];
        notes.extend(counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| match count {
            1 => format!("{what} once"),
            count => format!("{what} {count} times"),
        }));
        notes
    }

    fn phrases(&self, counted: &[(u64, &str)]) -> Vec<String> {
        let some = counted.iter().filter(|(count, _)| *count > 0);
        some.map(|(count, what)| format!("{count} of {} samples {what}", self.taken)).collect()
    }
}

#[cfg(test)]
#[path = "row_alignment_tests.rs"]
mod tests;
