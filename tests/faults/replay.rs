//! `sideslip replay` and `simulate` on broken inputs: each fault ends as the fault matrix says, and leaves no half file.

use crate::support::program::{RunFile, ended, files_in, folder, own, path, puma, replayed, sideslip, warns};
use std::path::PathBuf;

/// The bundled recording, damaged and written into a folder of its own.
fn damaged(name: &str, damage: impl FnOnce(&mut RunFile)) -> PathBuf {
    let mut run = RunFile::read(&puma());
    damage(&mut run);
    let file = folder(&format!("replay-{name}")).join("run.csv");
    run.write(&file);
    file
}

#[test]
fn a_run_file_that_was_cut_gives_what_is_whole_and_says_what_is_not() {
    let file = folder("replay-cut-text").join("run.csv");
    let text = std::fs::read(puma()).unwrap();
    let cut = text.len() * 3 / 4;
    // In the middle of a row.
    let cut = cut + text[cut..].iter().position(|&byte| byte == b'\n').unwrap() + 30;
    std::fs::write(&file, &text[..cut]).unwrap();
    let (status, run, said) = replayed(&file, &[]);
    assert_eq!(status, 3, "{said}");
    assert!(said.contains("1 of 939 rows skipped") && said.contains("cut short"), "{said}");
    assert!(warns(&run, &["1 of 939 rows skipped"]));
    assert!(run["modes"]["dutch_roll"]["omega"].as_f64().unwrap() > 1.0, "and the numbers of the rest");
}

#[test]
fn a_log_that_was_cut_anywhere_never_panics() {
    let folder = folder("replay-cut-log");
    let (whole, cut) = (folder.join("whole.mcap"), folder.join("cut.mcap"));
    assert_eq!(replayed(&puma(), &["--out", path(&whole)]).0, 0);
    let bytes = std::fs::read(&whole).unwrap();
    let mut seen = [0; 5];
    for twentieth in 0..20 {
        // Densely through the head, then through the whole file.
        for length in [bytes.len() * twentieth / 20, 8 + 400 * twentieth] {
            std::fs::write(&cut, &bytes[..length]).unwrap();
            let (status, run, said) = replayed(&cut, &[]);
            let status = usize::try_from(status).unwrap();
            assert!(matches!(status, 0 | 2 | 3 | 4), "{length} bytes: {status}, {said}");
            assert!(!said.contains("panicked"), "{said}");
            if matches!(status, 3 | 4) {
                assert!(said.contains("truncated after") && warns(&run, &["truncated after"]), "{length} bytes: {said}");
            }
            seen[status] += 1;
        }
    }
    // The beginning of a flight has no derivative.
    assert!(seen[3] > 5 && seen[3] + seen[4] > 15 && seen[2] > 1 && seen[0] == 0, "{seen:?}");
}

#[test]
fn cells_that_are_no_number_are_left_out_and_counted() {
    let file = damaged("nan", |run| {
        let (beta, r) = (run.place("beta"), run.place("r"));
        for k in (100..400).step_by(10) {
            run.rows[k][beta] = "NaN".into();
            run.rows[k + 1][r] = "inf".into();
        }
    });
    let (status, run, said) = replayed(&file, &[]);
    assert_eq!(status, 3, "{said}");
    assert!(said.contains("60 values not used"), "{said}");
    assert!(warns(&run, &["beta gave no number", "30 times"]) && warns(&run, &["r gave no number", "30 times"]));
    assert!(run["modes"]["dutch_roll"]["omega"].is_number());
}

#[test]
fn a_vane_that_dies_keeps_its_warning() {
    let file = damaged("dead-vane", |run| {
        let beta = run.place("beta");
        run.rows.iter_mut().skip(600).for_each(|row| row[beta] = "NaN".into());
    });
    let (status, run, said) = replayed(&file, &[]);
    assert_eq!(status, 3, "{said}");
    assert!(warns(&run, &["beta gave no number", "651 times"]), "{}", run["warnings"]);
}

