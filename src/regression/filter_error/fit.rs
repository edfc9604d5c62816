//! The search for the most likely parameters, gusts and noise: Fisher scoring with damping and step halving.
//!
//! Consumes the answer of output error as a start; goes down (1) of `posed` by steps of its (2), each run's own unknowns
//! eliminated first. It begins with the gusts' strength that is best of `STRENGTHS`, over the states' own motion in a second:
//! output error has put the gusts into the noise of the outputs. A gust that falls below `STILL` is none.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2nd ed., 2015, ch. 5, where the noise's densities are found
//! with the parameters; R is found so too, for where outputs are sampled at different times no steady gain gives it.
//! Numerics: the logarithms of densities move by no more than `MOST_LOG` in one step.

use super::disturbance::{Disturbances, Found};
use super::ended::answer;
use super::posed::{Posed, Stand};
use crate::regression::output_error::fit::{Noise, Settings};
use crate::regression::output_error::fitted::Fitted;
use crate::regression::output_error::model::{Delay, Parameter, Record, Structure};
use crate::regression::output_error::own::{Own, inverse_or_names};
use crate::regression::output_error::problem::Problem;
use crate::regression::output_error::reduced::Reduced;
use crate::regression::output_error::refused::Refused;
use crate::regression::output_error::simulated::simulate;

/// Strengths that are tried at first, of a state's rms in a second.
const STRENGTHS: [f64; 6] = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3];
/// Parts of the residuals' variance that are tried as noise of the outputs.
const PARTS: [f64; 2] = [1.0, 0.1];
/// Strength of a gust that is none.
const STILL: f64 = 1e-4;
const MOST_LOG: f64 = 1.5;
const HALVINGS: usize = 4;
const DAMPING_FIRST: f64 = 1e-6;
const DAMPING_RAISED: f64 = 1e-3;
const DAMPING_MOST: f64 = 1e8;
const COST_TOLD: f64 = 1e-11;

/// The most likely parameters of all records together, from where output error ended.
///
/// # Errors
/// [`Refused`], with what the data lack.
pub fn fit(
    structure: &Structure,
    parameters: &[Parameter],
    delays: &[Delay],
    records: &[Record],
    disturbances: &Disturbances,
    settings: &Settings,
    start: &Fitted,
) -> Result<(Fitted, Found), Refused> {
    let below = |what: &str, expected: usize, found: usize| {
        let what = format!("{what}, by place below");
        if found < expected { Ok(()) } else { Err(Refused::Shape { what, expected, found }) }
    };
    for &state in &disturbances.gusts {
        below("a state with gusts", structure.states.len(), state)?;
    }
    if start.theta.len() != parameters.len() || start.runs.len() != records.len() {
        let what = "parameters of the start".to_owned();
        return Err(Refused::Shape { what, expected: parameters.len(), found: start.theta.len() });
    }
    let free = |name: String, start: f64| Parameter { name, start, prior: None };
    let mut all = parameters.to_vec();
    all.extend(disturbances.gusts.iter().map(|&state| free(format!("gusts of {}", structure.states[state]), 0.0)));
    all.extend(structure.outputs.iter().map(|output| free(format!("noise of {output}"), 0.0)));
    let problem = Problem::new(structure, &all, delays, records, Noise::Diagonal)?;
    let mut posed = Posed::new(problem, disturbances, parameters.len());
    let own: Vec<Own> = start.runs.iter().map(|run| run.own.clone()).collect();
    let squares = posed.squares(&start.theta, &own);
    let begin = posed.begin(&start.theta, own, &start.noise_cov.diagonal(), &squares)?;
    let ended = posed.search(begin, settings, &squares)?;
    answer(&mut posed, ended)
}

/// Where a search ended.
pub(crate) struct Ended {
    pub(crate) stand: Stand,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
}

