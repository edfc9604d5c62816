//! A run as measured and as a model predicts it, with the figures of merit of every output.

use super::columns::Columns;
use crate::postflight::output_error::InputOutputRecord;
use crate::postflight::validation::prediction::{PredictionScore, score};

/// Measured and predicted outputs of a run, with figures of merit.
#[derive(Clone, Debug)]
pub struct RunPrediction {
    /// Name of the run.
    pub run: String,
    /// Measured inputs and outputs, deviations from trim.
    pub record: InputOutputRecord,
    /// Predicted outputs [outputs x samples].
    pub predicted: Vec<Vec<f64>>,
    /// Figures of merit by output; `None` of an output with fewer than 32 samples.
    pub scores: Vec<Option<PredictionScore>>,
}

impl RunPrediction {
    pub(crate) fn new(run: &Columns, record: InputOutputRecord, predicted: Vec<Vec<f64>>) -> Self {
        let scores = record.outputs.iter().zip(&predicted).map(|(z, y)| score(&record.times_s, z, y)).collect();
        RunPrediction { run: run.run.clone(), record, predicted, scores }
    }
}
