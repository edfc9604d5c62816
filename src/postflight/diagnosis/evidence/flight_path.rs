//! Several flight conditions: which derivatives vary with the flight path otherwise than the model says.
//!
//! Consumes the diagnosis of each condition with its flight-path angle gamma and the model as trimmed there; produces, for each
//! derivative that is off anywhere, d_i of the model and delta_i of the flight by condition, and the line
//!     delta_i = a + s gamma_i,  s = sum w (gamma - mean gamma) delta / sum w (gamma - mean gamma)^2,  w = 1/std^2      (1)
//! with the standard error of s from that of the delta_i, or from their scatter about the line where that is more.
//! Where a derivative was not found off, its delta is zero within the model's tolerance.

use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::Effect;
use crate::flight::model::LinearModel;
use crate::postflight::diagnosis::diagnose::Diagnosis;

/// Standard errors of a slope that is no chance.
const SURE: f64 = 3.0;

/// One flight condition.
#[derive(Clone, Copy, Debug)]
pub struct ConditionDiagnosis<'a> {
    /// Flight-path angle, rad, up positive.
    pub path_rad: f64,
    /// The model as trimmed there.
    pub model: &'a LinearModel,
    /// Its relative tolerance.
    pub tolerance: f64,
    /// What was found.
    pub diagnosis: &'a Diagnosis,
}

/// A derivative at one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionDerivative {
    /// The model's.
    pub model: f64,
    /// The flight's.
    pub flight: f64,
    /// Its standard error.
    pub std: f64,
    /// Whether it was found off there.
    pub off: bool,
}

/// A derivative over the conditions.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivativeTrend {
    /// Its axis.
    pub axis: Axis,
    /// Its variable.
    pub variable: Variable,
    /// By condition.
    pub at: Vec<ConditionDerivative>,
    /// s of (1), a radian, and its standard error: by how much more it changes with the path than the model's.
    pub slope: (f64, f64),
}

impl DerivativeTrend {
    /// Whether it varies with the path otherwise than the model says.
    pub fn varies(&self) -> bool {
        let (slope, std) = self.slope;
        libm::fabs(slope) > SURE * std
    }
}

/// Every derivative that is off at any condition.
pub fn varying(conditions: &[ConditionDiagnosis<'_>]) -> Vec<DerivativeTrend> {
    let found = |condition: &ConditionDiagnosis<'_>, axis: Axis, variable: Variable| {
        condition.diagnosis.findings.iter().find_map(|finding| match finding.cause.effect {
            Effect::Derivative { axis: a, variable: v, delta } if (a, v) == (axis, variable) => Some((delta, finding.cause.std)),
            _ => None,
        })
    };
    let every = Axis::ALL.into_iter().flat_map(|axis| Variable::ALL.into_iter().map(move |variable| (axis, variable)));
    let off = every.filter(|&(axis, variable)| conditions.iter().any(|one| found(one, axis, variable).is_some()));
    off.map(|(axis, variable)| {
        let held = |condition: &ConditionDiagnosis<'_>| {
            let model = condition.model.derivative(axis, variable);
            let tolerance = condition.tolerance * libm::fabs(model);
            match found(condition, axis, variable) {
                Some((delta, std)) => ConditionDerivative { model, flight: model + delta, std, off: true },
                None => ConditionDerivative { model, flight: model, std: tolerance, off: false },
            }
        };
        let at: Vec<ConditionDerivative> = conditions.iter().map(held).collect();
        let points: Vec<(f64, f64, f64)> =
            conditions.iter().zip(&at).map(|(one, held)| (one.path_rad, held.flight - held.model, held.std)).collect();
        DerivativeTrend { axis, variable, at, slope: slope(&points) }
    })
    .collect()
}

/// (1) of (gamma, delta, std); not a number where the conditions do not differ.
fn slope(points: &[(f64, f64, f64)]) -> (f64, f64) {
    let largest = points.iter().map(|point| point.2).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    // A derivative that the model lacks and that was not found off has no tolerance: it is as sure as a hundredth of the others.
    let weight = |std: f64| 1.0 / (std * std).max(1e-4 * largest * largest);
    let sum = |value: &dyn Fn(&(f64, f64, f64)) -> f64| points.iter().map(|point| weight(point.2) * value(point)).sum::<f64>();
    let whole = sum(&|_| 1.0);
    let (mean_path, mean) = (sum(&|point| point.0) / whole, sum(&|point| point.1) / whole);
    let spread = sum(&|point| (point.0 - mean_path) * (point.0 - mean_path));
    // Paths that differ by less than a tenth of a milliradian are one.
    if !(spread > 1e-8 * whole && points.len() > 1) {
        return (f64::NAN, f64::NAN);
    }
    let slope = sum(&|point| (point.0 - mean_path) * (point.1 - mean)) / spread;
    let about = sum(&|point| {
        let off = point.1 - mean - slope * (point.0 - mean_path);
        off * off
    });
    let freedom = points.len().saturating_sub(2).max(1) as f64;
    (slope, libm::sqrt((about / freedom).max(1.0) / spread))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_a_weighted_line() {
        let exact: Vec<(f64, f64, f64)> = [-0.1, 0.0, 0.1].map(|path| (path, 0.3 + 2.0 * path, 0.02)).to_vec();
        let (s, std) = slope(&exact);
        // Two outer points at 0.1 rad, errors 0.02: std = 0.02/sqrt(2*0.01).
        assert!((s - 2.0).abs() < 1e-12 && (std - 0.02 / libm::sqrt(0.02)).abs() < 1e-12, "{s} {std}");
        // A point off the line widens the error, one of little weight hardly moves it.
        let bent = slope(&[(-0.1, 0.1, 0.02), (0.0, 0.9, 0.02), (0.1, 0.5, 0.02)]);
        assert!(bent.1 > 5.0 * std, "{bent:?}");
        let loose = slope(&[(-0.1, 0.1, 0.02), (0.0, 0.3, 0.02), (0.1, 0.5, 0.02), (0.05, 9.0, 10.0)]);
        assert!((loose.0 - 2.0).abs() < 0.05);
        assert!(slope(&[(0.1, 1.0, 0.1), (0.1, 2.0, 0.1)]).0.is_nan() && slope(&[]).0.is_nan());
    }
}
