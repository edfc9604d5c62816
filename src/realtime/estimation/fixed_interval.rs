//! Fixed-interval smoother, offline: every state of a record, estimated from the whole of it.
//!
//! Consumes the samples of a run; produces the smoothed state at each sample, with its standard deviations, and the noise
//! statistics that were used. The filter runs over the record twice: once for the noise statistics of the whole record
//! (`noise`), once with them; then, from the end back (modified Bryson-Frazier), with l = 0, L = 0 behind the last sample,
//!     at a measurement:  l <- l - H' (nu + K' l s)/s,   L <- (I - K H)' L (I - K H) + H' H/s          (1)
//!     at a time step:    l <- F' l,   L <- F' L F                                                   (2)
//!     x_smoothed = x - P l,   P_smoothed = P - P L P,  x and P the filter's after the sample          (3)
//! No matrix is inverted. Memory is bounded: the filter is run again from a copy of the estimator, block by block.
//! Source: G. J. Bierman, Fixed interval smoothing with discrete measurements, Int. J. Control 18, 1973; D. Simon, Optimal State
//! Estimation, 2006, 9.4.
//! Numerics: (3) subtracts; a variance that rounding makes negative is reported as 0.
//! No states where the filter does not run; where it restarts, the record is divided.

use super::centre_of_mass::state_record;
use super::config::{ConfigError, EstimationConfig, NoiseSource};
use super::ekf::{FilterObserver, Fusion, Transition};
use super::estimator::Estimator;
use super::process::{MOVING, STATES, State};
use super::record::{EstimationEvent, NoiseRecord, StateRecord};
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::num::product::dot;

/// Samples whose details are kept at a time.
const BLOCK: usize = 1024;
/// Cost of the backward pass for one sample, in steps of the filter.
const BACKWARD_WORK: f64 = 4.0;

type Matrix = [[f64; STATES]; STATES];

/// Smoothed states of a record.
#[derive(Clone, Debug)]
pub struct FixedInterval {
    /// The state at each sample at which the filter ran, in order of time.
    pub states: Vec<StateRecord>,
    /// The noise statistics that were used.
    pub noise: NoiseRecord,
}

/// Steps of the filter at one sample.
#[derive(Clone, Default)]
struct Step {
    transition: Option<Box<Transition>>,
    fusions: Vec<(State, Fusion)>,
    /// The filter started here: later samples carry no information about earlier ones.
    begins: bool,
}

impl FilterObserver for Step {
    fn propagate(&mut self, transition: &Transition) {
        self.transition = Some(Box::new(*transition));
    }

    fn fuse(&mut self, row: &State, fusion: &Fusion) {
        if fusion.gain.is_some() {
            self.fusions.push((*row, *fusion));
        }
    }
}

/// l and L.
struct Adjoint {
    vector: State,
    matrix: Box<Matrix>,
}

impl Adjoint {
    fn new() -> Self {
        Adjoint { vector: [0.0; STATES], matrix: Box::new([[0.0; STATES]; STATES]) }
    }

    /// Back over a measurement, (1).
    fn back_over(&mut self, row: &State, fusion: &Fusion) {
        let Fusion { innovation, innovation_var: s, gain: Some(gain), .. } = fusion else { return };
        let along = dot(gain, &self.vector) + innovation / s;
        // L K and K' L K.
        let lk: State = core::array::from_fn(|i| dot(&self.matrix[i], gain));
        let klk = dot(gain, &lk);
        for i in 0..STATES {
            self.vector[i] -= row[i] * along;
            for j in 0..STATES {
                self.matrix[i][j] += row[i] * row[j] * (klk + 1.0 / s) - row[i] * lk[j] - lk[i] * row[j];
            }
        }
    }

    /// Back over a time step, (2).
    fn back_along(&mut self, transition: &Transition) {
        // F' m for the moving states; the others stay and F does not couple them.
        let transposed = |m: &State| {
            let mut out = *m;
            for (j, entry) in out.iter_mut().enumerate().take(MOVING) {
                *entry = transition.iter().zip(m).map(|(row, m)| row[j] * m).sum();
            }
            out
        };
        self.vector = transposed(&self.vector);
        // L F, row by row, then F' (L F), column by column.
        for row in self.matrix.iter_mut() {
            *row = transposed(row);
        }
        for j in 0..STATES {
            let column = transposed(&core::array::from_fn(|i| self.matrix[i][j]));
            for (row, entry) in self.matrix.iter_mut().zip(column) {
                row[j] = entry;
            }
        }
    }
}

