//! One grammar of recordings for every command that reads runs, and files of formats and maps that are none.

use super::chapter10_flight::{setup_of, with_setup};
use crate::support::program::{ended, folder, own, path, sideslip};
use crate::support::recorded_samples::{remaining_samples, samples_of};
use sideslip::flight::channel::Channel;
use sideslip::io::telemetry::logs::encode::ulog::UlogWriter;
use sideslip::io::telemetry::recording::Recording;
use std::path::{Path, PathBuf};

/// The same flight as a run file and as PCM.
fn flown(name: &str, rate: &str) -> (PathBuf, PathBuf) {
    let folder = folder(name);
    let [csv, pcm] = ["csv", "pcm"].map(|ending| {
        let file = folder.join(format!("run.{ending}"));
        let call = ["simulate", "--model", "puma", "--noise", "--rate", rate, "--duration", "20", "--out", path(&file)];
        let inputs = ["--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:3211:0.008:0.5:9"];
        let (status, _, said) = ended(&sideslip(&[&call[..], &inputs].concat()));
        assert_eq!(status, 0, "{said}");
        file
    });
    (csv, pcm)
}

fn url(pcm: &Path) -> String {
    format!("pcm+file://{0}?format={0}.toml", pcm.display())
}

#[test]
fn every_command_reads_the_url_of_a_recording() {
    let (csv, pcm) = flown("sources-urls", "64");
    let (by_path, by_url) = (format!("file://{}", csv.display()), url(&pcm));
    let model = own("replay/models/puma-like.toml");
    let out = pcm.with_file_name("again.csv");
    for source in [by_path.as_str(), by_url.as_str()] {
        for call in [
            &["replay", source][..],
            &["replay", source, "--bus"],
            &["check", source],
            &["identify", source],
            &["inspect", source],
            &["compare", source, "--model", path(&model)],
            &["convert", source, path(&out), "--force"],
            &["simulate", "--model", path(&model), "--controls", source, "--out", path(&out), "--force"],
        ] {
            let (status, _, said) = ended(&sideslip(call));
            assert!(status == 0 || (call[0] == "check" && status == 4), "{call:?}: {status} {said}");
        }
    }
    let call = ["diagnose", "--model", path(&model), "--fit", by_path.as_str(), "--holdout", by_path.as_str()];
    let (status, _, said) = ended(&sideslip(&call));
    assert!(status == 2 && said.contains("not fitted"), "{said}");
    let (status, _, said) = ended(&sideslip(&["replay", "udpin://127.0.0.1:14550"]));
    assert!(status == 2 && said.contains("expected a recording"), "{said}");
    let (status, _, said) = ended(&sideslip(&["check", "pcm+file://run.pcm"]));
    assert!(status == 2 && said.contains("needs the format of its frames"), "{said}");
    // Named by its file, not by its URL.
    let log = pcm.with_file_name("logs");
    let (status, _, said) = ended(&sideslip(&["replay", &by_url, "--out", &format!("{}/", path(&log))]));
    assert!(status == 0 && log.join("run.mcap").exists(), "{said}");
}

#[test]
fn at_slow_rates_the_words_of_an_instant_are_one_row_of_pcm() {
    for rate in ["10", "50"] {
        let (csv, pcm) = flown(&format!("sources-slow-{rate}"), rate);
        let sent = samples_of(&csv);
        let format = pcm.with_extension("pcm.toml");
        let got = remaining_samples(&mut Recording::open_pcm(&pcm, &format).unwrap());
        assert_eq!(got.len(), sent.len(), "{rate} Hz");
        for (sent, got) in sent.iter().zip(&got) {
            assert!(sent.present == got.present && (0.0..0.5e-3).contains(&(got.time_s - sent.time_s)), "{rate} Hz: {got:?}");
        }
    }
}

#[test]
fn a_format_or_a_map_that_is_no_text_is_a_wrong_call() {
    let (_, pcm) = flown("sources-formats", "64");
    let folder = pcm.parent().unwrap();
    let latin = folder.join("latin.toml");
    std::fs::write(&latin, b"name = \"Z\xfcrich\"").unwrap();
    for (file, expected) in [(path(folder), "cannot be read"), ("/dev/zero", "at most 16 MiB"), (path(&latin), "UTF-8")] {
        for call in [
            &["inspect", &format!("pcm+file://{}?format={file}", pcm.display())][..],
            &["replay", path(&pcm), "--config", file],
            &["linearise", "--model", file],
        ] {
            let (status, _, said) = ended(&sideslip(call));
            assert!(status == 2 && (said.contains(expected) || said.contains("model file")), "{call:?}: {status} {said}");
        }
    }
}

