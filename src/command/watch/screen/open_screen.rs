//! The terminal as a screen: alternate buffer, raw keys, no cursor; as it was before whatever ends the program, a panic too.

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::execute;
use ratatui::crossterm::style::ResetColor;
use ratatui::crossterm::terminal::{
    DisableLineWrap, EnableLineWrap, EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use std::io::{BufWriter, Result, Stdout, stdout};
use std::panic::{set_hook, take_hook};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the terminal is a screen now.
static OPEN: AtomicBool = AtomicBool::new(false);

/// The terminal, a screen until this is dropped.
pub(crate) struct OpenScreen {
    pub(super) terminal: Terminal<CrosstermBackend<BufWriter<Stdout>>>,
}

impl OpenScreen {
    /// Makes it a screen.
    ///
    /// # Errors
    /// The system's, where there is no terminal to read keys from or it does not take what is written.
    pub(crate) fn open() -> Result<Self> {
        enable_raw_mode()?;
        OPEN.store(true, Ordering::SeqCst);
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            close();
            before(panic);
        }));
        let opened = execute!(stdout(), EnterAlternateScreen, DisableLineWrap)
            .and_then(|()| Terminal::new(CrosstermBackend::new(BufWriter::new(stdout()))));
        match opened {
            Ok(terminal) => Ok(OpenScreen { terminal }),
            Err(error) => {
                close();
                Err(error)
            }
        }
    }
}

impl Drop for OpenScreen {
    fn drop(&mut self) {
        close();
    }
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
