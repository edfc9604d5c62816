//! Which messages may give a channel now, and whether their time fits their stream.
//!
//! Consumes the values of a message with its time; hands on rows whose time grows within each stream. A step back, or of more
//! than [`GAP_US`] forward, is believed once the next message of the stream follows it; until then its rows wait. A step that
//! the next message contradicts is refused. After a step back that was believed, rows carry one restart more.
//! Memory: at most [`STREAMS_MAX`] streams, and the rows of one message for each.

use super::{LogChannel, LogMappingTally, LogRow, LogSource};

/// A message that stands further down takes over after so long a silence, us.
pub const SILENCE_US: u64 = 2_000_000;
/// A longer step forward needs confirmation, us.
pub const GAP_US: u64 = 10_000_000;
/// Streams that are kept at most.
pub const STREAMS_MAX: usize = 256;

/// Channels that one message gives together, of which only one message is used at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LogGroup {
    Force,
    Rates,
    Attitude,
    Airspeed,
    Flow,
    Altitude,
    Rotor,
    Wind,
    Position,
    IndicatedAirspeed,
    BarometricHeight,
    Density,
    Outputs,
    SecondOutputs,
    Motors,
    Servos,
    Controls,
    Demands,
}

const GROUPS: usize = LogGroup::Demands as usize + 1;

/// A message as a giver of a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogOffer {
    pub(super) source: &'static LogSource,
    pub(super) group: LogGroup,
    /// Its place of preference among those that give the group.
    pub(super) rank: usize,
    pub(super) instance: u8,
}

#[derive(Debug)]
struct Stream {
    source: &'static LogSource,
    instance: u8,
    last_us: Option<u64>,
    restart: u32,
    /// Rows that wait for confirmation; none where empty.
    held: Vec<LogRow>,
}

/// The choice of messages, and the clocks of streams.
#[derive(Debug, Default)]
pub(super) struct RowGate {
    giving: [Option<(usize, u64)>; GROUPS],
    streams: Vec<Stream>,
    pub(super) tally: LogMappingTally,
}

impl RowGate {
    /// Whether that offer may give its group at that time.
    fn prefers(&self, offer: LogOffer, time_us: u64) -> bool {
        let giving = self.giving.get(offer.group as usize).copied().flatten();
        giving.is_none_or(|(before, last_us)| offer.rank <= before || time_us.abs_diff(last_us) > SILENCE_US)
    }

    /// Takes in the values of a message.
    pub(super) fn offer(
        &mut self,
        offer: LogOffer,
        time_us: Option<u64>,
        values: &[(LogChannel, f64)],
        put: &mut impl FnMut(LogRow),
    ) {
        let finite = values.iter().filter(|(_, value)| value.is_finite());
        self.tally.not_a_number += (values.len() - finite.clone().count()) as u64;
        if finite.clone().next().is_none() {
            return;
        }
        let Some(time_us) = time_us else {
            self.tally.no_time += 1;
            return;
        };
        if !self.prefers(offer, time_us) {
            self.tally.not_preferred += 1;
            return;
        }
        let LogOffer { source, instance, .. } = offer;
        let same = |stream: &Stream| std::ptr::eq(stream.source, source) && stream.instance == instance;
        let place = match self.streams.iter().position(same) {
            Some(place) => place,
            None if self.streams.len() < STREAMS_MAX => {
                self.streams.push(Stream { source, instance, last_us: None, restart: 0, held: Vec::new() });
                self.streams.len() - 1
            }
            None => {
                self.tally.streams_exceeded += 1;
                return;
            }
        };
        let Some(stream) = self.streams.get_mut(place) else { return };
        let row = |restart| {
            finite.clone().map(move |(channel, value)| LogRow {
                time_us,
                restart,
                channel: *channel,
                value: *value,
                source,
                instance,
            })
        };
        if let Some(held_us) = stream.held.first().map(|row| row.time_us) {
            let back_from = stream.last_us.filter(|last_us| held_us < *last_us);
            let near = time_us >= held_us && time_us - held_us <= GAP_US;
            // After a single step back the old times go on.
            if near && back_from.is_none_or(|last_us| time_us < last_us) {
                if back_from.is_some() {
                    stream.restart += 1;
                    self.tally.restarts += 1;
                } else {
                    self.tally.gaps += 1;
                }
                stream.last_us = Some(held_us);
                for held in &stream.held {
                    self.tally.rows += 1;
                    put(LogRow { restart: stream.restart, ..*held });
                }
            } else {
                self.tally.out_of_order += 1;
            }
            stream.held.clear();
        }
        match stream.last_us {
            Some(last_us) if time_us == last_us => self.tally.repeated += 1,
            Some(last_us) if time_us < last_us || time_us - last_us > GAP_US => stream.held.extend(row(stream.restart)),
            _ => {
                stream.last_us = Some(time_us);
                if let Some(giving) = self.giving.get_mut(offer.group as usize) {
                    *giving = Some((offer.rank, time_us));
                }
                row(stream.restart).for_each(|row| {
                    self.tally.rows += 1;
                    put(row);
                });
            }
        }
    }

