//! Rows with late channels, late rows, and a clock that jumps.

use super::{RowAlignment, SAME_S};
use crate::flight::channel::Channel;
use crate::flight::file::run_file::RunInfo;
use crate::flight::sample::Sample;
use crate::io::telemetry::record::RecordingRow;

fn alignment(latencies: &str, others: usize, window_s: f64) -> RowAlignment {
    let info = RunInfo::from_toml(&format!("latency_s = {latencies}")).unwrap();
    RowAlignment::new(info.latencies().unwrap(), others, window_s).unwrap()
}

/// A row of p, of tas and of another column; each holds the time that it was measured at.
fn row(stamp_s: f64, tas_latency_s: f64) -> (Sample, [Option<f64>; 1]) {
    let mut sample = Sample::new(stamp_s);
    sample.set(Channel::P, stamp_s);
    sample.set(Channel::Tas, stamp_s - tas_latency_s);
    (sample, [Some(stamp_s)])
}

fn played(alignment: &mut RowAlignment, rows: impl IntoIterator<Item = (Sample, [Option<f64>; 1])>) -> Vec<RecordingRow> {
    let mut out = Vec::new();
    for (number, (sample, others)) in (1..).zip(rows) {
        alignment.push(number, &sample, &others, &mut |row| out.push(row.clone()));
    }
    alignment.finish(&mut |row| out.push(row.clone()));
    assert!(out.windows(2).all(|two| two[1].sample.time_s > two[0].sample.time_s), "{out:?}");
    out
}

#[test]
fn every_channel_is_at_its_own_time_and_equal_times_are_one_row() {
    for (latency_s, own_rows) in [(0.25, false), (0.255, true)] {
        let mut alignment = alignment(&format!("{{ tas = {latency_s} }}"), 1, 0.0);
        let out = played(&mut alignment, (0..200).map(|k| row(0.01 * f64::from(k), latency_s)));
        assert_eq!(out.len(), if own_rows { 400 } else { 225 }, "{latency_s}");
        for RecordingRow { sample, others, .. } in &out {
            let values = [sample.get(Channel::P), sample.get(Channel::Tas), others[0]];
            assert!(values.iter().flatten().all(|at_s| (at_s - sample.time_s).abs() < SAME_S));
            assert_eq!(sample.get(Channel::P), others[0]);
        }
        let both = out.iter().filter(|row| row.sample.get(Channel::P).is_some() && row.sample.get(Channel::Tas).is_some());
        assert_eq!(both.count(), if own_rows { 0 } else { 175 });
        assert!(alignment.tally().losses().is_empty() && alignment.tally().notes().is_empty());
        assert_eq!((alignment.tally().put, alignment.dropouts().len()), (600, 0));
    }
}

#[test]
fn a_row_waits_no_longer_than_the_largest_latency_and_the_next_row() {
    let mut alignment = alignment("{ tas = 0.25 }", 1, 0.0);
    for k in 0..400 {
        let stamp_s = 0.01 * f64::from(k);
        let (sample, others) = row(stamp_s, 0.25);
        let mut newest_s = None;
        alignment.push(1, &sample, &others, &mut |row| newest_s = Some(row.sample.time_s));
        if k > 30 {
            let newest_s = newest_s.unwrap();
            assert!(stamp_s - newest_s < 0.25 + 0.01 + SAME_S && stamp_s - newest_s > 0.25 - SAME_S, "{stamp_s} {newest_s}");
        }
    }
}

#[test]
fn rows_in_another_order_and_twice_give_the_same() {
    let rows: Vec<_> = (0..200).map(|k| row(0.01 * f64::from(k), 0.25)).collect();
    let straight = played(&mut alignment("{ tas = 0.25 }", 1, 0.5), rows.clone());
    let mut shuffled = rows;
    for k in (0..180).step_by(20) {
        shuffled.swap(k, k + 13);
        shuffled.insert(k + 5, shuffled[k + 3]);
    }
    let mut alignment = alignment("{ tas = 0.25 }", 1, 0.5);
    let out = played(&mut alignment, shuffled);
    let plain = |rows: Vec<RecordingRow>| rows.into_iter().map(|row| (row.sample, row.others)).collect::<Vec<_>>();
    assert_eq!(plain(out), plain(straight));
    let tally = alignment.tally();
    assert_eq!((tally.repeated, tally.late, tally.put), (27, 0, 600));
    assert!(tally.reordered > 0 && tally.losses().is_empty());
    assert_eq!(tally.notes()[1], "27 of 627 samples came twice");
}

#[test]
fn one_wrong_stamp_is_a_stray_however_many_channels_its_row_has() {
    let mut rows: Vec<_> = (0..200).map(|k| row(0.01 * f64::from(k), 0.0)).collect();
    rows[100].0.time_s = 5000.0;
    rows[150].0.time_s = f64::NAN;
    let mut alignment = alignment("{}", 1, 1.0);
    let out = played(&mut alignment, rows);
    assert_eq!((out.len(), alignment.tally().strays, alignment.tally().no_time), (198, 3, 3));
    assert!(out.iter().all(|row| row.sample.time_s < 2.0) && alignment.shift_s().abs() < 1e-12);
    assert_eq!(alignment.tally().jumps_forward + alignment.tally().jumps_back, 0);
    let losses = ["3 of 600 samples have a time that contradicts those around them", "3 of 600 samples have no time"];
    assert_eq!(alignment.tally().losses(), losses);
    assert_eq!(alignment.dropouts().len(), 6, "two of each column");
}

#[test]
fn a_clock_that_goes_back_goes_on_behind_what_was() {
    let rows = (0..200).map(|k| row(0.01 * f64::from(k) + if k < 100 { 50.0 } else { 0.0 }, 0.0));
    let mut alignment = alignment("{ tas = 0.1 }", 1, 0.0);
    let out = played(&mut alignment, rows);
    assert_eq!((alignment.tally().put, alignment.tally().jumps_back, alignment.tally().late), (600, 1, 0));
    assert!(out.last().is_some_and(|row| row.sample.time_s > 52.0) && alignment.shift_s() > 50.0);
    assert_eq!(alignment.tally().notes(), ["the clock goes back once"]);
}
