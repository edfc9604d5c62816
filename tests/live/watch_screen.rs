//! `watch` in a terminal, beside a running estimator: pages, sizes, keys, what is out of date, and the terminal given back.

use super::stage::{Running, left_behind, signal, stage};
use crate::support::patience::until;
use crate::support::program::{ended, folder, path, puma, sideslip};
use crate::support::pseudo_terminal::{PseudoTerminal, start_and_hang_up};
use std::path::{Path, PathBuf};
use std::process::Command;

const SMALL: (u16, u16) = (80, 24);
const LARGE: (u16, u16) = (120, 50);

fn watch(root: &Path, more: &[&str]) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sideslip"));
    program.args(["watch", "--root", path(root)]).args(more).env_remove("NO_COLOR");
    program
}

/// Telemetry and estimator of the recording, in real time or faster; in a root of their own.
struct Flight {
    root: PathBuf,
    ingest: Running,
    estimate: Running,
}

impl Flight {
    fn of(name: &str, file: &Path, speed: &str) -> Self {
        let root = stage(name).join("root");
        let estimate = Running::start(&["estimate", "--root", path(&root)]);
        until("an estimator", || root.join(".sideslip/estimator").exists());
        let source = format!("file://{}", file.display());
        let ingest = Running::start(&["ingest", "--source", &source, "--speed", speed, "--root", path(&root)]);
        Flight { root, ingest, estimate }
    }

    fn end(mut self) {
        self.ingest.kill();
        assert!(signal("TERM", self.estimate.number()));
        assert_eq!(self.estimate.ended(), 0, "{:?}", self.estimate.said());
        assert_eq!(left_behind(&self.root), [""; 0]);
    }
}

/// Every row within the width, the bars at the top and at the foot.
fn is_framed(terminal: &PseudoTerminal, (_, rows): (u16, u16)) -> bool {
    let shown = terminal.rows();
    let (top, foot) = (shown.first().cloned().unwrap_or_default(), shown.last().cloned().unwrap_or_default());
    shown.len() == usize::from(rows) && top.contains("sideslip watch") && foot.contains("q: quit")
}

/// Turns to a page and waits for its words; printed where the pictures are wanted.
fn page(terminal: &mut PseudoTerminal, key: &str, words: &[&str]) {
    terminal.press(key);
    terminal.wait_for(words);
    if std::env::var_os("SIDESLIP_PICTURES").is_some() {
        eprintln!("{}\n", terminal.rows().join("\n"));
    }
}

fn every_page(name: &str, size: (u16, u16)) {
    let flight = Flight::of(name, &puma(), "1");
    let mut terminal = PseudoTerminal::start(watch(&flight.root, &[]), size);
    // While the samples come, and before they say anything.
    terminal.wait_for(&["puma-100kn-pedal-3211", "CURRENT", "NOT KNOWN YET, because", "samples/s", "Newest events"]);
    terminal.wait_for(&["Dutch roll", "omega", "zeta", "rad/s", "spiral"]);
    assert!(is_framed(&terminal, size), "{:#?}", terminal.rows());
    page(&mut terminal, "1", &["Stability", "Dutch roll", "Estimate", "Link", "Moments"]);
    page(&mut terminal, "2", &["with standard errors", "N_v", "+-", "rad/(m s)"]);
    if size == SMALL {
        assert!(terminal.shows(&["more lines"]) && !terminal.shows(&["Z  "]));
        until("the last lines", || {
            terminal.press("\x1b[F");
            std::thread::sleep(std::time::Duration::from_millis(100));
            terminal.shows(&["Z_w"])
        });
    } else {
        // Forces beside moments.
        terminal.wait_for(&["N_v", "Z_w"]);
    }
    page(&mut terminal, "3", &["Dutch roll (lat.)", "period", "time to half", "Output error"]);
    page(&mut terminal, "4", &["test ratio", "airspeed", "Bias of the sensors", "Channel"]);
    page(&mut terminal, "5", &["the filter has a state"]);
    page(&mut terminal, "?", &["ctrl-C", "STALE"]);
    assert!(is_framed(&terminal, size), "{:#?}", terminal.rows());
    terminal.press("q");
    assert_eq!(terminal.ended(), 0);
    assert!(terminal.bytes().contains("\x1b[?1049l"));
    flight.end();
}

#[test]
fn every_page_is_there_at_80_by_24() {
    let _turn = crate::alone();
    every_page("watch-small", SMALL);
}

#[test]
fn every_page_is_there_at_120_by_50() {
    let _turn = crate::alone();
    every_page("watch-large", LARGE);
}

#[test]
fn it_follows_the_size_of_the_terminal_down_to_next_to_nothing() {
    let _turn = crate::alone();
    let flight = Flight::of("watch-resize", &puma(), "10");
    let mut terminal = PseudoTerminal::start(watch(&flight.root, &[]), LARGE);
    terminal.wait_for(&["Dutch roll", "omega"]);
    for size in [SMALL, (40, 10), (12, 3), (1, 1), (200, 60), SMALL] {
        terminal.resize(size.0, size.1);
        if size.1 >= 10 {
            until(&format!("the bars at {size:?}"), || is_framed(&terminal, size));
        } else {
            // Long enough for an output or two; it must be alive afterwards.
            std::thread::sleep(std::time::Duration::from_millis(600));
        }
    }
    terminal.press("\x03");
    assert_eq!(terminal.ended(), 0);
    flight.end();
}

#[test]
fn it_ends_by_keys_and_by_signals_and_gives_the_terminal_back() {
    let _turn = crate::alone();
    let root = folder("watch-ends").join("root");
    for way in ["q", "\x03", "INT", "TERM", "HUP"] {
        let mut terminal = PseudoTerminal::start(watch(&root, &[]), SMALL);
        terminal.wait_for(&["NO ESTIMATOR"]);
        if way.len() == 1 {
            terminal.press(way);
        } else {
            assert!(signal(way, terminal.number()));
        }
        assert_eq!(terminal.ended(), 0, "{way}");
        assert!(terminal.bytes().contains("\x1b[?1049l"), "{way}");
    }
}