    /// No more will come: what waits was not confirmed.
    pub(super) fn finish(&mut self) {
        for stream in &mut self.streams {
            self.tally.out_of_order += u64::from(!stream.held.is_empty());
            stream.held.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LogNature, TAS};
    use super::*;

    static FIRST: LogSource = LogSource { message: "A", channels: "tas", nature: LogNature::Instrument, note: "" };
    static SECOND: LogSource = LogSource { message: "B", channels: "tas", nature: LogNature::Estimate, note: "" };

    fn times(seconds: &[f64]) -> (Vec<(f64, u32)>, LogMappingTally) {
        let (mut gate, mut rows) = (RowGate::default(), Vec::new());
        let offer = LogOffer { source: &FIRST, group: LogGroup::Airspeed, rank: 0, instance: 0 };
        for time in seconds {
            gate.offer(offer, Some((time * 1e6) as u64), &[(TAS, *time)], &mut |row| rows.push((row.time_s(), row.restart)));
        }
        gate.finish();
        (rows, gate.tally)
    }

    #[test]
    fn a_damaged_stamp_costs_one_message_and_a_restart_none() {
        let (rows, tally) = times(&[1.0, 2.0, 4e9, 3.0, 0.5, 4.0, 4.0, 5.0]);
        assert_eq!(rows, [1.0, 2.0, 3.0, 4.0, 5.0].map(|time| (time, 0)));
        assert_eq!((tally.out_of_order, tally.repeated, tally.restarts, tally.gaps), (2, 1, 0, 0));
        let (rows, tally) = times(&[8.0, 9.0, 1.0, 2.0, 3.0, 50.0, 51.0, 99.0]);
        assert_eq!(rows, [(8.0, 0), (9.0, 0), (1.0, 1), (2.0, 1), (3.0, 1), (50.0, 1), (51.0, 1)]);
        assert_eq!((tally.out_of_order, tally.repeated, tally.restarts, tally.gaps), (1, 0, 1, 1));
    }

    #[test]
    fn the_second_gives_a_channel_only_after_the_silence_of_the_first() {
        let mut gate = RowGate::default();
        let mut given = |source, rank, seconds: u64| {
            let mut count = 0;
            let offer = LogOffer { source, group: LogGroup::Airspeed, rank, instance: 0 };
            gate.offer(offer, Some(seconds * 1_000_000), &[(TAS, 1.0)], &mut |_| count += 1);
            count
        };
        let found = [
            given(&SECOND, 1, 1),
            given(&FIRST, 0, 2),
            given(&SECOND, 1, 3),
            given(&SECOND, 1, 5),
            given(&FIRST, 0, 6),
            given(&SECOND, 1, 7),
        ];
        assert_eq!(found, [1, 1, 0, 1, 1, 0]);
        assert_eq!(gate.tally.not_preferred, 2);
    }

    #[test]
    fn what_is_no_number_or_has_no_time_is_counted() {
        let mut gate = RowGate::default();
        let offer = LogOffer { source: &FIRST, group: LogGroup::Airspeed, rank: 0, instance: 0 };
        gate.offer(offer, Some(1), &[(TAS, f64::NAN)], &mut |_| panic!());
        gate.offer(offer, None, &[(TAS, 1.0)], &mut |_| panic!());
        assert_eq!((gate.tally.not_a_number, gate.tally.no_time, gate.tally.rows), (1, 1, 0));
    }
}
