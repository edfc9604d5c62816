//! Late, repeated, jumping and wrapping samples: each finds its place or its row in the tables.

use super::config::{RawStamp, ReorderConfig, ReorderSettingError, StampUnit};
use super::events::{ReorderTally, TimelineEventKind};
use super::{Reorder, TimedValue};

fn settings(channels: usize) -> ReorderConfig {
    ReorderConfig { window_s: 0.5, ..ReorderConfig::new(channels, StampUnit::Seconds) }
}

/// Everything pushed, then finished.
fn played(config: &ReorderConfig, samples: impl IntoIterator<Item = (usize, RawStamp, f64)>) -> (Vec<TimedValue>, Reorder) {
    let mut reorder = Reorder::new(config).unwrap();
    let mut out = Vec::new();
    for (channel, stamp, value) in samples {
        reorder.push(channel, stamp, value, &mut |sample| out.push(sample));
    }
    reorder.finish(&mut |sample| out.push(sample));
    assert!(out.windows(2).all(|two| two[1].time_s >= two[0].time_s), "the axis goes back");
    (out, reorder)
}

fn seconds(times: &[f64]) -> Vec<(usize, RawStamp, f64)> {
    times.iter().map(|&time_s| (0, RawStamp::Seconds(time_s), time_s)).collect()
}

fn kinds(reorder: &Reorder) -> Vec<(f64, TimelineEventKind)> {
    reorder.events().iter().map(|event| ((1e6 * event.at_s).round() / 1e6, event.kind)).collect()
}

#[test]
fn late_samples_find_their_place_and_those_beyond_the_window_their_row() {
    let mut samples = seconds(&[0.0, 0.1, 0.3, 0.2, 0.4, 0.4, 1.0, 0.45]);
    samples.push((0, RawStamp::Seconds(1.0), 7.0));
    let (out, reorder) = played(&settings(1), samples);
    assert_eq!(out.iter().map(|sample| sample.time_s).collect::<Vec<_>>(), [0.0, 0.1, 0.2, 0.3, 0.4, 1.0]);
    assert!(out.iter().all(|sample| sample.value.to_bits() == sample.time_s.to_bits()));
    let [(_, repeated), (at_s, TimelineEventKind::Late(by_s)), (_, contradicting)] = kinds(&reorder)[..] else {
        panic!("{:?}", reorder.events())
    };
    assert_eq!((repeated, contradicting), (TimelineEventKind::Repeated, TimelineEventKind::Contradicting));
    assert!((at_s - 0.45).abs() < 1e-9 && (by_s - 0.05).abs() < 1e-9);
    let ReorderTally { taken, put, reordered, late, repeated, contradicting, dropouts, missing, .. } = reorder.tally();
    assert_eq!((taken, put, reordered, late, repeated, contradicting), (9, 6, 1, 1, 1, 1));
    // 0.4 to 1.0 s at 10 Hz.
    assert_eq!((dropouts, missing, reorder.dropouts()[0].missing), (1, 5, 5));
    assert!((reorder.rate_hz(0).unwrap() - 10.0).abs() < 1e-9);
}

#[test]
fn a_clock_that_goes_back_begins_a_segment_and_a_stray_stamp_does_not() {
    let before: Vec<f64> = (0..100).map(|k| 600.0 + 0.1 * f64::from(k)).collect();
    let after: Vec<f64> = (0..100).map(|k| 3.0 + 0.1 * f64::from(k)).collect();
    let mut times = before.clone();
    times.insert(50, 4e9);
    times.insert(60, 1.0);
    times.extend(&after);
    let (out, reorder) = played(&settings(1), seconds(&times));
    assert_eq!(out.len(), 200);
    // Two seconds behind the last, which was at 609.9 s.
    for (k, sample) in out.iter().enumerate() {
        let (time_s, segment) = if k < 100 { (before[k], 0) } else { (611.9 + after[k - 100] - 3.0, 1) };
        assert!((sample.time_s - time_s).abs() < 1e-9 && sample.segment == segment, "{k}: {sample:?}");
    }
    let found = kinds(&reorder);
    let [(first_s, TimelineEventKind::Stray(ahead_s)), (second_s, TimelineEventKind::Stray(behind_s)), jump] = found[..] else {
        panic!("{found:?}")
    };
    assert!((first_s - 605.0).abs() < 1e-6 && (ahead_s - (4e9 - 605.0)).abs() < 1e-3);
    assert!((second_s - 605.9).abs() < 0.11 && behind_s < -604.0);
    let (at_s, TimelineEventKind::JumpBack(by_s)) = jump else { panic!("{jump:?}") };
    assert!((at_s - 611.9).abs() < 1e-6 && (by_s - 606.9).abs() < 1e-6);
    assert_eq!((reorder.tally().dropouts, reorder.tally().strays), (0, 2), "how long it was is not known");
}

