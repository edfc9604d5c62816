//! Writes a run file: preamble, header, rows, in SI, so that reading gives the same bits back.
//!
//! Consumes a [`RunInfo`], the channels to write and rows of values; produces text. A number is written as the shortest
//! decimal that reads back as itself; a channel that was not sampled is an empty cell.

use crate::flight::channel::Channel;
use crate::flight::file::run_file::RunInfo;
use std::io::{Result, Write};

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
    pub fn new(mut sink: W, info: &RunInfo, channels: &[Channel]) -> Result<Self> {
        for line in info.to_toml().lines() {
            writeln!(sink, "{}{line}", if line.is_empty() { "#" } else { "# " })?;
        }
        write!(sink, "time")?;
        for channel in channels {
            write!(sink, ",{}", channel.name(info.geometry().controls))?;
        }
        writeln!(sink)?;
        Ok(RunFileWriter { sink, channels: channels.into(), row: Vec::new() })
    }

    /// Writes the row at that time, s; `value` gives each channel's value, SI, where it was sampled.
    ///
    /// # Errors
    /// What the sink returns.
    pub fn write_row(&mut self, time_s: f64, value: impl Fn(Channel) -> Option<f64>) -> Result<()> {
        self.row.clear();
        write!(self.row, "{time_s}")?;
        for &channel in &self.channels {
            match value(channel) {
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
