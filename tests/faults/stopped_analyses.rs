//! Long analyses on a terminal: how far they are and how long they will take; ctrl-C ends them with what they have.

use crate::support::patience::until;
use crate::support::program::{ended, folder, own, path, sideslip};
use crate::support::pseudo_terminal::PseudoTerminal;
use std::process::Command;

/// A signal that comes after the end of the work, on a machine that others keep busy, is sent again to a new start of it.
const STARTS: usize = 5;

/// The exit status of work that was interrupted once these words were there, and all that it wrote.
fn interrupted(args: &[&str], words: &[&str]) -> (i32, String) {
    let mut attempts = (0..STARTS).map(|_| interrupted_once(args, words));
    attempts.find(|(status, _)| *status != 0).expect("the work ends before the signal reaches it")
}

/// Starts it on a terminal, interrupts it once these words are there, and waits for its end: the exit status and all it wrote.
fn interrupted_once(args: &[&str], words: &[&str]) -> (i32, String) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sideslip"));
    program.args(args);
    let mut terminal = PseudoTerminal::start(program, (160, 50));
    until(&format!("{words:?}"), || {
        let written = terminal.bytes();
        words.iter().all(|word| written.contains(word))
    });
    assert!(Command::new("kill").args(["-INT", &terminal.number().to_string()]).status().unwrap().success());
    let status = terminal.ended();
    (status, terminal.bytes())
}

#[test]
fn a_search_of_inputs_shows_the_time_left_and_ends_with_the_best_until_then() {
    let model = own("replay/models/puma-like.toml");
    let args = ["design", "--model", path(&model), "--control", "pedal", "--longest", "14"];
    let (status, written) = interrupted(&args, &[" sequences, best so far pedal:", ", about ", " left"]);
    assert_eq!(status, 3, "{written}");
    assert!(written.contains("best found") && written.contains("stopped by a signal after "), "{written}");
}

#[test]
fn a_diagnosis_and_an_identification_end_with_what_was_found_until_then() {
    let folder = folder("stopped-analyses");
    let (model, flown) = (own("replay/models/puma-like.toml"), folder.join("flown.toml"));
    let lag = "\n[[effect]]\nkind = \"actuator_lag\"\ncontrol = \"pedal\"\ntau = 0.2\n";
    std::fs::write(&flown, std::fs::read_to_string(&model).unwrap() + lag).unwrap();
    let runs = ["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.01:0.7", "lon_cyclic:3211:0.01:0.7", "collective:doublet:0.02:1"];
    let files: Vec<_> = (0..runs.len()).map(|place| folder.join(format!("{place}.csv"))).collect();
    for (place, (input, file)) in runs.iter().zip(&files).enumerate() {
        let seed = place.to_string();
        let args = ["simulate", "--model", path(&flown), "--input", input, "--noise", "--seed", &seed, "--duration", "40"];
        let (status, _, said) = ended(&sideslip(&[&args[..], &["--pilot", "attitude", "--out", path(file)]].concat()));
        assert_eq!(status, 0, "{said}");
    }
    let files: Vec<&str> = files.iter().map(|file| path(file)).collect();
    let (status, written) =
        interrupted(&[&["diagnose", "--model", path(&model), "--fit"], &files[..]].concat(), &["causes searched"]);
    assert_eq!(status, 3, "{written}");
    assert!(written.contains("stopped by a signal: these are the causes found until then"), "{written}");
    let (status, written) = interrupted(&[&["identify"], &files[..]].concat(), &["output error: "]);
    assert!(matches!(status, 3 | 4), "{status}: {written}");
    assert!(written.contains("stopped by a signal: the numbers are those of the search until then"), "{written}");
}
