//! The modes stage: derivatives in, modes out, with a status of their own.
//!
//! A mode has numbers where its standard errors resolve it: [`OscillatoryMode::is_resolved`], [`RealRoot::is_resolved`]; an
//! unstable one only where no other method contradicts its equations.

use super::record::{ModesRecord, OscillatoryMode, RealRoot};
use crate::flight::derivative::{Axis, Variable};
use crate::realtime::modes::{coupled, lateral};
use crate::realtime::regression::record::{DerivativesRecord, LateralDerivatives, Reason, SixAxisDerivatives, Status};

/// Standard error of omega, relative, below which the Dutch roll is known.
const OMEGA_KNOWN: f64 = 0.05;
/// Standard error of zeta below which the Dutch roll is known.
const ZETA_KNOWN: f64 = 0.02;

/// The modes of these derivatives; `six_axis` where all six equations have what the whole aircraft's need; `pitch_std` the
/// standard error of the pitch attitude in trim, rad.
pub fn step(derivatives: &DerivativesRecord, six_axis: Option<&SixAxisDerivatives>, pitch_std: f64) -> ModesRecord {
    let time_s = derivatives.time_s;
    let status = match (least(derivatives), lacking(derivatives)) {
        (status, Some(reason)) if status.rank() >= Status::Stale.rank() => Status::NotIdentifiable(reason),
        (status, _) => status,
    };
    let has_numbers = status.rank() >= Status::Stale.rank();
    let lateral = derivatives.lateral.as_ref().filter(|_| has_numbers);
    let Some(mut record) = lateral.and_then(|lateral| lateral::modes_of_trim(time_s, status, lateral, pitch_std)) else {
        return ModesRecord::empty(time_s, status);
    };
    if let (Some(six_axis), Some(lateral), Some(alone)) = (six_axis, &derivatives.lateral, &record.dutch_roll) {
        record.coupled = coupled::dutch_roll(six_axis, lateral, alone, pitch_std);
    }
    if record.status.rank() >= Status::Stale.rank() && record.dutch_roll.is_some_and(|pair| !pair.is_resolved()) {
        record.status = Status::NotIdentifiable(Reason::Unresolved);
    }
    record.dutch_roll = record.dutch_roll.filter(OscillatoryMode::is_resolved);
    record.coupled = record.coupled.filter(OscillatoryMode::is_resolved);
    record.lateral_phugoid = record.lateral_phugoid.filter(OscillatoryMode::is_resolved);
    record.roll = record.roll.filter(RealRoot::is_resolved);
    record.spiral = record.spiral.filter(RealRoot::is_resolved);
    match record.status {
        Status::Disagree => withhold_unstable(&mut record),
        Status::NotIdentifiable(_) => return ModesRecord::empty(time_s, record.status),
        _ => {}
    }
    if record.status == Status::Converged {
        let known = record.dutch_roll.is_some_and(|pair| pair.std_omega < OMEGA_KNOWN * pair.omega && pair.std_zeta < ZETA_KNOWN);
        if !known {
            record.status = Status::Converging;
        }
    }
    record
}

/// Where two methods disagree neither is trusted with an instability.
fn withhold_unstable(record: &mut ModesRecord) {
    for pair in [&mut record.dutch_roll, &mut record.coupled, &mut record.lateral_phugoid] {
        *pair = pair.filter(|pair| pair.real < 0.0);
    }
    for root in [&mut record.roll, &mut record.spiral] {
        *root = root.filter(|root| root.value < 0.0);
    }
}

/// The first derivative that the modes need and no equation has.
fn lacking(derivatives: &DerivativesRecord) -> Option<Reason> {
    if derivatives.lateral.is_some() {
        return None;
    }
    let lacks = |&(axis, variable): &(Axis, Variable)| {
        let equation = &derivatives.equations[axis.index()];
        equation.term(variable).is_none() && !equation.unresolved_variables().any(|other| other == variable)
    };
    let (axis, variable) = LateralDerivatives::NEEDED.into_iter().find(lacks)?;
    Some(Reason::NotExcited { axis, variable })
}

/// The status of the least advanced of the three lateral equations; `exciting` and `waiting` hide no other where the modes have
/// their derivatives all the same: an equation without a resolved one is that, and its doubt is part of the modes' standard
/// errors.
fn least(derivatives: &DerivativesRecord) -> Status {
    let equations = [Axis::L, Axis::N, Axis::Y].map(|axis| &derivatives.equations[axis.index()]);
    let is_unresolved = |status: Status| matches!(status, Status::Exciting | Status::Waiting);
    let complete = derivatives.lateral.is_some() && equations.iter().any(|equation| !is_unresolved(equation.status));
    let mut least = Status::Converged;
    for equation in equations {
        if equation.status.rank() < least.rank() && !(complete && is_unresolved(equation.status)) {
            least = match equation.status {
                // Which of the three it is says more than its condition index; of other reasons the reason itself does.
                Status::NotIdentifiable(Reason::Collinear { .. }) => {
                    Status::NotIdentifiable(Reason::Equation { axis: equation.axis })
                }
                status => status,
            };
        }
    }
    least
}
