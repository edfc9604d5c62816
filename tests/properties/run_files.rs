//! A run file that was written is read back bit for bit, and no bytes make the reader panic.

use proptest::prelude::*;
use sideslip::flight::channel::{CHANNELS, Channel, ControlNames};
use sideslip::flight::file::run_file::{RunFileWriter, RunInfo};
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::csv::CsvRecording;
use std::io::Cursor;
use std::path::Path;

/// Any bits, with the numbers that text handles badly made likely.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<u64>().prop_map(f64::from_bits),
        4 => -1e3..1e3_f64,
        1 => prop::sample::select(vec![0.0, -0.0, 5e-324, f64::MIN_POSITIVE, f64::MAX, f64::MIN, f64::INFINITY, f64::NAN, 0.1]),
    ]
}

fn any_rows() -> impl Strategy<Value = (Vec<Channel>, Vec<Sample>)> {
    let channels = prop::sample::subsequence(Channel::ALL.to_vec(), 0..=CHANNELS).prop_shuffle();
    channels.prop_flat_map(|channels| {
        let row = (any_number(), prop::collection::vec(prop::option::of(any_number()), channels.len()));
        let of = channels.clone();
        let rows = prop::collection::vec(row, 1..20).prop_map(move |rows| {
            let sample = |(time_s, values): (f64, Vec<Option<f64>>)| {
                let mut sample = Sample::new(time_s);
                of.iter().zip(values).for_each(|(&channel, value)| {
                    if let Some(value) = value {
                        sample.set(channel, value);
                    }
                });
                sample
            };
            rows.into_iter().map(sample).collect()
        });
        (Just(channels), rows)
    })
}

/// The same bits, or both no number (text does not carry a NaN's payload).
fn same(left: f64, right: f64) -> bool {
    left.to_bits() == right.to_bits() || (left.is_nan() && right.is_nan())
}

fn open(bytes: Vec<u8>) -> CsvRecording {
    CsvRecording::new(Path::new("written.csv"), Box::new(Cursor::new(bytes))).unwrap()
}

proptest! {
    #![proptest_config(super::cases(256))]

    #[test]
    fn what_is_written_is_read_bit_for_bit((channels, samples) in any_rows(), fixed_wing in any::<bool>()) {
        let mut info = RunInfo::default();
        let carries_controls = channels.iter().any(|channel| Channel::CONTROLS.contains(channel));
        if fixed_wing && carries_controls {
            info.set_controls(ControlNames::FixedWing);
        }
        let mut writer = RunFileWriter::new(Vec::new(), &info, &channels).unwrap();
        for sample in &samples {
            writer.write_row(sample.time_s, |channel| sample.get(channel)).unwrap();
        }
        let mut recording = open(writer.finish().unwrap());
        prop_assert_eq!(recording.info(), &info);
        for sample in &samples {
            let read = &recording.next_row().unwrap().unwrap().sample;
            prop_assert!(same(read.time_s, sample.time_s));
            prop_assert_eq!(read.present, sample.present);
            prop_assert!(read.values.iter().zip(&sample.values).all(|(&left, &right)| same(left, right)));
        }
        prop_assert!(recording.next_row().unwrap().is_none());
        prop_assert_eq!(recording.skipped().rows(), 0);
    }

    #[test]
    fn the_runs_own_document_comes_back(
        run in any::<String>(),
        note in prop::collection::vec("[ -~\t]*", 0..4),
        vane in prop::array::uniform3(-100.0..100.0_f64),
        blades in prop::option::of(1..=32_u32),
    ) {
        let mut document = toml::Table::new();
        document.insert("run".into(), run.clone().into());
        document.insert("note".into(), note.join("\n").into());
        document.insert("vane_position_m".into(), vane.to_vec().into());
        blades.map(|blades| document.insert("blades".into(), i64::from(blades).into()));
        let info = RunInfo::from_toml(&document.to_string()).unwrap();
        prop_assert_eq!(info.run(), Some(run.as_str()));
        let mut writer = RunFileWriter::new(Vec::new(), &info, &[]).unwrap();
        writer.write_row(0.0, |_| None).unwrap();
        let recording = open(writer.finish().unwrap());
        prop_assert_eq!(recording.info(), &info);
        prop_assert_eq!(recording.info().document(), &document);
    }

    #[test]
    fn no_bytes_make_the_reader_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        text in "[# \n\rtime,pq0-9.\"\\[\\]=]{0,200}",
    ) {
        for bytes in [bytes, text.clone().into_bytes(), format!("time,p\n{text}").into_bytes()] {
            let Ok(mut recording) = CsvRecording::new(Path::new("any"), Box::new(Cursor::new(bytes))) else { continue };
            while let Ok(Some(_)) = recording.next_row() {}
        }
    }
}
