//! Reads a CSV run file row by row; numbers are rounded correctly, so that written ones come back bit for bit.
//!
//! Consumes bytes; produces [`RecordingRow`]s. A row is one line: a stray quote costs its own row and no other, and the line
//! number of every row is exact. An empty cell was not sampled; `nan` and `inf` are values. A row with the wrong number
//! of cells, a cell that is no number, or no time, is skipped and counted. No line may be longer than [`LINE_MAX`].

use super::record::{RecordingError, RecordingRow, SkipReason, SkippedByReason};
use crate::flight::file::run_file::{RecordingColumn, RecordingHeader, RecordingTarget, RunFileError, RunInfo, quoted};
use crate::flight::sample::Sample;
use csv::{ByteRecord, Reader, ReaderBuilder, Terminator};
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result as IoResult};
use std::path::{Path, PathBuf};

/// The longest line, and the longest preamble, that is read, bytes.
pub const LINE_MAX: usize = 1 << 20;

const BYTE_ORDER_MARK: &[u8] = &[0xEF, 0xBB, 0xBF];

/// Hands bytes on until the allowance of the current line is used up; remembers how many, and the last one.
struct Allowance {
    source: BufReader<Box<dyn Read + Send>>,
    left: usize,
    handed: u64,
    last: u8,
}

/// How much the reader fetches at once, bytes.
const FETCH: usize = 8 << 10;

impl Read for Allowance {
    fn read(&mut self, buffer: &mut [u8]) -> IoResult<usize> {
        let read = self.source.read(buffer)?;
        match self.left.checked_sub(read) {
            Some(left) => self.left = left,
            None => return Err(Error::from(ErrorKind::FileTooLarge)),
        }
        self.handed += u64::try_from(read).unwrap_or(u64::MAX);
        self.last = buffer.get(..read).and_then(|bytes| bytes.last()).copied().unwrap_or(self.last);
        Ok(read)
    }
}

/// A CSV run file that is being read.
pub struct CsvRecording {
    path: PathBuf,
    info: RunInfo,
    columns: Vec<RecordingColumn>,
    reader: Reader<Allowance>,
    lines_before: usize,
    header_line: usize,
    record: ByteRecord,
    row: RecordingRow,
    rows: u64,
    skipped: SkippedByReason,
    ends_abruptly: bool,
    ended: bool,
}

