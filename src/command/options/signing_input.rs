//! `--signing-key`: the key of MAVLink 2 signing, and the file of its timestamps beside it.

use sideslip::error::Failure;
use sideslip::io::telemetry::mavlink::signing::LinkSigning;
use sideslip::io::telemetry::mavlink::signing_key::{KeyError, SigningKey};
use sideslip::io::telemetry::mavlink::signing_time::{SigningTime, system_steps};
use std::path::{Path, PathBuf};

/// Number of the link that telemetry comes from, in signatures.
pub(crate) const SOURCE_LINK: u8 = 0;
/// Number of the link to the ground station: the two processes sign with timestamps of their own.
pub(crate) const STATION_LINK: u8 = 1;

/// Reads the key.
pub(crate) fn read_key(file: &Path) -> Result<SigningKey, Failure> {
    SigningKey::read(file).map_err(|wrong| match wrong {
        KeyError::Io { path, source } => Failure::file(&path, format_args!("--signing-key: {source}")),
        KeyError::Content { .. } | KeyError::Exposed { .. } => Failure::Input(format!("--signing-key: {wrong}")),
    })
}

/// Signing with the key of that file on a link; its timestamps go on where they ended.
pub(crate) fn link_signing(file: &Path, link: u8) -> Result<LinkSigning, Failure> {
    let key = read_key(file)?;
    let timestamps = timestamps_of(file, link);
    let time = SigningTime::recorded(Box::new(system_steps), &timestamps)
        .map_err(|error| Failure::file(&timestamps, format_args!("{error}: timestamps of signatures have to be kept")))?;
    Ok(LinkSigning::new(key, link, time))
}

/// `flight.key.timestamp-1`, beside the key.
fn timestamps_of(file: &Path, link: u8) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(format!(".timestamp-{link}"));
    name.into()
}
