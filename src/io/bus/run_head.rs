//! Description of a run by its telemetry process before the first sample: one small file in the root for each incarnation.
//!
//! Written atomically and named by the incarnation that every sample carries, so that an estimator that starts late or is
//! restarted reads the description that belongs to its samples. The last few files are kept for estimators that are behind.

use super::error::BusError;
use super::root::BusRoot;
use crate::flight::file::log_head::LogHead;
use std::collections::BTreeMap;
use std::path::PathBuf;

const PLAYING: &str = "playing";

/// What the next telemetry needs to go on with the vehicle.
const VEHICLE: &str = "vehicle";

const KEPT: usize = 8;

fn place(root: &BusRoot, incarnation: u64) -> PathBuf {
    root.heads().join(format!("{incarnation:020}.json"))
}

/// Writes the head of an incarnation's run. Call it before the first sample.
///
/// # Errors
/// [`BusError::Root`] where the file cannot be written.
pub fn write_head(root: &BusRoot, incarnation: u64, head: &LogHead) -> Result<(), BusError> {
    let place = place(root, incarnation);
    let wrong = |what: String| BusError::Root { path: place.clone(), what };
    let text = serde_json::to_vec(&head.to_metadata("sideslip")).map_err(|error| wrong(error.to_string()))?;
    let directory = root.heads();
    let partial = directory.join(format!("{}.partial", std::process::id()));
    let written = std::fs::create_dir_all(&directory)
        .and_then(|()| std::fs::write(&partial, text))
        .and_then(|()| std::fs::rename(&partial, &place));
    written.map_err(|error| wrong(error.to_string()))?;
    let Ok(entries) = std::fs::read_dir(&directory) else { return Ok(()) };
    let mut heads: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    heads.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    heads.sort();
    for old in heads.iter().rev().skip(KEPT) {
        let _ = std::fs::remove_file(old);
    }
    Ok(())
}

/// The head of an incarnation's run; `None` where it has none (any more).
///
/// # Errors
/// [`BusError::Root`] where there is one and it cannot be understood.
pub fn read_head(root: &BusRoot, incarnation: u64) -> Result<Option<LogHead>, BusError> {
    let place = place(root, incarnation);
    let wrong = |what: String| BusError::Root { path: place.clone(), what };
    let text = match std::fs::read(&place) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(wrong(error.to_string())),
    };
    let texts: BTreeMap<String, String> = serde_json::from_slice(&text).map_err(|error| wrong(error.to_string()))?;
    LogHead::from_metadata(&texts).map(Some).map_err(|error| wrong(error.to_string()))
}

/// The head that was written last; `None` before the first.
///
/// # Errors
/// [`BusError::Root`] where it cannot be understood.
pub fn newest_head(root: &BusRoot) -> Result<Option<LogHead>, BusError> {
    let Ok(entries) = std::fs::read_dir(root.heads()) else { return Ok(None) };
    let number = |path: PathBuf| {
        if path.extension()? != "json" {
            return None;
        }
        path.file_stem()?.to_str()?.parse::<u64>().ok()
    };
    let newest = entries.flatten().filter_map(|entry| number(entry.path())).max();
    newest.map_or(Ok(None), |incarnation| read_head(root, incarnation))
}

/// When the first telemetry under this supervisor began, monotonic clock, ns: set once, so that one that is started again
/// knows that it is, and goes on with a recording where that would be now.
///
/// # Errors
/// [`BusError::Root`] where the file cannot be read or written.
pub fn playing_since(root: &BusRoot, now_ns: u64) -> Result<u64, BusError> {
    let place = root.heads().join(PLAYING);
    let wrong = |error: std::io::Error| BusError::Root { path: place.clone(), what: error.to_string() };
    match std::fs::read_to_string(&place) {
        Ok(text) => {
            let refused = || BusError::Root { path: place.clone(), what: "expected nanoseconds, found something else".into() };
            text.trim().parse().map_err(|_| refused())
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let partial = root.heads().join(format!("{}.partial", std::process::id()));
            std::fs::create_dir_all(root.heads()).map_err(wrong)?;
            std::fs::write(&partial, now_ns.to_string()).and_then(|()| std::fs::rename(&partial, &place)).map_err(wrong)?;
            Ok(now_ns)
        }
        Err(error) => Err(wrong(error)),
    }
}

/// Forgets what was played before, and the vehicle.
pub fn play_anew(root: &BusRoot) {
    for name in [PLAYING, VEHICLE] {
        let _ = std::fs::remove_file(root.heads().join(name));
    }
}

/// Writes down what a live vehicle's clock is known to be, by name: for telemetry that takes the place of one that died.
///
/// # Errors
/// [`BusError::Root`] where the file cannot be written.
pub fn write_vehicle(root: &BusRoot, numbers: &BTreeMap<&str, i64>) -> Result<(), BusError> {
    let place = root.heads().join(VEHICLE);
    let wrong = |what: String| BusError::Root { path: place.clone(), what };
    let text = serde_json::to_vec(numbers).map_err(|error| wrong(error.to_string()))?;
    let partial = place.with_file_name(format!("{}.partial", std::process::id()));
    let written = std::fs::write(&partial, text).and_then(|()| std::fs::rename(&partial, &place));
    written.map_err(|error| wrong(error.to_string()))
}

/// What was written down of the vehicle; `None` where nothing was.
///
/// # Errors
/// [`BusError::Root`] where it cannot be understood.
pub fn read_vehicle(root: &BusRoot) -> Result<Option<BTreeMap<String, i64>>, BusError> {
    let place = root.heads().join(VEHICLE);
    let wrong = |what: String| BusError::Root { path: place.clone(), what };
    match std::fs::read(&place) {
        Ok(text) => serde_json::from_slice(&text).map(Some).map_err(|error| wrong(error.to_string())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(wrong(error.to_string())),
    }
}
