//! Examples of `--help`: those on files are run as they are pasted, in a folder that has the files they name; the calls of those
//! on links, processes and formats of recorders are read by the program, which then finds nothing wrong with them.

use super::program::{RunFile, ended, folder, own, path, sideslip};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Commands that listen, send or run until they are stopped.
const LIVE: [&str; 5] = ["demo", "live", "ingest", "estimate", "watch"];
/// What an example names that no simulated flight writes, or that other processes share.
const NOT_HERE: [&str; 4] = ["pcm+", "ch10", ".key", "--bus"];

/// Every command with the lines of its examples.
pub(crate) fn examples() -> Vec<(String, Vec<String>)> {
    let (status, help, said) = ended(&sideslip(&["--help"]));
    assert_eq!(status, 0, "{said}");
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = listed.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    names
        .map(|name| {
            let (status, help, said) = ended(&sideslip(&[name, "--help"]));
            assert_eq!(status, 0, "{said}");
            let lines = help.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| line.starts_with("sideslip "));
            (name.to_owned(), lines.map(str::to_owned).collect())
        })
        .collect()
}

fn simulated(folder: &Path, name: &str, more: &[&str]) -> PathBuf {
    let (file, model) = (folder.join(name), folder.join("puma-100kn.toml"));
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let args = ["simulate", "--model", path(&model), "--noise", "--out", path(&file)];
    let (status, _, said) = ended(&sideslip(&[&args, more].concat()));
    assert_eq!(status, 0, "{name}: {said}");
    file
}

/// The files that examples name.
fn prepared(folder: &Path) {
    let model = own("replay/models/puma-like.toml");
    std::fs::create_dir_all(folder.join("replay/models")).unwrap();
    for name in ["puma-100kn.toml", "model.toml", "extended.toml", "replay/models/puma-like.toml"] {
        std::fs::copy(&model, folder.join(name)).unwrap();
    }
    std::fs::copy(own("replay/instruments/flight-test.toml"), folder.join("flight-test.toml")).unwrap();
    let short = ["--duration", "9", "--rate", "50", "--pilot", "attitude"];
    for (name, input, seed) in [
        ("flight.csv", "pedal:3211:0.02:0.7", "1"),
        ("3211.csv", "pedal:3211:0.02:0.6", "2"),
        ("lateral.csv", "lat_cyclic:doublet:0.01:1", "3"),
        ("doublet.csv", "pedal:doublet:0.02:0.8", "4"),
        ("other.csv", "pedal:doublet:0.015:1", "5"),
        ("holdout.csv", "pedal:doublet:0.015:0.9", "6"),
        ("tuesday.csv", "pedal:doublet:0.02:1", "7"),
        ("monday/one.csv", "pedal:3211:0.02:0.7", "8"),
        ("monday/two.csv", "lat_cyclic:3211:0.01:0.6", "9"),
        ("flight.tlog", "pedal:3211:0.02:0.7", "10"),
    ] {
        simulated(folder, name, &[&short[..], &["--input", input, "--seed", seed]].concat());
    }
    let inputs = ["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.01:0.7:8", "lon_cyclic:3211:0.02:0.7:14"];
    let mut gusty = vec!["--duration", "22", "--rate", "50", "--pilot", "attitude", "--turbulence", "1", "--seed", "11"];
    gusty.extend(inputs.iter().flat_map(|input| ["--input", input]));
    simulated(folder, "gusty.csv", &gusty);
    let inputs =
        ["pedal:3211:0.02:0.7", "lat_cyclic:doublet:0.01:1:25", "pedal:doublet:0.02:1:45", "lat_cyclic:3211:0.01:0.7:65"];
    let mut day = vec!["--duration", "85", "--rate", "25", "--pilot", "attitude", "--seed", "13"];
    day.extend(inputs.iter().flat_map(|input| ["--input", input]));
    simulated(folder, "day.csv", &day);
    simulated(folder, "00000012.bin", &["--input", "pedal:3211:0.02:0.7", "--duration", "100", "--rate", "50", "--seed", "12"]);
    std::fs::rename(folder.join("00000012.bin"), folder.join("00000012.BIN")).unwrap();
    for (name, from) in [("rud1.csv", "3211.csv"), ("ail1.csv", "lateral.csv")] {
        let text = RunFile::read(&folder.join(from))
            .text()
            .replace("lon_cyclic,lat_cyclic,collective,pedal", "elevator,aileron,throttle,rudder");
        std::fs::write(folder.join(name), text).unwrap();
    }
    let run = RunFile::read(&folder.join("flight.csv"));
    let cell = |row: &Vec<String>, name: &str| row[run.place(name)].clone();
    let radar: String = run.rows.iter().map(|row| format!("{},{},51.5\n", cell(row, "time"), cell(row, "altitude"))).collect();
    std::fs::write(folder.join("radar.csv"), format!("time,altitude,ground_speed\n{radar}")).unwrap();
    let coefficients = (0..400).map(|k| {
        let t = 0.02 * f64::from(k);
        let (alpha, qhat, elevator) = (0.05 * (2.1 * t).sin(), 0.01 * (3.7 * t).cos(), if k % 90 < 45 { 0.03 } else { -0.03 });
        let moment = -0.6 * alpha - 9.0 * qhat - 1.1 * elevator + 0.002 * (40.0 * t).sin();
        format!("{t:.2},{alpha},{qhat},{elevator},{moment}\n")
    });
    std::fs::write(folder.join("coefficients.csv"), format!("time,alpha,qhat,elevator,Cm\n{}", coefficients.collect::<String>()))
        .unwrap();
    let theirs: String =
        (0..500).map(|k| f64::from(k) * 0.02).map(|t| format!("{t:.2},{},{},{}\n", t.sin(), t.cos(), 0.5 * t)).collect();
    std::fs::write(
        folder.join("theirs.csv"),
        format!("Time (s),Roll Rate [deg/s],Pitch Rate [deg/s],Yaw Rate [deg/s]\n{theirs}"),
    )
    .unwrap();
    // What the examples hand JSON to; the folder is first on the path.
    std::fs::create_dir(folder.join("bin")).unwrap();
    let jq = folder.join("bin/jq");
    std::fs::write(&jq, "#!/bin/sh\nexec cat > /dev/null\n").unwrap();
    assert!(Command::new("chmod").args(["+x", path(&jq)]).status().unwrap().success());
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_sideslip"), folder.join("bin/sideslip")).unwrap();
}

