//! Rows against samples whose times were chosen by hand.

use super::super::format::{ParameterPlace, ParameterSpec, PcmFormatSpec};
use super::*;
use crate::flight::channel::Channel;

fn format(parameters: &[(&str, &str)]) -> PcmFormat {
    let parameters = (1..).zip(parameters).map(|(word, (name, unit))| ParameterSpec {
        name: (*name).into(),
        unit: (*unit).into(),
        places: vec![ParameterPlace::word(word)],
        ..ParameterSpec::default()
    });
    PcmFormat::new(PcmFormatSpec { words: 8, parameters: parameters.collect(), ..PcmFormatSpec::default() }).unwrap()
}

fn sample(parameter: usize, time_s: f64, value: f64) -> PcmSample {
    PcmSample { parameter, time_s, raw: 0, value: Some(value), flags: SampleFlags::NONE }
}

fn rows_of(rows: &mut PcmRows, samples: &[PcmSample]) -> Vec<RecordingRow> {
    let mut found = Vec::new();
    let mut each = |row: &RecordingRow| found.push(row.clone());
    samples.iter().for_each(|sample| rows.put(sample, &mut each));
    rows.finish(&mut each);
    found
}

#[test]
fn words_near_each_other_are_one_row_in_si_at_the_middle_of_their_times() {
    let mut rows = PcmRows::new(&format(&[("p", "deg/s"), ("oil", "K"), ("q", "")])).unwrap();
    let found = rows_of(&mut rows, &[sample(0, 1.0, 180.0), sample(1, 1.0002, 300.0), sample(2, 1.0006, 0.5)]);
    assert_eq!(found.len(), 2);
    assert!((found[0].sample.time_s - 1.0001).abs() < 1e-12);
    assert!((found[0].sample.get(Channel::P).unwrap() - std::f64::consts::PI).abs() < 1e-12);
    assert_eq!((found[0].sample.get(Channel::Q), found[0].others[0]), (None, Some(300.0)));
    assert_eq!((found[1].sample.get(Channel::Q), found[1].others[0], found[1].number), (Some(0.5), None, 2));
    assert!((found[1].sample.time_s - 1.0006).abs() < 1e-12);
}

#[test]
fn a_parameter_that_comes_again_begins_a_row() {
    let mut rows = PcmRows::new(&format(&[("p", "rad/s"), ("oil", "K")])).unwrap();
    let samples = [sample(0, 1.0, 1.0), sample(0, 1.0001, 2.0), sample(1, 1.0002, 3.0), sample(1, 1.0003, 4.0)];
    let found = rows_of(&mut rows, &samples);
    let of: Vec<_> = found.iter().map(|row| (row.sample.get(Channel::P), row.others[0])).collect();
    assert_eq!(of, [(Some(1.0), None), (Some(2.0), Some(3.0)), (None, Some(4.0))]);
}

#[test]
fn what_may_be_wrong_is_left_out_and_counted() {
    let mut rows = PcmRows::new(&format(&[("p", "rad/s")])).unwrap();
    let flagged = |flags| PcmSample { flags, ..sample(0, 1.0, 1.0) };
    let found = rows_of(
        &mut rows,
        &[
            flagged(SampleFlags::PARITY),
            flagged(SampleFlags::DOUBTFUL_FRAME.with(SampleFlags::PARITY)),
            flagged(SampleFlags::HIGH),
            flagged(SampleFlags::LOW),
            PcmSample { value: None, ..flagged(SampleFlags::NO_VALUE) },
            flagged(SampleFlags::EXTRAPOLATED),
        ],
    );
    assert_eq!(found.len(), 1);
    let expected = UnusedSamples { parity: 1, doubtful_frame: 1, out_of_limits: 2, beyond_step: 0, no_value: 1, extrapolated: 1 };
    assert_eq!(rows.unused(), expected);
    assert!(rows.unused().words().unwrap().contains("2 samples beyond their limits"));
    assert!(rows.shortfall().unwrap().ends_with(", p lost 5 of 6"), "{:?}", rows.shortfall());
    assert_eq!(UnusedSamples::default().words(), None);
    let mut many = PcmRows::new(&format(&[("a", ""), ("b", ""), ("c", ""), ("d", ""), ("e", ""), ("f", ""), ("g", "")])).unwrap();
    assert_eq!(many.shortfall(), None);
    for parameter in 0..6 {
        many.put(&PcmSample { flags: SampleFlags::HIGH, ..sample(parameter, 1.0, 1.0) }, &mut |_| {});
        many.put(&sample(6, 1.0, 1.0), &mut |_| {});
    }
    let words = many.shortfall().unwrap();
    assert!(
        words.ends_with("a lost 1 of 1, b lost 1 of 1, c lost 1 of 1, d lost 1 of 1, and 2 parameters more lost most of theirs"),
        "{words}"
    );
}

#[test]
fn parameters_that_cannot_be_channels_are_refused() {
    for (parameters, expected) in
        [(&[("p", "m")][..], "`p`"), (&[("time", "s")], "`time`"), (&[("rudder", ""), ("lon_cyclic", "")], "two namings")]
    {
        let said = PcmRows::new(&format(parameters)).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
}
