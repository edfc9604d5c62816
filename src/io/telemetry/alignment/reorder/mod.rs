//! Samples as they arrive, on one axis of time that never goes back, sorted within a bounded delay.
//!
//! Consumes samples, one by one or in groups of one stamp, with the stamps of one clock (seconds, or a counter of few bits), in
//! order of arrival; produces samples in
//! order of time, [`TimelineEvent`]s, a table of dropouts ([`super::dropout`]) and counters of both. Nothing is repaired in
//! silence: what is not handed on, or is not where its stamp says, has an event with its place in time.
//! - Stamps become one axis by `segment`: wraps are counted on, a clock that goes back begins a new segment.
//! - The channel's latency is subtracted. A sample is handed on once the newest stamp is [`ReorderConfig::window_s`] and the
//!   largest latency after it; one that arrives later than that is dropped, as [`TimelineEventKind::Late`].
//! - Of several samples of a channel with one time the first is kept; the others are [`TimelineEventKind::Repeated`] (same
//!   value) or [`TimelineEventKind::Contradicting`].
//!
//! Delay: at most the window and the largest latency of time on the clock. Memory: [`ReorderConfig::capacity`] samples, tables of
//! [`ReorderConfig::rows_max`] rows (more are counted only), all taken at the start. Where the window holds more samples than
//! that, the oldest goes early, as an event. A step back shorter than [`ReorderConfig::back_s`] cannot be told from late samples,
//! and one forward not from a silence: it is kept as the clock says, and counted.

pub mod config;
pub mod events;
mod segment;

use super::dropout::{Dropout, IntervalMonitor};
use config::{RawStamp, ReorderConfig, ReorderSettingError};
use events::{ReorderTally, TimelineEvent, TimelineEventKind, TimelineTables};
use segment::{AxisPlacement, CONFIRMED, DoubtfulGroups, SegmentedAxis};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A sample on the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedValue {
    /// Time on the axis, latency subtracted, s.
    pub time_s: f64,
    /// Which channel.
    pub channel: usize,
    /// Its value.
    pub value: f64,
    /// How often the clock had gone back before.
    pub segment: u32,
}

/// What waits, the earliest first; of one time in order of arrival.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    number: u64,
    sample: TimedValue,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.sample.time_s.total_cmp(&other.sample.time_s).then(self.number.cmp(&other.number))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

/// One channel's past.
#[derive(Clone, Debug)]
struct ChannelPast {
    latency_s: f64,
    newest_s: f64,
    /// The last that was handed on.
    last: Option<TimedValue>,
    monitor: IntervalMonitor,
}

/// The stage.
#[derive(Clone, Debug)]
pub struct Reorder {
    axis: SegmentedAxis,
    channels: Vec<ChannelPast>,
    waiting: BinaryHeap<Reverse<Waiting>>,
    capacity: usize,
    /// Window and largest latency, s.
    delay_s: f64,
    /// Nothing before is handed on any more, s.
    released_s: f64,
    segment: u32,
    /// Groups that came.
    groups: u64,
    /// Samples of groups whose stamps are in doubt: group, channel, value.
    in_doubt: Vec<(u64, usize, f64)>,
    tables: TimelineTables,
}

impl Reorder {
    /// With these settings; all memory is taken here.
    ///
    /// # Errors
    /// [`ReorderSettingError`] with the setting that cannot be.
    pub fn new(config: &ReorderConfig) -> Result<Self, ReorderSettingError> {
        config.check()?;
        let past = |(channel, &latency_s): (usize, &f64)| ChannelPast {
            latency_s,
            newest_s: f64::NEG_INFINITY,
            last: None,
            monitor: IntervalMonitor::new(channel),
        };
        let (most_s, least_s) = config.latency_range_s();
        // The first samples of a segment stand behind the last of the one before, whatever their latencies.
        let between_s = config.between_s + most_s - least_s;
        Ok(Reorder {
            axis: SegmentedAxis::new(config.unit, config.forward_s, config.back_s, between_s),
            channels: config.latencies_s.iter().enumerate().map(past).collect(),
            waiting: BinaryHeap::with_capacity(config.capacity),
            capacity: config.capacity,
            delay_s: config.window_s + most_s,
            released_s: f64::NEG_INFINITY,
            segment: 0,
            groups: 0,
            in_doubt: Vec::with_capacity(CONFIRMED * config.latencies_s.len().max(1)),
            tables: TimelineTables::new(config.rows_max),
        })
    }

