//! `sideslip replay --smoothed`: the file holds what the library's smoother gives, bit for bit, and the program reads it back.

use crate::support::program::{ended, folder, own, path, puma, real, sideslip};
use sideslip::flight::channel::Channel;
use sideslip::flight::file::run_file::{RecordingColumn, RecordingTarget, RunInfo};
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::record::RecordingRow;
use sideslip::io::telemetry::recording::Recording;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::fixed_interval::smooth;
use sideslip::realtime::estimation::record::StateRecord;
use std::path::Path;

struct Read {
    info: RunInfo,
    columns: Vec<RecordingColumn>,
    rows: Vec<RecordingRow>,
}

fn read(file: &Path) -> Read {
    let mut recording = Recording::open(file).unwrap();
    let mut rows = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        rows.push(row.clone());
    }
    assert_eq!(recording.skipped().rows(), 0);
    Read { info: recording.info().clone(), columns: recording.columns().to_vec(), rows }
}

fn smoothed_by_the_library(recording: &Read) -> Vec<StateRecord> {
    let samples: Vec<Sample> = recording.rows.iter().map(|row| row.sample).collect();
    smooth(&samples, &EstimationConfig::default(), *recording.info.geometry()).unwrap().states
}

fn written(args: &[&str]) -> String {
    let (status, out, said) = ended(&sideslip(&[&["replay", "--force"], args].concat()));
    // Without a derivative the states are written all the same.
    assert!(matches!(status, 0 | 4), "{status} {said}");
    out
}

#[test]
fn the_text_is_what_the_library_smooths_and_reads_back() {
    let folder = folder("smoothed-text");
    for (number, file) in [Some(puma()), real("attas-rud1.csv")].into_iter().flatten().enumerate() {
        let states_file = folder.join(format!("{number}.csv"));
        let set = "vane_position_m=[13.08,0,0]";
        let out = written(&[path(&file), "--smoothed", path(&states_file), "--set", set]);
        let mut recording = read(&file);
        recording.info.set(set).unwrap();
        let expected = smoothed_by_the_library(&recording);
        assert!(out.contains(&format!("smoothed: {}, {} states", states_file.display(), expected.len())), "{out}");
        let found = read(&states_file);
        assert!(found.info.geometry().vane_position_m.iter().all(|x| x.abs() < 1e-300), "what it holds is at the centre of mass");
        assert_eq!(found.info.text("smoothed"), Some("over the whole record, at the centre of mass"));
        let others: Vec<&RecordingColumn> =
            found.columns.iter().filter(|column| column.target == RecordingTarget::Other).collect();
        let place = |name: &str| others.iter().position(|column| column.name == name).unwrap();
        assert_eq!(others[place("std_r_dot")].inner_unit(), "rad/s^2");
        assert_eq!(found.rows.len(), expected.len());
        let mut measured = recording.rows.iter();
        for (row, state) in found.rows.iter().zip(&expected) {
            assert_eq!(row.sample.time_s.to_bits(), state.time_s.to_bits());
            for (channel, value) in [
                (Channel::P, state.rates[0]),
                (Channel::R, state.rates[2]),
                (Channel::Ay, state.specific_force[1]),
                (Channel::Psi, state.attitude[2]),
                (Channel::Altitude, state.altitude),
            ] {
                assert_eq!(row.sample.get(channel).unwrap().to_bits(), value.to_bits(), "{channel:?}");
            }
            for (name, value) in [
                ("v", state.velocity[1]),
                ("r_dot", state.angular_acceleration[2]),
                ("std_v", state.velocity_std[1]),
                ("std_r_dot", state.angular_acceleration_std[2]),
                ("std_altitude", state.altitude_std),
                ("std_bias_ay", state.accelerometer_bias_std[1]),
            ] {
                assert_eq!(row.others[place(name)].unwrap().to_bits(), value.to_bits(), "{name}");
            }
            let [tas, beta] = [Channel::Tas, Channel::Beta].map(|channel| row.sample.get(channel).unwrap());
            assert!((tas * beta.sin() - state.velocity[1]).abs() < 1e-12 * tas);
            let sampled = measured.find(|row| row.sample.time_s >= state.time_s).unwrap();
            let pedal = |row: &RecordingRow| row.sample.get(Channel::Pedal).map(f64::to_bits);
            assert_eq!(pedal(row), pedal(sampled), "controls as they were sampled");
        }
        // A run like any other, and smoothing it gives a file of the same columns.
        let again = folder.join("again.csv");
        written(&[path(&states_file), "--smoothed", path(&again)]);
        assert_eq!(read(&again).columns.len(), found.columns.len());
    }
}

