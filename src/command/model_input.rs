//! A model file by its path, as the commands take it.

use sideslip::error::Failure;
use sideslip::flight::model_file::ModelFile;
use std::path::Path;

/// Reads the model file of that path.
pub(crate) fn read_model(path: &Path) -> Result<ModelFile, Failure> {
    if path.as_os_str() == "puma" && !path.exists() {
        return Err(Failure::file(path, "the built-in model `puma` is of kind `level1`, which is not simulated yet"));
    }
    let bytes = std::fs::read(path).map_err(|error| Failure::file(path, format_args!("expected a model file: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|error| Failure::file(path, format_args!("expected UTF-8 text: {error}")))?;
    ModelFile::parse(&text).map_err(|misread| Failure::at(path, misread.line, misread.column, misread.what))
}
