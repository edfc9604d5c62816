//! Standard errors that hold where the model lacks something: innovations that are correlated in time, runs that disagree.
//!
//! Consumes a linearisation with its scores g_t = S_t' e_t by node; produces, for one parameter, the ratio of the robust standard
//! error to that of the likelihood. With c the parameter's row of A^-1 and psi_t = c g_t the influence of a node,
//!     V = c P c' + sum psi_t^2 + 2 sum_k sum_t psi_t psi_(t+k)                                        (1)
//!     V_between = R/(R - 1) sum_r (sum_(t in r) psi_t)^2                                              (2)
//!     ratio^2 = max(1, V, (N V + (R - 1) V_between)/(N + R - 1))/A^-1                                 (3)
//! P the precision of the priors, R the number of runs, N = [`PRIOR_RUNS`] how many runs' worth of trust (1) has. The sum over k
//! ends before its first pair of lags that is not positive (Geyer's initial positive sequence).
//! Sources: Newey and West 1987 (1); Liang and Zeger 1986 (2); C. J. Geyer, Practical Markov Chain Monte Carlo, 1992, sec. 3.3.

use super::normal_equations::Linearisation;
use super::parameter::RUN_OFFSETS;
use super::parameter_set::ParameterSet;
use super::problem::DiagnosisProblem;
use nalgebra::DVector;

/// N of (3).
const PRIOR_RUNS: f64 = 4.0;
/// Nodes are added up over so long, s: the motion of an aircraft is slower.
const BLOCK_S: f64 = 0.1;

/// (3) of the parameter at that place; one where the linearisation has no scores.
pub(crate) fn robust_ratio(problem: &DiagnosisProblem, point: &ParameterSet, local: &Linearisation, place: usize) -> f64 {
    let (order, shared) = problem.layout(point);
    let mut unit = DVector::zeros(order);
    let Some(entry) = unit.get_mut(place) else { return 1.0 };
    *entry = 1.0;
    let row = local.factor.solve(&unit);
    let variance = row.get(place).copied().unwrap_or(0.0);
    if !(variance > 0.0) {
        return 1.0;
    }
    let (mut by_data, mut influence) = (0.0, Vec::new());
    for (number, (run, record)) in local.runs.iter().zip(&problem.runs).enumerate() {
        let kept = shared + RUN_OFFSETS;
        let global = |column: usize| if column < shared { column } else { column + number * RUN_OFFSETS };
        let own: Vec<f64> = (0..kept).map(|column| row.get(global(column)).copied().unwrap_or(0.0)).collect();
        by_data += quadratic_form(&own, &run.information, kept);
        let by_node = run.scores.chunks_exact(kept).map(|score| score.iter().zip(&own).map(|(g, c)| g * c).sum::<f64>());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few nodes")]
        let nodes = (BLOCK_S / record.mesh.step_s).max(1.0) as usize;
        let by_node: Vec<f64> = by_node.collect();
        influence.push(by_node.chunks(nodes).map(|block| block.iter().sum()).collect());
    }
    let prior = (variance - by_data).max(0.0);
    let SumVariance { within, between } = SumVariance::of(&influence);
    let runs = influence.len() as f64;
    let pooled = (PRIOR_RUNS * within + (runs - 1.0) * between) / (PRIOR_RUNS + runs - 1.0);
    libm::sqrt((prior + f64::max(within, pooled)) / variance).max(1.0)
}

/// The variance of the sum of several series.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SumVariance {
    /// From the correlation inside of each, (1); not below that of white ones.
    within: f64,
    /// From how the sums of each differ, (2); that of one series is its square.
    between: f64,
}

impl SumVariance {
    fn of(series: &[Vec<f64>]) -> Self {
        let product = |lag: usize| series.iter().map(|one| product(one, lag)).sum::<f64>();
        let longest = series.iter().map(Vec::len).max().unwrap_or(0);
        let pairs = (0..longest / 2).map(|lag| product(2 * lag) + product(2 * lag + 1));
        let (white, positive) = (product(0), pairs.take_while(|pair| *pair > 0.0).sum::<f64>());
        let count = series.len() as f64;
        let sums = series.iter().map(|one| one.iter().sum::<f64>());
        let squares: f64 = sums.map(|sum| sum * sum).sum();
        SumVariance { within: (2.0 * positive - white).max(white), between: count / f64::max(count - 1.0, 1.0) * squares }
    }
}

