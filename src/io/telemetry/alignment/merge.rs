//! Rows of a second recording merged into those of a first, in order of time, on the first one's clock.
//!
//! Consumes rows of both ([`RowSource`]) and a [`ClockRelation`]; produces rows at the times of either, with empty cells where
//! the other was not sampled: the estimator takes channels at their own times, so nothing is interpolated. Rows of the two that
//! are no further apart than the tolerance, and nearest to each other, become one at the first one's time. A column that only the
//! second has is added at the end; of one that both have [`MergeRule`] says whose values count, by default the first one's alone:
//! one channel is one instrument.
//! Refused and counted ([`MergeTally`]), with the first place: rows without a finite time, and rows whose time does not grow
//! within their recording; put disordered recordings through [`super::reorder`] before.
//! Memory: two rows of each recording and the row that is handed on.

use super::clock_relation::ClockRelation;
use crate::flight::channel::Channel;
use crate::flight::file::run_file::{RecordingColumn, RecordingTarget};
use crate::flight::sample::Sample;
use crate::io::telemetry::record::{RecordingError, RecordingRow};

/// Whose values of a column that both recordings have count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MergeRule {
    /// Those of the first alone.
    #[default]
    First,
    /// Those of the second alone.
    Second,
    /// Both at their own times; in a common row that of the first.
    Both,
}

/// A recording that gives rows in order.
pub trait RowSource {
    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] of the recording.
    fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError>;
}

#[cfg(all(feature = "log", feature = "mavlink"))]
impl RowSource for super::aligned_recording::AlignedRecording {
    fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        super::aligned_recording::AlignedRecording::next_row(self)
    }
}

/// What came of the rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MergeTally {
    /// Rows taken of the first and of the second.
    pub taken: [u64; 2],
    /// Rows of each that have no finite time.
    pub no_time: [u64; 2],
    /// Rows of each whose time does not grow.
    pub not_growing: [u64; 2],
    /// The first row of each that was refused, by its number.
    pub first_refused: [Option<u64>; 2],
    /// Rows handed on.
    pub put: u64,
    /// Of these, rows that hold both.
    pub common: u64,
    /// Values that were left out by the rules.
    pub left_out: u64,
}

/// One recording on its way: its next row and the one after.
#[derive(Clone, Debug)]
struct Ahead {
    place: usize,
    head: Option<RecordingRow>,
    next: Option<RecordingRow>,
    last_s: f64,
}

/// The merge of two recordings.
#[derive(Clone, Debug)]
pub struct Merge {
    relation: ClockRelation,
    tolerance_s: f64,
    columns: Vec<RecordingColumn>,
    /// Known channels whose values of the first and of the second are left out.
    leave_known: [u32; 2],
    /// For each other column of the first and of the second: its place among those handed on.
    others: [Vec<Option<usize>>; 2],
    /// How many other columns are handed on.
    width: usize,
    ahead: [Ahead; 2],
    started: bool,
    row: RecordingRow,
    tally: MergeTally,
}

fn is_time(column: &RecordingColumn) -> bool {
    matches!(column.target, RecordingTarget::Time { .. })
}

fn is_same(one: &RecordingColumn, other: &RecordingColumn) -> bool {
    match (&one.target, &other.target) {
        (RecordingTarget::Known { channel, .. }, RecordingTarget::Known { channel: second, .. }) => channel == second,
        (RecordingTarget::Other, RecordingTarget::Other) => one.name == other.name && one.unit_text == other.unit_text,
        _ => false,
    }
}

impl Merge {
    /// Of recordings with these columns; `relation` leads from the second one's clock to the first one's. Rows within
    /// `tolerance_s` of each other become one.
    pub fn new(
        first: &[RecordingColumn],
        second: &[RecordingColumn],
        relation: ClockRelation,
        tolerance_s: f64,
        rule: impl Fn(&RecordingColumn) -> MergeRule,
    ) -> Self {
        let mut columns: Vec<RecordingColumn> = first.to_vec();
        columns.extend(second.iter().filter(|new| !is_time(new) && !first.iter().any(|old| is_same(old, new))).cloned());
        let kept: Vec<&RecordingColumn> = RecordingColumn::others(&columns).collect();
        let mut leave_known = [0; 2];
        let mut others = [Vec::new(), Vec::new()];
        for (place, (own, theirs)) in [(first, second), (second, first)].into_iter().enumerate() {
            for column in own.iter().filter(|column| !is_time(column)) {
                let shared = theirs.iter().any(|one| is_same(one, column));
                let left_out = shared && rule(column) == if place == 0 { MergeRule::Second } else { MergeRule::First };
                match &column.target {
                    RecordingTarget::Known { channel, .. } if left_out => leave_known[place] |= bit(*channel),
                    RecordingTarget::Other => {
                        let at = kept.iter().position(|one| is_same(one, column));
                        others[place].push(at.filter(|_| !left_out));
                    }
                    _ => {}
                }
            }
        }
        let width = kept.len();
        let row = RecordingRow { number: 0, sample: Sample::new(0.0), others: vec![None; width] };
        let ahead = [0, 1].map(|place| Ahead { place, head: None, next: None, last_s: f64::NEG_INFINITY });
        let tolerance_s = if tolerance_s >= 0.0 { tolerance_s } else { 0.0 };
        let tally = MergeTally::default();
        Merge { relation, tolerance_s, columns, leave_known, others, width, ahead, started: false, row, tally }
    }

