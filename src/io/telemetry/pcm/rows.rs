//! Rows of channels out of samples of parameters.
//!
//! Consumes the samples of a [decommutator](super::decommutator) in order of time; produces rows as of any recording: a
//! parameter whose name is that of a channel is converted to SI, the others keep their units. Samples within [`ROW_S`] of the
//! first of a row stand in it, and its time is the middle between its first and its last: no sample is shifted by more than a
//! quarter of a millisecond from its own time. Where words stand further apart, a minor frame gives several rows.
//!
//! Left out, and counted by reason: samples with wrong parity, of minor frames without pattern, beyond their limits, too far
//! from those beside them, and bits that are no number. An extrapolated calibration is used where the format allows it, and
//! counted. Nothing is allocated after the start.

use super::decommutator::{PcmSample, SampleFlags};
use super::layout::PcmFormat;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::file::run_file::{RecordingColumn, RecordingHeader, RecordingTarget};
use crate::flight::sample::Sample;
use crate::io::telemetry::record::RecordingRow;

/// Longest time from the first to the last sample of a row, s.
pub const ROW_S: f64 = 0.5e-3;

/// Samples that were not used, by reason, and those that were extrapolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnusedSamples {
    /// Of words with wrong parity.
    pub parity: u64,
    /// Of minor frames without a pattern at one of their ends.
    pub doubtful_frame: u64,
    /// Beyond the limits of their parameter.
    pub out_of_limits: u64,
    /// Further from those beside them than their largest step.
    pub beyond_step: u64,
    /// Bits that are no number, or one without an engineering value.
    pub no_value: u64,
    /// Used, although outside of the range of their calibration.
    pub extrapolated: u64,
}

impl UnusedSamples {
    /// In words; `None` where there is nothing to say.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        let parts = [
            (self.parity, "samples with wrong parity left out"),
            (self.doubtful_frame, "samples of minor frames without sync pattern left out"),
            (self.out_of_limits, "samples beyond their limits left out"),
            (self.beyond_step, "samples too far from those beside them left out"),
            (self.no_value, "samples without a value left out"),
            (self.extrapolated, "samples extrapolated beyond their calibration"),
        ];
        let parts: Vec<String> =
            parts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

/// What a parameter is in a row.
#[derive(Clone, Copy, Debug)]
enum Cell {
    Known(Channel, f64),
    Other(usize),
}

/// Joins samples to rows.
#[derive(Clone, Debug)]
pub struct PcmRows {
    cells: Vec<Cell>,
    columns: Vec<RecordingColumn>,
    controls: ControlNames,
    row: RecordingRow,
    /// Times of the first and the last sample of the row, s; `None` while it has none.
    span_s: Option<(f64, f64)>,
    unused: UnusedSamples,
    /// Of each parameter, samples and those that were left out.
    counts: Vec<(u64, u64)>,
}

/// Parameters that are named at most where they lost most of their samples.
const NAMED: usize = 4;

impl PcmRows {
    /// For the parameters of that format.
    ///
    /// # Errors
    /// A sentence where a channel has a unit of another quantity, the controls are called after two kinds of aircraft, or a
    /// parameter is called `time`.
    pub fn new(format: &PcmFormat) -> Result<Self, String> {
        let mut columns = vec![RecordingColumn::new("time", None)?];
        let (mut cells, mut others) = (Vec::new(), 0);
        for parameter in format.parameters() {
            let column = RecordingColumn::new(&parameter.name, Some(parameter.unit.as_str()).filter(|unit| !unit.is_empty()))?;
            cells.push(match column.target {
                RecordingTarget::Known { channel, factor } => Cell::Known(channel, factor),
                RecordingTarget::Other => {
                    others += 1;
                    Cell::Other(others - 1)
                }
                RecordingTarget::Time { .. } => {
                    return Err("parameter `time`: expected another name, time is that of the words".into());
                }
            });
            columns.push(column);
        }
        let header = RecordingHeader::from_columns(columns)?;
        Ok(PcmRows {
            counts: vec![(0, 0); cells.len()],
            cells,
            columns: header.columns,
            controls: header.controls,
            row: RecordingRow { number: 0, sample: Sample::new(0.0), others: vec![None; others] },
            span_s: None,
            unused: UnusedSamples::default(),
        })
    }