#[test]
fn measurements_that_are_not_read_are_told_by_every_command() {
    let folder = folder("sources-left-out");
    let file = folder.join("run.ch10");
    let text = setup_of();
    let from = text.find("\\CO-1:").map(|at| &text[at..at + text[at..].find(';').unwrap() + 1]).unwrap();
    std::fs::write(&file, with_setup(&text.replacen(from, "\\CO-1:;", 1), 2000)).unwrap();
    let out = folder.join("run.csv");
    for call in
        [&["convert", path(&file), path(&out)][..], &["replay", path(&file)], &["check", path(&file)], &["inspect", path(&file)]]
    {
        let (_, told, said) = ended(&sideslip(call));
        assert!((told + &said).contains("coefficient CO-1: expected a number, found none"), "{call:?}: {said}");
    }
    let from = text.find("\\BFM:").map(|at| &text[at..at + text[at..].find(';').unwrap() + 1]).unwrap();
    std::fs::write(&file, with_setup(&text.replacen(from, "\\BFM:;", 1), 2000)).unwrap();
    for call in [&["check", path(&file)][..], &["inspect", path(&file)]] {
        let (_, told, said) = ended(&sideslip(call));
        assert!((told + &said).contains("no binary format (BFM of its group C): read as unsigned"), "{call:?}: {said}");
    }
}

#[test]
fn two_drivers_of_outputs_do_not_share_a_column() {
    let file = folder("sources-ulog").join("two.ulg");
    let mut log = UlogWriter::new(0);
    log.format("actuator_outputs:uint64_t timestamp;uint32_t noutputs;float[16] output;").unwrap();
    log.format("actuator_motors:uint64_t timestamp;float[12] control;").unwrap();
    log.format(
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;int32_t accelerometer_timestamp_relative;\
         float[3] accelerometer_m_s2;uint8_t[4] _padding0;",
    )
    .unwrap();
    for (id, (instance, topic)) in (0..).zip([
        (0, "sensor_combined"),
        (0, "actuator_outputs"),
        (1, "actuator_outputs"),
        (0, "actuator_motors"),
        (1, "actuator_motors"),
    ]) {
        log.subscribe(instance, id, topic).unwrap();
    }
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    for at in 0..200_u64 {
        let time = (at * 10_000).to_le_bytes();
        log.data(0, &[&time, &floats(&[0.1; 3]), &[0; 4], &floats(&[0.0, 0.0, -9.8]), &[0; 4]]).unwrap();
        for (id, of) in [(1, 1100.0), (2, 1900.0)] {
            log.data(id, &[&time, &4_u32.to_le_bytes(), &floats(&[of; 16])]).unwrap();
        }
        for (id, of) in [(3, 0.25), (4, 0.75)] {
            log.data(id, &[&time, &floats(&[of; 12])]).unwrap();
        }
    }
    std::fs::write(&file, log.bytes()).unwrap();
    let mut recording = Recording::open(&file).unwrap();
    let others: Vec<String> = recording.columns().iter().map(|column| column.name.clone()).collect();
    let known = others.iter().filter(|name| *name == "time" || Channel::from_name(name).is_some()).count();
    let place = |name: &str| others.iter().position(|other| other == name).unwrap() - known;
    let mut rows = 0;
    while let Some(row) = recording.next_row().unwrap() {
        for (name, expected) in [("output_1", 1100.0), ("second_output_4", 1900.0), ("motor_2", 0.25)] {
            assert_eq!(row.others[place(name)], Some(expected), "{name}");
        }
        rows += 1;
    }
    assert!(rows == 200 && !others.contains(&"output_5".to_owned()), "{rows} {others:?}");
    assert_eq!(recording.shortfall(), None);
}

#[test]
fn what_a_log_does_not_say_of_the_instruments_is_told() {
    let file = folder("sources-geometry").join("run.bin");
    let model = own("replay/models/puma-like.toml");
    let call = ["simulate", "--model", path(&model), "--input", "pedal:doublet:0.02:1", "--set", "vane_position_m=[1.5,0,0]"];
    let (status, _, said) = ended(&sideslip(&[&call[..], &["--out", path(&file)]].concat()));
    assert!(status == 0 && said.contains("--set vane_position_m=[1.5,0,0]"), "{said}");
}

#[test]
fn rows_whose_time_does_not_grow_are_told_where_they_are_not_put_in_order() {
    let folder = folder("sources-order");
    let (file, out) = (folder.join("run.csv"), folder.join("out.csv"));
    let rows = (0..200).map(|at| format!("{},{}\n", if at == 100 { 0.5 } else { f64::from(at) * 0.02 }, at));
    std::fs::write(&file, format!("time,p\n{}", rows.collect::<String>())).unwrap();
    let converted = |more: &[&str]| ended(&sideslip(&[&["convert", path(&file), path(&out), "--force"], more].concat()));
    let (status, _, said) = converted(&[]);
    assert!(status == 3 && said.contains("1 rows whose time does not grow"), "{said}");
    let (_, _, said) = converted(&["--set", "latency_s={}"]);
    assert!(!said.contains("does not grow"), "{said}");
}
