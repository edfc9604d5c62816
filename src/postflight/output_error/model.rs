//! What is fitted: records, a linear structure whose entries are affine in the parameters, and the parameters.
//!
//! The model is
//!     x' = A x + B u + b_run,    y = C x + D u + c_run,    x(0) = x0_run                            (1)
//! | A B C D | every entry fixed + sum factor theta |  | b, c, x0 | free in each run where the structure says so, else 0 |

use super::error::OutputErrorFitError;

/// One run as recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputOutputRecord {
    /// Times, s, increasing.
    pub times_s: Vec<f64>,
    /// By input and sample; straight lines between samples.
    pub inputs: Vec<Vec<f64>>,
    /// By output and sample; NaN where it is not sampled.
    pub outputs: Vec<Vec<f64>>,
    /// Standard deviation of the white noise on each input, in its unit; none where it is empty.
    pub input_noise_std: Vec<f64>,
}

/// An entry of a matrix: `fixed + sum factor * theta`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MatrixEntry {
    /// The part that no parameter changes.
    pub fixed: f64,
    /// Parameters, by place, and their factors.
    pub terms: Vec<(usize, f64)>,
}

impl MatrixEntry {
    /// A known number.
    pub fn fixed(value: f64) -> Self {
        MatrixEntry { fixed: value, terms: Vec::new() }
    }

    /// A parameter as it is.
    pub fn free(parameter: usize) -> Self {
        MatrixEntry { fixed: 0.0, terms: vec![(parameter, 1.0)] }
    }

    /// Its value.
    pub fn value(&self, theta: &[f64]) -> f64 {
        self.terms.iter().fold(self.fixed, |sum, &(j, factor)| sum + factor * theta.get(j).copied().unwrap_or(f64::NAN))
    }
}

/// The model (1).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelStructure {
    /// Names of the states.
    pub states: Vec<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// States by states.
    pub a: Vec<Vec<MatrixEntry>>,
    /// States by inputs.
    pub b: Vec<Vec<MatrixEntry>>,
    /// Outputs by states.
    pub c: Vec<Vec<MatrixEntry>>,
    /// Outputs by inputs.
    pub d: Vec<Vec<MatrixEntry>>,
    /// By state: a free constant in its equation, its own in each run.
    pub state_bias: Vec<bool>,
    /// By output: likewise in the output.
    pub output_bias: Vec<bool>,
    /// By state: a free initial value, its own in each run; else 0.
    pub initial_state: Vec<bool>,
}

/// One unknown that holds over all runs.
#[derive(Clone, Debug, PartialEq)]
pub struct FitParameter {
    /// Its name.
    pub name: String,
    /// Where the search begins.
    pub start: f64,
    /// Mean and standard deviation of the prior.
    pub prior: Option<(f64, f64)>,
}

/// An input that is delayed by a parameter, s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputDelay {
    /// The input, by place.
    pub input: usize,
    /// The parameter, by place.
    pub parameter: usize,
}

fn sized(what: &str, expected: usize, found: usize) -> Result<(), OutputErrorFitError> {
    if expected == found { Ok(()) } else { Err(OutputErrorFitError::Shape { what: what.to_owned(), expected, found }) }
}

fn place(what: &str, below: usize, found: usize) -> Result<(), OutputErrorFitError> {
    if found < below {
        Ok(())
    } else {
        Err(OutputErrorFitError::Shape { what: format!("{what}, by place below"), expected: below, found })
    }
}

