//! A model file by its path, as the commands take it; `puma` is the one built in.

use sideslip::error::Failure;
use sideslip::simulation::flight_model::{Asked, FlightModel, ModelError, PUMA};
use std::path::Path;

/// Reads the model file of that path and trims it as asked.
pub(crate) fn read_model(path: &Path, asked: &Asked) -> Result<FlightModel, Failure> {
    if path.as_os_str() == "puma" && !path.exists() {
        return FlightModel::parse(PUMA, asked).map_err(|error| told(path, error));
    }
    let bytes = std::fs::read(path).map_err(|error| Failure::file(path, format_args!("expected a model file: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|error| Failure::file(path, format_args!("expected UTF-8 text: {error}")))?;
    FlightModel::parse(&text, asked).map_err(|error| told(path, error))
}

fn told(path: &Path, error: ModelError) -> Failure {
    match error {
        ModelError::Misread(misread) => Failure::at(path, misread.line, misread.column, misread.what),
        ModelError::Linear(_) => Failure::Input(format!("{error} ({})", path.display())),
        ModelError::Set(_) => Failure::Input(error.to_string()),
        ModelError::NoTrim(_) => Failure::file(path, error),
    }
}
