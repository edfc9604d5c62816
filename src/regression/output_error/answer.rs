//! From where the search ended to the answer: both covariances over all unknowns, and the figures that follow from them.
//!
//! The unknowns are theta and then every run's own in turn; M over all of them, bordered by the runs' blocks, is inverted whole
//! once. Priors add M_0 to M and, being as uncertain as they say, to the gradient's covariance W of `colour` as well.

use super::colour::gradient_cov;
use super::dense::Dense;
use super::fit::{Place, Problem};
use super::fitted::{Fitted, FittedRun, correlated, does_not_belong};
use super::information::Linear;
use super::own::{Own, inverse_or_names};
use super::refused::Refused;

/// Adds a run's block (theta, own) where it belongs among all unknowns.
fn add_block(all: &mut Dense, block: &Dense, parameters: usize, from: usize) {
    let place = |i: usize| if i < parameters { i } else { from + i - parameters };
    let size = block.rows().min(block.columns());
    for i in 0..size {
        for j in 0..size {
            all[(place(i), place(j))] += block[(i, j)];
        }
    }
}

fn roots(cov: &Dense) -> Vec<f64> {
    cov.diagonal().iter().map(|variance| libm::sqrt(*variance)).collect()
}

/// The answer at the end of the search.
pub(crate) fn answer(problem: &mut Problem<'_>, place: Place, iterations: usize, converged: bool) -> Result<Fitted, Refused> {
    let information = problem.information(&place);
    let layout = problem.prepared.layout.clone();
    let (p, own, columns) = (layout.parameters, layout.own(), layout.columns());
    let size = p + own * problem.runs.len();
    let mut names: Vec<String> = problem.parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let mut m = Dense::zeros(size, size);
    let mut prior = vec![0.0; p];
    for (run, block) in information.iter().enumerate() {
        names.extend(problem.prepared.structure.own_names(run));
        add_block(&mut m, &block.part(0..columns, 0..columns), p, p + run * own);
    }
    for (j, parameter) in problem.parameters.iter().enumerate() {
        if let Some((_, std)) = parameter.prior {
            prior[j] = 1.0 / (std * std);
            m[(j, j)] += prior[j];
        }
    }
    let cramer_rao = inverse_or_names(&m, &names)?;
    let values: f64 = problem.counts.iter().sum();
    let scale = values / (values - size as f64).max(1.0);
    let inverse_cov = place.whitening.inverse_cov();
    let mut w = Dense::zeros(size, size);
    for (place_of, ((run, simulated), own_values)) in problem.runs.iter().zip(&place.simulated).zip(&place.own).enumerate() {
        let steps = problem.prepared.steps(&place.point, &run.timeline, true);
        let linear =
            Linear { prepared: &problem.prepared, point: &place.point, steps: &steps, output_lines: &problem.output_lines };
        let block = gradient_cov(&linear, run, simulated, own_values, &inverse_cov, scale);
        add_block(&mut w, &block, p, p + place_of * own);
    }
    for (j, weight) in prior.iter().enumerate() {
        w[(j, j)] += weight;
    }
    let whole = cramer_rao.times(&w).times(&cramer_rao);
    let stds = roots(&whole);
    let (cov_cramer_rao, cov) = (cramer_rao.part(0..p, 0..p), whole.part(0..p, 0..p));
    let runs = problem.runs.iter().zip(&place.simulated).zip(&place.own).enumerate();
    let runs = runs.map(|(number, ((run, simulated), values))| {
        let from = p + number * own;
        let std = Own::zero(&layout).moved(&layout, &stds[from..from + own]);
        FittedRun::new(&layout, run, values.clone(), std, simulated)
    });
    let runs = runs.collect();
    let std = roots(&cov);
    Ok(Fitted {
        std_cramer_rao: roots(&cov_cramer_rao),
        insensitivity: (0..p).map(|j| 1.0 / libm::sqrt(m[(j, j)])).collect(),
        correlated: correlated(&cov_cramer_rao),
        f_corrected: place.theta.iter().zip(&std).map(|(theta, std)| theta * theta / (std * std)).collect(),
        cost_rise: place.theta.iter().zip(cov_cramer_rao.diagonal()).map(|(theta, var)| 0.5 * theta * theta / var).collect(),
        does_not_belong: does_not_belong(&place.theta, &cov_cramer_rao, &cov, problem.parameters),
        theta: place.theta,
        std,
        cov,
        cov_cramer_rao,
        noise_cov: place.noise_cov,
        cost: place.cost,
        iterations,
        converged,
        runs,
    })
}
