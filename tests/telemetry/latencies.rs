//! A simulated Puma flight whose airspeed and sideslip were stamped late: with `latency_s` the derivatives are those of the
//! flight without lateness, wherever the key stands, and without it they are not.

use super::derivatives::{apart, derivatives};
use crate::support::program::{ended, folder, path, sideslip};
use crate::support::recorded_samples::samples_of;
use std::path::{Path, PathBuf};

/// At 100 Hz whole rows.
const LATENCIES: &str = "{ tas = 0.25, beta = 0.2 }";
const LATE_ROWS: [(&str, usize); 2] = [("tas", 25), ("beta", 20)];

/// Flies a flight and writes it three times: as it was; with these channels late, `head` in its preamble; and as it was but for
/// the last samples of these channels, which a late recording does not have.
fn flown(folder: &Path, head: &str) -> [PathBuf; 3] {
    let [straight, late, shortened] = ["straight.csv", "late.csv", "shortened.csv"].map(|name| folder.join(name));
    let mut call = vec!["simulate", "--model", "puma", "--noise", "--seed", "7", "--rate", "100", "--out", path(&straight)];
    call.extend(["--input", "pedal:3211:0.01:0.7", "--input", "lat_cyclic:3211:0.005:0.5:7", "--duration", "22"]);
    let (status, _, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    let text = std::fs::read_to_string(&straight).unwrap();
    let (preamble, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    let cells: Vec<Vec<&str>> = rows.iter().map(|row| row.split(',').collect()).collect();
    let places = LATE_ROWS.map(|(name, by)| (cells[0].iter().position(|cell| cell.split(' ').next() == Some(name)).unwrap(), by));
    let preamble = preamble.iter().map(|line| format!("{line}\n")).collect::<String>();
    // The row whose cell stands in a row of a channel that is late by so many; none beyond an end of the flight.
    let write = |file: &Path, head: &str, taken: &dyn Fn(usize, usize) -> Option<usize>| {
        let mut written = format!("{preamble}{head}");
        for (number, row) in cells.iter().enumerate() {
            let cell = |(place, cell): (usize, &&str)| match places.iter().find(|(late, _)| *late == place && number > 0) {
                None => (*cell).to_owned(),
                Some((_, by)) => taken(number, *by).map_or(String::new(), |number| cells[number][place].to_owned()),
            };
            written += &(row.iter().enumerate().map(cell).collect::<Vec<_>>().join(",") + "\n");
        }
        std::fs::write(file, written).unwrap();
    };
    write(&late, head, &|number, by| number.checked_sub(by).filter(|number| *number > 0));
    write(&shortened, "", &|number, by| Some(number).filter(|number| number + by < cells.len()));
    [straight, late, shortened]
}

#[test]
fn with_latencies_the_derivatives_are_those_of_the_flight_without_lateness() {
    let folder = folder("latencies");
    let [_, late, shortened] = flown(&folder, "");
    let as_flown = derivatives(&samples_of(&shortened));
    let set = format!("latency_s={LATENCIES}");
    let aligned = folder.join("aligned.csv");
    for ending in ["csv", "mcap"] {
        let out = folder.join(format!("aligned.{ending}"));
        let (status, _, said) = ended(&sideslip(&["convert", path(&late), path(&out), "--set", &set]));
        assert_eq!(status, 0, "{said}");
        let found = apart(&as_flown, &derivatives(&samples_of(&out)));
        eprintln!("aligned, {ending}: {found:?}");
        assert!(found.compared > 12 && found.largest < 0.1 && found.different.is_empty(), "{found:?}");
    }
    let left = apart(&as_flown, &derivatives(&samples_of(&late)));
    eprintln!("late: {left:?}");
    assert!(left.largest > 3.0, "{left:?}");
    // What was subtracted is not subtracted again: the rows of the output are taken as they stand.
    let text = std::fs::read_to_string(&aligned).unwrap();
    assert!(text.contains("# latency_subtracted_s.tas = 0.25\n") && !text.contains("latency_s."), "{:?}", &text[..900]);
    let again = folder.join("again.csv");
    assert_eq!(ended(&sideslip(&["convert", path(&aligned), path(&again)])).0, 0);
    assert_eq!(std::fs::read_to_string(&again).unwrap(), text);
}

#[test]
fn the_key_in_the_head_and_in_set_give_the_same_answer_of_replay_and_identify() {
    let folder = folder("latencies-head");
    let [_, late, shortened] = flown(&folder, &format!("# latency_s = {LATENCIES}\n"));
    let numbers = |file: &Path, name: &str, more: &[&str]| {
        let json = folder.join(name);
        let (status, _, said) = ended(&sideslip(&[&["replay", path(file), "--json", path(&json)], more].concat()));
        assert_eq!(status, 0, "{said}");
        let all: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
        all["runs"][0]["equations"]["N"]["terms"].clone()
    };
    let by_head = numbers(&late, "head.json", &[]);
    assert!(by_head.as_array().is_some_and(|terms| terms.len() > 2), "{by_head}");
    assert_eq!(by_head, numbers(&late, "bus.json", &["--bus", "--speed", "max"]));
    let other = ["--set", "latency_s={ tas = 0.25 }"];
    assert_ne!(by_head, numbers(&late, "other.json", &other), "--set overrides the head");
    let lateral = |file: &Path, name: &str, more: &[&str]| {
        let out = folder.join(name);
        let call = ["identify", path(file), "--states", "v,p,phi,r", "--inputs", "lat_cyclic,pedal", "--out", path(&out)];
        let (status, _, said) = ended(&sideslip(&[&call[..], more].concat()));
        assert!([0, 4].contains(&status), "{said}");
        let all: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(out.join("derivatives.json")).unwrap()).unwrap();
        let all = all["output_error"]["parameters"].as_array().unwrap().clone();
        let of = |name: &str| all.iter().find(|one| one["name"] == name).unwrap().clone();
        ["N_v", "N_r", "L_v"].map(|name| (of(name)["value"].as_f64().unwrap(), of(name)["std"].as_f64().unwrap()))
    };
    let truth = lateral(&shortened, "shortened", &[]);
    let errors = |found: [(f64, f64); 3]| -> f64 {
        let apart = truth.iter().zip(found).map(|((own, std), (value, _))| (value - own).abs() / std);
        apart.fold(0.0, f64::max)
    };
    let (by_head, without) =
        (errors(lateral(&late, "by-head", &[])), errors(lateral(&late, "without", &["--set", "latency_s={}"])));
    eprintln!("identify: {by_head} and {without} standard errors");
    // Output error iterates to some hundredths of a standard error.
    assert!(by_head < 0.1 && without > 1.0, "{by_head} {without}");
}

#[test]
fn wrong_latencies_are_refused_where_they_stand() {
    let folder = folder("latencies-wrong");
    let [straight, late, _] = flown(&folder, "# latency_s = { bta = 0.1 }\n");
    let out = folder.join("out.csv");
    for (call, wanted) in [
        (vec!["convert", path(&late), path(&out)], "found `bta`; nearest is `beta`"),
        (
            vec!["replay", path(&straight), "--set", "latency_s={ tas = 7 }"],
            "--set: latency_s: tas: expected a number of 0 to 5 s",
        ),
        (vec!["check", path(&straight), "--set", "latency_s=0.2"], "expected a table of channels"),
        (
            vec!["simulate", "--model", "puma", "--input", "pedal:doublet:0.02:1", "--out", path(&out), "--set", "latency_s={}"],
            "latency_s",
        ),
    ] {
        let (status, _, said) = ended(&sideslip(&call));
        assert!(status == 2 && said.contains(wanted), "{status} {said}");
    }
    assert!(!out.exists());
}

#[test]
fn disordered_rows_are_counted_by_inspect_and_put_in_order_by_convert() {
    let folder = folder("latencies-order");
    let [straight, ..] = flown(&folder, "");
    let text = std::fs::read_to_string(&straight).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().position(|line| !line.starts_with('#')).unwrap() + 1;
    let columns = lines[first].split(',').count() - 1;
    // Ten rows out of order, one of them twice, and thirty that are missing.
    lines.drain(first + 1000..first + 1030);
    (0..10).for_each(|k| lines.swap(first + 100 * k + 20, first + 100 * k + 26));
    lines.insert(first + 500, lines[first + 495]);
    let (mixed, ordered) = (folder.join("mixed.csv"), folder.join("ordered.csv"));
    std::fs::write(&mixed, lines.join("\n") + "\n").unwrap();
    let (status, table, said) = ended(&sideslip(&["inspect", path(&mixed)]));
    assert_eq!(status, 0, "{said}");
    for wanted in [
        format!("{columns} of {} samples came twice", columns * (2201 - 30 + 1)),
        "samples are out of order; latency_s".to_owned(),
        format!("{columns} dropouts with {} samples missing", 30 * columns),
        "    30 of ax, 9.99 to 10.3 s".to_owned(),
    ] {
        assert!(table.contains(&wanted), "{wanted}: {table}");
    }
    let call = ["convert", path(&mixed), path(&ordered), "--set", "latency_s={}"];
    let (status, _, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    let whole = samples_of(&straight);
    let found = samples_of(&ordered);
    assert_eq!(found.len(), whole.len() - 30);
    assert!(found.iter().all(|sample| whole.contains(sample)) && found.is_sorted_by(|one, other| one.time_s < other.time_s));
}
