//! Decommutation, encoding, and the sorting and merging of samples by time allocate nothing after the start.

#[path = "line.rs"]
#[allow(dead_code, reason = "slips are for other tests")]
mod line;

use crate::support::allocations::during;
use crate::support::chapter10::{Recorder, Storage};
use line::{Random, add_errors, format, sent};
use sideslip::flight::channel::Channel;
use sideslip::flight::file::run_file::{RecordingColumn, RunInfo};
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::alignment::clock_relation::ClockRelation;
use sideslip::io::telemetry::alignment::merge::{Merge, MergeRule, RowSource};
use sideslip::io::telemetry::alignment::reorder::Reorder;
use sideslip::io::telemetry::alignment::reorder::config::{RawStamp, ReorderConfig, StampUnit};
use sideslip::io::telemetry::alignment::row_alignment::RowAlignment;
use sideslip::io::telemetry::chapter10::channel_decoder::ChannelDecoder;
use sideslip::io::telemetry::chapter10::packet::Chapter10Reader;
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use sideslip::io::telemetry::record::{RecordingError, RecordingRow};

#[test]
fn packets_of_chapter_10_that_continue_each_other_allocate_nothing() {
    let _turn = crate::alone();
    let text = "bit_rate = 160_000\nwords = 9\nword_bits = 16\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n\
        [[parameter]]\nname = \"p\"\nword = 1\n[[parameter]]\nname = \"q\"\nword = 8\n";
    let format = PcmFormat::from_toml(text).unwrap();
    let mut encoder = PcmEncoder::new(&format, 0.0).unwrap();
    let mut frame = |number: u32| {
        let mut bytes = Vec::new();
        encoder.minor_frame(|_, _| f64::from(number), &mut bytes).unwrap();
        bytes
    };
    let frames: Vec<Vec<u8>> = (0..600).map(&mut frame).collect();
    for storage in Storage::ALL {
        let recorder = Recorder { channel: 3, storage, first_rtc: 0, frame_ticks: 1e4, in_packet: 10 };
        let (mut decoder, mut samples, mut allocated) = (ChannelDecoder::new(&format).unwrap(), 0, 0);
        for (number, packet) in recorder.packets(&frames).iter().enumerate() {
            let mut reader = Chapter10Reader::default();
            reader.take(packet);
            let packet = reader.finish().unwrap();
            let here = during(|| decoder.packet(&packet, |_| samples += 1));
            allocated += if number > 1 { here } else { 0 };
        }
        assert_eq!((allocated, decoder.tally().packets > 50), (0, true), "{storage:?}");
        assert!(samples > 1100, "{samples}");
    }
}

#[test]
fn decommutation_allocates_nothing_after_the_start() {
    let _turn = crate::alone();
    let format = format("rnrz_l", "odd");
    let mut random = Random(51);
    let mut line = sent(&format, 2000, true, &mut random).line;
    // Noise between: search, check, lock, flywheel and loss.
    line.extend((0..5000).map(|_| random.next() as u8));
    line.extend(sent(&format, 2000, false, &mut random).line);
    add_errors(&mut line, 1e-3, &mut random);
    let mut decoder = PcmDecoder::new(&format, 0.0);
    let mut samples = 0_u64;
    let allocated = during(|| {
        for piece in line.chunks(777) {
            decoder.feed(piece, |_| samples += 1);
        }
        decoder.finish(|_| samples += 1);
    });
    assert_eq!(allocated, 0);
    let counters = decoder.synchronizer.counters();
    assert!(samples > 100_000 && counters.locks >= 2 && counters.losses >= 1, "{samples} {counters:?}");
    let mut encoder = PcmEncoder::new(&format, 0.0).unwrap();
    let mut line = Vec::with_capacity(100_000);
    let allocated = during(|| (0..1000).for_each(|_| encoder.minor_frame(|_, _| 5.0, &mut line).unwrap()));
    assert_eq!(allocated, 0);
}

