//! `sideslip live` as a process of its own, and what it leaves behind.

use super::child_guard::ChildGuard;
use crate::command::message;
use crate::command::options::replace_option::ReplaceOption;
use sideslip::error::{Failure, Outcome};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The longest that it may take to end.
const ENDING: Duration = Duration::from_secs(30);

/// What the processes of a run say.
pub(super) const SAID: &str = "processes.log";

/// The process; it ends with this one, however that ends.
pub(super) struct LiveChild {
    process: ChildGuard,
    log: PathBuf,
    out: PathBuf,
}

impl LiveChild {
    /// Starts it for a run (`run=NAME`): telemetry from that URL, logs into `out`, the numbers into `json`. What it says goes
    /// into a file.
    pub(super) fn start(run: &str, url: &str, root: &Path, out: &Path, json: &Path) -> Result<Self, Failure> {
        let failed = |error: std::io::Error| Failure::Running(format!("live cannot be started: {error}"));
        let log = out.join(SAID);
        let said = File::create(&log).map_err(|error| Failure::io(&log, &error))?;
        let mut call = Command::new(std::env::current_exe().map_err(failed)?);
        call.args(["live", "--supervised", "--source", url, "--set", run, "--set", "aircraft=puma", "--root"]).arg(root);
        call.arg("--out").arg(out).arg("--json").arg(json).arg(ReplaceOption::FORCE);
        let process = call.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(said).spawn().map_err(failed)?;
        Ok(LiveChild { process: ChildGuard(process), log, out: out.into() })
    }

    pub(super) fn log(&self) -> &Path {
        &self.log
    }

    /// The log that it wrote: as it said itself.
    pub(super) fn recording(&self) -> PathBuf {
        let said = std::fs::read_to_string(&self.log).unwrap_or_default();
        let named = said.lines().filter_map(|line| line.strip_prefix("sideslip: logging to ")).next_back();
        named.map_or_else(|| self.out.clone(), PathBuf::from)
    }

    /// A failure where it has ended already.
    pub(super) fn must_run(&mut self) -> Result<(), Failure> {
        match self.process.0.try_wait() {
            Ok(None) => Ok(()),
            Ok(Some(_)) => Err(Failure::Running(format!("live has ended; see {}", self.log.display()))),
            Err(error) => Err(Failure::Running(format!("live: {error}"))),
        }
    }

    /// Ends it in order: the log closed, the numbers written.
    pub(super) fn end(&mut self) -> Result<Outcome, Failure> {
        drop(self.process.0.stdin.take());
        let begun = Instant::now();
        while begun.elapsed() < ENDING {
            match self.process.0.try_wait().map_err(|error| Failure::Running(format!("live: {error}")))? {
                None => std::thread::sleep(Duration::from_millis(5)),
                Some(status) if status.code() == Some(0) => return Ok(Outcome::Done),
                Some(status) if status.code() == Some(3) => {
                    message(format_args!("sideslip: data were lost; see {}", self.log.display()));
                    return Ok(Outcome::DataLost);
                }
                Some(_) => return Err(Failure::Running(format!("live failed; see {}", self.log.display()))),
            }
        }
        Err(Failure::Running(format!("live does not end; see {}", self.log.display())))
    }
}
