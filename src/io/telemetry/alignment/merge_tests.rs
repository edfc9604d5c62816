//! Two small recordings merged, by hand.

use super::{Merge, MergeRule, MergeTally, RowSource};
use crate::flight::channel::Channel;
use crate::flight::file::run_file::RecordingColumn;
use crate::flight::sample::Sample;
use crate::io::telemetry::alignment::clock_relation::ClockRelation;
use crate::io::telemetry::record::{RecordingError, RecordingRow};

struct Rows {
    rows: Vec<RecordingRow>,
    place: usize,
}

impl Rows {
    /// Times with the values of a known channel and of one other column.
    fn of(channel: Channel, rows: &[(f64, Option<f64>, Option<f64>)]) -> Self {
        let row = |(k, (time_s, known, other)): (usize, &(f64, Option<f64>, Option<f64>))| {
            let mut sample = Sample::new(*time_s);
            known.iter().for_each(|value| sample.set(channel, *value));
            RecordingRow { number: k as u64 + 1, sample, others: vec![*other] }
        };
        Rows { rows: rows.iter().enumerate().map(row).collect(), place: 0 }
    }
}

impl RowSource for Rows {
    fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        self.place += 1;
        Ok(self.rows.get(self.place - 1))
    }
}

fn columns(names: &[&str]) -> Vec<RecordingColumn> {
    names.iter().map(|name| RecordingColumn::new(name, None).unwrap()).collect()
}

type Cells = (f64, Option<f64>, Option<f64>, Vec<Option<f64>>);

/// Everything that comes out: time, `p`, `tas`, the others.
fn merged(merge: &mut Merge, mut first: Rows, mut second: Rows) -> Vec<Cells> {
    let mut out = Vec::new();
    while let Some(row) = merge.next_row(&mut first, &mut second).unwrap() {
        let time_s = (1e9 * row.sample.time_s).round() / 1e9;
        out.push((time_s, row.sample.get(Channel::P), row.sample.get(Channel::Tas), row.others.clone()));
        assert_eq!(row.number, out.len() as u64);
    }
    assert!(out.windows(2).all(|two| two[1].0 > two[0].0), "{out:?}");
    out
}

#[test]
fn new_channels_are_added_at_their_own_times_and_equal_times_are_one_row() {
    let relation = ClockRelation::given(10.0, 0.0).unwrap();
    let mut merge =
        Merge::new(&columns(&["time", "p", "count"]), &columns(&["time", "tas", "pressure"]), relation, 0.002, |_| {
            MergeRule::First
        });
    let names: Vec<&str> = merge.columns().iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["time", "p", "count", "tas", "pressure"]);
    let first = Rows::of(Channel::P, &[(10.0, Some(1.0), Some(7.0)), (10.1, Some(2.0), None), (10.2, Some(3.0), Some(9.0))]);
    let second = Rows::of(Channel::Tas, &[(-0.5, Some(50.0), None), (0.101, Some(51.0), Some(8.0)), (0.15, None, Some(4.0))]);
    let out = merged(&mut merge, first, second);
    let wanted: Vec<Cells> = vec![
        (9.5, None, Some(50.0), vec![None, None]),
        (10.0, Some(1.0), None, vec![Some(7.0), None]),
        (10.1, Some(2.0), Some(51.0), vec![None, Some(8.0)]),
        (10.15, None, None, vec![None, Some(4.0)]),
        (10.2, Some(3.0), None, vec![Some(9.0), None]),
    ];
    assert_eq!(out, wanted);
    assert_eq!(merge.tally(), MergeTally { taken: [3, 3], put: 5, common: 1, ..MergeTally::default() });
}

#[test]
fn of_a_shared_channel_the_rule_says_whose_values_count() {
    let relation = ClockRelation::given(0.0, 0.0).unwrap();
    let rows =
        |offset: f64| [(0.0, Some(offset), Some(offset)), (1.0, Some(offset + 1.0), None), (2.5 + offset, Some(9.0), None)];
    let run = |rule: MergeRule| {
        let both = columns(&["time", "p", "count"]);
        let mut merge = Merge::new(&both, &both, relation, 1e-3, |_| rule);
        let out = merged(&mut merge, Rows::of(Channel::P, &rows(0.0)), Rows::of(Channel::P, &rows(0.25)));
        (out.into_iter().map(|(time_s, p, _, others)| (time_s, p, others[0])).collect::<Vec<_>>(), merge.tally().left_out)
    };
    let at = |p: [Option<f64>; 4], count: f64| {
        let times = [0.0, 1.0, 2.5, 2.75];
        (0..4).map(|k| (times[k], p[k], (k == 0).then_some(count))).collect::<Vec<_>>()
    };
    assert_eq!(run(MergeRule::First), (at([Some(0.0), Some(1.0), Some(9.0), None], 0.0), 4));
    assert_eq!(run(MergeRule::Second), (at([Some(0.25), Some(1.25), None, Some(9.0)], 0.25), 4));
    assert_eq!(run(MergeRule::Both), (at([Some(0.0), Some(1.0), Some(9.0), Some(9.0)], 0.0), 3));
}

#[test]
fn the_nearest_rows_go_together_and_each_only_once() {
    let relation = ClockRelation::given(0.0, 0.0).unwrap();
    let (one, two) = (columns(&["time", "p", "count"]), columns(&["time", "tas", "pressure"]));
    // 4 ms apart against 10 ms, within 3 ms.
    let fast: Vec<_> = (0..26).map(|k| (0.004 * f64::from(k), Some(f64::from(k)), None)).collect();
    let slow: Vec<_> = (0..11).map(|k| (0.0009 + 0.01 * f64::from(k), Some(f64::from(k)), None)).collect();
    let mut merge = Merge::new(&one, &two, relation, 0.003, |_| MergeRule::First);
    let out = merged(&mut merge, Rows::of(Channel::P, &fast), Rows::of(Channel::Tas, &slow));
    assert_eq!((out.len(), merge.tally().common), (26, 11));
    for (time_s, p, tas, _) in out {
        let nearest = |k: f64| (0.0009 + 0.01 * k - time_s).abs() <= 0.002 + 1e-12;
        assert!(p.is_some() && tas.is_none_or(nearest), "{time_s} {tas:?}");
    }
    // The other way round.
    let mut merge = Merge::new(&two, &one, relation, 0.003, |_| MergeRule::First);
    let out = merged(&mut merge, Rows::of(Channel::Tas, &slow), Rows::of(Channel::P, &fast));
    assert_eq!((out.len(), merge.tally().common), (26, 11));
    assert_eq!(out.iter().filter(|(_, p, ..)| p.is_some()).count(), 26);
}

#[test]
fn rows_without_time_or_out_of_order_are_counted_with_the_first() {
    let relation = ClockRelation::given(0.0, 1e-4).unwrap();
    let (one, two) = (columns(&["time", "p", "count"]), columns(&["time", "tas", "pressure"]));
    let mut merge = Merge::new(&one, &two, relation, 0.0, |_| MergeRule::First);
    let row = |time_s| (time_s, Some(1.0), None);
    let first = Rows::of(Channel::P, &[row(0.0), row(1.0), row(0.5), row(1.0), row(2.0)]);
    let second = Rows::of(Channel::Tas, &[row(f64::NAN), row(10_000.0), row(10_001.0)]);
    let out = merged(&mut merge, first, second);
    assert_eq!(out.iter().map(|cells| cells.0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 10_001.0, 10_002.000_1]);
    let tally = merge.tally();
    assert_eq!((tally.not_growing, tally.no_time, tally.first_refused), ([2, 0], [0, 1], [Some(3), Some(1)]));
}