impl Posed<'_> {
    /// Mean square of every state that gusts accelerate, without them.
    fn squares(&mut self, theta: &[f64], own: &[Own]) -> Vec<f64> {
        let prepared = &self.problem.prepared;
        let (n, point) = (prepared.layout.states, prepared.at(theta));
        let (mut sums, mut count) = (vec![0.0; n], 0.0);
        for (run, own) in self.problem.runs.iter_mut().zip(own) {
            run.delay(&prepared.layout, theta);
            let simulated = simulate(&prepared.layout, &point, &prepared.steps(&point, &run.timeline, false), run, own);
            for x in simulated.states.chunks_exact(n.max(1)) {
                sums.iter_mut().zip(x).for_each(|(sum, x)| *sum += x * x);
                count += 1.0;
            }
        }
        self.disturbances.gusts.iter().map(|&state| (sums[state] / count).max(1e-200)).collect()
    }

    /// The best of the strengths that are tried.
    fn begin(&mut self, theta: &[f64], own: Vec<Own>, noise: &[f64], squares: &[f64]) -> Result<Stand, Refused> {
        let mut best: Option<Stand> = None;
        let mut refused = None;
        let strengths = if squares.is_empty() { &STRENGTHS[..1] } else { &STRENGTHS[..] };
        for (strength, part) in strengths.iter().flat_map(|&strength| PARTS.map(|part| (strength, part))) {
            let mut tried = theta.to_vec();
            tried.extend(squares.iter().map(|square| libm::log(strength * strength * square)));
            tried.extend(noise.iter().zip(&self.problem.floors).map(|(r, floor)| libm::log((part * r).max(*floor))));
            match self.at(tried, own.clone()) {
                Ok(stand) if best.as_ref().is_none_or(|best| stand.cost < best.cost) => best = Some(stand),
                Ok(_) => {}
                Err(error) => refused = Some(error),
            }
        }
        best.ok_or_else(|| refused.unwrap_or(Refused::Diverges { run: 0 }))
    }

    /// Goes down from a place.
    fn search(&mut self, from: Stand, settings: &Settings, squares: &[f64]) -> Result<Ended, Refused> {
        let mut stand = from;
        let (mut damping, mut length_before, mut iterations) = (DAMPING_FIRST, f64::INFINITY, 0);
        loop {
            self.still_ones(&mut stand, squares)?;
            let information = self.information(&stand);
            let structure = self.problem.prepared.structure;
            let mut reduced = Reduced::of(self.problem.prepared.layout.parameters, &information, |run| structure.own_names(run))?;
            reduced.with_priors(self.problem.parameters, &stand.theta);
            reduced.hold(&self.held());
            let next = loop {
                let Some((step, own_steps, length)) = reduced.step(damping) else {
                    if damping > DAMPING_MOST {
                        let names: Vec<String> = self.problem.parameters.iter().map(|one| one.name.clone()).collect();
                        let blind = inverse_or_names(&reduced.matrix, &names).err();
                        return Err(blind.unwrap_or(Refused::Singular { names, smallest: 0.0 }));
                    }
                    damping = (10.0 * damping).max(DAMPING_RAISED);
                    continue;
                };
                let told = 0.5 * length * length > COST_TOLD * stand.cost.abs().max(1.0);
                let converged = length < settings.tolerance || (!told && length > 0.9 * length_before);
                if converged || iterations == settings.iterations || damping > DAMPING_MOST {
                    return Ok(Ended { stand, iterations, converged });
                }
                length_before = length;
                let mut part = 1.0;
                let mut lower = None;
                for _ in 0..=HALVINGS {
                    let moved = self.moved(&stand, &step, &own_steps, part);
                    if let Some(next) = moved.filter(|next| !told || next.cost < stand.cost) {
                        lower = Some(next);
                        break;
                    }
                    part *= 0.5;
                }
                if let Some(next) = lower {
                    break next;
                }
                damping = (10.0 * damping).max(DAMPING_RAISED);
                length_before = f64::INFINITY;
            };
            stand = next;
            damping *= 0.1;
            iterations += 1;
        }
    }

    /// Takes gusts out that have become none.
    fn still_ones(&mut self, stand: &mut Stand, squares: &[f64]) -> Result<(), Refused> {
        let densities = self.densities(&stand.theta);
        let mut found = false;
        for ((still, q), square) in self.still.iter_mut().zip(&densities).zip(squares) {
            if !*still && *q < STILL * STILL * square {
                (*still, found) = (true, true);
            }
        }
        if found {
            *stand = self.at(stand.theta.clone(), stand.own.clone())?;
        }
        Ok(())
    }

    /// After a part of a step.
    fn moved(&mut self, stand: &Stand, step: &[f64], own_steps: &[Vec<f64>], part: f64) -> Option<Stand> {
        let outputs_from = self.parameters + self.still.len();
        let theta = stand.theta.iter().zip(step).enumerate().map(|(j, (theta, step))| {
            let by = if j < self.parameters { part * step } else { part * step.clamp(-MOST_LOG, MOST_LOG) };
            let floor =
                j.checked_sub(outputs_from).and_then(|o| self.problem.floors.get(o)).map_or(f64::NEG_INFINITY, |x| libm::log(*x));
            (theta + by).max(floor)
        });
        let theta = theta.collect();
        let scaled = |steps: &Vec<f64>| -> Vec<f64> { steps.iter().map(|step| part * step).collect() };
        let layout = &self.problem.prepared.layout;
        let own = stand.own.iter().zip(own_steps).map(|(own, steps)| own.moved(layout, &scaled(steps))).collect();
        self.at(theta, own).ok()
    }
}
