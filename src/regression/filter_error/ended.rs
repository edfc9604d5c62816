//! From where the search ended to the answer: covariances, each run's innovations, what the disturbances are.
//!
//! The unknowns are theta, ln q, ln r and then every run's own. M is (2) of `posed`; in place of M's part of the means the
//! innovations' own colour gives the covariance W of the gradient (`output_error::colour`, on innovations over their standard
//! deviations), and Sigma = M^-1 W M^-1. Innovations that are white give W = M but for chance.

use super::disturbance::{Found, Gust};
use super::fit::Ended;
use super::posed::Posed;
use crate::regression::output_error::answer::{add_block, roots};
use crate::regression::output_error::colour::Coloured;
use crate::regression::output_error::dense::Dense;
use crate::regression::output_error::fitted::{Fitted, FittedRun, correlated, does_not_belong};
use crate::regression::output_error::own::{Own, inverse_or_names};
use crate::regression::output_error::refused::Refused;
use crate::regression::output_error::simulated::simulate;

/// What a run's innovations are.
struct OfRun {
    coloured: Coloured,
    variances: Dense,
    foretold: Vec<Vec<f64>>,
}

/// The answer at the end of the search.
pub(crate) fn answer(posed: &mut Posed<'_>, ended: Ended) -> Result<(Fitted, Found), Refused> {
    let Ended { stand, iterations, converged } = ended;
    let layout = posed.problem.prepared.layout.clone();
    let (p, all, own, columns, outputs) = (posed.parameters, layout.parameters, layout.own(), layout.columns(), layout.outputs);
    let size = all + own * stand.own.len();
    let mut names: Vec<String> = posed.problem.parameters.iter().map(|one| one.name.clone()).collect();
    let (mut m, mut runs) = (Dense::zeros(size, size), Vec::new());
    let (mut spread, mut noise) = (vec![0.0; outputs], vec![0.0; outputs]);
    let r = posed.noise(&stand.theta);
    for run in 0..stand.own.len() {
        names.extend(posed.problem.prepared.structure.own_names(run));
        let samples = posed.problem.runs.get(run).map_or(0, |one| one.samples);
        let width = outputs * columns;
        let (mut rows, mut whitened) = (vec![0.0; samples * width], vec![f64::NAN; samples * outputs]);
        let mut foretold = vec![vec![f64::NAN; samples]; outputs];
        let measured = posed.problem.runs.get(run).map(|one| one.outputs.clone()).unwrap_or_default();
        let (means, variances) = posed.information_of(run, &stand, |one| {
            let (root, place) = (libm::sqrt(one.s), one.sample * outputs + one.output);
            whitened[place] = one.v / root;
            foretold[one.output][one.sample] = measured[place] - one.v;
            spread[one.output] += one.s;
            noise[one.output] += r[one.output];
            let row = &mut rows[place * columns..(place + 1) * columns];
            row.iter_mut().zip(one.change).for_each(|(row, x)| *row = x / root);
        });
        for block in [&means, &variances] {
            add_block(&mut m, &block.part(0..columns, 0..columns), all, all + run * own);
        }
        let Some(one) = posed.problem.runs.get(run) else { continue };
        let unit = Dense::from_fn(outputs, outputs, |i, j| f64::from(u8::from(i == j)));
        runs.push(OfRun { coloured: Coloured::of(one, columns, &whitened, rows, &unit), variances, foretold });
    }
    let mut prior = vec![0.0; size];
    for (j, parameter) in posed.problem.parameters.iter().enumerate() {
        if let Some((_, std)) = parameter.prior {
            prior[j] = 1.0 / (std * std);
        }
    }
    let held = posed.held();
    (0..size).for_each(|j| m[(j, j)] += prior[j] + f64::from(u8::from(held.contains(&j))));
    let cramer_rao = inverse_or_names(&m, &names)?;
    let sandwich = |of_means: &dyn Fn(usize, &Coloured) -> Dense| {
        let mut w = Dense::zeros(size, size);
        for (run, one) in runs.iter().enumerate() {
            add_block(&mut w, &of_means(run, &one.coloured), all, all + run * own);
            add_block(&mut w, &one.variances.part(0..columns, 0..columns), all, all + run * own);
        }
        (0..size).for_each(|j| w[(j, j)] += prior[j]);
        cramer_rao.times(&w).times(&cramer_rao)
    };
    let first = sandwich(&|_, one| one.gradient_cov());
    let whole = sandwich(&|run, one| {
        let at = |i: usize| if i < all { i } else { i + run * own };
        one.again(&Dense::from_fn(columns, columns, |i, j| first[(at(i), at(j))]))
    });
    let stds = roots(&whole);
    let (cov_cramer_rao, cov) = (cramer_rao.part(0..p, 0..p), whole.part(0..p, 0..p));
    let mut fitted_runs = Vec::new();
    for (number, (run, values)) in posed.problem.runs.iter_mut().zip(&stand.own).enumerate() {
        let prepared = &posed.problem.prepared;
        run.delay(&layout, &stand.theta);
        let simulated = simulate(&layout, &stand.point, &prepared.steps(&stand.point, &run.timeline, false), run, values);
        let from = all + number * own;
        let std = Own::zero(&layout).moved(&layout, &stds[from..from + own]);
        fitted_runs.push(FittedRun::new(&layout, run, values.clone(), std, &simulated));
    }
    let densities = posed.densities(&stand.theta);
    let gusts = posed.disturbances.gusts.iter().zip(densities).enumerate().map(|(place, (&state, density))| {
        let std_log = if density > 0.0 { stds[p + place] } else { 0.0 };
        Gust { state, density, std_log }
    });
    let gusts = gusts.collect();
    let disturbed = spread.iter().zip(&noise).map(|(all, noise)| 1.0 - noise / all).collect();
    let theta = stand.theta[..p].to_vec();
    let std = roots(&cov);
    let fitted = Fitted {
        std_cramer_rao: roots(&cov_cramer_rao),
        insensitivity: (0..p).map(|j| 1.0 / libm::sqrt(m[(j, j)])).collect(),
        correlated: correlated(&cov_cramer_rao),
        f_corrected: theta.iter().zip(&std).map(|(theta, std)| theta * theta / (std * std)).collect(),
        cost_rise: theta.iter().zip(cov_cramer_rao.diagonal()).map(|(theta, var)| 0.5 * theta * theta / var).collect(),
        does_not_belong: does_not_belong(&theta, &cov_cramer_rao, &cov, posed.problem.parameters),
        theta,
        std,
        cov,
        cov_cramer_rao,
        noise_cov: Dense::from_fn(outputs, outputs, |i, j| if i == j { r[i] } else { 0.0 }),
        cost: stand.cost,
        iterations,
        converged,
        runs: fitted_runs,
    };
    Ok((fitted, Found { gusts, foretold: runs.into_iter().map(|one| one.foretold).collect(), disturbed }))
}
