//! Options that write one file for each recording: its name, or a directory for several.

use crate::command::options::telemetry_source::RecordingSource;
use crate::command::terminal::output_file::refuse_to_overwrite;
use sideslip::error::Failure;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// An option that gives a file for each recording.
pub(super) struct OutputPerRecording {
    pub(super) option: &'static str,
    /// Endings that its files can have; the first where only a directory was named.
    pub(super) endings: &'static [&'static str],
}

/// The logs of `--out`.
pub(super) const LOGS: OutputPerRecording = OutputPerRecording { option: "--out", endings: &["mcap"] };

impl OutputPerRecording {
    /// The file of each recording, in their order; nothing is made yet.
    pub(super) fn places(&self, out: Option<&Path>, sources: &[RecordingSource]) -> Result<Vec<Option<PathBuf>>, Failure> {
        let Some(out) = out else { return Ok(vec![None; sources.len()]) };
        let OutputPerRecording { option, endings } = self;
        let usual = endings.first().copied().unwrap_or_default();
        let places: Vec<PathBuf> = if sources.len() == 1 && !names_directory(out) {
            vec![out.to_path_buf()]
        } else if out.exists() && !out.is_dir() {
            let what = format_args!("{option}: expected a directory for the files of {} recordings, found a file", sources.len());
            return Err(Failure::file(out, what));
        } else {
            sources.iter().map(|source| out.join(format!("{}.{usual}", source.stem()))).collect()
        };
        let read: Vec<PathBuf> = sources.iter().flat_map(RecordingSource::files).collect();
        let mut seen = BTreeSet::new();
        for place in &places {
            // Without an ending it is clear only where there is one format.
            let unclear =
                |ending: Option<&OsStr>| ending.map_or(endings.len() > 1, |ending| endings.iter().all(|known| ending != *known));
            if unclear(place.extension()) || place.as_os_str() == "-" {
                let what = format_args!("{option}: expected a name that ends in .{}", endings.join(" or ."));
                return Err(Failure::file(place, what));
            }
            if !seen.insert(place) {
                let what = format_args!("{option}: two recordings of that name would have the same file");
                return Err(Failure::file(place, what));
            }
            refuse_to_overwrite(option, place, &read)?;
        }
        Ok(places.into_iter().map(Some).collect())
    }
}

/// Whether the path stands for a directory: it is one, or ends as one.
fn names_directory(path: &Path) -> bool {
    path.is_dir() || path.as_os_str().to_string_lossy().ends_with('/')
}

/// Makes the directory of such files where it is missing.
pub(super) fn make_directory(out: Option<&Path>, logs: &[Option<PathBuf>]) -> Result<(), Failure> {
    match out {
        Some(out) if logs.len() > 1 || names_directory(out) => {
            std::fs::create_dir_all(out).map_err(|error| Failure::io(out, &error))
        }
        _ => Ok(()),
    }
}
