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

/// The setup (TMATS) that a recorder sent, for telemetry that takes the place of one that died: it may not come again.
const SETUP: &str = "setup";

/// The count of a recorder's time at which the run's time is zero, for the same.
const COUNTER: &str = "counter";

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

/// Forgets what was played before, the vehicle, and the setup.
pub fn play_anew(root: &BusRoot) {
    for name in [PLAYING, VEHICLE, SETUP, COUNTER] {
        let _ = std::fs::remove_file(root.heads().join(name));
    }
}

/// Writes down the setup that a recorder sent.
///
/// # Errors
/// [`BusError::Root`] where the file cannot be written.
pub fn write_setup(root: &BusRoot, text: &[u8]) -> Result<(), BusError> {
    write_whole(root, SETUP, text)
}

/// The setup that was written down; `None` where none was.
///
/// # Errors
/// [`BusError::Root`] where it cannot be read.
pub fn read_setup(root: &BusRoot) -> Result<Option<Vec<u8>>, BusError> {
    read_whole(root, SETUP)
}

/// Writes down the count of a recorder's time at which the run's time is zero.
///
/// # Errors
/// [`BusError::Root`] where the file cannot be written.
pub fn write_counter(root: &BusRoot, zero: i64) -> Result<(), BusError> {
    write_whole(root, COUNTER, zero.to_string().as_bytes())
}

/// The count that was written down; `None` where none was, or what stands there is no number.
///
/// # Errors
/// [`BusError::Root`] where it cannot be read.
pub fn read_counter(root: &BusRoot) -> Result<Option<i64>, BusError> {
    let text = read_whole(root, COUNTER)?;
    Ok(text.and_then(|text| String::from_utf8(text).ok()?.trim().parse().ok()))
}

fn write_whole(root: &BusRoot, name: &str, text: &[u8]) -> Result<(), BusError> {
    let place = root.heads().join(name);
    let partial = place.with_file_name(format!("{}.partial", std::process::id()));
    let written = std::fs::create_dir_all(root.heads())
        .and_then(|()| std::fs::write(&partial, text))
        .and_then(|()| std::fs::rename(&partial, &place));
    written.map_err(|error| BusError::Root { path: place.clone(), what: error.to_string() })
}

fn read_whole(root: &BusRoot, name: &str) -> Result<Option<Vec<u8>>, BusError> {
    let place = root.heads().join(name);
    match std::fs::read(&place) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(BusError::Root { path: place, what: error.to_string() }),
    }
}

/// Writes down what a live vehicle's clock is known to be, by name: for telemetry that takes the place of one that died.
///
/// # Errors
/// [`BusError::Root`] where the file cannot be written.
pub fn write_vehicle(root: &BusRoot, numbers: &BTreeMap<&str, i64>) -> Result<(), BusError> {
    let wrong = |what: String| BusError::Root { path: root.heads().join(VEHICLE), what };
    let text = serde_json::to_vec(numbers).map_err(|error| wrong(error.to_string()))?;
    write_whole(root, VEHICLE, &text)
}

/// What was written down of the vehicle; `None` where nothing was.
///
/// # Errors
/// [`BusError::Root`] where it cannot be understood.
pub fn read_vehicle(root: &BusRoot) -> Result<Option<BTreeMap<String, i64>>, BusError> {
    let wrong = |what: String| BusError::Root { path: root.heads().join(VEHICLE), what };
    let Some(text) = read_whole(root, VEHICLE)? else { return Ok(None) };
    serde_json::from_slice(&text).map(Some).map_err(|error| wrong(error.to_string()))
}