    /// The columns of the rows that are handed on: those of the first in their order, then the new ones of the second.
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// What came of the rows so far.
    pub fn tally(&self) -> MergeTally {
        self.tally
    }

    /// The next row of both together, numbered from 1; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] of either recording.
    pub fn next_row(
        &mut self,
        first: &mut dyn RowSource,
        second: &mut dyn RowSource,
    ) -> Result<Option<&RecordingRow>, RecordingError> {
        if !self.started {
            self.started = true;
            for _ in 0..2 {
                self.advance(0, first)?;
                self.advance(1, second)?;
            }
        }
        let time_s = |row: &Option<RecordingRow>| row.as_ref().map(|row| row.sample.time_s);
        let [ours, theirs] = &self.ahead;
        let (take, at_s) = match (time_s(&ours.head), time_s(&theirs.head)) {
            (None, None) => return Ok(None),
            (Some(ours_s), None) => ([true, false], ours_s),
            (None, Some(theirs_s)) => ([false, true], theirs_s),
            (Some(ours_s), Some(theirs_s)) => {
                let apart_s = libm::fabs(ours_s - theirs_s);
                let nearer = |next: Option<f64>, to_s: f64| next.is_some_and(|next_s| libm::fabs(next_s - to_s) < apart_s);
                let alone =
                    apart_s > self.tolerance_s || nearer(time_s(&ours.next), theirs_s) || nearer(time_s(&theirs.next), ours_s);
                match (alone, ours_s <= theirs_s) {
                    (false, _) => ([true, true], ours_s),
                    (true, true) => ([true, false], ours_s),
                    (true, false) => ([false, true], theirs_s),
                }
            }
        };
        self.tally.put += 1;
        self.tally.common += u64::from(take == [true, true]);
        self.row.number = self.tally.put;
        self.row.sample = Sample::new(at_s);
        self.row.others.clear();
        self.row.others.resize(self.width, None);
        // The second before, so that the first's value stands where both have one.
        if take[1] {
            self.copy(1);
            self.advance(1, second)?;
        }
        if take[0] {
            self.copy(0);
            self.advance(0, first)?;
        }
        Ok(Some(&self.row))
    }

    /// Writes the head of that recording into the row.
    fn copy(&mut self, place: usize) {
        let (Some(ahead), Some(&leave), Some(others)) =
            (self.ahead.get(place), self.leave_known.get(place), self.others.get(place))
        else {
            return;
        };
        let Some(head) = &ahead.head else { return };
        for channel in Channel::ALL {
            let Some(value) = head.sample.get(channel) else { continue };
            let stays = leave & bit(channel) == 0;
            // What is left out, or the second's value that stands there already.
            self.tally.left_out += u64::from(!stays || self.row.sample.get(channel).is_some());
            if stays {
                self.row.sample.set(channel, value);
            }
        }
        for (value, at) in head.others.iter().zip(others) {
            let Some(value) = value else { continue };
            match at.and_then(|at| self.row.others.get_mut(at)) {
                Some(cell) => self.tally.left_out += u64::from(cell.replace(*value).is_some()),
                None => self.tally.left_out += 1,
            }
        }
    }

    /// Moves that recording on by one row, on the first one's clock.
    fn advance(&mut self, place: usize, source: &mut dyn RowSource) -> Result<(), RecordingError> {
        let Some(ahead) = self.ahead.get_mut(place) else { return Ok(()) };
        // The rows change places and keep their memory.
        std::mem::swap(&mut ahead.head, &mut ahead.next);
        let mut spare = ahead.next.take();
        while let Some(row) = source.next_row()? {
            self.tally.taken[ahead.place] += 1;
            let own_s = row.sample.time_s;
            let time_s = if ahead.place == 0 { own_s } else { self.relation.ours_s(own_s) };
            let refused = if !time_s.is_finite() {
                Some(&mut self.tally.no_time)
            } else if time_s <= ahead.last_s {
                Some(&mut self.tally.not_growing)
            } else {
                None
            };
            if let Some(count) = refused {
                count[ahead.place] += 1;
                self.tally.first_refused[ahead.place].get_or_insert(row.number);
                continue;
            }
            ahead.last_s = time_s;
            let next = match spare.take() {
                Some(mut kept) => {
                    kept.number = row.number;
                    kept.sample = row.sample;
                    kept.others.clone_from(&row.others);
                    kept
                }
                None => row.clone(),
            };
            ahead.next = Some(RecordingRow { sample: Sample { time_s, ..next.sample }, ..next });
            break;
        }
        Ok(())
    }
}

fn bit(channel: Channel) -> u32 {
    1 << channel.index()
}

#[cfg(test)]
#[path = "merge_tests.rs"]
mod tests;
