//! Names that try to steer a terminal: of runs, aircraft, manoeuvres, models and files, in what each command says.

use crate::support::program::{ended, folder, own, path, puma, sideslip};
use crate::support::pseudo_terminal::PseudoTerminal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Clears the screen, sets the title, colours by C0 and by C1, turns the direction; then ordinary letters of three scripts.
const NAME: &str = "\u{1b}[2J\u{1b}]0;owned\u{7}\u{1b}[31m\u{9b}33mx\u{202e}y\u{2066}-\u{f6}\u{3b1}\u{65e5}";

/// As it is shown.
const SHOWN: &str = "\\x1b[2J\\x1b]0;owned\\x07\\x1b[31m\\u{9b}33mx\\u{202e}y\\u{2066}-\u{f6}\u{3b1}\u{65e5}";

/// The name as a string of TOML.
const TOML: &str = "\"\\u001b[2J\\u001b]0;owned\\u0007\\u001b[31m\\u009b33mx\\u202ey\\u2066-\u{f6}\u{3b1}\u{65e5}\"";

/// A run and a model with such names, in files with such names.
fn hostile(folder: &Path) -> (PathBuf, PathBuf) {
    let run = folder.join("run\u{1b}[2J\u{202e}.csv");
    let text = std::fs::read_to_string(puma()).unwrap();
    let named = text.lines().map(|line| match line.split_once(" = ") {
        Some((key @ ("# run" | "# aircraft" | "# manoeuvre"), _)) => format!("{key} = {TOML}\n"),
        _ => format!("{line}\n"),
    });
    std::fs::write(&run, named.collect::<String>()).unwrap();
    let model = folder.join("model\u{1b}[2J\u{202e}.toml");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    std::fs::write(&model, text.replace("name = \"puma-100kn-level\"", &format!("name = {TOML}"))).unwrap();
    (run, model)
}

fn steers(c: char) -> bool {
    c != '\n' && (c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'))
}

#[test]
fn no_command_writes_them_raw() {
    let folder = folder("hostile-names");
    let (run, model) = hostile(&folder);
    let (run, model) = (path(&run), path(&model));
    let absent = folder.join("absent\u{1b}[2J\u{202e}.csv");
    let calls: [(&[&str], &str); 9] = [
        (&["replay", run], SHOWN),
        (&["check", run], SHOWN),
        (&["compare", run, "--model", model], SHOWN),
        (&["identify", run, "--states", "v,p,r", "--inputs", "pedal,lat_cyclic"], ""),
        (&["linearise", "--model", model], SHOWN),
        (&["inspect", run], "\\x1b[2J"),
        (&["replay", path(&absent)], "absent\\x1b[2J\\u{202e}.csv"),
        (&["compare", run, "--model", path(&absent)], "absent\\x1b[2J\\u{202e}.csv"),
        (&["watch", "--every", "\u{1b}[2J"], "--every"),
    ];
    for (call, expected) in calls {
        let (_, out, said) = ended(&sideslip(call));
        let all = format!("{out}{said}");
        assert!(all.contains(expected) && !all.is_empty(), "{call:?}: {all}");
        assert!(!all.contains(steers), "{call:?}: {all:?}");
    }
}

/// What a name of several lines would say in a line of its own.
const FORGED: &str = "forged: all is well";

#[test]
fn a_name_of_several_lines_makes_no_line_of_its_own() {
    let folder = folder("hostile-lines");
    let name = |ending: &str| folder.join(format!("a\n{FORGED}{ending}"));
    let (run, model, absent, damaged) = (name(".csv"), name(".toml"), name("-absent.csv"), name("-damaged.csv"));
    let text = std::fs::read_to_string(puma()).unwrap();
    let named = text.lines().map(|line| match line.split_once(" = ") {
        Some((key @ ("# run" | "# aircraft" | "# manoeuvre"), _)) => format!("{key} = \"x\\n{FORGED}\"\n"),
        _ => format!("{line}\n"),
    });
    std::fs::write(&run, named.collect::<String>()).unwrap();
    std::fs::write(&damaged, text.lines().take(60).map(|line| format!("{line}\n")).collect::<String>() + "1,2\n").unwrap();
    let own_model = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    std::fs::write(&model, own_model.replace("name = \"puma-100kn-level\"", &format!("name = \"x\\n{FORGED}\""))).unwrap();
    let (run, model, absent, damaged) = (path(&run), path(&model), path(&absent), path(&damaged));
    let speed = format!("x\n{FORGED}");
    let given = format!("--speed=x\n{FORGED}");
    let calls: [&[&str]; 14] = [
        &["replay", run],
        &["replay", damaged],
        &["check", run],
        &["compare", run, "--model", model],
        &["identify", run, "--states", "v,p,r", "--inputs", "pedal,lat_cyclic"],
        &["linearise", "--model", model],
        &["inspect", run],
        &["inspect", damaged],
        &["inspect", run, "--manoeuvres"],
        &["replay", absent],
        &["identify", absent],
        &["compare", run, "--model", absent],
        &["replay", run, "--speed", &speed],
        &["replay", run, &given],
    ];
    for call in calls {
        let (_, out, said) = ended(&sideslip(call));
        let all = format!("{out}{said}");
        assert!(all.contains("forged"), "{call:?}: {all}");
        let own_line = all.lines().find(|line| line.starts_with("forged"));
        assert_eq!(own_line, None, "{call:?}: {all}");
    }
}

#[test]
fn a_json_document_on_standard_output_says_the_same_without_them() {
    let folder = folder("hostile-json");
    let (run, _) = hostile(&folder);
    let (status, out, said) = ended(&sideslip(&["replay", path(&run), "--json", "-"]));
    assert!(status == 0 && !out.contains(steers) && !said.contains(steers), "{status} {said:?}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["runs"][0]["run"], NAME);
}

#[test]
fn on_a_terminal_only_our_own_colours_pass() {
    let folder = folder("hostile-terminal");
    let (run, _) = hostile(&folder);
    let mut program = Command::new(env!("CARGO_BIN_EXE_sideslip"));
    program.args(["check", path(&run)]).env_remove("NO_COLOR");
    let mut terminal = PseudoTerminal::start(program, (100, 50));
    terminal.ended();
    let written = terminal.bytes();
    assert!(written.contains("\\x1b[2J") && written.contains("\u{65e5}"), "{written:?}");
    for (at, _) in written.match_indices('\x1b') {
        let rest = &written[at..];
        // Ours, and the line of progress that is written anew.
        let own = ["\x1b[0;1m", "\x1b[0;31m", "\x1b[0;33m", "\x1b[0;0m", "\x1b[K"];
        assert!(own.iter().any(|own| rest.starts_with(own)), "{rest:?}");
    }
}