    /// Takes a sample; `put` gets what is due.
    pub fn push(&mut self, channel: usize, stamp: RawStamp, value: f64, put: &mut impl FnMut(TimedValue)) {
        self.push_group(stamp, std::iter::once((channel, value)), put);
    }

    /// Takes samples of one stamp, of each channel at most one: together they are one witness of a jump of the clock.
    pub fn push_group(
        &mut self,
        stamp: RawStamp,
        samples: impl Iterator<Item = (usize, f64)> + Clone,
        put: &mut impl FnMut(TimedValue),
    ) {
        self.groups += 1;
        let stamp_s = self.axis.unwrapped_s(stamp);
        let (mut first, channels) = (None, self.channels.len());
        for (channel, _) in samples.clone() {
            self.tables.tally.taken += 1;
            if stamp_s.is_none() || channel >= channels {
                let at_s = self.axis.newest_s().unwrap_or(0.0);
                self.tables.event(at_s, channel, TimelineEventKind::NoTime);
            } else {
                first.get_or_insert(channel);
            }
        }
        let (Some(clock_s), Some(first)) = (stamp_s, first) else { return };
        let samples = samples.filter(|(channel, _)| *channel < channels);
        match self.axis.place(clock_s, self.groups) {
            AxisPlacement::At { strays, wrapped } => {
                let at_s = self.axis.on_axis_s(clock_s);
                self.strays(&strays, clock_s);
                if wrapped {
                    self.tables.event(at_s, first, TimelineEventKind::Wrap);
                }
                for (channel, value) in samples {
                    self.place(channel, at_s, value, put);
                }
            }
            AxisPlacement::InDoubt { strays } => {
                self.strays(&strays, self.axis.newest_clock_s().unwrap_or(0.0));
                self.hold_in_doubt(samples);
            }
            AxisPlacement::Jumped { confirmed, by_s, from_axis_s, wrapped } => {
                self.hold_in_doubt(samples);
                let begins_s = confirmed.iter().map(|one| one.clock_s).fold(f64::INFINITY, f64::min);
                let at_s = self.axis.on_axis_s(begins_s);
                if by_s < 0.0 {
                    // Nothing of the segment before can come any more.
                    self.release(f64::INFINITY, put);
                    self.released_s = self.released_s.max(from_axis_s);
                    self.segment = self.segment.saturating_add(1);
                    let tables = &mut self.tables;
                    for past in &mut self.channels {
                        past.monitor.restart(&mut |finding| tables.interval(finding));
                        past.newest_s = f64::NEG_INFINITY;
                    }
                    tables.event(at_s, first, TimelineEventKind::JumpBack(-by_s));
                } else {
                    self.tables.event(at_s, first, TimelineEventKind::JumpForward(by_s));
                }
                if wrapped {
                    self.tables.event(at_s, first, TimelineEventKind::Wrap);
                }
                for one in confirmed.iter() {
                    let at_s = self.axis.on_axis_s(one.clock_s);
                    for place in 0..self.in_doubt.len() {
                        if let Some(&(_, channel, value)) = self.in_doubt.get(place).filter(|(group, ..)| *group == one.group) {
                            self.place(channel, at_s, value, put);
                        }
                    }
                }
                self.in_doubt.clear();
            }
        }
        if let Some(newest_s) = self.axis.newest_s() {
            self.release(newest_s - self.delay_s, put);
        }
    }

    /// No more will come: what waits is handed on, what was in doubt is not.
    pub fn finish(&mut self, put: &mut impl FnMut(TimedValue)) {
        let strays = self.axis.finish();
        self.strays(&strays, self.axis.newest_clock_s().unwrap_or(0.0));
        self.release(f64::INFINITY, put);
        let tables = &mut self.tables;
        for past in &mut self.channels {
            past.monitor.finish(&mut |finding| tables.interval(finding));
        }
    }

    /// What happened, in the order in which it was found.
    pub fn events(&self) -> &[TimelineEvent] {
        &self.tables.events
    }

    /// The table of dropouts, of each channel in order of time; complete after [`Reorder::finish`].
    pub fn dropouts(&self) -> &[Dropout] {
        &self.tables.dropouts
    }

    /// Counters.
    pub fn tally(&self) -> ReorderTally {
        self.tables.tally
    }

