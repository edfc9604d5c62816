//! From where the search ended to the answer: both covariances over all unknowns, and the figures that follow from them.
//!
//! The unknowns are theta and then every run's own in turn; M over all of them, bordered by the runs' blocks, is inverted whole
//! once. Priors add M_0 to M and, being as uncertain as they say, to the gradient's covariance W of `colour` as well.

use super::colour::Coloured;
use super::dense::Dense;
use super::fit::Ended;
use super::fitted::{Fitted, FittedRun, correlated, does_not_belong};
use super::information::Linear;
use super::own::{Own, inverse_or_names};
use super::problem::Problem;
use super::refused::Refused;

/// How often what the fit took from the residuals is given back; a second time changes errors by less than 1 %.
const GIVEN_BACK: usize = 1;

/// Adds a run's block (theta, own) where it belongs among all unknowns.
pub(crate) fn add_block(all: &mut Dense, block: &Dense, parameters: usize, from: usize) {
    let place = |i: usize| if i < parameters { i } else { from + i - parameters };
    let size = block.rows().min(block.columns());
    for i in 0..size {
        for j in 0..size {
            all[(place(i), place(j))] += block[(i, j)];
        }
    }
}

pub(crate) fn roots(cov: &Dense) -> Vec<f64> {
    cov.diagonal().iter().map(|variance| libm::sqrt(*variance)).collect()
}

/// The answer at the end of the search.
pub(crate) fn answer(problem: &mut Problem<'_>, ended: Ended) -> Result<Fitted, Refused> {
    let Ended { place, information, iterations, converged } = ended;
    problem.delay(&place);
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
    let inverse_cov = place.whitening.inverse_cov();
    let mut coloured = Vec::with_capacity(problem.runs.len());
    for ((run, simulated), own_values) in problem.runs.iter().zip(&place.simulated).zip(&place.own) {
        let steps = problem.prepared.steps(&place.point, &run.timeline, true);
        let linear =
            Linear { prepared: &problem.prepared, point: &place.point, steps: &steps, output_lines: &problem.output_lines };
        coloured.push(Coloured::new(&linear, run, simulated, own_values, &inverse_cov, &place.noise_cov));
    }
    let sandwich = |gradient_cov: &dyn Fn(usize, &Coloured) -> Dense| {
        let mut w = Dense::zeros(size, size);
        for (run, one) in coloured.iter().enumerate() {
            add_block(&mut w, &gradient_cov(run, one), p, p + run * own);
        }
        for (j, weight) in prior.iter().enumerate() {
            w[(j, j)] += weight;
        }
        cramer_rao.times(&w).times(&cramer_rao)
    };
    let mut whole = sandwich(&|_, one| one.gradient_cov());
    for _ in 0..GIVEN_BACK {
        let of_run = |run: usize| {
            let at = |i: usize| if i < p { i } else { i + run * own };
            Dense::from_fn(columns, columns, |i, j| whole[(at(i), at(j))])
        };
        whole = sandwich(&|run, one| one.again(&of_run(run)));
    }
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
