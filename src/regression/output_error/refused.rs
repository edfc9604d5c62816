//! Why a fit by output error is refused, with the values that say so.

use core::fmt;

/// What makes the data or the question hopeless.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// Something has another size than the structure asks for.
    Shape {
        /// What it is.
        what: String,
        /// Size that the structure asks for.
        expected: usize,
        /// Size as given.
        found: usize,
    },
    /// A number that has to be finite is not.
    NotFinite {
        /// What it is.
        what: String,
        /// Run, from 0.
        run: usize,
        /// Sample, from 0.
        sample: usize,
    },
    /// A standard deviation of a prior that is not above zero, a start that is not finite.
    Parameter {
        /// Its name.
        name: String,
        /// The value that cannot be.
        value: f64,
    },
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
    /// An input that moves in no run, and parameters that only its motion tells.
    StillInput {
        /// Its name.
        input: String,
        /// Where it stands.
        value: f64,
        /// The parameters.
        parameters: Vec<String>,
    },
    /// An output that no run has.
    NeverSampled {
        /// Its name.
        output: String,
    },
    /// An output that stands still in every run: an instrument that is dead, whose noise nothing tells.
    StillOutput {
        /// Its name.
        output: String,
        /// Where it stands.
        value: f64,
    },
    /// A full noise covariance needs all outputs at the same instants.
    NotSampledTogether {
        /// Run, from 0.
        run: usize,
        /// First sample that has a part of them, from 0.
        sample: usize,
    },
    /// A full noise covariance that is not positive: outputs that are the same but for a factor.
    NoiseNotPositive,
    /// The outputs of the starting values run out of the range of numbers.
    Diverges {
        /// Run, from 0.
        run: usize,
    },
    /// The data do not tell these, or not one from the other, at the values that the search has reached.
    Singular {
        /// Names that take part in the direction that nothing tells.
        names: Vec<String>,
        /// Smallest eigenvalue of the information, scaled to a unit diagonal.
        smallest: f64,
    },
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::Shape { what, expected, found } => write!(f, "{what}: {expected} expected, {found} found"),
            Refused::NotFinite { what, run, sample } => {
                write!(f, "{what} of run {} is not a finite number at sample {}", run + 1, sample + 1)
            }
            Refused::Parameter { name, value } => write!(f, "parameter {name}: {value} cannot be its start or its prior"),
            Refused::TimesNotIncreasing { run, sample, before_s, after_s } => {
                write!(f, "run {}: time goes from {before_s} s to {after_s} s at sample {}", run + 1, sample + 1)
            }
            Refused::TooFewSamples { values, unknowns } => {
                write!(f, "{values} measured values cannot tell {unknowns} unknowns")
            }
            Refused::StillInput { input, value, parameters } => {
                write!(f, "input {input} stands at {value} in every run, so nothing tells {}", parameters.join(", "))
            }
            Refused::NeverSampled { output } => write!(f, "output {output} is sampled in no run"),
            Refused::StillOutput { output, value } => write!(f, "output {output} stands at {value} in every run"),
            Refused::NotSampledTogether { run, sample } => {
                let (run, sample) = (run + 1, sample + 1);
                write!(f, "run {run}, sample {sample}: a full noise covariance needs all outputs at the same instants")
            }
            Refused::NoiseNotPositive => write!(f, "the covariance of the residuals is singular: outputs repeat each other"),
            Refused::Diverges { run } => {
                write!(f, "run {}: the outputs of the starting values run out of the range of numbers", run + 1)
            }
            Refused::Singular { names, smallest } => {
                if names.is_empty() || !smallest.is_finite() {
                    return write!(f, "the search has run out of the range of numbers: the runs do not bear this model");
                }
                let names = names.join(", ");
                write!(
                    f,
                    "the search has ended where the runs do not tell these, or not one from the other: {names} (smallest eigenvalue \
                     {smallest:.1e}); an input that moves one of them alone would"
                )
            }
        }
    }
}

impl core::error::Error for Refused {}