#[test]
fn what_no_instrument_measures_is_no_column() {
    let Some(file) = real("citation-2018-dutchroll.csv") else { return };
    let states = folder("smoothed-sparse").join("states.csv");
    written(&[path(&file), "--smoothed", path(&states)]);
    let names: Vec<String> = read(&states).columns.into_iter().map(|column| column.name).collect();
    for absent in ["ax", "std_ax", "bias_ay", "std_bias_az", "beta", "psi", "std_psi"] {
        assert!(!names.iter().any(|name| name == absent), "{absent}");
    }
    for present in ["time", "tas", "alpha", "u", "v", "std_v", "r", "std_r", "bias_r", "r_dot", "std_r_dot", "phi", "rudder"] {
        assert!(names.iter().any(|name| name == present), "{present}");
    }
}

#[test]
fn the_log_is_the_recording_with_its_smoothed_states_beside_it() {
    let file = folder("smoothed-log").join("states.mcap");
    written(&[path(&puma()), "--smoothed", path(&file)]);
    let (recording, back) = (read(&puma()), read(&file));
    let samples = |read: &Read| read.rows.iter().map(|row| row.sample).collect::<Vec<_>>();
    assert_eq!(format!("{:?}", samples(&back)), format!("{:?}", samples(&recording)));
    let expected = smoothed_by_the_library(&recording);
    let bytes = std::fs::read(&file).unwrap();
    let mut count = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        if message.channel.topic != "/smoothed" {
            continue;
        }
        let found: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        let state = &expected[count];
        assert_eq!(message.channel.schema.as_ref().unwrap().name, "sideslip.Smoothed");
        assert_eq!(found["time"], state.time_s);
        assert_eq!(found["r"], state.rates[2]);
        assert_eq!(found["std_r_dot"], state.angular_acceleration_std[2]);
        assert_eq!(found["lag"], expected[expected.len() - 1].time_s - state.time_s);
        count += 1;
    }
    assert_eq!(count, expected.len());
}

#[test]
fn several_recordings_have_a_file_each_in_a_directory() {
    let folder = folder("smoothed-several");
    let (other, states) = (folder.join("other.csv"), folder.join("states"));
    std::fs::copy(puma(), &other).unwrap();
    written(&[path(&puma()), path(&other), "--smoothed", path(&states)]);
    let mut names: Vec<_> = std::fs::read_dir(&states).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["other.csv", "puma-100kn-pedal-3211.csv"]);
}

#[test]
fn what_cannot_be_smoothed_is_refused_in_one_line_and_nothing_is_written() {
    let folder = folder("smoothed-refused");
    let text = std::fs::read_to_string(puma()).unwrap();
    let (blind, back) = (folder.join("blind.csv"), folder.join("back.csv"));
    std::fs::write(&blind, text.replace(",tas,", ",speed_unknown,")).unwrap();
    // The clock is set back by two seconds in the middle.
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let middle = lines.len() / 2;
    for line in &mut lines[middle..] {
        let (time, rest) = line.split_once(',').unwrap();
        *line = format!("{},{rest}", time.parse::<f64>().unwrap() - 4.0);
    }
    std::fs::write(&back, lines.join("\n")).unwrap();
    let standing = folder.join("standing.csv");
    std::fs::write(&standing, "kept").unwrap();
    let model = own("replay/models/puma.toml");
    for (args, expected) in [
        (vec![path(&blind), "--smoothed", path(&standing)], "blind.csv: --smoothed: expected `p`, `q` and `r` together, `tas`"),
        (vec![path(&back), "--smoothed", path(&standing)], "back.csv: --smoothed: expected time that increases for a text file"),
        (vec![path(&blind), "--smoothed", path(&blind)], "--smoothed: expected another file than the one that is read"),
        (vec![path(&blind), "--smoothed", "states.json"], "--smoothed: expected a name that ends in .csv or .mcap"),
        (vec![path(&blind), "--smoothed", "/no/where/states.csv"], "--smoothed: expected a folder /no/where, found none"),
        (vec![path(&blind), "--smoothed", "s.mcap", "--out", "s.mcap"], "expected another file than that of --out or --json"),
        (vec![path(&model), "--smoothed", path(&standing)], "puma.toml"),
    ] {
        let (status, _, said) = ended(&sideslip(&[&["replay", "--force"], args.as_slice()].concat()));
        assert_eq!(status, 2, "{said}");
        assert!(said.contains(expected) && said.trim_end().lines().count() == 1, "{said}");
    }
    assert_eq!(std::fs::read_to_string(&standing).unwrap(), "kept");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 3, "nothing half written");
}
