//! An output file that is there whole or not at all: written beside its place, then moved to it.
//!
//! What is no regular file (a pipe, a device) cannot be replaced and is written directly; a symbolic link keeps pointing
//! where it does, and what it points to is replaced.

use super::console::print_json;
use sideslip::error::Failure;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Result as IoResult, Write};
use std::path::{Path, PathBuf};

/// A file on its way to its place; dropped before [`OutputFile::keep`] it leaves nothing behind.
#[derive(Debug)]
pub(crate) struct OutputFile {
    target: PathBuf,
    /// Where it is written; the target itself where that cannot be replaced.
    place: PathBuf,
}

impl OutputFile {
    /// A file that will stand at `target`; nothing is written yet.
    pub(crate) fn beside(target: &Path) -> Result<Self, Failure> {
        let Some(name) = target.file_name() else {
            return Err(Failure::file(target, "expected the name of a file to write"));
        };
        let Ok(standing) = target.metadata() else {
            return Ok(OutputFile { place: target.with_file_name(partial(Path::new(name))), target: target.into() });
        };
        if standing.is_dir() {
            return Err(Failure::file(target, "expected the name of a file to write, found a directory"));
        }
        if !standing.is_file() {
            return Ok(OutputFile { place: target.into(), target: target.into() });
        }
        let target = target.canonicalize().map_err(|error| Failure::io(target, &error))?;
        Ok(OutputFile { place: target.with_file_name(partial(&target)), target })
    }

    /// Where it will stand.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    pub(crate) fn place(&self) -> &Path {
        &self.place
    }

    /// Moves what was written to where it belongs.
    pub(crate) fn keep(self) -> Result<(), Failure> {
        if self.place == self.target {
            return Ok(());
        }
        std::fs::rename(&self.place, &self.target).map_err(|error| Failure::io(&self.target, &error))
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if self.place != self.target {
            // After `keep` there is nothing left under this name.
            let _ = std::fs::remove_file(&self.place);
        }
    }
}

/// `run.csv` as `run.partial-4711.csv`.
fn partial(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().map(|ending| format!(".{}", ending.to_string_lossy())).unwrap_or_default();
    format!("{stem}.partial-{}{ending}", std::process::id())
}

/// Writes a whole file, or leaves what stood there.
pub(crate) fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Write) -> IoResult<()>) -> Result<(), Failure> {
    let output = OutputFile::beside(path)?;
    let written = File::create(output.place()).and_then(|file| {
        let mut file = BufWriter::new(file);
        write(&mut file)?;
        match file.into_inner().map_err(|error| error.into_error())?.sync_all() {
            // A pipe or a device cannot be synchronised; everything has been handed over to it.
            Err(error) if error.kind() == ErrorKind::InvalidInput => Ok(()),
            other => other,
        }
    });
    written.map_err(|error| Failure::io(path, &error))?;
    output.keep()
}

/// A result as JSON: to standard output where the path is `-`, else to a file, whole or not at all.
pub(crate) fn write_json(path: &Path, text: &str) -> Result<(), Failure> {
    if path.as_os_str() == "-" { print_json(text).map(drop) } else { write_whole(path, |file| file.write_all(text.as_bytes())) }
}

/// Refuses, before long work, a file to write in a folder that is not there.
pub(crate) fn refuse_without_folder(option: &str, output: &Path) -> Result<(), Failure> {
    match output.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        Some(folder) => Err(Failure::file(output, format_args!("{option}: expected a folder {}, found none", folder.display()))),
        None => Ok(()),
    }
}

/// Whether two names are of one file, written already or not.
pub(crate) fn same_place(one: &Path, other: &Path) -> bool {
    let whole = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        path.canonicalize().ok().or_else(|| Some(folder.canonicalize().ok()?.join(path.file_name()?)))
    };
    one == other || whole(one).is_some_and(|one| Some(one) == whole(other))
}

/// Refuses to write over a file that is read.
pub(crate) fn refuse_to_overwrite(option: &str, output: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    let Ok(output_file) = output.canonicalize() else { return Ok(()) };
    if inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == output_file)) {
        let what = format_args!("{option}: expected another file than the one that is read, found the same");
        return Err(Failure::file(output, what));
    }
    Ok(())
}