#[test]
fn time_that_goes_back_or_stands_still_costs_those_samples() {
    let file = damaged("time", |run| {
        run.rows[500][0] = "9.5".into();
        run.rows[600][0] = run.rows[599][0].clone();
        run.rows[700][0] = run.rows[699][0].clone();
    });
    let (status, run, said) = replayed(&file, &[]);
    assert_eq!(status, 3, "{said}");
    assert!(said.contains("3 of 1251 samples dropped for their time"), "{said}");
    assert!(warns(&run, &["time went back by 0.480 s"]), "{}", run["warnings"]);
    assert!(warns(&run, &["a second sample came with the same time", "2 times"]));
    assert!(run["modes"]["dutch_roll"]["omega"].is_number());
}

#[test]
fn a_gap_is_said_and_the_filter_starts_again() {
    let file = damaged("gap", |run| drop(run.rows.drain(400..649)));
    let (status, run, said) = replayed(&file, &[]);
    assert_eq!(status, 0, "{said}");
    assert!(warns(&run, &["nothing came for 5.00 s", "starts again"]), "{}", run["warnings"]);
    assert!(run["modes"]["dutch_roll"]["omega"].is_number());
}

#[test]
fn a_slow_run_gets_a_sentence_and_no_estimate() {
    let slow = folder("replay-slow").join("slow.csv");
    let model = own("replay/models/puma-like.toml");
    let args = ["simulate", "--model", path(&model), "--input", "pedal:3211:0.02:0.7", "--rate", "4", "--out", path(&slow)];
    assert_eq!(ended(&sideslip(&args)).0, 0);
    let (_, run, table) = replayed(&slow, &[]);
    assert!(run["modes"]["dutch_roll"].is_null());
    let reason = run["equations"]["N"]["reason"].as_str().unwrap();
    assert_eq!(reason, "the rates come at 4.00 Hz, derivatives need 8 Hz");
    assert!(table.contains("rates come at 4.00 Hz, derivatives need 8 Hz"), "{table}");
}

#[test]
fn a_missing_vane_or_accelerometer_costs_what_it_alone_can_tell() {
    let write = |name: &str, gone: &[&str]| {
        let file = folder(&format!("replay-{name}")).join("run.csv");
        gone.iter().fold(RunFile::read(&puma()), |run, channel| run.without(channel)).write(&file);
        file
    };
    let (status, run, _) = replayed(&write("no-beta", &["beta"]), &[]);
    assert_eq!(status, 4, "no derivative is left");
    assert!(warns(&run, &["brings no sideslip (beta)"]), "{}", run["warnings"]);
    let (status, run, table) = replayed(&write("no-force", &["ax", "ay", "az"]), &[]);
    assert_eq!(status, 0);
    assert!(warns(&run, &["no accelerometer ay"]), "{}", run["warnings"]);
    assert!(table.contains("no accelerometer on this axis (channel ay)"), "{table}");
    let (status, run, _) = replayed(&write("neither", &["beta", "ay"]), &[]);
    assert_eq!(status, 4);
    assert!(run["modes"]["status"].as_str().unwrap().starts_with("not identifiable"), "{}", run["modes"]);
}

#[test]
fn a_wrong_call_or_file_ends_with_status_2_one_line_and_no_output() {
    let folder = folder("replay-wrong");
    let (unit, rows, log) = (folder.join("unit.csv"), folder.join("rows.csv"), folder.join("log.mcap"));
    std::fs::write(&unit, "time,p,tas[furlong]\n0,0,1\n").unwrap();
    std::fs::write(&rows, "time,p\n1;2\n").unwrap();
    let puma = puma();
    let (unit_file, rows_file, out) = (path(&unit), path(&rows), path(&log));
    for (args, words) in [
        (vec!["replay", unit_file, "--out", out], vec!["unit.csv:1:8:", "`tas`", "furlong"]),
        (vec!["replay", rows_file, "--out", out], vec!["rows.csv:2:1:", "expected 2 cells"]),
        (vec!["replay", path(&puma), unit_file, "--json", out], vec!["unit.csv:1:8:"]),
        (vec!["replay", path(&puma), "--set", "vane=1", "--out", out], vec!["--set", "vane_position_m"]),
        (vec!["replay", path(&puma), "--trim-window", "-1", "--out", out], vec!["trim window"]),
        (vec!["replay", rows_file, "--json", rows_file], vec!["--json", "found the same"]),
        (vec!["replay", path(&puma), "--out", rows_file], vec!["--out", ".mcap"]),
        (vec!["replay", path(&puma), rows_file, "--out", rows_file], vec!["--out", "directory"]),
    ] {
        let (status, printed, said) = ended(&sideslip(&args));
        assert_eq!((status, printed.as_str(), said.lines().count()), (2, "", 1), "{args:?}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{args:?}: {said}");
        assert_eq!(files_in(&folder), ["rows.csv", "unit.csv"], "{args:?}");
    }
    assert_eq!(std::fs::read_to_string(&rows).unwrap(), "time,p\n1;2\n");
}

