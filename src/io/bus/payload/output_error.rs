//! Payload of an output-error estimate: parameters, modes, convergence.

use super::message::{MessageHeader, at, bytes_of, place, service, text_of};
use crate::flight::derivative::{Axis, Variable};
use crate::io::bus::error::BusError;
use crate::postflight::output_error::record::{OutputErrorProgress, OutputErrorRecord, PARAMETERS, ParameterRecord, REASON};
use crate::realtime::modes::record::{OscillatoryMode, RealRoot};
use iceoryx2::prelude::ZeroCopySend;

const SCHEMA: &str = "sideslip.OutputError.1";

/// A derivative, with the meaning of [`ParameterRecord`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Parameter.1")]
#[expect(missing_docs, reason = "the fields are those of the record")]
pub struct ParameterBody {
    pub axis: u32,
    pub variable: u32,
    pub value: f64,
    pub std: f64,
    pub std_cramer_rao: f64,
}

/// Output error as it stands; `time_s` of the header is the record's.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("sideslip.OutputError.1")]
#[expect(missing_docs, reason = "fields are what their names say")]
pub struct OutputErrorPayload {
    pub header: MessageHeader,
    /// Time of the newest sample that the numbers rest on, s; NaN where there are none.
    pub fitted_s: f64,
    /// What is there: 1 Dutch roll, 2 roll, 4 spiral, 8 lateral phugoid, 16 coupled Dutch roll, 32 short period.
    pub present: u64,
    /// How far it is: waiting 0, converging 1, converged 2, stale 3, failed 4.
    pub progress: u32,
    /// Derivatives that are there.
    pub count: u32,
    /// Manoeuvres that the numbers rest on.
    pub manoeuvres: u32,
    /// Manoeuvres that were left behind.
    pub dropped: u32,
    /// Samples that the numbers rest on.
    pub samples: u32,
    pub reason_bytes: u32,
    /// The reason, UTF-8; zeros behind it.
    pub reason: [u8; REASON],
    /// The derivatives; zeros behind them.
    pub parameters: [ParameterBody; PARAMETERS],
    /// Dutch roll of the lateral subsystem.
    pub dutch_roll: OscillatoryMode,
    /// Roll subsidence.
    pub roll: RealRoot,
    pub spiral: RealRoot,
    /// The slower pair where roll and spiral have joined.
    pub lateral_phugoid: OscillatoryMode,
    /// Dutch roll of the whole aircraft.
    pub coupled: OscillatoryMode,
    pub short_period: OscillatoryMode,
}
service!(OutputErrorPayload, "sideslip/output_error", "sideslip.OutputError.1", buffer 16, history 1);

impl From<&OutputErrorRecord> for OutputErrorPayload {
    fn from(record: &OutputErrorRecord) -> Self {
        let there = [
            record.dutch_roll.is_some(),
            record.roll.is_some(),
            record.spiral.is_some(),
            record.lateral_phugoid.is_some(),
            record.coupled.is_some(),
            record.short_period.is_some(),
        ];
        let mut parameters = [ParameterBody::default(); PARAMETERS];
        for (to, from) in parameters.iter_mut().zip(&record.parameters) {
            let ParameterRecord { axis, variable, value, std, std_cramer_rao } = *from;
            *to = ParameterBody { axis: place(axis.index()), variable: place(variable.index()), value, std, std_cramer_rao };
        }
        OutputErrorPayload {
            header: MessageHeader { time_s: record.time_s, ..MessageHeader::default() },
            fitted_s: record.fitted_s,
            present: there.iter().rev().fold(0, |bits, &there| bits * 2 + u64::from(there)),
            progress: place(record.progress.index()),
            count: place(record.parameters.len()),
            manoeuvres: record.manoeuvres,
            dropped: record.dropped,
            samples: record.samples,
            reason_bytes: place(record.reason.len()),
            reason: bytes_of(&record.reason),
            parameters,
            dutch_roll: record.dutch_roll.unwrap_or_default(),
            roll: record.roll.unwrap_or_default(),
            spiral: record.spiral.unwrap_or_default(),
            lateral_phugoid: record.lateral_phugoid.unwrap_or_default(),
            coupled: record.coupled.unwrap_or_default(),
            short_period: record.short_period.unwrap_or_default(),
        }
    }
}

impl OutputErrorPayload {
    /// The record.
    ///
    /// # Errors
    /// [`BusError::Payload`] for a code that there is not, and a reason that is no text.
    pub fn record(&self) -> Result<OutputErrorRecord, BusError> {
        let wrong = |field, expected, found: u64| BusError::Payload { schema: SCHEMA, field, expected, found };
        if self.present > 63 {
            return Err(wrong("present", "0 to 63", self.present));
        }
        let there = |bit: u64| self.present & bit != 0;
        let mut record = OutputErrorRecord {
            time_s: self.header.time_s,
            fitted_s: self.fitted_s,
            progress: at(&OutputErrorProgress::ALL, self.progress, SCHEMA, "progress")?,
            manoeuvres: self.manoeuvres,
            dropped: self.dropped,
            samples: self.samples,
            dutch_roll: there(1).then_some(self.dutch_roll),
            roll: there(2).then_some(self.roll),
            spiral: there(4).then_some(self.spiral),
            lateral_phugoid: there(8).then_some(self.lateral_phugoid),
            coupled: there(16).then_some(self.coupled),
            short_period: there(32).then_some(self.short_period),
            ..OutputErrorRecord::EMPTY
        };
        record.explain(text_of(&self.reason, self.reason_bytes, SCHEMA, "reason_bytes")?);
        let bodies = usize::try_from(self.count).ok().and_then(|count| self.parameters.get(..count));
        for body in bodies.ok_or_else(|| wrong("count", "0 to 60", self.count.into()))? {
            let ParameterBody { value, std, std_cramer_rao, .. } = *body;
            let axis = at(&Axis::ALL, body.axis, SCHEMA, "axis")?;
            let variable = at(&Variable::ALL, body.variable, SCHEMA, "variable")?;
            let _ = record.parameters.push(ParameterRecord { axis, variable, value, std, std_cramer_rao });
        }
        Ok(record)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_comes_back_as_it_was_and_codes_that_there_are_not_are_refused() {
        let mut record =
            OutputErrorRecord { time_s: 3.0, fitted_s: 2.5, progress: OutputErrorProgress::Failed, ..OutputErrorRecord::EMPTY };
        record.explain("no control is in the regression's equations");
        let parameter = ParameterRecord { axis: Axis::N, variable: Variable::Pedal, value: -1.5, std: 0.1, std_cramer_rao: 0.05 };
        record.parameters.push(parameter).unwrap();
        let payload = OutputErrorPayload::from(&record);
        assert_eq!(payload.record().unwrap(), record);
        for wrong in [
            OutputErrorPayload { progress: 6, ..payload },
            OutputErrorPayload { count: 61, ..payload },
            OutputErrorPayload { present: 64, ..payload },
            OutputErrorPayload { reason_bytes: 121, ..payload },
        ] {
            assert!(wrong.record().is_err());
        }
        let mut wrong = payload;
        wrong.parameters[0].axis = 6;
        assert!(wrong.record().is_err());
    }
}
