//! MAVLink as a user meets it: slow telemetry, damaged logs, strange configurations, controls that do not fit.

use crate::support::program::{ended, folder, own, path, puma, replayed, sideslip, warns};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A simulated flight as tlog, in a folder of its own.
fn flown(name: &str, more: &[&str]) -> PathBuf {
    let file = folder(name).join("run.tlog");
    let model = own("replay/models/puma-like.toml");
    let mut args = vec!["simulate", "--model", path(&model), "--out", path(&file), "--noise", "flight"];
    args.extend(["--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:3211:0.008:0.5:7"]);
    args.extend(more);
    let (status, _, said) = ended(&sideslip(&args));
    assert_eq!(status, 0, "{said}");
    file
}

fn inspected(file: &Path, more: &[&str]) -> (i32, Value, String) {
    let mut args = vec!["inspect", path(file), "--json", "-"];
    args.extend(more);
    let (status, out, said) = ended(&sideslip(&args));
    (status, serde_json::from_str(&out).unwrap_or_default(), said)
}

#[test]
fn real_telemetry_is_too_slow_and_it_is_said() {
    let root = std::env::var_os("SIDESLIP_DATA").map_or_else(|| own("../shared/data"), PathBuf::from);
    for (name, hz, status) in [("plane-canberra", 1.0, 4), ("quad-dronekit-v1", 2.9, 4), ("vtol-sitl-v1", 4.2, 4)] {
        let file = root.join("mavlink").join(format!("{name}.tlog"));
        if !file.is_file() {
            eprintln!("SKIPPED: no recording {}", file.display());
            continue;
        }
        let (ended_with, table, said) = ended(&sideslip(&["replay", path(&file)]));
        assert_eq!(ended_with, status, "{said}");
        let (_, after) = table.split_once("the rates come at ").unwrap_or_else(|| panic!("{table}"));
        let (found, _) = after.split_once(" Hz, derivatives need 8 Hz").unwrap_or_else(|| panic!("{table}"));
        // A running mean beside the median interval of the whole log.
        assert!((found.parse::<f64>().unwrap() / hz - 1.0_f64).abs() < 0.15, "{found} Hz, {hz} Hz expected");
    }
}

#[test]
fn damage_costs_what_is_damaged_and_is_counted() {
    let file = flown("mavlink-damage", &[]);
    let (status, whole, said) = inspected(&file, &[]);
    assert_eq!(status, 0, "{said}");
    let mut bytes = std::fs::read(&file).unwrap();
    // Far from each other: a frame with a wrong byte, two bytes lost, a burst of noise; and the end cut off.
    bytes[40_015] ^= 0x10;
    bytes.drain(80_000..80_002);
    bytes.splice(120_000..120_000, (0..100).map(|i| (i * 37) as u8 | 0xFC));
    bytes.truncate(bytes.len() - 5);
    std::fs::write(&file, &bytes).unwrap();
    let (status, damaged, said) = inspected(&file, &[]);
    assert!(status == 3 && said.contains("passed over"), "{said}");
    let lost = whole["messages"]["total"].as_u64().unwrap() - damaged["messages"]["total"].as_u64().unwrap();
    assert!((3..=4).contains(&lost), "{lost} frames lost");
    let (status, run, said) = replayed(&file, &[]);
    assert!(status == 3 && warns(&run, &["passed over"]) && run["modes"]["dutch_roll"]["omega"].is_number(), "{said}");
}

#[test]
fn a_configuration_changes_the_channels_and_a_wrong_one_is_refused_with_its_place() {
    let file = flown("mavlink-config", &[]);
    let config = file.with_file_name("config.toml");
    std::fs::write(&config, "aircraft = \"fixed_wing\"\n[sources]\nflow_angles = []\n[controls.rudder]\nfull_deg = -10\n")
        .unwrap();
    let (status, seen, said) = inspected(&file, &["--config", path(&config)]);
    assert_eq!(status, 0, "{said}");
    let named = |answer: &Value, name: &str| {
        let channels = answer["channels"].as_array().unwrap().clone();
        channels.into_iter().find(|channel| channel["name"] == name)
    };
    assert!(named(&seen, "beta").is_none() && named(&seen, "pedal").is_none());
    let (_, plain, _) = inspected(&file, &[]);
    let least = named(&plain, "pedal").unwrap()["min"].as_f64().unwrap();
    let most = named(&seen, "rudder").unwrap()["max"].as_f64().unwrap();
    assert!((most + least).abs() < 1e-15, "{most} is not {least} turned about");
    std::fs::write(&config, "[sources]\nairspeed = [\"GPS\"]\n").unwrap();
    for command in ["inspect", "replay"] {
        let (status, _, said) = ended(&sideslip(&[command, path(&file), "--config", path(&config)]));
        assert!(status == 2 && said.contains("config.toml:2:13:") && said.contains("AIRSPEED, VFR_HUD"), "{said}");
    }
}

#[test]
fn a_file_without_motion_is_refused_with_who_is_in_it() {
    let bytes = std::fs::read(flown("mavlink-nobody", &["--duration", "1"])).unwrap();
    let file = folder("mavlink-heartbeat").join("quiet.tlog");
    // The first record of every flight is its heartbeat: 8 bytes of stamp, 21 of frame.
    std::fs::write(&file, bytes[..29].repeat(3)).unwrap();
    let (status, _, said) = inspected(&file, &[]);
    assert!(status == 2 && said.contains("found none in 3 messages of 1/1"), "{said}");
}

