//! A run as measured and as a model predicts it, with the figures of merit of every output.

use super::columns::Columns;
use crate::postflight::output_error::InputOutputRecord;
use crate::postflight::validation::prediction::{PredictionScore, score};

/// A run as measured and as predicted by the model.
#[derive(Clone, Debug)]
pub struct RunPrediction {
    /// The run's name.
    pub run: String,
    /// What was measured.
    pub record: InputOutputRecord,
    /// What the model says, by output.
    pub predicted: Vec<Vec<f64>>,
    /// How well, by output; `None` where there is too little to say.
    pub scores: Vec<Option<PredictionScore>>,
}

impl RunPrediction {
    pub(crate) fn new(run: &Columns, record: InputOutputRecord, predicted: Vec<Vec<f64>>) -> Self {
        let scores = record.outputs.iter().zip(&predicted).map(|(z, y)| score(&record.times_s, z, y)).collect();
        RunPrediction { run: run.run.clone(), record, predicted, scores }
    }
}