#[test]
fn sorting_by_time_allocates_nothing_after_the_start() {
    let _turn = crate::alone();
    let unit = StampUnit::Counter { bits: 32, tick_s: 1e-6 };
    let config = ReorderConfig { capacity: 64, rows_max: 500, ..ReorderConfig::new(4, unit) };
    let mut reorder = Reorder::new(&config).unwrap();
    let mut random = Random(77);
    let mut put = 0_u64;
    let allocated = during(|| {
        let mut count = u64::from(u32::MAX) - 10_000_000;
        for k in 0..100_000_u64 {
            count += 5_000;
            // Late, lost, repeated, stray, and two jumps.
            let late = random.next() % 40 * 20_000;
            let stamp = match k {
                _ if random.next().is_multiple_of(500) => random.next(),
                30_000..60_000 => count - 100_000_000,
                _ => count,
            };
            if !random.next().is_multiple_of(50) {
                let stamp = RawStamp::Count(stamp.wrapping_sub(late) % (1 << 32));
                (0..1 + u64::from(random.next().is_multiple_of(9)))
                    .for_each(|_| reorder.push((k % 4) as usize, stamp, 1.0, &mut |_| put += 1));
            }
        }
        reorder.finish(&mut |_| put += 1);
    });
    assert_eq!(allocated, 0);
    let tally = reorder.tally();
    eprintln!("{tally:?}");
    assert!(tally.jumps_back >= 1 && tally.wraps >= 1 && tally.repeated > 1000 && tally.strays > 10 && tally.beyond_tables > 0);
    let lost = tally.late + tally.repeated + tally.contradicting + tally.strays + tally.no_time;
    assert_eq!((tally.put, tally.put + lost), (put, tally.taken), "every sample is handed on or counted");
}

#[test]
fn rows_with_late_channels_are_aligned_without_allocation() {
    let _turn = crate::alone();
    let info = RunInfo::from_toml("latency_s = { tas = 0.25, beta = 0.103 }").unwrap();
    let mut alignment = RowAlignment::new(info.latencies().unwrap(), 3, 0.0).unwrap();
    let (mut random, mut rows) = (Random(78), 0_u64);
    let mut push = |k: u64| {
        let stray_s = if random.next().is_multiple_of(300) { 500.0 } else { 0.0 };
        let back_s = if k > 30_000 { 200.0 } else { 0.0 };
        let mut sample = Sample::new(0.01 * k as f64 + stray_s - back_s);
        [Channel::P, Channel::Tas, Channel::Beta].iter().for_each(|channel| sample.set(*channel, 1.0));
        alignment.push(k, &sample, &[Some(1.0), None, Some(2.0)], &mut |_| rows += 1);
    };
    let allocated = during(|| (0..60_000).for_each(&mut push));
    let tally = alignment.tally();
    eprintln!("{tally:?}");
    assert_eq!((allocated, tally.jumps_back), (0, 1));
    assert!(rows > 110_000 && tally.strays > 500);
}

/// Rows at equal intervals, made in place.
struct Regular {
    step_s: f64,
    count: u64,
    row: RecordingRow,
}

impl RowSource for Regular {
    fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        if self.row.number == self.count {
            return Ok(None);
        }
        self.row.number += 1;
        self.row.sample.time_s = self.step_s * self.row.number as f64;
        Ok(Some(&self.row))
    }
}

#[test]
fn merging_allocates_nothing_after_the_first_rows() {
    let _turn = crate::alone();
    let source = |step_s, count, channel| {
        let mut sample = Sample::new(0.0);
        sample.set(channel, 1.0);
        Regular { step_s, count, row: RecordingRow { number: 0, sample, others: vec![Some(3.0); 2] } }
    };
    let columns = |names: [&str; 4]| names.map(|name| RecordingColumn::new(name, None).unwrap());
    let (mut first, mut second) = (source(0.01, 50_000, Channel::P), source(0.004, 100_000, Channel::Tas));
    let relation = ClockRelation::given(12.0, 1e-5).unwrap();
    let (one, two) = (columns(["time", "p", "a", "b"]), columns(["time", "tas", "c", "d"]));
    let mut merge = Merge::new(&one, &two, relation, 1e-3, |_| MergeRule::First);
    for _ in 0..10 {
        merge.next_row(&mut first, &mut second).unwrap();
    }
    // Both go on for so long; at their ends rows are given back.
    let allocated = during(|| (0..100_000).for_each(|_| assert!(merge.next_row(&mut first, &mut second).unwrap().is_some())));
    assert_eq!(allocated, 0);
    while merge.next_row(&mut first, &mut second).unwrap().is_some() {}
    assert_eq!((merge.tally().taken, merge.columns().len()), ([50_000, 100_000], 7));
}
