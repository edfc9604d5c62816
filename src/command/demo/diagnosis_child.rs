//! `sideslip diagnose` as a process of its own: all runs against the Level-1 simulation.

use super::child_guard::{ChildGuard, stopped_early};
use super::test_flight::DENSITY;
use crate::command::message;
use crate::command::options::replace_option::ReplaceOption;
use serde_json::Value;
use sideslip::error::Failure;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Polling interval of its end.
const POLL: Duration = Duration::from_millis(50);

/// Numbers, words, pages and models, those of a test point with its number.
pub(super) const DIAGNOSIS: &str = "diagnosis.json";
pub(super) const WORDS: &str = "diagnosis.txt";
pub(super) const PAGES: &str = "report.html";
pub(super) const EXTENDED: &str = "puma-extended.toml";

pub(super) struct DiagnosisFiles {
    pub(super) answer: Value,
    pub(super) json: PathBuf,
    pub(super) said: PathBuf,
}

/// Diagnoses the runs that are fitted, and measures the improvement on the hold-out runs.
pub(super) fn diagnosed(fit: &[PathBuf], kept: &[PathBuf], out: &Path, stop: &AtomicBool) -> Result<DiagnosisFiles, Failure> {
    let failed = |error: std::io::Error| Failure::Running(format!("the diagnosis cannot be started: {error}"));
    let [json, said, pages] = [DIAGNOSIS, WORDS, PAGES].map(|name| out.join(name));
    let file = File::create(&said).map_err(|error| Failure::io(&said, &error))?;
    let mut call = Command::new(std::env::current_exe().map_err(failed)?);
    call.args(["diagnose", "--model", "puma", "--density", DENSITY, "--fit"]).args(fit).arg("--holdout").args(kept);
    call.arg("--json").arg(&json).arg("--html").arg(&pages).arg("--extended").arg(out.join(EXTENDED));
    // What stands there was refused before the flights.
    call.arg(ReplaceOption::FORCE);
    let mut process = ChildGuard(call.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file).spawn().map_err(failed)?);
    let mut told = 0;
    let status = loop {
        if stop.load(Ordering::Relaxed) {
            return Err(stopped_early());
        }
        let text = std::fs::read_to_string(&said).unwrap_or_default();
        let points: Vec<&str> = text.lines().filter(|line| line.starts_with("test point ")).collect();
        points.iter().skip(told).for_each(|line| message(format_args!("  {line}")));
        told = told.max(points.len());
        match process.0.try_wait().map_err(failed)? {
            Some(status) => break status,
            None => std::thread::sleep(POLL),
        }
    };
    // 3: rows were skipped or a run was set aside, which is said in its text.
    if !matches!(status.code(), Some(0 | 3)) {
        return Err(Failure::Running(format!("the diagnosis failed; see {}", said.display())));
    }
    let text = std::fs::read_to_string(&json).map_err(|error| Failure::io(&json, &error))?;
    let answer = serde_json::from_str(&text).map_err(|error| Failure::Running(format!("{}: {error}", json.display())))?;
    Ok(DiagnosisFiles { answer, json, said })
}
