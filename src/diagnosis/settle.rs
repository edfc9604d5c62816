//! The way down: steps of all parameters and of the noise densities, until nothing changes any more.
//!
//! Consumes the problem and a point; produces the point where it settles, with its neighbourhood. Parameters go by (1) of
//! `problem`; the noise of forces and moments, and that of gusts where there are any, by its own scores, (4) of `filter`:
//!     ln q <- ln q - (d cost)/(d^2 cost)                                                              (1)
//! Where noises are far from where they settle, passes without other sensitivities, which are quick, bring them nearer first.

use super::filter::NOISES;
use super::linearise::{Local, With};
use super::point::{OWN, Point};
use super::problem::Problem;
use crate::flight::derivative::AXES;
use nalgebra::DVector;

/// Most that the logarithm of a density changes at once.
const DENSITY_STEP: f64 = 3.0;
/// Change of the cost by which noises are far from where they settle, and rounds of quick passes that then bring them nearer.
const FAR: f64 = 30.0;
const QUICK_ROUNDS: usize = 3;
/// Parts of a step that are tried.
const STEPS: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// Least second derivative by a noise's logarithm.
const LEAST_CURVATURE: f64 = 0.3;

/// How far a point is followed down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounds {
    /// Most steps.
    pub most: usize,
    /// Change of the cost below which nothing changes any more.
    pub gain: f64,
}

impl Rounds {
    /// Until it has settled.
    pub const SETTLED: Rounds = Rounds { most: 14, gain: 0.3 };

    /// To see what it is worth.
    pub const fn some(most: usize) -> Self {
        Rounds { most, gain: 1.0 }
    }
}

impl Problem {
    /// Goes down from a point until nothing changes any more.
    pub fn settle(&self, point: Point, rounds: Rounds) -> Option<(Point, Local)> {
        let there = self.neighbourhood(point, true)?;
        self.settle_on(there, rounds)
    }

    /// The same from a point whose neighbourhood is known.
    pub fn settle_on(&self, (mut point, mut local): (Point, Local), rounds: Rounds) -> Option<(Point, Local)> {
        let mut before = local.noisier;
        for _ in 0..rounds.most {
            let (force, gust, moved) = self.renewed(&point, &local.noisier, &before);
            before = local.noisier;
            let step = local.factor.solve(&local.pull);
            let gain = step.dot(&local.pull);
            // A step may lead out of what the kinematics can carry: then a part of it, and in the end none.
            let parts = STEPS.into_iter().find_map(|part| {
                let mut next = self.stepped(&point, &step, part);
                (next.force, next.gust.0) = (force, gust);
                self.neighbourhood(next, moved > FAR)
            });
            let Some(next) = parts else { break };
            (point, local) = next;
            if gain < rounds.gain && moved < 2.0 * rounds.gain {
                break;
            }
        }
        Some((point, local))
    }

    /// The neighbourhood of a point, its noises brought nearer to where they settle; with its own where the filter cannot follow
    /// with those.
    fn neighbourhood(&self, point: Point, far: bool) -> Option<(Point, Local)> {
        if far && self.says_all() {
            let found = self.with_noises_found(point.clone());
            if let Some(local) = self.linearise(&found, &[], With::Slopes) {
                return Some((found, local));
            }
        }
        let local = self.linearise(&point, &[], With::Slopes)?;
        Some((point, local))
    }

    /// The noises alone brought nearer to where they settle: a pass without sensitivities is a quick one.
    fn with_noises_found(&self, mut point: Point) -> Point {
        let mut before = None;
        for _ in 0..QUICK_ROUNDS {
            let Some(local) = self.linearise(&point, &[], With::Noises) else { break };
            let (force, gust, moved) = self.renewed(&point, &local.noisier, &before.unwrap_or(local.noisier));
            before = Some(local.noisier);
            (point.force, point.gust.0) = (force, gust);
            if moved < FAR {
                break;
            }
        }
        point
    }

    /// A part of a step of the parameters.
    fn stepped(&self, point: &Point, step: &DVector<f64>, part: f64) -> Point {
        let mut next = point.clone();
        let run_s = self.runs.iter().map(|run| run.mesh.length_s()).fold(f64::INFINITY, f64::min);
        let at = |place: usize| part * step.get(place).copied().unwrap_or(0.0);
        let places = point.places();
        for (place, &key) in places.iter().enumerate() {
            next.change(key, at(place), run_s);
        }
        for (k, &(axis, variable, _)) in self.small.iter().enumerate() {
            next.small[axis.index()][variable.index()] += at(places.len() + k);
        }
        let shared = places.len() + self.small.len();
        for (number, own) in next.own.iter_mut().enumerate() {
            for (k, value) in own.iter_mut().enumerate() {
                *value += at(shared + number * OWN + k);
            }
        }
        next
    }

    /// The noises after a step (1), and what the change is worth at most, as that of the parameters. Where the slope has changed
    /// its sign the last step went too far, and so would this one: half of it is taken.
    fn renewed(&self, point: &Point, noisier: &[(f64, f64); NOISES], before: &[(f64, f64); NOISES]) -> ([f64; AXES], f64, f64) {
        let by = |of: usize| {
            let ((slope, curvature), (last, _)) = (noisier[of], before[of]);
            let part = if slope * last < 0.0 && self.says_all() { 0.5 } else { 1.0 };
            libm::exp((-part * slope / curvature.max(LEAST_CURVATURE)).clamp(-DENSITY_STEP, DENSITY_STEP))
        };
        let force: [f64; AXES] = core::array::from_fn(|axis| (point.force[axis] * by(axis)).max(self.least[axis]));
        let changes = force.iter().zip(&point.force).zip(noisier);
        let moved = changes.map(|((a, b), (slope, _))| libm::fabs(slope * libm::log(a / b))).fold(0.0, f64::max);
        // The gusts' density goes with the square of their standard deviation.
        (force, point.gust.0 * libm::sqrt(by(AXES)), moved)
    }
}