    /// The time, then the parameters in the order of the format.
    #[must_use]
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// How the controls are called.
    #[must_use]
    pub fn controls(&self) -> ControlNames {
        self.controls
    }

    /// What was left out so far.
    #[must_use]
    pub fn unused(&self) -> UnusedSamples {
        self.unused
    }

    /// What was left out so far in words, and the parameters that lost most of their samples; `None` where nothing was.
    #[must_use]
    pub fn shortfall(&self) -> Option<String> {
        let mut words = self.unused.words()?;
        let named = self.columns.iter().skip(1).zip(&self.counts);
        let mut most = named.filter(|(_, (samples, left_out))| 2 * left_out > *samples);
        for (column, (samples, left_out)) in most.by_ref().take(NAMED) {
            words.push_str(&format!(", {} lost {left_out} of {samples}", column.name));
        }
        match most.count() {
            0 => {}
            more => words.push_str(&format!(", and {more} parameters more lost most of theirs")),
        }
        Some(words)
    }

    /// Takes in a sample; gives the row that it does not belong to any more.
    pub fn put(&mut self, sample: &PcmSample, each: &mut impl FnMut(&RecordingRow)) {
        let value = self.usable(sample);
        if let Some((samples, left_out)) = self.counts.get_mut(sample.parameter) {
            *samples += 1;
            *left_out += u64::from(value.is_none());
        }
        let Some(value) = value else { return };
        let Some(cell) = self.cells.get(sample.parameter).copied() else { return };
        let taken = match cell {
            Cell::Known(channel, _) => self.row.sample.get(channel).is_some(),
            Cell::Other(place) => self.row.others.get(place).is_some_and(Option::is_some),
        };
        let within = self.span_s.is_none_or(|(first_s, _)| (0.0..=ROW_S).contains(&(sample.time_s - first_s)));
        if taken || !within {
            self.finish(each);
        }
        match cell {
            Cell::Known(channel, factor) => self.row.sample.set(channel, value * factor),
            Cell::Other(place) => {
                if let Some(other) = self.row.others.get_mut(place) {
                    *other = Some(value);
                }
            }
        }
        self.span_s = Some((self.span_s.map_or(sample.time_s, |(first_s, _)| first_s), sample.time_s));
    }

    /// Gives the row that waits for further samples.
    pub fn finish(&mut self, each: &mut impl FnMut(&RecordingRow)) {
        let Some((first_s, last_s)) = self.span_s.take() else { return };
        self.row.number += 1;
        self.row.sample.time_s = 0.5 * (first_s + last_s);
        each(&self.row);
        self.row.sample = Sample::new(0.0);
        self.row.others.fill(None);
    }

    /// The value, where it may be used.
    fn usable(&mut self, sample: &PcmSample) -> Option<f64> {
        let has = |flag| sample.flags.contains(flag);
        let reason = if has(SampleFlags::DOUBTFUL_FRAME) {
            &mut self.unused.doubtful_frame
        } else if has(SampleFlags::PARITY) {
            &mut self.unused.parity
        } else if sample.value.is_none() {
            &mut self.unused.no_value
        } else if has(SampleFlags::LOW) || has(SampleFlags::HIGH) {
            &mut self.unused.out_of_limits
        } else if has(SampleFlags::STEP) {
            &mut self.unused.beyond_step
        } else {
            self.unused.extrapolated += u64::from(has(SampleFlags::EXTRAPOLATED));
            return sample.value;
        };
        *reason += 1;
        None
    }
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod tests;
