//! Process noise: gusts, whose densities are estimated, and noise of the recorded inputs, whose densities are known.
//!
//! With E_i the unit vector of state i and B_l the column of input l, the state equation is
//!     x' = A x + B u + b + sum_i E_i w_i + sum_l B_l n_l                                            (1)
//! w_i white with density q_i, (unit of x_i')^2 s; n_l white with density s_l(t), (unit of u_l)^2 s. Samples of an input at
//! intervals T with noise of standard deviation sigma have s = sigma^2 T.

/// Gusts and the noise of inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbances {
    /// States, by place, that gusts accelerate.
    pub gusts: Vec<usize>,
    /// By run, input and interval between samples: density of the input's noise; inputs that are left out have none.
    pub inputs: Vec<Vec<Vec<f64>>>,
}

/// One gust as found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gust {
    /// The state, by place.
    pub state: usize,
    /// Density, (unit of x')^2 s; 0 where the records do not ask for it.
    pub density: f64,
    /// Standard error of its logarithm; 0 with a density of 0.
    pub std_log: f64,
}

/// What filter error finds besides what output error does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProcessNoiseEstimate {
    /// The gusts.
    pub gusts: Vec<Gust>,
    /// By run, output and sample: what the filter says of an output from the samples before it, NaN where it was not measured.
    pub predicted: Vec<Vec<Vec<f64>>>,
    /// By output: part of the innovations' variance that is no noise of the output.
    pub disturbed: Vec<f64>,
}