#[test]
fn frames_without_stamps_are_read_too() {
    let bytes = std::fs::read(flown("mavlink-bare", &["--duration", "1"])).unwrap();
    let (mut bare, mut rest) = (Vec::new(), &bytes[..]);
    while let Some((frame, after)) = rest.get(8..).and_then(|rest| rest.split_at_checked(12 + usize::from(rest[1]))) {
        bare.extend_from_slice(frame);
        rest = after;
    }
    let file = folder("mavlink-stream").join("capture.bin");
    std::fs::write(&file, bare).unwrap();
    let (status, seen, said) = inspected(&file, &[]);
    assert!(status == 0 && seen["format"] == "MAVLink stream" && seen["rows"] == 101, "{said}");
}

#[test]
fn a_control_that_is_no_pulse_is_refused_and_nothing_is_written() {
    let out = folder("mavlink-pulse").join("run.tlog");
    let model = own("replay/models/puma-like.toml");
    let args = ["simulate", "--model", path(&model), "--input", "pedal:step:-0.6:0.05", "--out", path(&out)];
    let (status, _, said) = ended(&sideslip(&args));
    assert!(status == 2 && said.contains("pulse of 1 to 65534 us for pedal") && !out.exists(), "{status} {said}");
}

#[test]
fn the_same_flight_gives_the_same_bytes() {
    let [one, two] = ["mavlink-same-1", "mavlink-same-2"].map(|name| std::fs::read(flown(name, &[])).unwrap());
    assert!(one == two && one.len() > 100_000);
    assert!(puma().is_file());
}

/// The scale of a control, wherever controls are shown: assumed where nobody states it, and known where `--config` does.
#[test]
fn the_scale_of_controls_is_said_to_be_assumed_until_it_is_stated() {
    let file = flown("mavlink-scale", &["--duration", "12"]);
    let folder = file.parent().unwrap();
    let (config, csv, json) = (folder.join("scale.toml"), folder.join("run.csv"), folder.join("answer.json"));
    let names = ["lon_cyclic", "lat_cyclic", "collective", "pedal"];
    let stated: String = names.iter().map(|name| format!("[controls.{name}]\nfull_us = 500\nfull_deg = 10\n")).collect();
    std::fs::write(&config, stated).unwrap();
    let assumed = "per unit of command, scale assumed";
    for command in ["inspect", "check", "replay", "identify"] {
        let (status, out, said) = ended(&sideslip(&[command, path(&file), "--json", path(&json), "--force"]));
        assert!(matches!(status, 0 | 3 | 4), "{command}: {said}");
        assert!((out + &said).contains(assumed), "{command}: {said}");
        let (_, out, said) =
            ended(&sideslip(&[command, path(&file), "--config", path(&config), "--json", path(&json), "--force"]));
        assert!(!(out + &said).contains("assumed"), "{command}: {said}");
    }
    // Who converts it does not lose it, and may state it there.
    let (status, _, said) = ended(&sideslip(&["convert", path(&file), path(&csv)]));
    assert!(status == 0 && said.contains("the scale of lon_cyclic, lat_cyclic, collective, pedal is assumed"), "{said}");
    let (_, out, said) = ended(&sideslip(&["inspect", path(&csv)]));
    assert!(out.contains(assumed) && out.contains("scale assumed"), "{out}{said}");
    let (status, _, said) = ended(&sideslip(&["identify", path(&csv), "--out", path(&folder.join("report"))]));
    assert!(matches!(status, 0 | 3), "{said}");
    let page = std::fs::read_to_string(folder.join("report/report.html")).unwrap();
    let table = page.split_once("<table aria-label=\"Derivatives\">").unwrap().1.split_once("</table>").unwrap().0;
    assert!(table.contains(assumed) && page.contains("derivatives by ") && page.matches(assumed).count() > 2, "{table}");
    let (_, out, said) = ended(&sideslip(&["identify", path(&csv), "--set", "assumed_scale=[]"]));
    assert!(!(out + &said).contains("assumed"), "{said}");
}

/// Every key of the file of `--config`, in `--help` and in the guide, whose example is one.
#[test]
fn every_key_of_the_configuration_is_documented_and_the_guide_s_example_is_read() {
    let (status, help, said) = ended(&sideslip(&["check", "--help"]));
    assert_eq!(status, 0, "{said}");
    let guide = std::fs::read_to_string(own("src/guide/use.md")).unwrap();
    let example = guide.split("```toml\n").filter_map(|part| part.split("```").next()).find(|text| text.contains("[controls."));
    let example = example.unwrap();
    let keys = ["system", "component", "aircraft", "reorder_ms", "channel", "zero_us", "full_us", "full_deg", "sensor", "ratio"];
    let sources = ["specific_force", "rates", "attitude", "airspeed", "flow_angles", "altitude", "controls", "rotor_speed"];
    for key in keys.iter().chain(&sources) {
        assert!(help.contains(key) && example.contains(key), "{key}");
    }
    let read = sideslip::io::telemetry::mavlink::mapping::MavlinkConfig::from_toml(example).unwrap();
    assert_eq!((read.system, read.rotor_ratio, read.assumed_scale()), (Some(1), 0.1, [true, true, true, false]));
}
