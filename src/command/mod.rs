//! The commands, one file each: they join readers, pipeline, simulation and outputs; no mathematics here.

pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod design;
pub(crate) mod diagnose;
pub(crate) mod estimate;
pub(crate) mod identify;
pub(crate) mod ingest;
pub(crate) mod inspect;
pub(crate) mod linearise;
pub(crate) mod live;
pub(crate) mod man;
mod options;
mod recordings;
pub(crate) mod replay;
pub(crate) mod simulate;
mod terminal;
pub(crate) mod watch;

use std::path::PathBuf;
pub(crate) use terminal::console::{finish, message, message_text};
pub(crate) use terminal::stop::file_size_limit_is_an_error;

/// Directory that the processes of a run share: as named, or the user's own place.
pub(crate) fn root_path(named: Option<&PathBuf>) -> PathBuf {
    named.cloned().unwrap_or_else(sideslip::io::bus::root::BusRoot::default_path)
}

/// How long a restarted process waits for its role, because its predecessor may be ending; others are refused at once.
pub(crate) fn patience(supervised: bool) -> std::time::Duration {
    std::time::Duration::from_secs(if supervised { 10 } else { 0 })
}
