//! Adequacy of the model for the runs: parameters that these runs cannot show, forces that the model leaves to process noise,
//! instruments noisier than their own third differences say.
//!
//! Consumes the problem and a parameter set; produces the problem without unidentifiable derivative errors, the cost that process
//! noise beyond its floor saves axis by axis, and the problem with each output's variance multiplied by
//!     mean e^2 (1 + 2 sum rho_k)                                                                      (1)
//! e the whitened innovations and rho_k their autocorrelation at lag k, up to the first lag where it is not positive.

use super::maximise::{Effort, maximise};
use super::normal_equations::{Detail, linearise};
use super::parameter_set::ParameterSet;
use super::problem::DiagnosisProblem;
use crate::flight::derivative::AXES;

/// Lags of the test for coloured innovations.
const COLOUR_LAGS: usize = 40;
/// Innovations that scatter by more than this, of the variance that they should have, are of noisier instruments.
const NOISIER: f64 = 2.0;
/// Instruments are noisier than they seem where more than this part of all that the runs have is.
const NOISY_PART: f64 = 0.25;
/// Information on a small error, over what is known of it beforehand, below which it is as good as none.
const SHOWS: f64 = 0.02;
/// Times that their noise is taken anew.
const NOISE_ROUNDS: usize = 5;

/// Without the small errors that these runs cannot show: with noise at its least they would be known hardly better than
/// beforehand, and so what they do is nothing beside the noise.
pub fn without_unidentifiable(mut problem: DiagnosisProblem) -> DiagnosisProblem {
    let mut least = problem.null_hypothesis();
    let said =
        least.force_density.iter_mut().zip(problem.noise_floor).zip(problem.unmodelled).filter(|(_, unmodelled)| !unmodelled);
    said.for_each(|((force, least), _)| *force = least);
    let Some(local) = linearise(&problem, &least, &[], Detail::Slopes) else { return problem };
    let factor = local.factor.l();
    let mut rows = factor.row_iter();
    problem.derivative_tolerances.retain(|(.., std)| rows.next().is_none_or(|row| row.norm_squared() * std * std > 1.0 + SHOWS));
    problem
}

/// What each axis's noise beyond the least is worth: how much the cost rises without it.
pub fn unexplained(problem: &DiagnosisProblem, point: &ParameterSet) -> Option<[f64; AXES]> {
    let least = problem.noise_floor_at(point);
    let here = linearise(problem, point, &[], Detail::Cost)?.cost;
    let mut rises = [0.0; AXES];
    for (axis, rise) in rises.iter_mut().enumerate().filter(|(axis, _)| !problem.unmodelled[*axis]) {
        let mut without = point.clone();
        without.force_density[axis] = least[axis];
        *rise = linearise(problem, &without, &[], Detail::Cost).map_or(f64::INFINITY, |there| there.cost - here);
    }
    Some(rises)
}

/// The same with each output of each run as noisy as it is about a point: its innovations e, whitened by the noise that was
/// taken, scatter by more or are coloured, so that n of them count as fewer. The variance is multiplied by
/// with rho_k their autocorrelation up to where it is first not positive, until that is nowhere much more than one. `None`
/// where it is much more on a few only: a force that the model lacks is seen by these, noisy instruments are all alike.
pub fn with_observed_noise(problem: &DiagnosisProblem, point: &ParameterSet) -> Option<DiagnosisProblem> {
    let mut noisier = problem.clone();
    let mut point = point.clone();
    for round in 0..NOISE_ROUNDS {
        let local = linearise(&noisier, &point, &[], Detail::Traces)?;
        let (mut much, mut all) = (0.0, 0.0);
        for (run, passed) in noisier.runs.iter_mut().zip(&local.runs) {
            let seen = run.output_noise.iter_mut().zip(&run.outputs).enumerate().filter(|(_, (_, series))| series.is_some());
            for (output, (noise, _)) in seen {
                let of = passed.innovations.iter().filter(|(_, place, _)| *place == output);
                let by = scatter(&of.map(|(_, _, e)| *e).collect::<Vec<f64>>());
                all += 1.0;
                if by > NOISIER {
                    *noise *= libm::sqrt(by);
                    much += 1.0;
                }
            }
        }
        if round == 0 && !(much > NOISY_PART * all) {
            return None;
        }
        if much == 0.0 {
            break;
        }
        (point, _) = maximise(&noisier, point, Effort::SETTLED)?;
    }
    Some(noisier)
}

/// (1) of whitened innovations in order of time.
fn scatter(e: &[f64]) -> f64 {
    if e.len() < COLOUR_LAGS {
        return 1.0;
    }
    let product = |lag: usize| e.iter().zip(e.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>() / e.len() as f64;
    let power = product(0);
    if !(power > 0.0) {
        return 1.0;
    }
    let coloured: f64 = (1..COLOUR_LAGS).map(|lag| product(lag) / power).take_while(|rho| *rho > 0.0).sum();
    power * (1.0 + 2.0 * coloured)
}
