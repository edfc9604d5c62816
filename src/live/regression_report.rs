//! What output error and the diagnosis take from a publication of the regression.

use crate::flight::derivative::{AXES, VARIABLES, Variable};
use crate::realtime::regression::record::{DerivativesRecord, Status};
use crate::realtime::regression::recursive::Recursive;

/// What a publication of the regression reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegressionReport {
    /// When, s.
    pub time_s: f64,
    /// Whether the aircraft is excited.
    pub excited: bool,
    /// By axis, a bit for each variable in its equation.
    pub terms: [u16; AXES],
    /// Standard errors of the derivatives by axis and variable, SI and radians; NaN where there is no number. Single precision
    /// keeps the message small: it waits in a queue of samples.
    pub std: [[f32; VARIABLES]; AXES],
    /// What curvature of the forces and moments contributes to the standard errors of any linear model of this motion; NaN
    /// where no equation has the term.
    pub curvature_std: [[f32; VARIABLES]; AXES],
}

impl RegressionReport {
    /// Before the first publication.
    pub const NONE: RegressionReport = RegressionReport {
        time_s: 0.0,
        excited: false,
        terms: [0; AXES],
        std: [[f32::NAN; VARIABLES]; AXES],
        curvature_std: [[f32::NAN; VARIABLES]; AXES],
    };

    /// What a regression reports with these derivatives.
    pub fn new(record: &DerivativesRecord, regression: &Recursive) -> Self {
        let mut report = RegressionReport {
            time_s: record.time_s,
            excited: record.excited,
            curvature_std: *regression.curvature_std(),
            ..RegressionReport::NONE
        };
        for ((bits, std), equation) in report.terms.iter_mut().zip(&mut report.std).zip(&record.equations) {
            if equation.status.rank() < Status::Stale.rank() {
                continue;
            }
            let variables = equation.terms.iter().filter_map(|term| term.variable);
            *bits = variables.fold(equation.unresolved, |bits, variable: Variable| bits | 1 << variable.index());
            for term in &equation.terms {
                if let Some(place) = term.variable.and_then(|variable| std.get_mut(variable.index())) {
                    *place = term.std as f32;
                }
            }
        }
        report
    }

    /// Whether any equation has a term.
    pub fn has_terms(&self) -> bool {
        self.terms.iter().any(|bits| *bits != 0)
    }
}
