//! A simulated Puma flight as a log of ArduPilot, of PX4 and as PCM, against the run file of the same flight.

use super::derivatives::{Apart, apart, derivatives};
use crate::support::program::{ended, folder, own, path, sideslip};
use crate::support::recorded_samples::remaining_samples;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::recording::Recording;
use sideslip::realtime::regression::record::DerivativesRecord;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Flies the same flight into a file of each ending.
fn flown(name: &str, endings: &[&str], more: &[&str]) -> Vec<PathBuf> {
    let folder = folder(&format!("simulated-logs-{name}"));
    let files = endings.iter().map(|ending| folder.join(format!("run.{ending}"))).collect::<Vec<_>>();
    for file in &files {
        let mut call = vec!["simulate", "--model", "puma", "--noise", "--seed", "7", "--out", path(file)];
        call.extend(["--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:3211:0.008:0.5:7", "--duration", "22"]);
        call.extend(more);
        let (status, _, said) = ended(&sideslip(&call));
        assert_eq!(status, 0, "{said}");
    }
    files
}

fn samples(file: &Path) -> Vec<Sample> {
    let mut recording = if file.extension().is_some_and(|ending| ending == "pcm") {
        Recording::open_pcm(file, &file.with_extension("pcm.toml")).unwrap()
    } else {
        Recording::open(file).unwrap()
    };
    let samples = remaining_samples(&mut recording);
    // Dropouts are words that are no number.
    assert!(recording.shortfall().is_none_or(|what| what.ends_with("samples without a value left out")));
    samples
}

fn estimated(file: &Path) -> DerivativesRecord {
    derivatives(&samples(file))
}

fn against_text(name: &str, endings: &[&str], more: &[&str]) -> Vec<(String, Apart)> {
    let files = flown(name, &[&["csv"], endings].concat(), more);
    let text = estimated(&files[0]);
    let compared = files[1..].iter().zip(endings).map(|(file, ending)| {
        let found = apart(&text, &estimated(file));
        eprintln!("{name}, {ending}: {found:?}");
        ((*ending).to_owned(), found)
    });
    compared.collect()
}

#[test]
fn at_rates_that_every_log_keeps_the_derivatives_are_those_of_the_run_file() {
    // What is left: of ArduPilot's log pulse widths of whole microseconds, of PCM the places of the words in their frame.
    for (ending, found) in against_text("same-rates", &["bin", "ulg", "pcm"], &["--rate", "50"]) {
        assert!(found.compared > 12 && found.largest < 0.25 && found.different.is_empty(), "{ending}: {found:?}");
    }
}

#[test]
fn where_a_logger_keeps_fewer_samples_the_derivatives_differ_by_less_than_a_standard_error() {
    // Attitude, air data and controls are logged at 50 Hz at most: what the run file has beyond is not in the logs.
    for rate in ["100", "250"] {
        for (ending, found) in against_text(&format!("rate-{rate}"), &["bin", "ulg", "pcm"], &["--rate", rate]) {
            let bound = if ending == "pcm" { 0.1 } else { 1.0 };
            assert!(found.compared > 12 && found.largest < bound, "{rate} Hz, {ending}: {found:?}");
            assert!((0.8..1.25).contains(&found.std_ratio), "{rate} Hz, {ending}: {found:?}");
            assert!(ending != "pcm" || found.different.is_empty(), "{rate} Hz: {found:?}");
        }
    }
}

/// The instruments of a small aircraft with an autopilot: everything but the inertial unit and the controls at a rate of its own.
fn autopilot(file: &Path, inertial_hz: f64, flow_hz: f64, airspeed_hz: f64, pressure_hz: f64) {
    let mut text = format!("rate_hz = {inertial_hz}\n");
    for (channels, rate_hz) in [
        (&["phi", "theta", "psi", "lon_cyclic", "lat_cyclic", "collective", "pedal", "rotor_speed"][..], 50.0),
        (&["alpha", "beta"], flow_hz),
        (&["tas"], airspeed_hz),
        (&["altitude"], pressure_hz),
    ] {
        for channel in channels {
            text += &format!("[channel.{channel}]\nrate_hz = {rate_hz}\n");
        }
    }
    std::fs::write(file, text).unwrap();
}

