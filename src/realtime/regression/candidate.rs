//! Candidate regressors: which terms each equation is offered, which belong to it, and where they stand in the sums.
//!
//! Consumes smoothed signals and the run's trim; produces the vector z \[17\] of the information matrix:
//!     z = [1, u v w p q r, lon lat col pedal, ax ay az p' q' r'], all but the 1 as deviations from trim    (1)
//! Primary terms are the stiffness, damping and control terms of (23) and (24) of Padfield et al. 1987 and their like on the
//! other axes: they are in the equation whatever their F, so that their standard errors are reported instead of a zero; every
//! other term is selected by its F.

use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::realtime::estimation::record::{SignalNoise, SmoothedRecord, TrimRecord};

/// Length of z, (1).
pub const SIGNALS: usize = 1 + VARIABLES + AXES;

/// A residual as coefficients over z: 1 at the response, -theta at the regressors.
pub type Coefficients = [f64; SIGNALS];
/// Place of the bias in z.
pub const BIAS: usize = 0;
/// Number of regressors in z, the bias among them.
pub const REGRESSORS: usize = 1 + VARIABLES;

/// Place of a variable in z.
pub const fn regressor(variable: Variable) -> usize {
    1 + variable.index()
}

/// The variable at a place of z; `None` for the bias.
pub fn variable(regressor: usize) -> Option<Variable> {
    regressor.checked_sub(1).and_then(|place| Variable::ALL.get(place).copied())
}

/// Place of an axis' response in z.
pub const fn response(axis: Axis) -> usize {
    REGRESSORS + axis.index()
}

/// Standard deviation below which a regressor is not excited, SI; it is then no primary term.
pub const STILL: [f64; VARIABLES] = [0.3, 0.15, 0.15, 0.003, 0.003, 0.003, 5e-4, 5e-4, 5e-4, 5e-4];

/// Part of [`STILL`] below which a regressor is no candidate: its derivative is not identifiable.
pub const UNMOVED: f64 = 1.0 / 3.0;

/// Whether the term belongs to the equation whatever its F.
pub const fn is_primary(axis: Axis, variable: Variable) -> bool {
    use Variable::{Collective, LatCyclic, LonCyclic, P, Pedal, Q, R, U, V, W};
    match axis {
        Axis::X => matches!(variable, U | W | LonCyclic | Collective),
        // p and r correlate with v in a Dutch roll: left out of Y, they would bias Y_v.
        Axis::Z => matches!(variable, U | W | LonCyclic | Collective),
        Axis::Y | Axis::L | Axis::N => matches!(variable, V | P | R | LatCyclic | Pedal),
        Axis::M => matches!(variable, U | W | Q | LonCyclic | Collective),
    }
}

/// z of (1); `None` where a signal that has a trim was not sampled.
///
/// A control without a trim is zero, as is a specific force: the equation that needs it is refused elsewhere.
pub fn signals(record: &SmoothedRecord, trim: &TrimRecord) -> Option<[f64; SIGNALS]> {
    let mut z = [0.0; SIGNALS];
    z[BIAS] = 1.0;
    for i in 0..3 {
        z[1 + i] = record.velocity[i] - trim.velocity[i];
        z[4 + i] = record.rates[i] - trim.rates[i];
        if trim.specific_force[i].is_finite() {
            z[REGRESSORS + i] = record.specific_force[i] - trim.specific_force[i];
        }
        z[REGRESSORS + 3 + i] = record.angular_acceleration[i];
    }
    for i in 0..4 {
        if trim.controls[i].is_finite() {
            z[7 + i] = if record.controls_present[i] { record.controls[i] - trim.controls[i] } else { f64::NAN };
        }
    }
    z.iter().all(|entry| entry.is_finite()).then_some(z)
}

/// Variances of what the instruments' noise leaves in z; the controls' recording is taken as exact.
pub fn noise_variances(noise: &SignalNoise) -> [f64; SIGNALS] {
    let mut variances = [0.0; SIGNALS];
    for i in 0..3 {
        variances[1 + i] = noise.velocity[i] * noise.velocity[i];
        variances[4 + i] = noise.rates[i] * noise.rates[i];
        variances[REGRESSORS + i] = noise.specific_force[i] * noise.specific_force[i];
        variances[REGRESSORS + 3 + i] = noise.angular_acceleration[i] * noise.angular_acceleration[i];
    }
    variances
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_variables_are_each_others_inverse() {
        assert_eq!(variable(BIAS), None);
        for one in Variable::ALL {
            assert_eq!(variable(regressor(one)), Some(one));
        }
        assert_eq!(response(Axis::N), SIGNALS - 1);
        assert_eq!(variable(REGRESSORS), None);
    }
}
