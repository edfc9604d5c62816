//! One step of a stepwise regression: which term entered or left, and the equation after it.

use super::fit::{EquationFit, FitQuality, TermEstimate};

/// What happened at a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TermChange {
    /// Biases and kept terms only.
    Begun,
    /// That candidate entered.
    Entered(usize),
    /// That candidate left.
    Left(usize),
}

/// The equation after one step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepwiseStep {
    /// What happened.
    pub change: TermChange,
    /// Terms in, with both their partial F.
    pub terms: Vec<TermEstimate>,
    /// What the whole is judged by.
    pub quality: FitQuality,
}

impl StepwiseStep {
    pub(super) fn new(change: TermChange, fit: &EquationFit) -> Self {
        StepwiseStep { change, terms: fit.terms.clone(), quality: fit.quality }
    }
}
