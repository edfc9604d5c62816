//! What stands before the header of a table: the preamble of a run file, or lines that are passed over.
//!
//! Consumes bytes; produces the TOML document of a preamble, or how many lines were passed over. Refused: a preamble whose lines
//! do not begin with `# `, are no UTF-8, or are longer than a line may be.

use crate::flight::file::run_file::RunFileError;
use crate::io::telemetry::record::RecordingError;
use std::io::{BufRead, Error, Read, Result as IoResult};
use std::path::Path;

/// The longest line, and the longest preamble, that is read, bytes.
pub const LINE_MAX: usize = 1 << 20;

const BYTE_ORDER_MARK: &[u8] = &[0xEF, 0xBB, 0xBF];

/// What is said of too long a line or preamble.
pub(crate) fn too_long(what: &str) -> String {
    format!("expected {what} of at most {LINE_MAX} bytes, found a longer one")
}

/// Goes to the header of a table: that line, or the first that is no comment. How many lines are before it.
pub(crate) fn skip_to_header<R: BufRead>(source: &mut R, header_line: Option<usize>) -> IoResult<usize> {
    if source.fill_buf()?.starts_with(BYTE_ORDER_MARK) {
        source.consume(BYTE_ORDER_MARK.len());
    }
    let mut skipped = 0;
    loop {
        let is_header = match header_line {
            Some(line) => skipped + 1 >= line,
            None => source.fill_buf()?.first() != Some(&b'#'),
        };
        if is_header || source.skip_until(b'\n')? == 0 {
            return Ok(skipped);
        }
        skipped += 1;
    }
}

/// The document of the preamble, with as many lines as it has in the file.
pub(crate) struct Preamble {
    pub(crate) text: String,
    pub(crate) lines: usize,
}

/// Why it cannot be read.
pub(crate) enum PreambleFailure {
    Io(Error),
    Place(RunFileError),
}

impl PreambleFailure {
    pub(crate) fn at(self, path: &Path) -> RecordingError {
        match self {
            PreambleFailure::Io(source) => RecordingError::Io { path: path.into(), source },
            PreambleFailure::Place(place) => RecordingError::Place { path: path.into(), place },
        }
    }
}

/// Reads the lines that start with `# `, or are a lone `#`, and stops before the first other one.
pub(crate) fn read_preamble<R: BufRead>(source: &mut R) -> Result<Preamble, PreambleFailure> {
    let io = PreambleFailure::Io;
    if source.fill_buf().map_err(io)?.starts_with(BYTE_ORDER_MARK) {
        source.consume(BYTE_ORDER_MARK.len());
    }
    let mut preamble = Preamble { text: String::new(), lines: 0 };
    let mut line = Vec::new();
    while source.fill_buf().map_err(io)?.first() == Some(&b'#') {
        let number = preamble.lines + 1;
        let place = |column: usize, what: String| PreambleFailure::Place(RunFileError { line: number, column, what });
        line.clear();
        let room = (LINE_MAX - preamble.text.len().min(LINE_MAX)).saturating_add(2);
        let limit = u64::try_from(room).unwrap_or(u64::MAX);
        source.by_ref().take(limit).read_until(b'\n', &mut line).map_err(io)?;
        if line.len() == room && line.last() != Some(&b'\n') {
            return Err(place(1, too_long("a preamble")));
        }
        let text = line.strip_suffix(b"\n").unwrap_or(&line);
        let text = match text.strip_suffix(b"\r").unwrap_or(text) {
            [b'#'] => &[],
            [b'#', b' ', rest @ ..] => rest,
            _ => return Err(place(2, "expected a space after `#`, or no preamble".into())),
        };
        match std::str::from_utf8(text) {
            Ok(text) => preamble.text.push_str(text),
            Err(error) => {
                let column = String::from_utf8_lossy(text.get(..error.valid_up_to()).unwrap_or_default()).chars().count() + 3;
                return Err(place(column, "expected UTF-8 text, found other bytes".into()));
            }
        }
        preamble.text.push('\n');
        preamble.lines = number;
    }
    Ok(preamble)
}