impl std::fmt::Debug for CsvRecording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CsvRecording").field("path", &self.path).field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl CsvRecording {
    /// Reads preamble and header; `path` is named in messages only.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or preamble or header is wrong.
    pub fn new(path: &Path, source: Box<dyn Read + Send>) -> Result<Self, RecordingError> {
        let mut source = BufReader::new(source);
        let preamble = read_preamble(&mut source).map_err(|failure| failure.at(path))?;
        let lines_before = preamble.lines;
        let info = RunInfo::from_toml(&preamble.text).map_err(|place| {
            // The prefix `# ` stands before every line of the document.
            RecordingError::Place { path: path.into(), place: RunFileError { column: place.column + 2, ..place } }
        })?;
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .quoting(false)
            .terminator(Terminator::Any(b'\n'))
            .buffer_capacity(FETCH)
            .from_reader(Allowance { source, left: 0, handed: 0, last: b'\n' });
        let mut recording = CsvRecording {
            path: path.into(),
            info,
            columns: Vec::new(),
            reader,
            lines_before,
            header_line: 0,
            record: ByteRecord::new(),
            row: RecordingRow { number: 0, sample: Sample::new(0.0), others: Vec::new() },
            rows: 0,
            skipped: SkippedByReason::default(),
            ends_abruptly: false,
            ended: false,
        };
        recording.read_header()?;
        Ok(recording)
    }

    /// What the run says of itself.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The columns in the order of the file.
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// What was skipped so far.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// Whether the last line, once it was read, had no end.
    pub fn ends_abruptly(&self) -> bool {
        self.ends_abruptly
    }

    /// The next row that can be read; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, a line is too long, or the end comes without a single good row.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        loop {
            let Some(line) = self.read_line()? else { return self.end().map(|()| None) };
            let number = u64::try_from(line).unwrap_or(u64::MAX);
            match fill(&mut self.row, &self.columns, &self.record, number) {
                Ok(()) => break,
                Err(skip) => {
                    let (record, columns) = (&self.record, &self.columns);
                    let cut = self.ends_abruptly && skip.reason == SkipReason::CellCount;
                    self.skipped.count(skip.reason, number, || skip.example(record, columns, cut));
                }
            }
        }
        self.rows += 1;
        Ok(Some(&self.row))
    }

    /// Whether no row at all was good. Said once: after an end there is only `None`.
    fn end(&mut self) -> Result<(), RecordingError> {
        let said = std::mem::replace(&mut self.ended, true);
        if said || self.rows > 0 {
            return Ok(());
        }
        match self.skipped.reasons().first() {
            None => Err(self.place(self.header_line, 1, "expected rows after the header, found none".into())),
            Some(first) => {
                let what = format!("expected a row, found none in {} lines; the first: {}", self.skipped.rows(), first.example);
                Err(self.place(usize::try_from(first.first).unwrap_or(usize::MAX), 1, what))
            }
        }
    }

    fn read_header(&mut self) -> Result<(), RecordingError> {
        let Some(line) = self.read_line()? else {
            return Err(self.place(
                self.lines_before + 1,
                1,
                "expected a header row of channel names, found the end of the file".into(),
            ));
        };
        let mut cells = Vec::with_capacity(self.record.len());
        for cell in &self.record {
            let Ok(text) = std::str::from_utf8(cell) else {
                let column = self.record.iter().take(cells.len()).map(|cell| cell.len() + 1).sum::<usize>() + 1;
                let what = format!("expected UTF-8 text in the header, found {}", quoted(&String::from_utf8_lossy(cell)));
                return Err(self.place(line, column, what));
            };
            cells.push(text);
        }
        if cells.first().is_some_and(|cell| cell.starts_with('#')) {
            return Err(self.place(
                line,
                1,
                "expected `# ` with a space before a line of the preamble, or the header row".into(),
            ));
        }
        let header =
            RecordingHeader::parse(line, &cells).map_err(|place| RecordingError::Place { path: self.path.clone(), place })?;
        let others = RecordingColumn::others(&header.columns).count();
        self.row.others.resize(others, None);
        self.info.set_controls(header.controls);
        self.columns = header.columns;
        self.header_line = line;
        Ok(())
    }

    /// Reads the next line that is not blank into `record`; its number from 1.
    fn read_line(&mut self) -> Result<Option<usize>, RecordingError> {
        while !self.ended {
            self.reader.get_mut().left = LINE_MAX + FETCH;
            match self.reader.read_byte_record(&mut self.record) {
                Ok(true) => {}
                Ok(false) => return Ok(None),
                Err(error) => return Err(self.broken(error)),
            }
            // The reader stands behind the line's end, unless the file ended first.
            let end = self.reader.position().byte();
            self.ends_abruptly = end == self.reader.get_ref().handed && self.reader.get_ref().last != b'\n';
            let ends = usize::try_from(self.reader.position().line()).unwrap_or(usize::MAX);
            let line = self.lines_before + if self.ends_abruptly { ends } else { ends.saturating_sub(1) };
            let blank = self.record.len() == 1 && self.record.iter().all(|cell| cell.trim_ascii().is_empty());
            if !blank {
                return Ok(Some(line));
            }
        }
        Ok(None)
    }

    fn broken(&mut self, error: csv::Error) -> RecordingError {
        self.ended = true;
        let line = self.lines_before + usize::try_from(self.reader.position().line()).unwrap_or(usize::MAX);
        match error.into_kind() {
            csv::ErrorKind::Io(source) if source.kind() == ErrorKind::FileTooLarge => self.place(line, 1, too_long("a line")),
            csv::ErrorKind::Io(source) => RecordingError::Io { path: self.path.clone(), source },
            other => self.place(line, 1, format!("{other:?}")),
        }
    }

    fn place(&self, line: usize, column: usize, what: String) -> RecordingError {
        RecordingError::Place { path: self.path.clone(), place: RunFileError { line, column, what } }
    }
}

