//! Why a fit by output error is refused, with the values that say so.

use core::fmt;

/// Why a fit by output error or filter error is refused.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum OutputErrorFitError {
    /// A size differs from that of the structure.
    Shape {
        what: String,
        /// Size that the structure asks for.
        expected: usize,
        found: usize,
    },
    /// A number that has to be finite is not.
    NotFinite {
        what: String,
        /// Run, from 0.
        run: usize,
        /// Sample, from 0.
        sample: usize,
    },
    /// A standard deviation of a prior that is not above zero, a start that is not finite.
    Parameter { name: String, value: f64 },
    /// Time stands still or goes back.
    TimesNotIncreasing {
        /// Run, from 0.
        run: usize,
        /// The later sample, from 0.
        sample: usize,
        /// Time before it, s.
        before_s: f64,
        /// Its time, s.
        after_s: f64,
    },
    /// Fewer measured values than unknowns.
    TooFewSamples {
        /// Measured values in all runs.
        values: usize,
        /// Parameters, initial states and biases.
        unknowns: usize,
    },
    /// An input that moves in no run, and the parameters that only its motion identifies.
    StillInput { input: String, value: f64, parameters: Vec<String> },
    /// An output that no run has.
    NeverSampled { output: String },
    /// An output that is constant in every run: a dead instrument, whose noise is unidentifiable.
    StillOutput { output: String, value: f64 },
    /// A full noise covariance needs all outputs at the same instants.
    NotSampledTogether {
        /// Run, from 0.
        run: usize,
        /// First sample that has a part of them, from 0.
        sample: usize,
    },
    /// A full noise covariance that is not positive: outputs that are the same but for a factor.
    NoiseNotPositive,
    /// The outputs diverge at the start values.
    Diverges {
        /// Run, from 0.
        run: usize,
    },
    /// These are unidentifiable, alone or jointly, at the values that the search has reached.
    Singular {
        /// Names with a part in the unidentifiable direction.
        names: Vec<String>,
        /// Smallest eigenvalue of the information, scaled to a unit diagonal.
        smallest: f64,
    },
}

impl fmt::Display for OutputErrorFitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            OutputErrorFitError::Shape { what, expected, found } => write!(f, "{what}: {expected} expected, {found} found"),
            OutputErrorFitError::NotFinite { what, run, sample } => {
                write!(f, "{what} of run {} is not a finite number at sample {}", run + 1, sample + 1)
            }
            OutputErrorFitError::Parameter { name, value } => {
                write!(f, "parameter {name}: {value} cannot be its start or its prior")
            }
            OutputErrorFitError::TimesNotIncreasing { run, sample, before_s, after_s } => {
                write!(f, "run {}: time goes from {before_s} s to {after_s} s at sample {}", run + 1, sample + 1)
            }
            OutputErrorFitError::TooFewSamples { values, unknowns } => {
                write!(f, "{values} measured values cannot determine {unknowns} unknowns")
            }
            OutputErrorFitError::StillInput { input, value, parameters } => {
                write!(f, "input {input} stands at {value} in every run, so {} is not identifiable", parameters.join(", "))
            }
            OutputErrorFitError::NeverSampled { output } => write!(f, "output {output} is sampled in no run"),
            OutputErrorFitError::StillOutput { output, value } => write!(f, "output {output} stands at {value} in every run"),
            OutputErrorFitError::NotSampledTogether { run, sample } => {
                let (run, sample) = (run + 1, sample + 1);
                write!(f, "run {run}, sample {sample}: a full noise covariance needs all outputs at the same instants")
            }
            OutputErrorFitError::NoiseNotPositive => {
                write!(f, "the covariance of the residuals is singular: outputs repeat each other")
            }
            OutputErrorFitError::Diverges { run } => {
                write!(f, "run {}: the outputs of the starting values run out of the range of numbers", run + 1)
            }
            OutputErrorFitError::Singular { names, smallest } => {
                if names.is_empty() || !smallest.is_finite() {
                    return write!(f, "the search has run out of the range of numbers: the runs do not support this model");
                }
                let names = names.join(", ");
                write!(
                    f,
                    "the search has ended where these parameters are not identifiable, or not distinguishable: {names} (smallest eigenvalue \
                     {smallest:.1e}); an input that moves one of them alone would identify them"
                )
            }
        }
    }
}

impl core::error::Error for OutputErrorFitError {}
