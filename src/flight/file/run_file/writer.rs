//! Writes a run file: preamble, header, rows, in SI, so that reading gives the same bits back.
//!
//! Consumes a [`RunInfo`], the channels and other columns to write and rows of values; produces text. A number is written as
//! the shortest decimal that reads back as itself; what was not sampled is an empty cell. Refused: a name or unit of another
//! column that would not read back.

use crate::flight::channel::Channel;
use crate::flight::file::run_file::{RecordingColumn, RunInfo, quoted};
use std::io::{Error, ErrorKind, Result, Write};

/// A run file that is being written. Buffer the sink: a row is one small write.
#[derive(Debug)]
pub struct RunFileWriter<W: Write> {
    sink: W,
    channels: Vec<Channel>,
    row: Vec<u8>,
}

impl<W: Write> RunFileWriter<W> {
    /// Writes preamble and header; controls are called as the run's geometry says.
    ///
    /// # Errors
    /// What the sink returns.
    pub fn new(sink: W, info: &RunInfo, channels: &[Channel]) -> Result<Self> {
        RunFileWriter::with_others(sink, info, channels, &[])
    }

    /// The same, with other columns behind the channels.
    ///
    /// # Errors
    /// What the sink returns, or that a name or a unit cannot stand in a header.
    pub fn with_others(mut sink: W, info: &RunInfo, channels: &[Channel], others: &[&RecordingColumn]) -> Result<Self> {
        for line in info.to_toml().lines() {
            writeln!(sink, "{}{line}", if line.is_empty() { "#" } else { "# " })?;
        }
        write!(sink, "time")?;
        for channel in channels {
            write!(sink, ",{}", channel.name(info.geometry().controls))?;
        }
        for column in others {
            let unit = column.unit_text.as_deref().unwrap_or("");
            let is_plain = |text: &str| !text.contains([',', '"', '[', ']', '\'', '#']) && !text.chars().any(char::is_control);
            if !(is_plain(&column.name) && is_plain(unit)) || column.name.trim() != column.name || column.name.is_empty() {
                let what = format!("column {} [{}] cannot stand in the header of a run file", quoted(&column.name), quoted(unit));
                return Err(Error::new(ErrorKind::InvalidInput, what));
            }
            write!(sink, ",{}", column.name)?;
            if !unit.is_empty() {
                write!(sink, "[{unit}]")?;
            }
        }
        writeln!(sink)?;
        Ok(RunFileWriter { sink, channels: channels.into(), row: Vec::new() })
    }

    /// Writes the row at that time, s; `value` gives each channel's value, SI, where it was sampled.
    ///
    /// # Errors
    /// What the sink returns.
    pub fn write_row(&mut self, time_s: f64, value: impl Fn(Channel) -> Option<f64>) -> Result<()> {
        self.write_row_with(time_s, value, &[])
    }

    /// The same, with the values of the other columns in their order.
    ///
    /// # Errors
    /// What the sink returns.
    pub fn write_row_with(&mut self, time_s: f64, value: impl Fn(Channel) -> Option<f64>, others: &[Option<f64>]) -> Result<()> {
        self.row.clear();
        write!(self.row, "{time_s}")?;
        let known = self.channels.iter().map(|channel| value(*channel));
        for cell in known.chain(others.iter().copied()) {
            match cell {
                Some(value) => write!(self.row, ",{value}")?,
                None => self.row.push(b','),
            }
        }
        self.row.push(b'\n');
        self.sink.write_all(&self.row)
    }

    /// Flushes and gives the sink back.
    ///
    /// # Errors
    /// What the sink returns.
    pub fn finish(mut self) -> Result<W> {
        self.sink.flush()?;
        Ok(self.sink)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::ControlNames;

    #[test]
    fn other_columns_keep_their_units_and_names_that_would_not_read_back_are_refused() {
        let column = |name: &str, unit: &str| RecordingColumn::new(name, Some(unit).filter(|unit| !unit.is_empty())).unwrap();
        let info = RunInfo::default();
        let (oil, gear) = (column("oil", "K"), column("gear", ""));
        let mut writer = RunFileWriter::with_others(Vec::new(), &info, &[Channel::P], &[&oil, &gear]).unwrap();
        writer.write_row_with(1.0, |_| None, &[Some(300.5), None]).unwrap();
        assert_eq!(String::from_utf8(writer.finish().unwrap()).unwrap(), "time,p,oil[K],gear\n1,,300.5,\n");
        for (name, unit) in [("a,b", ""), ("a", "x]"), ("#a", ""), (" a", ""), ("", "")] {
            assert!(RunFileWriter::with_others(Vec::new(), &info, &[], &[&column(name, unit)]).is_err(), "{name} {unit}");
        }
    }

    #[test]
    fn a_small_file_is_written_as_the_conventions_say() {
        let mut info = RunInfo::from_toml("run = \"1/2\"\nblades = 4").unwrap();
        info.set_controls(ControlNames::FixedWing);
        let mut writer = RunFileWriter::new(Vec::new(), &info, &[Channel::P, Channel::Pedal]).unwrap();
        writer.write_row(0.0, |channel| (channel == Channel::P).then_some(-0.1)).unwrap();
        writer.write_row(0.01, |_| Some(1e-7)).unwrap();
        let text = String::from_utf8(writer.finish().unwrap()).unwrap();
        assert_eq!(text, "# blades = 4\n# run = \"1/2\"\ntime,p,rudder\n0,-0.1,\n0.01,0.0000001,0.0000001\n");
    }
}
