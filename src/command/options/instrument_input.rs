//! An instruments file by its path, as `simulate` takes it.

use sideslip::error::Failure;
use sideslip::io::text_file::read_text;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument_file::InstrumentFile;
use std::path::Path;

/// Reads the instruments file of that path for what that flight gives.
pub(crate) fn read_instruments(path: &Path, flight: &Flight) -> Result<InstrumentFile, Failure> {
    let refused = |error: &dyn std::fmt::Display| Failure::file(path, format_args!("expected an instruments file: {error}"));
    let text = read_text(path).map_err(|error| refused(&error))?;
    InstrumentFile::parse(&text, |channel| flight.gives(channel))
        .map_err(|misread| Failure::at(path, misread.line, misread.column, misread.what))
}