    /// Nothing before this time on the axis is handed on any more, s.
    pub fn released_s(&self) -> f64 {
        self.released_s
    }

    /// How far the axis is ahead of the clock, s.
    pub fn shift_s(&self) -> f64 {
        self.axis.on_axis_s(0.0)
    }

    /// The rate of a channel now, Hz; `None` until it is known.
    pub fn rate_hz(&self, channel: usize) -> Option<f64> {
        self.channels.get(channel)?.monitor.rate_hz()
    }

    fn place(&mut self, channel: usize, axis_s: f64, value: f64, put: &mut impl FnMut(TimedValue)) {
        let Some(past) = self.channels.get_mut(channel) else { return };
        let sample = TimedValue { time_s: axis_s - past.latency_s, channel, value, segment: self.segment };
        if sample.time_s < self.released_s {
            let kind = match past.last {
                Some(last) if last.time_s.total_cmp(&sample.time_s).is_eq() => same_time(&last, &sample),
                _ => TimelineEventKind::Late(self.released_s - sample.time_s),
            };
            self.tables.event(sample.time_s, channel, kind);
        } else {
            self.tables.tally.reordered += u64::from(sample.time_s < past.newest_s);
            past.newest_s = past.newest_s.max(sample.time_s);
            if self.waiting.len() >= self.capacity
                && let Some(Reverse(Waiting { sample: earliest, .. })) = self.waiting.peek().copied()
                && earliest.time_s <= sample.time_s
            {
                self.tables.event(earliest.time_s, earliest.channel, TimelineEventKind::Early);
                self.release_next(put);
            }
            if self.waiting.len() < self.capacity {
                self.waiting.push(Reverse(Waiting { number: self.tables.tally.taken, sample }));
            } else {
                // It is the earliest itself.
                self.tables.event(sample.time_s, channel, TimelineEventKind::Early);
                self.hand_on(sample, put);
            }
        }
    }

    /// Keeps the samples of the group that came last until its stamp is confirmed or not.
    fn hold_in_doubt(&mut self, samples: impl Iterator<Item = (usize, f64)>) {
        for (channel, value) in samples {
            if self.in_doubt.len() < self.in_doubt.capacity() {
                self.in_doubt.push((self.groups, channel, value));
            }
        }
    }

    /// Groups whose stamps nothing has confirmed, beside a time of the clock that is right.
    fn strays(&mut self, strays: &DoubtfulGroups, right_s: f64) {
        let at_s = self.axis.on_axis_s(right_s);
        for stray in strays.iter() {
            let kind = TimelineEventKind::Stray(stray.clock_s - right_s);
            for (_, channel, _) in self.in_doubt.iter().filter(|(group, ..)| *group == stray.group) {
                self.tables.event(at_s, *channel, kind);
            }
            self.in_doubt.retain(|(group, ..)| *group != stray.group);
        }
    }

    /// Hands on all before that time.
    fn release(&mut self, before_s: f64, put: &mut impl FnMut(TimedValue)) {
        while self.waiting.peek().is_some_and(|Reverse(next)| next.sample.time_s < before_s) {
            self.release_next(put);
        }
        if before_s.is_finite() {
            self.released_s = self.released_s.max(before_s);
        }
    }

    fn release_next(&mut self, put: &mut impl FnMut(TimedValue)) {
        if let Some(Reverse(next)) = self.waiting.pop() {
            self.hand_on(next.sample, put);
        }
    }

    fn hand_on(&mut self, sample: TimedValue, put: &mut impl FnMut(TimedValue)) {
        self.released_s = self.released_s.max(sample.time_s);
        let Some(past) = self.channels.get_mut(sample.channel) else { return };
        if let Some(last) = past.last.filter(|last| last.time_s.total_cmp(&sample.time_s).is_eq()) {
            self.tables.event(sample.time_s, sample.channel, same_time(&last, &sample));
            return;
        }
        past.last = Some(sample);
        let tables = &mut self.tables;
        past.monitor.take(sample.time_s, &mut |finding| tables.interval(finding));
        tables.tally.put += 1;
        put(sample);
    }
}

/// Of two samples of a channel with one time.
fn same_time(first: &TimedValue, second: &TimedValue) -> TimelineEventKind {
    if first.value.total_cmp(&second.value).is_eq() { TimelineEventKind::Repeated } else { TimelineEventKind::Contradicting }
}

#[cfg(test)]
#[path = "reorder_tests.rs"]
mod tests;
