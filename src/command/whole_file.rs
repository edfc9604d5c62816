//! An output file that is there whole or not at all: written beside its place, then moved to it.

use sideslip::error::Failure;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file by way of a temporary one in the same folder; what fails leaves nothing behind.
pub(crate) fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), Failure> {
    let Some(name) = path.file_name() else {
        return Err(Failure::file(path, "expected the name of a file to write"));
    };
    let mut beside = name.to_owned();
    beside.push(format!(".partial-{}", std::process::id()));
    let temporary: PathBuf = path.with_file_name(beside);
    let written = File::create(&temporary).and_then(|file| {
        let mut file = BufWriter::new(file);
        write(&mut file)?;
        file.into_inner().map_err(|error| error.into_error())?.sync_all()?;
        std::fs::rename(&temporary, path)
    });
    written.map_err(|error| {
        let _ = std::fs::remove_file(&temporary);
        Failure::io(path, &error)
    })
}
