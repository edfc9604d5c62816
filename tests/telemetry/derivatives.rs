//! The last derivatives of a flight by the pipeline, and how far those of two ways of the same flight are apart.

use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::realtime::regression::record::{DerivativesRecord, TermRecord};

/// How near a standard error is to its value, as part of it, where rounding decides whether the derivative is resolved.
const ON_THE_LIMIT: f64 = 0.05;

/// What the pipeline says last.
pub(crate) fn derivatives<'a>(samples: impl IntoIterator<Item = &'a Sample>) -> DerivativesRecord {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut last = None;
    for sample in samples {
        last = pipeline.step(sample).derivatives.clone().or(last);
    }
    last.unwrap()
}

/// Differences of derivatives.
#[derive(Debug, Default)]
pub(crate) struct Apart {
    /// How many both have.
    pub(crate) compared: usize,
    /// The largest, in standard errors of the first, and whose it is.
    pub(crate) largest: f64,
    pub(crate) whose: String,
    /// Geometric mean of the second's standard errors over the first's.
    pub(crate) std_ratio: f64,
    /// Derivatives that one has and the other has not, but for those on the limit of resolution, and equations with another
    /// status.
    pub(crate) different: Vec<String>,
}

/// Compares every derivative.
pub(crate) fn apart(one: &DerivativesRecord, other: &DerivativesRecord) -> Apart {
    let mut apart = Apart::default();
    let mut logarithms = 0.0;
    let is_clear = |term: &TermRecord| (term.std / term.value.abs() - 1.0).abs() > ON_THE_LIMIT;
    for (first, second) in one.equations.iter().zip(&other.equations) {
        if first.status != second.status {
            apart.different.push(format!("{:?}: {:?}, {:?}", first.axis, first.status, second.status));
        }
        let clear = second.terms.iter().filter(|term| is_clear(term)).filter_map(|term| term.variable);
        let missing = clear.filter(|variable| first.term(*variable).is_none());
        apart.different.extend(missing.map(|variable| format!("{:?}_{variable:?} of the second alone", first.axis)));
        for term in first.terms.iter() {
            let Some(variable) = term.variable else { continue };
            let Some(found) = second.term(variable) else {
                if is_clear(term) {
                    apart.different.push(format!("{:?}_{variable:?} of the first alone", first.axis));
                }
                continue;
            };
            let difference = (found.value - term.value).abs() / term.std;
            apart.compared += 1;
            logarithms += (found.std / term.std).ln();
            if difference > apart.largest {
                apart.largest = difference;
                apart.whose = format!("{:?}_{variable:?}", first.axis);
            }
        }
    }
    apart.std_ratio = (logarithms / apart.compared.max(1) as f64).exp();
    apart
}
