//! A supervised process of this program: started, polled, restarted after a pause, ended by closing its input.

use crate::command::message;
use sideslip::error::Failure;
use std::os::fd::OwnedFd;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child as Process, ChildStdin, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Pause before another start; doubles with each death that follows soon, up to [`LONGEST`].
const SHORTEST: Duration = Duration::from_millis(10);
const LONGEST: Duration = Duration::from_millis(250);
/// Who lived that long died of something new.
const LIVED: Duration = Duration::from_millis(250);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProcessExit {
    /// By itself, with what it had to do done.
    Finished,
    /// By a signal or a failure.
    Killed,
    /// Because its call or its input is wrong: another start would end the same.
    WrongCall,
}

/// A process that is kept alive.
pub(super) struct SupervisedProcess {
    name: &'static str,
    call: Vec<String>,
    /// What it gets as its standard output: a socket that outlives it.
    held: Option<OwnedFd>,
    running: Option<(Process, ChildStdin, Instant)>,
    /// Exit status of the last one that ended by itself.
    finished: Option<i32>,
    pause: Duration,
    due: Option<Instant>,
    restarts: u64,
    /// How often it ended with a failure of its own, not by a signal.
    failures: u64,
}

impl SupervisedProcess {
    /// The command of that name, with those arguments; not started yet.
    pub(super) fn new(name: &'static str, call: Vec<String>, held: Option<OwnedFd>) -> Self {
        SupervisedProcess {
            name,
            call,
            held,
            running: None,
            finished: None,
            pause: SHORTEST,
            due: None,
            restarts: 0,
            failures: 0,
        }
    }

    pub(super) fn name(&self) -> &'static str {
        self.name
    }

    /// How often it was started again.
    pub(super) fn restarts(&self) -> u64 {
        self.restarts
    }

    /// How often it ended with a failure that it said itself.
    pub(super) fn failures(&self) -> u64 {
        self.failures
    }

    /// Starts it. It is in a process group of its own: ctrl-C reaches the supervisor alone, which ends it in order.
    pub(super) fn start(&mut self) -> Result<(), Failure> {
        let failed = |error: std::io::Error| Failure::Running(format!("{} cannot be started: {error}", self.name));
        let program = std::env::current_exe().map_err(failed)?;
        let mut command = Command::new(program);
        command.arg(self.name).arg("--supervised").args(&self.call).stdin(Stdio::piped()).process_group(0);
        if let Some(held) = &self.held {
            command.arg("--held").stdout(held.try_clone().map_err(failed)?);
        }
        let mut process = command.spawn().map_err(failed)?;
        let Some(input) = process.stdin.take() else {
            return Err(Failure::Running(format!("{} has no standard input", self.name)));
        };
        message(format_args!("sideslip: {} is process {}", self.name, process.id()));
        self.running = Some((process, input, Instant::now()));
        self.due = None;
        Ok(())
    }

    /// Starts it again once its pause is over.
    pub(super) fn start_when_due(&mut self) -> Result<(), Failure> {
        if self.due.is_some_and(|due| Instant::now() >= due) {
            self.restarts += 1;
            self.start()?;
        }
        Ok(())
    }

    /// Whether it has died since the last poll, and how; it is reported, and the pause begins.
    pub(super) fn poll_exit(&mut self) -> Result<Option<ProcessExit>, Failure> {
        let Some((process, _, started)) = &mut self.running else { return Ok(None) };
        let polled = process.try_wait().map_err(|error| Failure::Running(format!("{}: {error}", self.name)))?;
        let Some(status) = polled else { return Ok(None) };
        let (number, lived) = (process.id(), started.elapsed());
        self.running = None;
        if let Some(0 | 3) = status.code() {
            self.finished = status.code();
            self.due = Some(Instant::now() + self.pause);
            return Ok(Some(ProcessExit::Finished));
        }
        if status.code() == Some(2) {
            return Ok(Some(ProcessExit::WrongCall));
        }
        self.failures += u64::from(status.code().is_some());
        self.pause = if lived >= LIVED { SHORTEST } else { (self.pause * 2).min(LONGEST) };
        self.due = Some(Instant::now() + self.pause);
        message(format_args!(
            "sideslip: {} (process {number}) ended {} after {:.2} s; it is started again",
            self.name,
            how(status),
            lived.as_secs_f64()
        ));
        Ok(Some(ProcessExit::Killed))
    }

    /// Kills it, because it does nothing any more; the next poll finds it dead.
    pub(super) fn kill(&mut self, why: &str) {
        if let Some((process, _, _)) = &mut self.running {
            message(format_args!("sideslip: {} (process {}) {why}; it is killed", self.name, process.id()));
            let _ = process.kill();
        }
    }

    /// How long it has been running.
    pub(super) fn age(&self) -> Duration {
        self.running.as_ref().map_or(Duration::ZERO, |(_, _, started)| started.elapsed())
    }

    /// Ends it by its input and waits; `None` where it had to be killed or ended by a signal.
    pub(super) fn end(&mut self, limit: Duration) -> Result<Option<i32>, Failure> {
        let Some((mut process, input, _)) = self.running.take() else { return Ok(self.finished) };
        drop(input);
        let begun = Instant::now();
        loop {
            let polled = process.try_wait().map_err(|error| Failure::Running(format!("{}: {error}", self.name)))?;
            match polled {
                Some(status) => return Ok(status.code()),
                None if begun.elapsed() < limit => std::thread::sleep(Duration::from_millis(2)),
                None => {
                    message(format_args!("sideslip: {} does not end; it is killed", self.name));
                    let killed = process.kill().and_then(|()| process.wait());
                    killed.map_err(|error| Failure::Running(format!("{}: {error}", self.name)))?;
                    return Ok(None);
                }
            }
        }
    }
}

fn how(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("with exit status {code}"),
        (None, Some(signal)) => format!("by signal {signal}"),
        (None, None) => "in an unknown way".to_owned(),
    }
}
