//! One step of a stepwise regression: which term entered or left, and the equation after it.

use super::fit::{EquationFit, FitQuality, TermEstimate};

/// Change of the equation at a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TermChange {
    /// Biases and kept terms only.
    Begun,
    /// The candidate at this place entered.
    Entered(usize),
    /// The candidate at this place left.
    Left(usize),
}

/// The equation after one step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepwiseStep {
    /// Entry or removal.
    pub change: TermChange,
    /// Terms in, with both their partial F.
    pub terms: Vec<TermEstimate>,
    /// Figures of merit.
    pub quality: FitQuality,
}

impl StepwiseStep {
    pub(super) fn new(change: TermChange, fit: &EquationFit) -> Self {
        StepwiseStep { change, terms: fit.terms.clone(), quality: fit.quality }
    }
}
