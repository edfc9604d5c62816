//! Reads a CSV run file row by row; numbers are rounded correctly, so that written ones come back bit for bit.
//!
//! Consumes bytes; produces [`RecordingRow`]s. A row is one line: a stray quote costs its own row and no other, and the line
//! number of every row is exact. An empty cell was not sampled; `nan` and `inf` are values. A row with the wrong number
//! of cells, a cell that is no number, or no time, is skipped and counted. No line may be longer than [`LINE_MAX`].
//! Separators other than the comma, a decimal comma, dates, and times in ms, us or ns are found out from the first lines and said
//! ([`CsvRecording::found_out`]). A table of another program is read by a section of a map: columns without a meaning there
//! may hold anything.

use super::channel_map::map_file::MapSection;
use super::record::{RecordingError, RecordingRow, SkipReason, SkippedByReason};
use super::table::cell::{header_text, join_quoted, number_of};
use super::table::clock::{TableClock, scaled};
use super::table::header::{DerivedChannels, MappedHeader};
use super::table::layout::{TableLayout, first_lines, lines, unit_row};
use super::table::looks::{TimeColumn, hint, look_alikes};
pub use super::table::preamble::LINE_MAX;
use super::table::preamble::{read_preamble, skip_to_header, too_long};
use crate::flight::file::run_file::{RecordingColumn, RecordingHeader, RecordingTarget, RunFileError, RunInfo, quoted};
use crate::flight::sample::Sample;
use csv::{ByteRecord, Reader, ReaderBuilder, Terminator};
use std::io::{BufReader, Cursor, Error, ErrorKind, Read, Result as IoResult};
use std::path::{Path, PathBuf};

/// So many headers of another program's table are named in a message.
const HEADERS_NAMED: usize = 40;

