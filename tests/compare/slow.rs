//! The slow part: real models, whose diagnoses look at instruments too.

mod real_models;