#[test]
fn a_step_forward_is_kept_as_the_clock_says_and_counted() {
    let times: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k) + if k < 50 { 0.0 } else { 100.0 }).collect();
    let (out, reorder) = played(&settings(1), seconds(&times));
    assert!(out.iter().zip(&times).all(|(sample, time_s)| (sample.time_s - time_s).abs() < 1e-12));
    assert_eq!((out.len(), reorder.tally().jumps_forward), (100, 1));
    let [(at_s, TimelineEventKind::JumpForward(by_s))] = kinds(&reorder)[..] else { panic!() };
    assert!((at_s - 105.0).abs() < 1e-9 && (by_s - 100.1).abs() < 1e-9);
    assert_eq!(reorder.dropouts().iter().map(|row| row.missing).collect::<Vec<_>>(), [1000]);
}

#[test]
fn counters_of_32_bits_go_on_after_their_end_with_late_ones_around_it() {
    for (tick_s, name) in [(1e-6, "us"), (1e-3, "ms")] {
        let config = ReorderConfig { unit: StampUnit::Counter { bits: 32, tick_s }, ..settings(1) };
        let step = (0.02 / tick_s).round() as u64;
        let first = (1_u64 << 32) - 50 * step;
        let mut counts: Vec<u64> = (0..100).map(|k| first + k * step).collect();
        // The last before the turn comes after the first behind it.
        counts.swap(49, 50);
        let low = |count: &u64| (0, RawStamp::Count(count % (1 << 32)), 0.0);
        let (out, reorder) = played(&config, counts.iter().map(low));
        assert_eq!(out.len(), 100);
        for (k, sample) in out.iter().enumerate() {
            let time_s = (first + k as u64 * step) as f64 * tick_s;
            assert!((sample.time_s - time_s).abs() < 1e-9 * time_s, "{name} {k}");
        }
        let ReorderTally { wraps, reordered, jumps_back, jumps_forward, dropouts, strays, .. } = reorder.tally();
        assert_eq!((wraps, reordered, jumps_back, jumps_forward, dropouts, strays), (1, 1, 0, 0, 0, 0), "{name}");
        assert!((reorder.events()[0].at_s - (1_u64 << 32) as f64 * tick_s).abs() < 1e-6);
    }
}

#[test]
fn latencies_are_subtracted_and_channels_sorted_by_when_it_was() {
    let config = ReorderConfig { latencies_s: vec![0.0, 0.25, -0.05], ..settings(3) };
    let samples = (0..200).map(|k| (k % 3, RawStamp::Seconds(0.01 * k as f64), k as f64));
    let (out, reorder) = played(&config, samples);
    assert_eq!((out.len(), reorder.tally().late, reorder.events().len()), (200, 0, 0));
    for sample in out {
        let stamp_s = 0.01 * sample.value;
        assert!((sample.time_s - (stamp_s - [0.0, 0.25, -0.05][sample.channel])).abs() < 1e-12);
    }
    // Across a jump too.
    let jumping = (0..200).map(|k| {
        let stamp_s = 0.01 * k as f64 + if k < 100 { 50.0 } else { 0.0 };
        (k % 3, RawStamp::Seconds(stamp_s), k as f64)
    });
    let (out, reorder) = played(&config, jumping);
    assert_eq!((out.len(), reorder.tally().jumps_back, reorder.events().len()), (200, 1, 1));
}

#[test]
fn what_waits_and_what_is_listed_is_bounded() {
    let config = ReorderConfig { capacity: 8, rows_max: 5, ..settings(1) };
    let mut reorder = Reorder::new(&config).unwrap();
    let mut put = 0;
    for k in 0..1000 {
        reorder.push(0, RawStamp::Seconds(0.001 * f64::from(k)), 0.0, &mut |_| put += 1);
        assert!(reorder.waiting.len() <= 8);
    }
    assert!(put >= 992);
    let tally = reorder.tally();
    assert_eq!((tally.early, reorder.events().len(), tally.beyond_tables), (992, 5, 987));
    // One that is older than all that wait, and no place is free.
    reorder.push(0, RawStamp::Seconds(0.9915), 0.0, &mut |_| put += 1);
    assert_eq!((reorder.tally().late, put), (0, 993));
    reorder.push(1, RawStamp::Seconds(1.0), 0.0, &mut |_| put += 1);
    reorder.push(0, RawStamp::Seconds(f64::NAN), 0.0, &mut |_| put += 1);
    reorder.push(0, RawStamp::Count(5), 0.0, &mut |_| put += 1);
    assert_eq!(reorder.tally().no_time, 3);
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let refused = |config: ReorderConfig| Reorder::new(&config).err();
    assert_eq!(
        refused(ReorderConfig { window_s: -1.0, ..settings(1) }),
        Some(ReorderSettingError::Negative { name: "window_s", value: -1.0 })
    );
    let unit = StampUnit::Counter { bits: 64, tick_s: 1e-6 };
    assert_eq!(refused(ReorderConfig { unit, ..settings(1) }), Some(ReorderSettingError::Counter { bits: 64, tick_s: 1e-6 }));
    assert_eq!(
        refused(ReorderConfig { window_s: 3.0, ..settings(1) }),
        Some(ReorderSettingError::BackWithinWindow { back_s: 2.0, window_s: 3.0 })
    );
    assert!(matches!(
        refused(ReorderConfig { latencies_s: vec![f64::INFINITY], ..settings(1) }),
        Some(ReorderSettingError::Latency { channel: 0, .. })
    ));
    assert_eq!(refused(ReorderConfig { capacity: 0, ..settings(1) }), Some(ReorderSettingError::NoCapacity));
}
