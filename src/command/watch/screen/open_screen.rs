//! The terminal as a screen: alternate buffer, raw keys, no cursor; as it was before whatever ends or stops the program, a panic
//! and ctrl-Z too.

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::execute;
use ratatui::crossterm::style::ResetColor;
use ratatui::crossterm::terminal::{
    Clear, ClearType, DisableLineWrap, EnableLineWrap, EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode,
    enable_raw_mode,
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Signal, getpgrp, kill_current_process_group};
use rustix::termios::tcgetpgrp;
use signal_hook::consts::{SIGCONT, SIGTSTP};
use signal_hook::low_level::emulate_default_handler;
use std::fs::File;
use std::io::{BufWriter, IsTerminal, Result, Stdout, stdin, stdout};
use std::os::fd::{AsFd, OwnedFd};
use std::panic::{set_hook, take_hook};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Whether the terminal is a screen now.
static OPEN: AtomicBool = AtomicBool::new(false);

/// The terminal, a screen until this is dropped.
pub(crate) struct OpenScreen {
    pub(super) terminal: Terminal<CrosstermBackend<BufWriter<Stdout>>>,
    /// What the keys are read from.
    keyboard: OwnedFd,
    /// SIGTSTP came: the terminal is to be given back and the program stopped.
    stopping: Arc<AtomicBool>,
    /// SIGCONT came: whoever had the terminal meanwhile left it as he liked.
    continued: Arc<AtomicBool>,
}

impl OpenScreen {
    /// Makes it a screen.
    ///
    /// # Errors
    /// The system's, where there is no terminal to read keys from or it does not take what is written.
    pub(crate) fn open() -> Result<Self> {
        let keyboard = if stdin().is_terminal() { stdin().as_fd().try_clone_to_owned()? } else { File::open("/dev/tty")?.into() };
        let (stopping, continued) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        signal_hook::flag::register(SIGTSTP, Arc::clone(&stopping))?;
        signal_hook::flag::register(SIGCONT, Arc::clone(&continued))?;
        enable_raw_mode()?;
        OPEN.store(true, Ordering::SeqCst);
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            close();
            before(panic);
        }));
        match entered() {
            Ok(terminal) => Ok(OpenScreen { terminal, keyboard, stopping, continued }),
            Err(error) => {
                close();
                Err(error)
            }
        }
    }

    /// Ctrl-Z, which raw keys make no signal of: what the terminal would send, to the jobs that it shows; to this process alone
    /// where it is not the terminal's.
    pub(super) fn stop(&self) {
        let of_terminal = tcgetpgrp(&self.keyboard).is_ok_and(|shown| shown == getpgrp());
        if !(of_terminal && kill_current_process_group(Signal::TSTP).is_ok()) {
            self.stopping.store(true, Ordering::SeqCst);
        }
    }

    /// Gives the terminal back and stops where that was asked for; whether everything is to be drawn anew, because the program
    /// goes on after a stop.
    ///
    /// # Errors
    /// The system's, where the terminal is no screen again.
    pub(super) fn stop_and_go_on(&mut self) -> Result<bool> {
        if self.stopping.swap(false, Ordering::SeqCst) {
            close();
            emulate_default_handler(SIGTSTP)?;
            // Going on from here is what SIGCONT says, too.
            self.continued.store(true, Ordering::SeqCst);
        }
        if !self.continued.swap(false, Ordering::SeqCst) {
            return Ok(false);
        }
        // A stop that could not be caught has left the screen as it was, and others have set the terminal since.
        close();
        enable_raw_mode()?;
        OPEN.store(true, Ordering::SeqCst);
        // A new one draws every cell; to clear the old one would ask the terminal for its cursor, which may never answer.
        self.terminal = entered()?;
        execute!(stdout(), Clear(ClearType::All))?;
        Ok(true)
    }

    /// Waits that long for a key or a signal; whether the terminal is still there. Reading keys from one that has gone never
    /// ends.
    ///
    /// # Errors
    /// The system's.
    pub(super) fn wait_for_keys(&self, wait: Duration) -> Result<bool> {
        let mut keyboard = [PollFd::new(&self.keyboard, PollFlags::IN)];
        let wait = Timespec::try_from(wait).unwrap_or(Timespec { tv_sec: 0, tv_nsec: 0 });
        match poll(&mut keyboard, Some(&wait)) {
            Ok(_) => {
                let [keyboard] = keyboard;
                Ok(!keyboard.revents().intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL))
            }
            Err(Errno::INTR) => Ok(true),
            Err(error) => Err(error.into()),
        }
    }
}

impl Drop for OpenScreen {
    fn drop(&mut self) {
        close();
    }
}

fn entered() -> Result<Terminal<CrosstermBackend<BufWriter<Stdout>>>> {
    execute!(stdout(), EnterAlternateScreen, DisableLineWrap)?;
    Terminal::new(CrosstermBackend::new(BufWriter::new(stdout())))
}

/// Gives the terminal back, once; one that is gone needs nothing back.
fn close() {
    if OPEN.swap(false, Ordering::SeqCst) {
        let _ = execute!(stdout(), ResetColor, EnableLineWrap, LeaveAlternateScreen, Show);
        let _ = disable_raw_mode();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Run by the test of terminals as a process of its own.
    #[test]
    #[ignore = "needs a terminal: run as a process of its own by a test of the screen"]
    fn a_screen_that_panics() {
        let mut opened = OpenScreen::open().unwrap();
        opened.terminal.draw(|frame| frame.render_widget("still a screen", frame.area())).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(200));
        panic!("on purpose");
    }
}
