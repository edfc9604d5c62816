//! The modes stage: derivatives in, modes out, with a status of their own.

use super::lateral;
use super::record::ModesRecord;
use crate::flight::derivative::{Axis, Variable};
use crate::regression::record::{DerivativesRecord, Reason, Status};

/// Standard error of omega, relative, below which the Dutch roll is known.
const OMEGA_KNOWN: f64 = 0.05;
/// Standard error of zeta below which the Dutch roll is known.
const ZETA_KNOWN: f64 = 0.02;

/// The modes of these derivatives.
pub fn step(derivatives: &DerivativesRecord) -> ModesRecord {
    let time_s = derivatives.time_s;
    let status = least(derivatives);
    if let Some(axis) = without_motion(derivatives) {
        let status = Status::NotIdentifiable(Reason::Equation { axis });
        return ModesRecord { time_s, status, dutch_roll: None, roll: None, spiral: None, lateral_phugoid: None };
    }
    let record = derivatives.lateral.as_ref().and_then(|lateral| lateral::modes(time_s, status, lateral));
    let Some(mut record) = record else {
        return ModesRecord { time_s, status, dutch_roll: None, roll: None, spiral: None, lateral_phugoid: None };
    };
    if record.status == Status::Converged {
        let known = record.dutch_roll.is_some_and(|pair| pair.std_omega < OMEGA_KNOWN * pair.omega && pair.std_zeta < ZETA_KNOWN);
        if !known {
            record.status = Status::Converging;
        }
    }
    record
}

/// The equation that has numbers and yet none for the motion that it stands for: roll without `L_p`, yaw without `N_v`.
/// A run that never moved sideways gives such ones, and roots of a matrix of zeros would be no answer.
fn without_motion(derivatives: &DerivativesRecord) -> Option<Axis> {
    derivatives.lateral?;
    let lacks = |(axis, variable): &(Axis, Variable)| derivatives.equations[axis.index()].term(*variable).is_none();
    [(Axis::L, Variable::P), (Axis::N, Variable::V)].into_iter().find(lacks).map(|(axis, _)| axis)
}

/// The status of the least advanced of the three lateral equations.
fn least(derivatives: &DerivativesRecord) -> Status {
    let rank = |status: &Status| match status {
        Status::NotIdentifiable(_) => 0,
        Status::Waiting => 1,
        Status::Exciting => 2,
        Status::Stale => 3,
        Status::Converging => 4,
        Status::Converged => 5,
    };
    let mut least = Status::Converged;
    for axis in [Axis::L, Axis::N, Axis::Y] {
        let equation = &derivatives.equations[axis.index()];
        if rank(&equation.status) < rank(&least) {
            least = match equation.status {
                Status::NotIdentifiable(_) => Status::NotIdentifiable(Reason::Equation { axis }),
                status => status,
            };
        }
    }
    least
}
