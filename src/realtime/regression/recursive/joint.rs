//! Derivatives of several equations with their joint covariance, as the modes need them.
//!
//! Consumes the fitted equations; produces [`LateralDerivatives`] and [`SixAxisDerivatives`]. The covariance between two
//! equations is that of least squares, `coloured_errors` (1); what `endogeneity` and `curvature` add stands within each
//! equation.

use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::realtime::estimation::record::TrimRecord;
use crate::realtime::regression::candidate::{SIGNALS, regressor};
use crate::realtime::regression::coloured_errors;
use crate::realtime::regression::information::Information;
use crate::realtime::regression::record::{
    EquationRecord, LATERAL, LateralDerivatives, MOTION, Reason, SixAxisDerivatives, Status,
};
use crate::realtime::regression::stepwise::Fit;

/// Reason of an X equation without numbers whose fit is good enough for the coupling of the whole aircraft.
pub(super) const AX_NOT_CONFIRMED: Reason = Reason::NotConfirmed { channel: Channel::Ax };

/// Change of the derivatives of X, relative, by an ax in another unit (g for m/s^2, 9.81); one by a reversed ax is smaller.
const BY_ANOTHER_UNIT: f64 = 8.81;

/// Y_v beyond which no aircraft's is taken to be where moving air hides the unit of ay, 1/s: small unmanned ones reach 0.7.
const SIDE_FORCE: f64 = 0.7;
/// Change of the derivatives of Y, relative, by a reversed ay.
const BY_REVERSAL: f64 = 2.0;
/// Standard errors by which a negative Y_v tells that ay is not reversed.
const OPPOSES_SIDESLIP: f64 = 2.0;

/// The fit of X with what a wrong sign or unit of ax would change as part of its covariance. A lateral test input hardly moves
/// the airspeed, which alone confirms ax, and X hardly enters the Dutch roll.
pub(super) fn of_unconfirmed_ax(fit: Fit) -> Fit {
    with_relative_error(fit, BY_ANOTHER_UNIT)
}

/// The fit of Y with what an error of ay that moving air hides would change as part of its covariance: a reversal where the side
/// force is not known to oppose the sideslip, as every aircraft's does, or g for m/s^2 where Y_v would not be beyond every
/// aircraft's in the other unit.
pub(super) fn of_plausible_ay(fit: Fit, hidden: f64) -> Fit {
    let place = regressor(Variable::V);
    let (y_v, std) = (fit.theta[place], libm::sqrt(fit.cov[place][place]));
    let by_unit = if libm::fabs(y_v) * (1.0 + BY_ANOTHER_UNIT) < SIDE_FORCE { BY_ANOTHER_UNIT } else { 0.0 };
    let by_reversal = if y_v < -OPPOSES_SIDESLIP * std { 0.0 } else { BY_REVERSAL };
    with_relative_error(fit, libm::fmin(hidden, libm::fmax(by_unit, by_reversal)))
}

/// One factor on all derivatives, known to be one with that standard error.
fn with_relative_error(mut fit: Fit, relative_error: f64) -> Fit {
    let change = fit.theta.map(|value| relative_error * value);
    for (row, by_row) in fit.cov.iter_mut().zip(change) {
        for (entry, by_column) in row.iter_mut().zip(change) {
            *entry += by_row * by_column;
        }
    }
    fit
}

/// The lateral derivatives with their joint covariance, where Y, L and N all have them. Those without a number of their own are
/// among them, with their covariance: a mode can be known where they are not.
pub(super) fn lateral(
    information: &Information<SIGNALS>,
    trim: &TrimRecord,
    fits: &[Option<Fit>; AXES],
) -> Option<LateralDerivatives> {
    let inside = |(axis, variable): (Axis, Variable)| {
        fits[axis.index()].as_ref().is_some_and(|fit| fit.order.contains(&regressor(variable)))
    };
    if !LateralDerivatives::NEEDED.into_iter().all(inside) {
        return None;
    }
    let mut values = [0.0; LATERAL];
    let mut cov = [[0.0; LATERAL]; LATERAL];
    let axes = [Axis::Y, Axis::L, Axis::N];
    for (a, axis_a) in axes.into_iter().enumerate() {
        let fit_a = fits[axis_a.index()].as_ref()?;
        for (b, axis_b) in axes.into_iter().enumerate().skip(a) {
            let fit_b = fits[axis_b.index()].as_ref()?;
            if a == b {
                continue;
            }
            let parameters = fit_a.order.len().max(fit_b.order.len());
            let ahead = coloured_errors::residual_covariance(information, &fit_a.residual, &fit_b.residual, parameters);
            let behind = coloured_errors::residual_covariance(information, &fit_b.residual, &fit_a.residual, parameters);
            let block = coloured_errors::covariance(information, &fit_a.dispersion, &fit_b.dispersion, &ahead, &behind);
            for i in 0..3 {
                for j in 0..3 {
                    let (row, column) = (LateralDerivatives::NAMES[3 * a + i].1, LateralDerivatives::NAMES[3 * b + j].1);
                    cov[3 * a + i][3 * b + j] = block[regressor(row)][regressor(column)];
                    // The same where a is b: the block of one equation is symmetric.
                    cov[3 * b + j][3 * a + i] = block[regressor(row)][regressor(column)];
                }
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                let (row, column) = (LateralDerivatives::NAMES[3 * a + i].1, LateralDerivatives::NAMES[3 * a + j].1);
                cov[3 * a + i][3 * a + j] = fit_a.cov[regressor(row)][regressor(column)];
            }
            values[3 * a + i] = fit_a.theta[regressor(LateralDerivatives::NAMES[3 * a + i].1)];
        }
    }
    let [u0, _, w0] = trim.velocity;
    let [phi0, theta0] = trim.attitude;
    let trim_std = [trim.velocity_std[0], trim.velocity_std[2]];
    Some(LateralDerivatives { values, cov, u0, w0, trim_std, phi0, theta0 })
}

/// The derivatives of every equation, where each has numbers, or lacks them only because ax is not confirmed, and the
/// longitudinal ones that the coupling needs are among them.
pub(super) fn six_axis(
    trim: &TrimRecord,
    fits: &[Option<Fit>; AXES],
    equations: &[EquationRecord; AXES],
) -> Option<SixAxisDerivatives> {
    let has_numbers = |equation: &EquationRecord| {
        equation.status.rank() >= Status::Stale.rank() || equation.status == Status::NotIdentifiable(AX_NOT_CONFIRMED)
    };
    let missing = |&(axis, variable): &(Axis, Variable)| {
        !fits[axis.index()].as_ref().is_some_and(|fit| fit.order.contains(&regressor(variable)))
    };
    if !equations.iter().all(has_numbers) || SixAxisDerivatives::NEEDED.iter().any(missing) {
        return None;
    }
    let [_, v0, _] = trim.velocity;
    let [_, v0_std, _] = trim.velocity_std;
    let (values, cov) = ([[0.0; MOTION]; AXES], [[[0.0; MOTION]; MOTION]; AXES]);
    let mut six_axis = SixAxisDerivatives { values, cov, v0, v0_std };
    for ((fit, values), cov) in fits.iter().zip(&mut six_axis.values).zip(&mut six_axis.cov) {
        let fit = fit.as_ref()?;
        for i in 0..MOTION {
            let row = regressor(Variable::ALL[i]);
            values[i] = fit.theta[row];
            for (entry, variable) in cov[i].iter_mut().zip(Variable::ALL) {
                *entry = fit.cov[row][regressor(variable)];
            }
        }
    }
    Some(six_axis)
}