#[test]
fn inertial_measurements_and_air_data_at_rates_of_their_own_have_the_derivatives_of_the_run_file() {
    // The logger keeps every sample of these instruments, so that the same measurements are in each file. PX4 writes its
    // inertial messages 250 times a second at most.
    for (inertial_hz, flow_hz, airspeed_hz, pressure_hz, endings) in [
        (50.0, 25.0, 10.0, 10.0, &["bin", "ulg"][..]),
        (200.0, 50.0, 10.0, 25.0, &["bin", "ulg"]),
        (400.0, 50.0, 50.0, 50.0, &["bin"]),
    ] {
        let name = format!("autopilot-{inertial_hz}");
        let instruments = folder(&format!("{name}-instruments")).join("autopilot.toml");
        autopilot(&instruments, inertial_hz, flow_hz, airspeed_hz, pressure_hz);
        for (ending, found) in against_text(&name, endings, &["--instruments", path(&instruments)]) {
            assert!(
                found.compared > 12 && found.largest < 0.25 && found.different.is_empty(),
                "{inertial_hz} Hz, {ending}: {found:?}"
            );
        }
    }
}

#[test]
fn instruments_of_several_rates_keep_them_in_pcm() {
    let instruments = own("replay/instruments/flight-test.toml");
    for (_, found) in against_text("instruments", &["pcm"], &["--instruments", path(&instruments)]) {
        assert!(found.compared >= 12 && found.largest < 0.25 && found.different.is_empty(), "{found:?}");
    }
}

/// A folder that holds both readers; `None`, said loudly, where they cannot be installed.
fn readers() -> Option<PathBuf> {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("log-readers");
    let there = || {
        let mut tried = Command::new("python3");
        tried.args(["-c", "from pymavlink import DFReader; from pyulog import ULog"]);
        tried.env("PYTHONPATH", &place).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    };
    if !there() {
        let install = ["-m", "pip", "install", "--quiet", "--target", path(&place), "pymavlink==2.4.50", "pyulog==1.3.0"];
        let _ = Command::new("python3").args(install).stdout(Stdio::null()).stderr(Stdio::null()).status();
    }
    let found = there();
    if !found {
        eprintln!("SKIPPED: pymavlink and pyulog cannot be installed by pip");
    }
    found.then_some(place)
}

#[test]
fn pymavlink_and_pyulog_read_every_value_of_the_flight() {
    let Some(readers) = readers() else { return };
    let files = flown("peers", &["csv", "bin", "ulg"], &[]);
    let mut peer = Command::new("python3");
    peer.arg(own("tests/telemetry/peer_flight.py")).args(&files).env("PYTHONPATH", readers);
    let (status, out, said) = ended(&peer.output().unwrap());
    assert_eq!(status, 0, "{said}");
    eprint!("{out}");
    let lines: Vec<Vec<&str>> = out.lines().map(|line| line.split(' ').collect()).collect();
    assert_eq!(lines.len(), 2 * 18, "{out}");
    for line in lines {
        let [log, channel, count, largest] = line[..] else { panic!("{line:?}") };
        let (count, largest): (u32, f64) = (count.parse().unwrap(), largest.parse().unwrap());
        let inertial = ["p", "q", "r", "ax", "ay", "az"].contains(&channel);
        assert_eq!(count, if inertial { 2201 } else { 1101 }, "{log} {channel}");
        // A pulse is a whole number of microseconds of 0.02 degrees; pressures are of single precision.
        let bound = match (log, channel) {
            ("bin", "lon_cyclic" | "lat_cyclic" | "collective" | "pedal") => 0.01_f64.to_radians() * 1.0001,
            (_, "altitude") => 1e-3,
            _ => 5e-6,
        };
        assert!(largest <= bound, "{log} {channel}: {largest}");
    }
}

#[test]
fn a_recording_that_cannot_be_written_is_refused() {
    let folder = folder("simulated-logs-refused");
    let out = folder.join("run.ulog");
    let call = ["simulate", "--model", "puma", "--input", "pedal:doublet:0.02:1", "--out", path(&out)];
    let (status, _, said) = ended(&sideslip(&call));
    assert!(status == 2 && said.contains(".bin, .ulg or .pcm"), "{said}");
    // The format of the frames goes beside the stream, never over a file that is read.
    let model = folder.join("run.pcm.toml");
    std::fs::copy(own("replay/models/puma-like.toml"), &model).unwrap();
    let out = folder.join("run.pcm");
    let call = ["simulate", "--model", path(&model), "--input", "pedal:doublet:0.02:1", "--out", path(&out)];
    let (status, _, said) = ended(&sideslip(&call));
    assert!(status == 2 && said.contains("expected another file"), "{said}");
    assert!(!out.exists());
}
