//! The program in a terminal of a given size, and what a person sees there.

use super::patience::until;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Termios, Winsize, tcgetattr, tcsetwinsize};
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::process::{Child, Command};
use std::sync::{Arc, Mutex};

/// A program in a terminal of its own; killed where the test ends before it does.
pub(crate) struct PseudoTerminal {
    child: Child,
    master: File,
    /// Kept open, so that what was written last can be read after the program's end.
    slave: File,
    before: Termios,
    seen: Arc<Mutex<Seen>>,
}

struct Seen {
    screen: vt100::Parser,
    bytes: Vec<u8>,
}

/// Both ends of a new terminal; the program in it has no hold of the first.
fn opened_ends() -> (File, File) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let device = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let mut opened = OpenOptions::new();
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut opened, OpenptFlags::NOCTTY.bits() as i32);
    let slave = opened.read(true).write(true).open(device).unwrap();
    (File::from(master), slave)
}

/// Starts a program in a terminal that is gone, without a signal, as soon as something was written to it.
pub(crate) fn start_and_hang_up(mut program: Command) -> Child {
    let (mut master, slave) = opened_ends();
    tcsetwinsize(&slave, size(80, 24)).unwrap();
    let end = || slave.try_clone().unwrap();
    let child = program.stdin(end()).stdout(end()).stderr(end()).env("TERM", "xterm-256color").spawn().unwrap();
    // The command holds ends of its own.
    drop((program, slave));
    assert!(master.read(&mut [0; 64]).unwrap() > 0);
    child
}

impl PseudoTerminal {
    /// Starts it; colours as `TERM` promises them, unless the call says otherwise.
    pub(crate) fn start(mut program: Command, (columns, rows): (u16, u16)) -> Self {
        let (master, slave) = opened_ends();
        let before = tcgetattr(&slave).unwrap();
        let seen = Arc::new(Mutex::new(Seen { screen: vt100::Parser::new(length(rows), length(columns), 0), bytes: Vec::new() }));
        let (mut reader, kept) = (master.try_clone().unwrap(), Arc::clone(&seen));
        tcsetwinsize(&slave, size(columns, rows)).unwrap();
        let end = || slave.try_clone().unwrap();
        let child = program.stdin(end()).stdout(end()).stderr(end()).env("TERM", "xterm-256color").spawn().unwrap();
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = reader.read(&mut bytes) {
                let mut seen = kept.lock().unwrap();
                seen.screen.process(&bytes[..count]);
                seen.bytes.extend_from_slice(&bytes[..count]);
            }
        });
        PseudoTerminal { child, master, slave, before, seen }
    }

    /// Its process number.
    pub(crate) fn number(&self) -> u32 {
        self.child.id()
    }

    /// Presses keys.
    pub(crate) fn press(&mut self, keys: &str) {
        self.master.write_all(keys.as_bytes()).unwrap();
    }

    /// Makes it larger or smaller.
    pub(crate) fn resize(&self, columns: u16, rows: u16) {
        let mut seen = self.seen.lock().unwrap();
        tcsetwinsize(&self.slave, size(columns, rows)).unwrap();
        seen.screen.screen_mut().set_size(length(rows), length(columns));
    }

    /// The rows as they stand there now.
    pub(crate) fn rows(&self) -> Vec<String> {
        let seen = self.seen.lock().unwrap();
        let (_, columns) = seen.screen.screen().size();
        seen.screen.screen().rows(0, columns.get()).collect()
    }

    /// Whether the screen has all of these words now.
    pub(crate) fn shows(&self, words: &[&str]) -> bool {
        let rows = self.rows().join("\n");
        words.iter().all(|word| rows.contains(word))
    }

    /// Waits until it has all of these words.
    pub(crate) fn wait_for(&self, words: &[&str]) {
        until(&format!("{words:?} on the screen"), || self.shows(words));
    }

    /// Whether the first place of these words is coloured.
    pub(crate) fn is_coloured(&self, words: &str) -> bool {
        let rows = self.rows();
        let place = rows.iter().enumerate().find_map(|(y, row)| Some((y, row[..row.find(words)?].chars().count())));
        let (y, x) = place.unwrap_or_else(|| panic!("{words} is not there: {rows:#?}"));
        let seen = self.seen.lock().unwrap();
        let cell = seen.screen.screen().cell(y as u16, x as u16).unwrap();
        cell.fgcolor() != vt100::Color::Default
    }

    /// Whether the program shows a screen now.
    pub(crate) fn is_screen(&self) -> bool {
        self.seen.lock().unwrap().screen.screen().alternate_screen()
    }

    /// Whether the settings are those before the program.
    pub(crate) fn is_as_before(&self) -> bool {
        let (before, now) = (&self.before, tcgetattr(&self.slave).unwrap());
        (before.input_modes, before.output_modes, before.local_modes) == (now.input_modes, now.output_modes, now.local_modes)
    }

    /// Somebody else writes to it.
    pub(crate) fn scribble(&mut self, text: &str) {
        self.slave.write_all(text.as_bytes()).unwrap();
    }

    /// Everything that was written so far.
    pub(crate) fn bytes(&self) -> String {
        String::from_utf8_lossy(&self.seen.lock().unwrap().bytes).into_owned()
    }

    /// Waits for its end: the exit status, after checking that the terminal is as it was.
    pub(crate) fn ended(&mut self) -> i32 {
        let mut status = None;
        until("the program has ended", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        // What is written behind it comes after it; no terminal shows this one.
        self.slave.write_all(b"\0").unwrap();
        until("what it wrote last has been read", || self.seen.lock().unwrap().bytes.contains(&0));
        let (alternate, hidden) = {
            let seen = self.seen.lock().unwrap();
            (seen.screen.screen().alternate_screen(), seen.screen.screen().hide_cursor())
        };
        assert!(!alternate && !hidden, "the screen was not given back");
        let (before, after) = (&self.before, tcgetattr(&self.slave).unwrap());
        assert_eq!(
            (before.input_modes, before.output_modes, before.control_modes, before.local_modes),
            (after.input_modes, after.output_modes, after.control_modes, after.local_modes)
        );
        status.and_then(|status| status.code()).unwrap_or(-1)
    }
}

impl Drop for PseudoTerminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn length(cells: u16) -> NonZeroU16 {
    NonZeroU16::new(cells).unwrap()
}

fn size(columns: u16, rows: u16) -> Winsize {
    Winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 }
}