#[test]
fn a_log_is_not_written_over_the_recording_that_is_read() {
    let log = folder("replay-onto-itself").join("run.mcap");
    assert_eq!(replayed(&puma(), &["--out", path(&log)]).0, 0);
    let before = std::fs::read(&log).unwrap();
    let (status, _, said) = replayed(&log, &["--out", path(&log)]);
    assert!(status == 2 && said.contains("found the same"), "{said}");
    assert_eq!(std::fs::read(&log).unwrap(), before);
}

#[test]
fn a_result_is_not_written_over_what_it_was_read_from() {
    let folder = folder("result-onto-itself");
    let (run, model) = (folder.join("run.csv"), folder.join("model.toml"));
    std::fs::copy(puma(), &run).unwrap();
    std::fs::copy(own("replay/models/puma-like.toml"), &model).unwrap();
    let log = folder.join("run.mcap");
    for (call, kept) in [
        (vec!["inspect", path(&run), "--json", path(&run)], puma()),
        (vec!["linearise", "--model", path(&model), "--json", path(&model)], own("replay/models/puma-like.toml")),
        (vec!["replay", path(&run), "--out", path(&log), "--json", path(&log)], puma()),
    ] {
        let (status, _, said) = ended(&sideslip(&call));
        assert!(status == 2 && said.contains("found the same"), "{call:?}: {said}");
        let read = if call[0] == "linearise" { &model } else { &run };
        assert_eq!(std::fs::read(read).unwrap(), std::fs::read(kept).unwrap());
    }
    assert_eq!(files_in(&folder), ["model.toml", "run.csv"]);
}

#[test]
fn a_log_that_another_process_is_writing_is_left_alone() {
    let log = folder("replay-two-writers").join("run.mcap");
    std::fs::write(&log, "being written").unwrap();
    let writer = std::fs::OpenOptions::new().append(true).open(&log).unwrap();
    writer.lock().unwrap();
    assert_eq!(replayed(&puma(), &["--out", path(&log)]).0, 2, "it is there already");
    let (status, _, said) = replayed(&puma(), &["--out", path(&log), "--force"]);
    assert!(status == 1 && said.contains("another process is writing this log"), "{status}: {said}");
    assert_eq!(std::fs::read_to_string(&log).unwrap(), "being written");
    drop(writer);
    assert_eq!(replayed(&puma(), &["--out", path(&log), "--force"]).0, 0);
    assert_eq!(replayed(&log, &[]).0, 0, "and nothing of what stood there is left");
}

#[test]
fn a_misspelt_derivative_is_found_where_it_stands() {
    let folder = folder("simulate-misspelt");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    let line = 1 + text.lines().position(|line| line == "[derivatives.N]").unwrap() + 1;
    let model = folder.join("model.toml");
    std::fs::write(&model, text.replace("[derivatives.N]\nu =", "[derivatives.N]\nuu =")).unwrap();
    let out = folder.join("run.mcap");
    let (status, _, said) =
        ended(&sideslip(&["simulate", "--model", path(&model), "--input", "pedal:step:0.01:1", "--out", path(&out)]));
    assert_eq!((status, said.lines().count()), (2, 1), "{said}");
    assert!(said.contains(&format!("model.toml:{line}:1:")) && said.contains("uu"), "{said}");
    assert_eq!(files_in(&folder), ["model.toml"]);
}