/// Smooths a record.
///
/// # Errors
/// [`ConfigError`] names the setting that cannot be used.
pub fn smooth(samples: &[Sample], config: &EstimationConfig, geometry: RunGeometry) -> Result<FixedInterval, ConfigError> {
    let smoothed = smooth_watched(samples, config, geometry, |_| true)?;
    // Never cancelled.
    Ok(smoothed.unwrap_or_else(|| FixedInterval { states: Vec::new(), noise: *Estimator::of(*config, geometry).noise() }))
}

/// The same, with the completed part of the work (0 to 1) passed to `watch`; `None` where that returned false.
///
/// # Errors
/// [`ConfigError`] names the setting that cannot be used.
pub fn smooth_watched(
    samples: &[Sample],
    config: &EstimationConfig,
    geometry: RunGeometry,
    mut watch: impl FnMut(f64) -> bool,
) -> Result<Option<FixedInterval>, ConfigError> {
    let work = samples.len().max(1) as f64 * (2.0 + BACKWARD_WORK);
    let mut done = 0.0;
    let mut go_on = |block: &[Sample], weight: f64| {
        done += block.len() as f64 * weight;
        watch(done / work)
    };
    let mut scout = Box::new(Estimator::new(*config, geometry)?);
    for block in samples.chunks(BLOCK) {
        for sample in block {
            scout.step(sample);
        }
        if !go_on(block, 1.0) {
            return Ok(None);
        }
    }
    let noise = *scout.noise();
    let config = EstimationConfig {
        noise: noise.noise,
        angular_acceleration_walk: noise.angular_acceleration_walk,
        specific_force_walk: noise.specific_force_walk,
        noise_source: NoiseSource::Configured,
        ..*config
    };
    let mut estimator = Box::new(Estimator::new(config, geometry)?);
    let mut starts = Vec::with_capacity(samples.len().div_ceil(BLOCK));
    for block in samples.chunks(BLOCK) {
        starts.push(estimator.clone());
        for sample in block {
            estimator.step(sample);
        }
        if !go_on(block, 1.0) {
            return Ok(None);
        }
    }
    let mut states = Vec::with_capacity(samples.len());
    let mut adjoint = Adjoint::new();
    for (block, start) in samples.chunks(BLOCK).zip(starts).rev() {
        let mut estimator = start;
        let mut steps = Vec::with_capacity(block.len());
        for sample in block {
            let mut step = Step::default();
            let output = estimator.step_with(sample, &mut step);
            let ran = output.state.is_some();
            step.begins = output.events.contains(&EstimationEvent::Initialised);
            let posterior = estimator.filter().filter(|_| ran).map(|filter| (*filter.state(), filter.covariance().clone()));
            steps.push((sample.time_s, step, posterior));
        }
        for (time_s, step, posterior) in steps.iter().rev() {
            if step.begins {
                adjoint = Adjoint::new();
            }
            let Some((x, factor)) = posterior else { continue };
            let p: Matrix = core::array::from_fn(|i| core::array::from_fn(|j| factor.covariance(i, j)));
            let mut smoothed = *x;
            let mut std = [0.0; STATES];
            for i in 0..STATES {
                let mut lp = [0.0; STATES];
                for (k, weight) in p[i].iter().enumerate() {
                    smoothed[i] -= weight * adjoint.vector[k];
                    for (sum, entry) in lp.iter_mut().zip(&adjoint.matrix[k]) {
                        *sum += weight * entry;
                    }
                }
                let change: f64 = lp.iter().zip(&p[i]).map(|(a, b)| a * b).sum();
                std[i] = libm::sqrt((p[i][i] - change).max(0.0));
            }
            states.push(state_record(*time_s, &smoothed, &std, &geometry));
            for (row, fusion) in step.fusions.iter().rev() {
                adjoint.back_over(row, fusion);
            }
            if let Some(transition) = &step.transition {
                adjoint.back_along(transition);
            }
        }
        if !go_on(block, BACKWARD_WORK) {
            return Ok(None);
        }
    }
    states.reverse();
    Ok(Some(FixedInterval { states, noise }))
}
