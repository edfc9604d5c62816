//! A serial line in raw mode at a given speed, read with a time limit.
//!
//! Consumes the device's path and baud rate; produces an open file whose reads return after at most 0.1 s. Refused: a path that
//! is not a terminal device, a speed that the system does not support.

use std::fs::File;
use std::io::{Error, Result};
use std::path::Path;

/// Speeds that are admitted, baud: from the slowest radio to the fastest link.
pub const BAUD_RANGE: std::ops::RangeInclusive<u32> = 1_200..=4_000_000;

/// Opens the device.
///
/// # Errors
/// What the system says; of a path that is no terminal device that it is none.
#[cfg(unix)]
pub fn open(device: &Path, baud: u32) -> Result<File> {
    use rustix::termios::{OptionalActions, SpecialCodeIndex, tcgetattr, tcsetattr};
    use std::os::unix::fs::OpenOptionsExt;
    // A line without carrier must not hold up the opening, and must not become the controlling terminal.
    let flags = rustix::fs::OFlags::NOCTTY | rustix::fs::OFlags::NONBLOCK;
    let file = std::fs::OpenOptions::new().read(true).write(true).custom_flags(flags.bits().cast_signed()).open(device)?;
    let system = |error: rustix::io::Errno| Error::from(error);
    let mut settings = tcgetattr(&file).map_err(system)?;
    settings.make_raw();
    settings.set_speed(baud).map_err(system)?;
    // A read ends with the first bytes, or empty after a tenth of a second.
    settings.special_codes[SpecialCodeIndex::VMIN] = 0;
    settings.special_codes[SpecialCodeIndex::VTIME] = 1;
    tcsetattr(&file, OptionalActions::Now, &settings).map_err(system)?;
    rustix::fs::fcntl_setfl(&file, rustix::fs::OFlags::empty()).map_err(system)?;
    Ok(file)
}

/// Serial lines are opened on Unix only.
///
/// # Errors
/// Always.
#[cfg(not(unix))]
pub fn open(_device: &Path, _baud: u32) -> Result<File> {
    Err(Error::from(std::io::ErrorKind::Unsupported))
}
