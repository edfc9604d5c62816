//! State of the diagnosis filter, its noise and what a run of the filter produces.
//!
//! | symbol | place | unit | meaning |
//! | --- | --- | --- | --- |
//! | u v w | [`VELOCITY`] | m/s | velocity of the centre of mass over the ground, body axes, still air |
//! | p q r | [`RATES`] | rad/s | body rates |
//! | phi theta psi | [`ATTITUDE`] | rad | Euler angles |
//! | h | [`ALTITUDE`] | m | altitude |
//! | a | [`LAG`] | of its channel | reading of the one output that has a first-order lag |
//! | ug vg wg | [`GUST`] | m/s | gust velocity, body axes |
//!
//! The order lets a run without gusts carry the first eleven states only, one without a lag the first ten.

use crate::flight::derivative::AXES;
use crate::postflight::diagnosis::data::run_data::OUTPUTS;

/// Number of states.
pub const STATES: usize = 14;
/// Offset of u, v, w.
pub const VELOCITY: usize = 0;
/// Offset of p, q, r.
pub const RATES: usize = 3;
/// Offset of phi, theta, psi.
pub const ATTITUDE: usize = 6;
/// Place of the altitude.
pub const ALTITUDE: usize = 9;
/// Place of the lagged output.
pub const LAG: usize = 10;
/// Offset of the gust velocities.
pub const GUST: usize = 11;

/// Noise densities that are estimated: six axes, and gusts.
pub const NOISES: usize = AXES + 1;

/// The state vector.
pub type FilterState = [f64; STATES];
/// A matrix over the states, by row.
pub type StateMatrix = [[f64; STATES]; STATES];

/// Noise of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterNoise {
    /// Spectral density of forces and moments by axis, (m/s^2)^2 s and (rad/s^2)^2 s.
    pub force: [f64; AXES],
    /// Standard deviation of each gust component, m/s, and its time constant L/V, s.
    pub gust: (f64, f64),
    /// Variance of one sample of each output.
    pub output: [f64; OUTPUTS],
}

/// Result of one run of the filter.
#[derive(Clone, Debug, Default)]
pub struct FilterResult {
    /// Sum of squares and logarithms of variances.
    pub cost: f64,
    /// By output: sum of squared whitened innovations, and their number.
    pub squares: [(f64, f64); OUTPUTS],
    /// Slope of the cost by the logarithm of each density, gusts' last, and its expected second derivative.
    pub noise_score: [(f64, f64); NOISES],
    /// S'S, the first `kept` rows of it, [kept x columns].
    pub information: Vec<f64>,
    /// Diagonal of S'S.
    pub diagonal: Vec<f64>,
    /// S'e.
    pub gradient: Vec<f64>,
    /// Root mean square of each column's force, where it has one: of its axis.
    pub strength: Vec<f64>,
    /// S'e of each node's readings, [nodes x kept]; only where traces are asked for.
    pub scores: Vec<f64>,
    /// States after each node's readings.
    pub states: Vec<FilterState>,
    /// Whitened innovations: node, output, value; only where asked for.
    pub innovations: Vec<(usize, usize, f64)>,
}

/// Time constant of the first-order gust along an axis: across the flight Dryden's is of second order, and has both the variance
/// and the roughness of a first-order one that is a third faster.
pub(crate) fn gust_time(axis: usize, gust_s: f64) -> f64 {
    if axis == 0 { gust_s } else { gust_s * (2.0 / 3.0) }
}

/// Three states from a place on.
pub(crate) fn triple(x: &FilterState, from: usize) -> [f64; 3] {
    [x[from], x[from + 1], x[from + 2]]
}