impl ModelStructure {
    /// Whether the matrices have the sizes of the names and ask for parameters that exist.
    ///
    /// # Errors
    /// [`OutputErrorFitError::Shape`], [`OutputErrorFitError::NotFinite`].
    pub fn check(&self, parameters: usize, delays: &[InputDelay]) -> Result<(), OutputErrorFitError> {
        let (states, inputs, outputs) = (self.states.len(), self.inputs.len(), self.outputs.len());
        sized("flags of state biases", states, self.state_bias.len())?;
        sized("flags of output biases", outputs, self.output_bias.len())?;
        sized("flags of initial states", states, self.initial_state.len())?;
        if outputs == 0 {
            return Err(OutputErrorFitError::Shape { what: "outputs, at least".to_owned(), expected: 1, found: 0 });
        }
        for (name, matrix, rows, columns) in [
            ("A", &self.a, states, states),
            ("B", &self.b, states, inputs),
            ("C", &self.c, outputs, states),
            ("D", &self.d, outputs, inputs),
        ] {
            sized(&format!("rows of {name}"), rows, matrix.len())?;
            for row in matrix {
                sized(&format!("columns of {name}"), columns, row.len())?;
                for (column, entry) in row.iter().enumerate() {
                    if !entry.fixed.is_finite() || entry.terms.iter().any(|(_, factor)| !factor.is_finite()) {
                        return Err(OutputErrorFitError::NotFinite {
                            what: format!("an entry of {name}"),
                            run: 0,
                            sample: column,
                        });
                    }
                    entry.terms.iter().try_for_each(|&(j, _)| place(&format!("a parameter of {name}"), parameters, j))?;
                }
            }
        }
        for delay in delays {
            place("a delayed input", inputs, delay.input)?;
            place("the parameter of a delay", parameters, delay.parameter)?;
        }
        Ok(())
    }

    /// Whether a run has what the structure asks for. `run` is its place, for the message.
    ///
    /// # Errors
    /// [`OutputErrorFitError::Shape`], [`OutputErrorFitError::NotFinite`], [`OutputErrorFitError::TimesNotIncreasing`].
    pub fn check_record(&self, record: &InputOutputRecord, run: usize) -> Result<(), OutputErrorFitError> {
        let samples = record.times_s.len();
        sized(&format!("inputs of run {}", run + 1), self.inputs.len(), record.inputs.len())?;
        sized(&format!("outputs of run {}", run + 1), self.outputs.len(), record.outputs.len())?;
        for (name, values) in self.inputs.iter().zip(&record.inputs).chain(self.outputs.iter().zip(&record.outputs)) {
            sized(&format!("samples of {name} in run {}", run + 1), samples, values.len())?;
        }
        let bad = |what: &str, sample: usize| OutputErrorFitError::NotFinite { what: what.to_owned(), run, sample };
        let mut before_s = f64::NEG_INFINITY;
        for (sample, &after_s) in record.times_s.iter().enumerate() {
            if !after_s.is_finite() {
                return Err(bad("time", sample));
            }
            if !(after_s > before_s) {
                return Err(OutputErrorFitError::TimesNotIncreasing { run, sample, before_s, after_s });
            }
            before_s = after_s;
        }
        for (name, values) in self.inputs.iter().zip(&record.inputs) {
            if let Some(sample) = values.iter().position(|value| !value.is_finite()) {
                return Err(bad(&format!("input {name}"), sample));
            }
        }
        for (name, values) in self.outputs.iter().zip(&record.outputs) {
            if let Some(sample) = values.iter().position(|value| value.is_infinite()) {
                return Err(bad(&format!("output {name}"), sample));
            }
        }
        Ok(())
    }

    /// Number of run parameters.
    pub fn run_parameter_count(&self) -> usize {
        [&self.initial_state, &self.state_bias, &self.output_bias].iter().flat_map(|flags| flags.iter()).filter(|&&on| on).count()
    }

    /// Names of the run parameters, in the order x0, b, c.
    pub fn run_parameter_names(&self, run: usize) -> Vec<String> {
        let named = |what: &str, names: &[String], flags: &[bool]| -> Vec<String> {
            let chosen = names.iter().zip(flags).filter(|(_, on)| **on);
            chosen.map(|(name, _)| format!("{what} {name} of run {}", run + 1)).collect()
        };
        let mut names = named("initial", &self.states, &self.initial_state);
        names.extend(named("bias of state equation", &self.states, &self.state_bias));
        names.extend(named("bias of output", &self.outputs, &self.output_bias));
        names
    }
}