/// Whether the process is stopped, as a shell's jobs are.
fn is_stopped(process: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    stat.rsplit_once(") ").is_some_and(|(_, state)| state.starts_with('T'))
}

#[test]
fn a_stop_gives_the_terminal_back_and_going_on_draws_it_anew() {
    let _turn = crate::alone();
    let root = folder("watch-stops").join("root");
    for way in ["\x1a", "TSTP", "STOP"] {
        let mut terminal = PseudoTerminal::start(watch(&root, &[]), SMALL);
        terminal.wait_for(&["NO ESTIMATOR", "q: quit"]);
        if way == "\x1a" {
            terminal.press(way);
        } else {
            assert!(signal(way, terminal.number()));
        }
        until("the program is stopped", || is_stopped(terminal.number()));
        if way != "STOP" {
            until("the screen is given back", || !terminal.is_screen());
            assert!(terminal.is_as_before(), "{way:?}");
        }
        terminal.scribble("\x1b[2J\x1b[5;5Hsomebody else's words");
        terminal.wait_for(&["somebody else's words"]);
        assert!(signal("CONT", terminal.number()));
        until("the screen is back", || terminal.is_screen() && terminal.shows(&["NO ESTIMATOR", "q: quit"]));
        assert!(!terminal.is_as_before() && !terminal.shows(&["somebody else's words"]), "{way:?}: {:#?}", terminal.rows());
        terminal.press("q");
        assert_eq!(terminal.ended(), 0, "{way:?}");
    }
}

/// Reading keys from a terminal that has gone never ends: half a core was spent on it.
#[test]
fn it_ends_with_its_terminal() {
    let _turn = crate::alone();
    let mut program = start_and_hang_up(watch(&folder("watch-hang-up").join("root"), &[]));
    until("the program has ended", || program.try_wait().unwrap().is_some());
}

#[test]
fn what_is_out_of_date_is_told_by_a_word_and_a_colour() {
    let _turn = crate::alone();
    let mut flight = Flight::of("watch-stale", &puma(), "10");
    let mut coloured = PseudoTerminal::start(watch(&flight.root, &[]), SMALL);
    let mut plain = PseudoTerminal::start(
        {
            let mut call = watch(&flight.root, &[]);
            call.env("NO_COLOR", "1");
            call
        },
        SMALL,
    );
    for terminal in [&coloured, &plain] {
        terminal.wait_for(&["omega"]);
    }
    assert_eq!(flight.ingest.ended(), 0);
    flight.estimate.kill();
    for terminal in [&mut coloured, &mut plain] {
        terminal.wait_for(&["STALE", "the estimator has ended", "omega"]);
    }
    assert!(coloured.is_coloured("STALE,") && coloured.is_coloured("omega"));
    assert!(!plain.is_coloured("STALE,") && !plain.is_coloured("omega"));
    let written = plain.bytes();
    let colours = ["\x1b[3", "\x1b[4", "\x1b[9"].iter().filter(|code| {
        written
            .match_indices(**code)
            .any(|(at, _)| written[at + 3..].starts_with(|c: char| c.is_ascii_digit()) && !written[at + 3..].starts_with("9m"))
    });
    assert_eq!(colours.count(), 0, "{written:?}");
    for terminal in [&mut coloured, &mut plain] {
        terminal.press("q");
        assert_eq!(terminal.ended(), 0);
    }
}

#[test]
fn a_wrong_root_is_told_from_an_estimator_that_is_waited_for() {
    let _turn = crate::alone();
    let folder = folder("watch-wrong-root");
    let (wrong, right) = (folder.join("wrong"), folder.join("right"));
    let mut terminal = PseudoTerminal::start(watch(&wrong, &[]), SMALL);
    terminal.wait_for(&["nothing of Sideslip runs in this root", "the root is ", "NO ESTIMATOR in this root"]);
    terminal.press("q");
    assert_eq!(terminal.ended(), 0);
    let mut estimate = Running::start(&["estimate", "--root", path(&right)]);
    until("an estimator", || right.join(".sideslip/estimator").exists());
    let mut terminal = PseudoTerminal::start(watch(&right, &[]), SMALL);
    let holder = format!("WAITING: the estimator (process {})", estimate.number());
    terminal.wait_for(&["NOT KNOWN YET, because there is no estimate yet", &holder, "NO TELEMETRY in this root"]);
    terminal.press("q");
    assert_eq!(terminal.ended(), 0);
    assert!(signal("TERM", estimate.number()));
    assert_eq!(estimate.ended(), 0);
    // Into a pipe the words are those they always were, the reason on standard error.
    let (status, out, said) = ended(&sideslip(&["watch", "--root", path(&wrong), "--count", "1"]));
    assert_eq!((status, out.as_str()), (0, "no estimate yet\n"));
    assert!(said.contains("nothing of Sideslip runs in this root") && said.contains(path(&wrong)), "{said}");
}

#[test]
fn with_plain_a_terminal_has_lines() {
    let _turn = crate::alone();
    let root = folder("watch-plain").join("root");
    let mut terminal = PseudoTerminal::start(watch(&root, &["--plain", "--count", "2", "--every", "0.1"]), SMALL);
    terminal.wait_for(&["no estimate yet"]);
    assert_eq!(terminal.ended(), 0);
    let written = terminal.bytes();
    assert_eq!(written.matches("no estimate yet").count(), 2);
    assert!(!written.contains('\x1b'), "{written:?}");
}