/// Hands bytes on until the allowance of the current line is used up; remembers how many, and the last one.
struct Allowance {
    source: Box<dyn Read + Send>,
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
    /// How many cells a row has.
    width: usize,
    layout: TableLayout,
    clock: TableClock,
    derived: DerivedChannels,
    /// Whether only what the map names has to be a number.
    is_mapped: bool,
    found_out: Vec<String>,
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
        let info = RunInfo::from_toml(&preamble.text).map_err(|place| {
            // The prefix `# ` stands before every line of the document.
            RecordingError::Place { path: path.into(), place: RunFileError { column: place.column + 2, ..place } }
        })?;
        CsvRecording::begin(path, source, preamble.lines, info, None)
    }

    /// A table of another program, by a section of a map; `info` is what the map says of the run.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or the header lacks what the map names.
    pub fn mapped(
        path: &Path,
        source: Box<dyn Read + Send>,
        section: &MapSection,
        info: RunInfo,
    ) -> Result<Self, RecordingError> {
        let mut source = BufReader::new(source);
        let io = |source| RecordingError::Io { path: path.into(), source };
        let before = skip_to_header(&mut source, section.header_line).map_err(io)?;
        CsvRecording::begin(path, source, before, info, Some(section))
    }

    /// Looks at the first lines, from the header on, and reads it.
    fn begin(
        path: &Path,
        mut source: BufReader<Box<dyn Read + Send>>,
        lines_before: usize,
        info: RunInfo,
        section: Option<&MapSection>,
    ) -> Result<Self, RecordingError> {
        let first = first_lines(&mut source);
        let looked_at: Vec<&[u8]> = lines(&first).collect();
        let stated = section.map_or((None, None), |section| (section.separator, section.decimal));
        let layout = TableLayout::of(&looked_at, stated.0, stated.1);
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .quoting(false)
            .delimiter(layout.separator)
            .terminator(Terminator::Any(b'\n'))
            .buffer_capacity(FETCH)
            .from_reader(Allowance {
                source: Box::new(Cursor::new(first.clone()).chain(source)),
                left: 0,
                handed: 0,
                last: b'\n',
            });
        let mut recording = CsvRecording {
            path: path.into(),
            info,
            columns: Vec::new(),
            width: 0,
            layout,
            clock: TableClock::Number { factor: 1.0 },
            derived: DerivedChannels::default(),
            is_mapped: section.is_some(),
            found_out: if stated == (None, None) { layout.words() } else { Vec::new() },
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
        let time = match section {
            None => recording.read_header()?,
            Some(section) => recording.read_mapped_header(section, unit_row(&looked_at, layout))?,
        };
        let seen = TimeColumn::look(looked_at.get(1..).unwrap_or_default(), layout, time, section);
        recording.read_clock(&seen, section)?;
        let others = RecordingColumn::others(&recording.columns).count();
        recording.row.others.resize(others, None);
        Ok(recording)
    }

    /// What of the file's form was found out, and which columns may be channels, in sentences.
    pub fn found_out(&self) -> &[String] {
        &self.found_out
    }

    /// How times are read.
    pub(super) fn clock(&mut self) -> &mut TableClock {
        &mut self.clock
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
            match self.fill(number) {
                Ok(()) => break,
                Err(skip) => {
                    let example = || skip.example(&self.record, &self.columns, self.width, self.ends_abruptly);
                    self.skipped.count(skip.reason, number, example);
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

    /// Reads the header of a run file; the place of the time.
    fn read_header(&mut self) -> Result<usize, RecordingError> {
        let line = self.header_row()?;
        let mut cells = Vec::with_capacity(self.record.len());
        for cell in &self.record {
            let Ok(text) = std::str::from_utf8(cell) else {
                let column = self.record.iter().take(cells.len()).map(|cell| cell.len() + 1).sum::<usize>() + 1;
                let found = quoted(&String::from_utf8_lossy(cell));
                let what = format!(
                    "expected UTF-8 text in the header, found {found}; a table of another program is read by a map, which `sideslip \
                     inspect FILE --map-template map.toml` writes"
                );
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
        let header = RecordingHeader::parse(line, &cells).map_err(|mut place| {
            place.what.push_str(&hint(&cells));
            RecordingError::Place { path: self.path.clone(), place }
        })?;
        self.found_out.extend(look_alikes(&cells, &header.columns));
        self.info.set_controls(header.controls);
        self.columns = header.columns;
        self.width = self.columns.len();
        self.header_line = line;
        Ok(self.columns.iter().position(|column| matches!(column.target, RecordingTarget::Time { .. })).unwrap_or_default())
    }

    /// Reads the header of another program; the place of the time.
    fn read_mapped_header(&mut self, section: &MapSection, units: Option<ByteRecord>) -> Result<usize, RecordingError> {
        self.header_line = self.header_row()?;
        let mut read: Vec<(String, bool)> = self.record.iter().map(header_text).collect();
        if let Some(units) = units {
            self.found_out.push("the line below the header holds units".to_owned());
            for ((text, _), unit) in read.iter_mut().zip(units.iter().map(header_text).map(|(unit, _)| unit)) {
                if !unit.is_empty() {
                    text.push_str(&format!(" [{}]", unit.trim_matches(['[', ']', '(', ')'])));
                }
            }
            self.read_line()?;
        }
        let mut headers: Vec<&str> = read.iter().map(|(text, _)| text.as_str()).collect();
        if let Some(first) = headers.first_mut() {
            *first = first.trim_start_matches(['#', '%']).trim_start();
        }
        let header = MappedHeader::new(section, &headers).map_err(|what| {
            let all: Vec<String> = headers.iter().take(HEADERS_NAMED).map(|header| quoted(header)).collect();
            let more = if headers.len() > HEADERS_NAMED { ", ..." } else { "" };
            self.place(self.header_line, 1, format!("by the map, {what}; the columns are {}{more}", all.join(" ")))
        })?;
        if read.iter().any(|(_, is_latin)| *is_latin) {
            self.found_out.push("the header is no UTF-8 and was read as Latin-1".to_owned());
        }
        self.width = headers.len();
        self.columns = header.columns;
        self.derived = header.derived;
        Ok(header.time)
    }

    fn header_row(&mut self) -> Result<usize, RecordingError> {
        match self.read_line()? {
            Some(line) => Ok(line),
            None => Err(self.place(
                self.lines_before + 1,
                1,
                "expected a header row of channel names, found the end of the file".into(),
            )),
        }
    }

    /// How times are read, by header, map and first rows.
    fn read_clock(&mut self, seen: &TimeColumn, section: Option<&MapSection>) -> Result<(), RecordingError> {
        let stated = self.columns.get(seen.place).map(|column| (column.target, column.unit_text.clone()));
        let clock = match (section, stated) {
            (None, Some((RecordingTarget::Time { factor }, unit))) => {
                seen.of_run_file(factor, unit.as_deref(), self.lines_before > 0)
            }
            (Some(section), Some((_, unit))) => {
                seen.of_mapped(&section.time, unit.as_deref()).map_err(|what| self.place(self.header_line, 1, what))?
            }
            _ => return Ok(()),
        };
        self.found_out.extend(clock.said);
        self.clock = clock.clock;
        if let Some(started) = clock.started {
            self.info.add_text("recorded_at", &started);
        }
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
            join_quoted(&mut self.record, self.layout.separator);
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

/// Why one row was skipped, and at which cell.
struct Skip {
    reason: SkipReason,
    cell: usize,
}

impl Skip {
    fn example(&self, record: &ByteRecord, columns: &[RecordingColumn], width: usize, ends_abruptly: bool) -> String {
        let name = columns.get(self.cell).map_or("", |column| &column.name);
        let found = quoted(&String::from_utf8_lossy(record.get(self.cell).unwrap_or_default()));
        match self.reason {
            SkipReason::CellCount => {
                let cut = if ends_abruptly { " in a last line that is cut short" } else { "" };
                format!("expected {width} cells, found {}{cut}", record.len())
            }
            SkipReason::NoTime => format!("column `{name}`: expected the time, found an empty cell"),
            SkipReason::NotANumber | SkipReason::Damaged => {
                let cell = record.get(self.cell).unwrap_or_default();
                let numeric = |byte: &u8| byte.is_ascii_digit() || b",.' \"+-".contains(byte);
                let has_separator = cell.iter().any(|byte| matches!(byte, b',' | b'.' | b'\''));
                let besides = if has_separator && cell.iter().all(numeric) {
                    " (one decimal sign in all of the file, no separators of thousands)"
                } else {
                    ""
                };
                format!("column `{name}`: expected a number, found {found}{besides}")
            }
        }
    }
}

impl CsvRecording {
    /// Fills the row from the cells, or says why it cannot be; the row is then meaningless.
    fn fill(&mut self, number: u64) -> Result<(), Skip> {
        let CsvRecording { row, record, columns, clock, derived, .. } = self;
        if record.len() != self.width {
            return Err(Skip { reason: SkipReason::CellCount, cell: 0 });
        }
        let decimal = self.layout.decimal;
        row.number = number;
        row.sample = Sample::new(0.0);
        let mut others = row.others.iter_mut();
        for (cell, (text, column)) in record.iter().zip(columns).enumerate() {
            let wrong = |()| Skip { reason: SkipReason::NotANumber, cell };
            match column.target {
                RecordingTarget::Time { .. } => match clock.seconds(text, decimal).map_err(wrong)? {
                    Some(time_s) => row.sample.time_s = time_s,
                    None => return Err(Skip { reason: SkipReason::NoTime, cell }),
                },
                RecordingTarget::Known { channel, factor } => {
                    if let Some(value) = number_of(text, decimal).map_err(wrong)? {
                        row.sample.set(channel, scaled(value, factor));
                    }
                }
                RecordingTarget::Other => {
                    let value = match number_of(text, decimal) {
                        Err(()) if self.is_mapped && !derived.takes(cell) => None,
                        value => value.map_err(wrong)?,
                    };
                    if let Some(other) = others.next() {
                        *other = value;
                    }
                }
            }
        }
        let number = |cell: usize| record.get(cell).and_then(|text| number_of(text, decimal).ok()?);
        derived.put(&mut row.sample, number).map_err(|cell| Skip { reason: SkipReason::Damaged, cell })
    }
}
