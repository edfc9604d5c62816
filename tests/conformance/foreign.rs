//! The conformance files of the MCAP project, read in place: none is a log of ours, all are refused with what they hold.

use sideslip::io::telemetry::mcap::{LogReadError, SampleReader};
use std::fs::File;
use std::path::{Path, PathBuf};

/// The folder of recordings that nobody here made.
fn data() -> PathBuf {
    match std::env::var_os("SIDESLIP_DATA") {
        Some(folder) => PathBuf::from(folder),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "mcap") {
            files.push(path);
        }
    }
}

#[test]
fn the_conformance_files_are_refused_with_their_topics() {
    let mut files = Vec::new();
    collect(&data().join("mcap-conformance"), &mut files);
    if files.is_empty() {
        eprintln!("SKIPPED: no recordings under {}", data().display());
        return;
    }
    for path in &files {
        let error = SampleReader::open(File::open(path).unwrap()).map(|_| ()).unwrap_err();
        let LogReadError::Foreign(found) = &error else { panic!("{}: {error}", path.display()) };
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let expected = if name.contains("Message") { "the topics example" } else { "no topic" };
        assert_eq!(found, expected, "{name}");
    }
    eprintln!("{} files refused with what they hold", files.len());
}