/// x' M x of a symmetric matrix of which the upper triangle is there, by row.
fn quadratic_form(x: &[f64], upper: &[f64], order: usize) -> f64 {
    let rows = upper.chunks_exact(order).zip(x).enumerate();
    let of_row = |(place, (row, own)): (usize, (&[f64], &f64))| {
        let beyond: f64 = row.iter().zip(x).skip(place + 1).map(|(entry, other)| entry * other).sum();
        own * (own * row.get(place).copied().unwrap_or(0.0) + 2.0 * beyond)
    };
    rows.map(of_row).sum()
}

/// Sum of the products of values so many places apart.
fn product(series: &[f64], lag: usize) -> f64 {
    series.iter().zip(series.iter().skip(lag)).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::super::likelihood_tests::problem_with;
    use super::super::maximise::{Effort, maximise};
    use super::super::normal_equations::{Detail, linearise};
    use super::super::parameter_set::Hypothesis;
    use super::*;
    use crate::flight::derivative::{Axis, Variable};
    use crate::flight::effect::Effect;
    use crate::num::random::NormalNoise;

    /// Of a first-order autoregression with the coefficient a and unit steps, n values have a sum of variance n/(1 - a)^2.
    #[test]
    fn the_variance_of_a_sum_is_that_of_its_autoregression() {
        for coefficient in [0.0, 0.5, 0.9] {
            let mut noise = NormalNoise::new(7, 1);
            let (runs, length) = (400, 1000);
            let series: Vec<Vec<f64>> = (0..runs)
                .map(|_| {
                    let mut value = 0.0;
                    let steps = (0..length + 100).map(|_| {
                        value = coefficient * value + noise.draw();
                        value
                    });
                    steps.skip(100).collect()
                })
                .collect();
            let expected = f64::from(runs) * length as f64 / (1.0 - coefficient) / (1.0 - coefficient);
            let SumVariance { within, between } = SumVariance::of(&series);
            assert!((within / expected - 1.0).abs() < 0.1, "{coefficient}: {within} is not {expected}");
            // 400 squares: a standard error of 7 %.
            assert!((between / expected - 1.0).abs() < 0.25, "{coefficient}: {between} is not {expected}");
        }
    }

    #[test]
    fn a_quadratic_form_needs_the_upper_triangle_alone() {
        let upper = [2.0, 0.5, -1.0, f64::NAN, 3.0, 0.25, f64::NAN, f64::NAN, 4.0];
        // 2 + 3 4 + 4 9 + 2 (0.5 2 - 1 3 + 0.25 6)
        let found = quadratic_form(&[1.0, 2.0, 3.0], &upper, 3);
        assert!((found - 49.0).abs() < 1e-12, "{found}");
    }

    /// Where the model with its cause is right nothing is added; where another law is at work beside it, what it leaves is.
    #[test]
    fn the_ratio_is_near_one_where_the_model_is_right_and_grows_where_something_is_left() {
        let wrong = Effect::Derivative { axis: Axis::N, variable: Variable::V, delta: 0.01 };
        let left = Effect::TransportDelay { control: crate::flight::control::Control::Pedal, delay: 0.15 };
        let ratio = |effects: Vec<Effect>| {
            let problem = problem_with(effects);
            let mut point = problem.null_hypothesis();
            point.hypotheses = vec![Hypothesis::of(wrong, 0.1)];
            let (point, _) = maximise(&problem, point, Effort::SETTLED).unwrap();
            let local = linearise(&problem, &point, &[], Detail::Traces).unwrap();
            robust_ratio(&problem, &point, &local, point.main_place_of(0))
        };
        let (right, lacking) = (ratio(vec![wrong]), ratio(vec![wrong, left]));
        assert!((1.0..1.3).contains(&right) && lacking > 1.5 * right, "{right} {lacking}");
    }
}
