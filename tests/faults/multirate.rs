//! Channels that come at times of their own, stop, begin late or stand elsewhere: the numbers stay right, or there are none.

use crate::support::program::{RunFile, ended, folder, own, path, puma, replayed, sideslip, warns};
use serde_json::Value;
use std::path::PathBuf;

const CONTROLS: [&str; 4] = ["lon_cyclic", "lat_cyclic", "collective", "pedal"];
const FORCES: [&str; 3] = ["ax", "ay", "az"];
const RATES: [&str; 3] = ["p", "q", "r"];

/// The bundled recording, changed and written into a folder of its own.
fn changed(name: &str, change: impl FnOnce(&mut RunFile)) -> PathBuf {
    let mut run = RunFile::read(&puma());
    change(&mut run);
    let file = folder(&format!("multirate-{name}")).join("run.csv");
    run.write(&file);
    file
}

/// These channels half an interval later than the others, on the straight line between their samples.
fn half_an_interval_later(run: &mut RunFile, channels: &[&str]) {
    let places: Vec<usize> = channels.iter().map(|channel| run.place(channel)).collect();
    let mut rows = Vec::new();
    for pair in run.rows.windows(2) {
        let number = |row: &[String], place: usize| row[place].parse::<f64>().unwrap();
        let (mut others, mut own) = (pair[0].clone(), vec![String::new(); pair[0].len()]);
        own[0] = (0.5 * (number(&pair[0], 0) + number(&pair[1], 0))).to_string();
        for &place in &places {
            own[place] = (0.5 * (number(&pair[0], place) + number(&pair[1], place))).to_string();
            others[place].clear();
        }
        rows.extend([others, own]);
    }
    run.rows = rows;
}

/// Without these channels in those rows.
fn silenced(run: &mut RunFile, channels: &[&str], rows: std::ops::Range<usize>) {
    for channel in channels {
        let place = run.place(channel);
        run.rows[rows.clone()].iter_mut().for_each(|row| row[place].clear());
    }
}

/// The Dutch roll of the model behind the recording, -0.155 +- 1.043i, near enough.
fn is_right(run: &Value) {
    let pair = &run["modes"]["dutch_roll"];
    let (omega, zeta) = (pair["omega"].as_f64().unwrap(), pair["zeta"].as_f64().unwrap());
    assert!((omega - 1.0545).abs() < 0.012 && (zeta - 0.147).abs() < 0.008, "{pair}");
}

/// A derivative of the model behind the recording.
fn known(axis: &str, variable: &str) -> f64 {
    let model: toml::Table = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap().parse().unwrap();
    model["derivatives"][axis][variable].as_float().unwrap()
}

fn status(run: &Value, axis: &str) -> String {
    run["equations"][axis]["status"].as_str().unwrap().to_owned()
}

#[test]
fn controls_and_accelerometers_at_times_of_their_own_give_the_same_dutch_roll() {
    for (name, channels) in [("controls", CONTROLS.as_slice()), ("forces", &FORCES), ("vane", &["beta", "tas"])] {
        let (exit, run, said) = replayed(&changed(name, |run| half_an_interval_later(run, channels)), &[]);
        assert_eq!(exit, 0, "{said}");
        is_right(&run);
        let terms = run["equations"]["N"]["terms"].as_array().unwrap();
        let pedal = terms.iter().find(|term| term["name"] == "N_pedal").unwrap_or_else(|| panic!("{name}: {terms:?}"));
        assert!((pedal["value"].as_f64().unwrap() + 9.87).abs() < 0.3, "{name}: {pedal}");
    }
}

#[test]
fn a_rate_on_rows_of_its_own_is_as_good_as_one_beside_the_others() {
    let (exit, run, said) = replayed(&changed("q", |run| half_an_interval_later(run, &["q"])), &[]);
    assert_eq!(exit, 0, "{said}");
    is_right(&run);
}

#[test]
fn a_channel_that_stops_is_said_and_changes_no_number() {
    for (name, channels) in [("ay", ["ay"].as_slice()), ("pedal", &["pedal"]), ("rates", &RATES)] {
        let file = changed(&format!("stops-{name}"), |run| silenced(run, channels, 600..1251));
        let (exit, run, said) = replayed(&file, &[]);
        assert_eq!(exit, 0, "{said}");
        let said = if name == "rates" { ["p, q and r", "silent"] } else { [channels[0], "silent"] };
        assert!(warns(&run, &said), "{name}: {}", run["warnings"]);
        assert_eq!((status(&run, "Y"), status(&run, "N")), ("stale".into(), "stale".into()), "{name}");
        is_right(&run);
    }
}

#[test]
fn an_accelerometer_that_begins_late_has_no_trim_and_no_number() {
    let (exit, run, said) = replayed(&changed("late", |run| silenced(run, &["ay"], 0..300)), &[]);
    assert_eq!(exit, 0, "{said}");
    assert!(status(&run, "Y").starts_with("not identifiable") && run["modes"]["dutch_roll"].is_null(), "{}", run["modes"]);
    let terms = run["equations"]["N"]["terms"].as_array().unwrap();
    assert!(terms.iter().any(|term| term["name"] == "N_v"), "yaw does not need it: {terms:?}");
}

#[test]
fn accelerometers_away_from_the_centre_of_mass_are_no_fault_of_the_vanes() {
    let flown = folder("multirate-position").join("run.csv");
    let model = own("replay/models/puma-like.toml");
    let args = ["simulate", "--model", path(&model), "--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:doublet:0.01:1:14"];
    let more = ["--rate", "50", "--noise", "flight", "--set", "accelerometer_position_m=[6,0,1]", "--out", path(&flown)];
    assert_eq!(ended(&sideslip(&[args.as_slice(), &more].concat())).0, 0);
    let (_, run, _) = replayed(&flown, &[]);
    assert!(!warns(&run, &["is inconsistent with the motion"]), "{}", run["warnings"]);
    is_right(&run);
    // Force at the centre of mass and velocity there, whatever the accelerometers' place: the model's own derivatives.
    for (axis, variable) in [("Y", "v"), ("Y", "pedal"), ("L", "v"), ("Z", "w")] {
        let (name, known) = (format!("{axis}_{variable}"), known(axis, variable));
        let terms = run["equations"][axis]["terms"].as_array().unwrap();
        let term = terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{name}: {terms:?}"));
        let (value, std) = (term["value"].as_f64().unwrap(), term["std"].as_f64().unwrap());
        assert!((value - known).abs() < 4.0 * std + 0.03 * known.abs(), "{name}: {value} +- {std}, the model has {known}");
    }
    let (_, run, _) = replayed(&flown, &["--set", "accelerometer_position_m=[0,0,0]"]);
    assert!(warns(&run, &["is inconsistent with the motion"]), "taken for somewhere else: {}", run["warnings"]);
}

#[test]
fn a_recording_that_becomes_unreadable_leaves_a_whole_log_of_what_came_before() {
    let file = changed("unreadable", |run| {
        run.rows.truncate(500);
        run.rows.push(vec!["1".repeat(3 << 20)]);
    });
    let log = file.with_file_name("run.mcap");
    let (exit, _, said) = replayed(&file, &["--out", path(&log)]);
    assert!(exit == 2 && said.contains("found a longer one"), "{said}");
    let (exit, answer, said) = ended(&sideslip(&["inspect", path(&log), "--json", "-"]));
    assert_eq!(exit, 0, "the log has its end: {said}");
    assert_eq!(serde_json::from_str::<Value>(&answer).unwrap()["rows"], 500);
}