fn too_long(what: &str) -> String {
    format!("expected {what} of at most {LINE_MAX} bytes, found a longer one")
}

/// Why one row was skipped, and at which cell.
struct Skip {
    reason: SkipReason,
    cell: usize,
}

impl Skip {
    fn example(&self, record: &ByteRecord, columns: &[RecordingColumn], cut: bool) -> String {
        let name = columns.get(self.cell).map_or("", |column| &column.name);
        let found = quoted(&String::from_utf8_lossy(record.get(self.cell).unwrap_or_default()));
        match self.reason {
            SkipReason::CellCount => {
                let cut = if cut { " in a last line that is cut short" } else { "" };
                format!("expected {} cells, found {}{cut}", columns.len(), record.len())
            }
            SkipReason::NoTime => format!("column `{name}`: expected the time, found an empty cell"),
            SkipReason::NotANumber | SkipReason::Damaged => format!("column `{name}`: expected a number, found {found}"),
        }
    }
}

/// Fills the row from the cells, or says why it cannot be; the row is then meaningless.
fn fill(row: &mut RecordingRow, columns: &[RecordingColumn], record: &ByteRecord, number: u64) -> Result<(), Skip> {
    if record.len() != columns.len() {
        return Err(Skip { reason: SkipReason::CellCount, cell: 0 });
    }
    row.number = number;
    row.sample = Sample::new(0.0);
    let mut others = row.others.iter_mut();
    for (cell, (text, column)) in record.iter().zip(columns).enumerate() {
        let value = number_of(text).map_err(|()| Skip { reason: SkipReason::NotANumber, cell })?;
        match (column.target, value) {
            (RecordingTarget::Time { .. }, None) => return Err(Skip { reason: SkipReason::NoTime, cell }),
            (RecordingTarget::Time { factor }, Some(value)) => row.sample.time_s = scaled(value, factor),
            (RecordingTarget::Known { channel, factor }, Some(value)) => row.sample.set(channel, scaled(value, factor)),
            (RecordingTarget::Known { .. }, None) => {}
            (RecordingTarget::Other, value) => {
                if let Some(other) = others.next() {
                    *other = value;
                }
            }
        }
    }
    Ok(())
}

/// A factor of one must not touch the bits.
#[expect(clippy::float_cmp, reason = "exactly one means SI already")]
fn scaled(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { value * factor }
}

/// The number in a cell; `None` where it is empty. Spaces and one pair of quotes around it do not count.
fn number_of(cell: &[u8]) -> Result<Option<f64>, ()> {
    let mut cell = cell.trim_ascii();
    if let [b'"', inner @ .., b'"'] = cell {
        cell = inner.trim_ascii();
    }
    if cell.is_empty() {
        return Ok(None);
    }
    std::str::from_utf8(cell).ok().and_then(|text| text.parse().ok()).map(Some).ok_or(())
}

/// The document of the preamble, with as many lines as it has in the file.
struct Preamble {
    text: String,
    lines: usize,
}

enum PreambleFailure {
    Io(Error),
    Place(RunFileError),
}

impl PreambleFailure {
    fn at(self, path: &Path) -> RecordingError {
        match self {
            PreambleFailure::Io(source) => RecordingError::Io { path: path.into(), source },
            PreambleFailure::Place(place) => RecordingError::Place { path: path.into(), place },
        }
    }
}

/// Reads the lines that start with `# `, or are a lone `#`, and stops before the first other one.
fn read_preamble<R: BufRead>(source: &mut R) -> Result<Preamble, PreambleFailure> {
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
