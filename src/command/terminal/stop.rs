//! What ends a command before its work is done: a signal, or the end of the process that started it.

use sideslip::error::Failure;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use std::io::Read;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Two signals closer than this are one.
const SAID_TWICE: Duration = Duration::from_millis(500);

/// The flag of this process, for what would wait for a terminal.
static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Whether a command that ends by [`stopped_by_signals`] was asked to.
pub(crate) fn is_asked_to_stop() -> bool {
    STOP.get().is_some_and(|stop| stop.load(Ordering::Relaxed))
}

/// A file that reaches the limit of its size (`ulimit -f`) is a write error, which is reported, and no silent end.
pub(crate) fn file_size_limit_is_an_error() {
    // Where the signal cannot be caught, the process ends by it as before.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
}

/// A flag that the first SIGINT, SIGTERM or SIGHUP sets; another one, half a second later or more, ends the process at once.
/// Sooner it is the same wish said twice, as `timeout` and shells do that signal a process and its group.
pub(crate) fn stopped_by_signals() -> Result<Arc<AtomicBool>, Failure> {
    let (stop, insists) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register_conditional_shutdown(signal, 1, Arc::clone(&insists))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
            .map_err(|error| Failure::Running(format!("signals cannot be caught: {error}")))?;
    }
    let _ = STOP.set(Arc::clone(&stop));
    let asked = Arc::clone(&stop);
    let arm = move || {
        while !asked.load(Ordering::Relaxed) {
            std::thread::sleep(SAID_TWICE / 5);
        }
        std::thread::sleep(SAID_TWICE);
        insists.store(true, Ordering::Relaxed);
    };
    let started = std::thread::Builder::new().name("sideslip-signal".to_owned()).spawn(arm);
    started.map_err(|error| Failure::Running(format!("no thread could be started: {error}")))?;
    Ok(stop)
}

/// The flag of [`stopped_by_signals`], which is asked for once: a signal that came stays known to what follows.
pub(crate) fn stop_flag() -> Result<Arc<AtomicBool>, Failure> {
    STOP.get().map_or_else(stopped_by_signals, |stop| Ok(Arc::clone(stop)))
}

/// In a process that another started: stop where standard input ends.
pub(crate) fn supervised(is: bool, stop: &Arc<AtomicBool>) -> Result<(), Failure> {
    if is {
        let stop = Arc::clone(stop);
        let listen = move || {
            let mut bytes = [0; 64];
            while std::io::stdin().read(&mut bytes).is_ok_and(|read| read > 0) {}
            stop.store(true, Ordering::Relaxed);
        };
        let started = std::thread::Builder::new().name("sideslip-parent".to_owned()).spawn(listen);
        started.map_err(|error| Failure::Running(format!("no thread could be started: {error}")))?;
    }
    Ok(())
}