/// A line in a shell, in the folder.
fn in_shell(folder: &Path, line: &str) -> (i32, String) {
    let path = format!("{}:{}", folder.join("bin").display(), std::env::var("PATH").unwrap());
    let call = format!("set -o pipefail; {line}");
    let output = Command::new("bash").args(["-c", &call]).current_dir(folder).env("PATH", path).output().unwrap();
    let (status, _, said) = ended(&output);
    (status, said)
}

/// Names of the files and folders in it.
fn content(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    names
}

/// The line with `--force` for its first command.
fn forced(line: &str) -> String {
    let end = [" |", " &&"].iter().filter_map(|word| line.find(word)).min().unwrap_or(line.len());
    let (call, rest) = line.split_at(end);
    format!("{call} --force{rest}")
}

fn copied(from: &Path, to: &Path) {
    assert!(Command::new("cp").args(["-R", path(from), path(to)]).status().unwrap().success());
}

/// Runs the examples of these commands, each in a folder of its own.
pub(crate) fn run_examples(place: &str, of: impl Fn(&str) -> bool) {
    let all: Vec<(String, Vec<String>)> = examples().into_iter().filter(|(name, _)| of(name)).collect();
    let (root, mut number) = (folder(place), 0);
    let base = root.join("base");
    std::fs::create_dir(&base).unwrap();
    prepared(&base);
    for (name, lines) in all {
        assert!(!lines.is_empty(), "{name} --help has no example");
        for line in lines {
            number += 1;
            let here = root.join(number.to_string());
            copied(&base, &here);
            if LIVE.contains(&name.as_str()) || NOT_HERE.iter().any(|part| line.contains(part)) {
                let call = line.split('|').next().unwrap();
                let (status, said) = in_shell(&here, &format!("{call} --no-such-option"));
                assert!(status == 2 && said.contains("unexpected argument '--no-such-option'"), "{line}: {status}: {said}");
            } else {
                let files = content(&here);
                let (status, said) = in_shell(&here, &line);
                assert!(matches!(status, 0 | 3 | 4), "{line}: {status}: {said}");
                // Again, as a user does: what it wrote is not replaced unasked, and with --force it is. What a shell writes is
                // the shell's.
                if content(&here) != files && !line.contains('>') {
                    let (status, said) = in_shell(&here, &line);
                    assert!(status == 2 && said.contains("--force replaces it"), "again: {line}: {status}: {said}");
                    let (status, said) = in_shell(&here, &forced(&line));
                    assert!(matches!(status, 0 | 3 | 4), "again with --force: {line}: {status}: {said}");
                }
            }
            std::fs::remove_dir_all(&here).unwrap();
        }
    }
}
