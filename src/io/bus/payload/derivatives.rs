//! Payload of the derivatives of all axes, with the joint covariance of the lateral derivatives.

use super::message::{ABSENT, MessageHeader, at, flag, place, service};
use super::status::StatusBody;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::io::bus::error::BusError;
use crate::realtime::regression::record::{
    DerivativesRecord, EquationRecord, FrequencyTerm, LateralDerivatives, Status, TERMS, TermRecord,
};
use iceoryx2::prelude::ZeroCopySend;

const SCHEMA: &str = "sideslip.Derivatives.2";

/// One term, with the meaning of [`TermRecord`]; `variable` is its place, [`ABSENT`] for the bias.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Term.2")]
#[expect(missing_docs, reason = "the fields are those of the record")]
pub struct TermBody {
    pub variable: u32,
    /// Step of entry times two, one more where the term is primary.
    pub step_and_primary: u32,
    pub value: f64,
    pub std: f64,
    pub std_white: f64,
    /// Of the frequency domain; NaN where there is none.
    pub frequency_value: f64,
    pub frequency_std: f64,
}

/// One axis' equation, with the meaning of [`EquationRecord`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Equation.3")]
#[expect(missing_docs, reason = "the fields are those of the record")]
pub struct EquationBody {
    pub axis: u32,
    /// How many of the terms count.
    pub count: u32,
    pub status: StatusBody,
    pub terms: [TermBody; TERMS],
    pub r_squared: f64,
    pub f_total: f64,
    pub samples: f64,
    pub residual_std: f64,
    pub condition_index: f64,
    pub unresolved: u64,
}

/// All equations at one time; `time_s` of the header is the record's.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Derivatives.3")]
pub struct DerivativesPayload {
    /// Its header.
    pub header: MessageHeader,
    /// 1 where the aircraft is being excited now.
    pub excited: u32,
    /// 1 where the lateral derivatives are there.
    pub has_lateral: u32,
    /// One equation an axis.
    pub equations: [EquationBody; AXES],
    /// The lateral derivatives; zeros where they are not there.
    pub lateral: LateralDerivatives,
}
service!(DerivativesPayload, "sideslip/derivatives", "sideslip.Derivatives.3", buffer 64, history 1);

impl EquationBody {
    fn new(record: &EquationRecord) -> Self {
        let mut terms = [TermBody::default(); TERMS];
        for (to, from) in terms.iter_mut().zip(&record.terms) {
            *to = TermBody {
                variable: from.variable.map_or(ABSENT, |variable| place(variable.index())),
                step_and_primary: u32::from(from.step) * 2 + u32::from(from.primary),
                value: from.value,
                std: from.std,
                std_white: from.std_white,
                frequency_value: from.frequency.map_or(f64::NAN, |second| second.value),
                frequency_std: from.frequency.map_or(f64::NAN, |second| second.std),
            };
        }
        EquationBody {
            axis: place(record.axis.index()),
            count: place(record.terms.len()),
            status: record.status.into(),
            terms,
            r_squared: record.r_squared,
            f_total: record.f_total,
            samples: record.samples,
            residual_std: record.residual_std,
            condition_index: record.condition_index,
            unresolved: record.unresolved.into(),
        }
    }

    fn record(&self) -> Result<EquationRecord, BusError> {
        let mut record = EquationRecord::empty(at(&Axis::ALL, self.axis, SCHEMA, "axis")?, self.status.status()?);
        let wrong = || BusError::Payload { schema: SCHEMA, field: "count", expected: "0 to 11", found: self.count.into() };
        let count = usize::try_from(self.count).map_err(|_| wrong())?;
        for body in self.terms.get(..count).ok_or_else(wrong)? {
            let variable = match body.variable {
                ABSENT => None,
                index => Some(at(&Variable::ALL, index, SCHEMA, "variable")?),
            };
            let step = u8::try_from(body.step_and_primary / 2);
            let found = body.step_and_primary.into();
            let second = FrequencyTerm { value: body.frequency_value, std: body.frequency_std };
            let term = TermRecord {
                variable,
                value: body.value,
                std: body.std,
                std_white: body.std_white,
                step: step.map_err(|_| BusError::Payload { schema: SCHEMA, field: "step", expected: "0 to 511", found })?,
                primary: body.step_and_primary % 2 == 1,
                frequency: second.value.is_finite().then_some(second),
            };
            record.terms.push(term).map_err(|_| wrong())?;
        }
        record.r_squared = self.r_squared;
        record.f_total = self.f_total;
        record.samples = self.samples;
        record.residual_std = self.residual_std;
        record.condition_index = self.condition_index;
        record.unresolved = u16::try_from(self.unresolved).map_err(|_| BusError::Payload {
            schema: SCHEMA,
            field: "unresolved",
            expected: "a bit for each variable",
            found: self.unresolved,
        })?;
        Ok(record)
    }
}

impl From<&DerivativesRecord> for DerivativesPayload {
    fn from(record: &DerivativesRecord) -> Self {
        let mut equations = [EquationBody::default(); AXES];
        equations.iter_mut().zip(&record.equations).for_each(|(to, from)| *to = EquationBody::new(from));
        DerivativesPayload {
            header: MessageHeader { time_s: record.time_s, ..MessageHeader::default() },
            excited: record.excited.into(),
            has_lateral: record.lateral.is_some().into(),
            equations,
            lateral: record.lateral.unwrap_or_default(),
        }
    }
}

impl DerivativesPayload {
    /// The record.
    ///
    /// # Errors
    /// [`BusError::Payload`] for a place or a count that there is not.
    pub fn record(&self) -> Result<DerivativesRecord, BusError> {
        let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Waiting));
        for (to, from) in equations.iter_mut().zip(&self.equations) {
            *to = from.record()?;
        }
        Ok(DerivativesRecord {
            time_s: self.header.time_s,
            equations,
            lateral: flag(self.has_lateral, SCHEMA, "has_lateral")?.then_some(self.lateral),
            excited: flag(self.excited, SCHEMA, "excited")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::mem::offset_of;

    #[test]
    fn the_lateral_derivatives_travel_in_the_order_of_their_schema() {
        let offsets = [
            offset_of!(LateralDerivatives, values),
            offset_of!(LateralDerivatives, cov),
            offset_of!(LateralDerivatives, u0),
            offset_of!(LateralDerivatives, w0),
            offset_of!(LateralDerivatives, phi0),
            offset_of!(LateralDerivatives, theta0),
            offset_of!(LateralDerivatives, trim_std),
            size_of::<LateralDerivatives>(),
        ];
        assert_eq!(offsets.map(|bytes| bytes / 8), [0, 9, 90, 91, 92, 93, 94, 96]);
    }
}
