//! An instruments file by its path, as `simulate` takes it.

use sideslip::error::Failure;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument_file::InstrumentFile;
use std::path::Path;

/// Reads the instruments file of that path for what that flight gives.
pub(crate) fn read_instruments(path: &Path, flight: &Flight) -> Result<InstrumentFile, Failure> {
    let refused = |error: &dyn std::fmt::Display| Failure::file(path, format_args!("expected an instruments file: {error}"));
    let bytes = std::fs::read(path).map_err(|error| refused(&error))?;
    let text = String::from_utf8(bytes).map_err(|error| refused(&error))?;
    InstrumentFile::parse(&text, |channel| flight.gives(channel))
        .map_err(|misread| Failure::at(path, misread.line, misread.column, misread.what))
}
