//! What causes are worth on runs that they were not found in.

pub mod holdout_gain;
pub mod horizon_prediction;
