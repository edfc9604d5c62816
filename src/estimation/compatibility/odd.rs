//! Runs whose instruments are not those of the others: one bad run is neither hidden among good ones nor blamed on them.
//!
//! Consumes runs; produces groups, each with what was found in it: those that share their instruments' errors, and odd ones. With
//! J_i a run's part of the joint cost at the joint minimum, E_i its evidence by itself, parameters of its own paid for, and f_i
//! how many parameters that hold over all runs it determines by itself,
//!     G_i = J_i - E_i,  in healthy runs f_i (1 - 1/runs) on average                                      (1)
//! for each of them has lent itself to that run's noise. Where (G_i - f_i)/sqrt(2 f_i) > ODD in any run, or two runs' own values
//! of what they are said to share are apart, that run goes apart without which the others and it cost least, and the others are
//! looked at anew, until none is left. Odd runs that are like each other become one group again.
//! E_i takes a search of its own. Most runs are spared it: with everything let go that may be at fault, at no price, a run costs
//! less than any search finds, and one linearisation about the joint minimum tells by how much,
//!     G_i <= J_i - J_free + g^T C g                                                                  (2)
//! (J_free its cost there under the priors of what is free, g and C its pull and dispersion).

use super::alone::{Alone, apart};
use super::filter::{Prepared, pass};
use super::fit::{Local, Point, Run, SHARED, linearise, parameter_at};
use super::noise::{first_guess, improve, prior};
use super::parameter::Kind;
use super::select::{Found, candidates, price, select};
use super::side_by_side::side_by_side;

/// Normalised (1): healthy runs have -2.5 to 0, one with r or beta 1.15 times the truth in a lateral manoeuvre 20.
const ODD: f64 = 6.0;
/// Standard errors of their difference by which two runs' own values of a shared fault are apart.
const APART: f64 = 5.0;
/// Sweeps over the variances within which the noise settles.
const SWEEPS: usize = 8;

/// Runs that were fitted together.
#[derive(Clone, Debug)]
pub struct Group {
    /// Which, by their places among all.
    pub members: Vec<usize>,
    /// What came of them, in that order.
    pub found: Found,
    /// What each says alone of what holds over all of them, where it is not the only one.
    pub alone: Vec<Option<Alone>>,
    /// Whether it was taken out from among others.
    pub apart: bool,
}

/// A run taken by itself.
struct ByItself {
    found: Found,
    /// E of (1).
    cost: Option<f64>,
    /// f of (1).
    freedom: f64,
}

impl ByItself {
    fn of(run: &Run) -> Option<ByItself> {
        let found = select(vec![run.clone()])?;
        Some(ByItself { cost: evidence_alone(&found), freedom: freedom(&found.point, &found.local), found })
    }

    fn group(&self, run: usize, apart: bool) -> Group {
        Group { members: vec![run], found: self.found.clone(), alone: Vec::new(), apart }
    }
}

/// E of a run by itself, its noise settled.
pub(super) fn evidence_alone(found: &Found) -> Option<f64> {
    Some(settled(found, 0)? + found.point.prior_cost() + price(&found.point, &found.local))
}

/// The groups of runs; one whose motion cannot be followed is in none.
pub fn groups(runs: &[Run]) -> Vec<Group> {
    if let [run] = runs {
        let found = select(vec![run.clone()]);
        return found.into_iter().map(|found| Group { members: vec![0], found, alone: Vec::new(), apart: false }).collect();
    }
    let joint = |these: &[usize]| select(these.iter().filter_map(|&run| runs.get(run).cloned()).collect());
    let all: Vec<usize> = (0..runs.len()).collect();
    let of_all = (all.len() > 1).then(|| joint(&all)).flatten();
    let agreed = of_all.as_ref().and_then(plainly_agreeing);
    let of_all = match (of_all, agreed) {
        (Some(found), Some(alone)) => return vec![Group { members: all, found, alone, apart: false }],
        (of_all, _) => of_all,
    };
    let itself: Vec<Option<ByItself>> = side_by_side(runs, ByItself::of);
    let mut together: Vec<usize> = (0..runs.len()).filter(|&run| itself.get(run).is_some_and(Option::is_some)).collect();
    let by_itself = |run: usize, apart: bool| itself.get(run)?.as_ref().map(|one| one.group(run, apart));
    let mut groups = Vec::new();
    let mut rest = if together == all { of_all } else { (together.len() > 1).then(|| joint(&together)).flatten() };
    let mut agreed = None;
    while together.len() > 1 {
        agreed = rest.as_ref().and_then(|joint| agreeing(joint, &together, &itself));
        if agreed.is_some() {
            break;
        }
        if together.len() == 2 {
            groups.extend(together.drain(..).filter_map(|run| by_itself(run, true)));
        } else {
            let Some((run, others)) = odd_one(&together, &itself, joint) else { break };
            groups.extend(by_itself(run, true));
            together.retain(|one| *one != run);
            rest = Some(others);
        }
    }
    rejoin(&mut groups, &joint, &itself);
    match rest {
        Some(found) if together.len() > 1 => {
            let alone = agreed.unwrap_or_else(|| Alone::each(&found.runs, &found.point));
            groups.push(Group { members: together, found, alone, apart: false });
        }
        _ => {
            let first = groups.is_empty();
            groups.extend(together.pop().and_then(|run| by_itself(run, !first)));
        }
    }
    groups
}

/// Odd runs that are like each other become one group.
fn rejoin(groups: &mut Vec<Group>, joint: &impl Fn(&[usize]) -> Option<Found>, itself: &[Option<ByItself>]) {
    let mut members: Vec<usize> = groups.iter().flat_map(|group| group.members.clone()).collect();
    members.sort_unstable();
    if members.len() < 2 {
        return;
    }
    let Some(found) = joint(&members) else { return };
    if let Some(alone) = agreeing(&found, &members, itself) {
        *groups = vec![Group { members, found, alone, apart: true }];
    }
}

/// What each run says alone; `None` where one stands out by (1), or contradicts the others in what they are said to share.
fn agreeing(joint: &Found, together: &[usize], itself: &[Option<ByItself>]) -> Option<Vec<Option<Alone>>> {
    let places: Vec<usize> = (0..together.len()).collect();
    let excess = side_by_side(&places, |&place| {
        let itself = itself.get(*together.get(place)?)?.as_ref()?;
        let shared = settled(joint, place)? + joint.point.own_prior_cost(place);
        Some((shared - itself.cost?, itself.freedom))
    });
    if excess.into_iter().flatten().any(|excess| stands_out(excess) > ODD) {
        return None;
    }
    let alone = Alone::each(&joint.runs, &joint.point);
    (!disagree(joint, &alone)).then_some(alone)
}

/// By how much (1) is more than usual, of G and f.
fn stands_out((excess, free): (f64, f64)) -> f64 {
    let free = free.max(1.0);
    (excess - free) / libm::sqrt(2.0 * free)
}

/// [`agreeing`] without any run fitted by itself, where (1) is small enough whatever that would find.
fn plainly_agreeing(joint: &Found) -> Option<Vec<Option<Alone>>> {
    let places: Vec<usize> = (0..joint.runs.len()).collect();
    let excess = side_by_side(&places, |&place| excess_at_most(joint, place));
    if !excess.into_iter().all(|excess| excess.is_some_and(|excess| stands_out(excess) <= ODD)) {
        return None;
    }
    let alone = Alone::each(&joint.runs, &joint.point);
    (!disagree(joint, &alone)).then_some(alone)
}

/// What G of (1) is at most, (2), and f.
fn excess_at_most(joint: &Found, place: usize) -> Option<(f64, f64)> {
    let (mut run, mut point) = apart(&joint.runs, &joint.point, place)?;
    let guess = first_guess(&run.record);
    run.noise = improve(&run.record, &point.theta(0), &run.noise, &guess, SWEEPS)?;
    let run = std::slice::from_ref(&run);
    let free = freedom(&point, &linearise(run, &point)?);
    point.free = candidates(run, &point.clone()).into_iter().chain(point.free).collect();
    let local = linearise(run, &point)?;
    let step = local.step();
    let falls: f64 = step.iter().zip(&local.pull).map(|(step, pull)| step * pull).sum();
    Some((joint.point.own_prior_cost(place) - point.prior_cost() + falls, free))
}

/// Whether the runs' own values of a shared fault are too far apart.
fn disagree(joint: &Found, alone: &[Option<Alone>]) -> bool {
    let shared = joint.point.free.iter().map(|&place| parameter_at(place)).filter(|(_, own)| own.is_none());
    shared.map(|(parameter, _)| parameter).filter(|parameter| parameter.kind != Kind::Bias).any(|parameter| {
        let said: Vec<(f64, f64)> = alone.iter().flatten().filter_map(|one| one.says(parameter)).collect();
        let pairs = said.iter().enumerate().flat_map(|(k, a)| said.iter().skip(k + 1).map(move |b| (a, b)));
        pairs.into_iter().any(|(a, b)| (a.0 - b.0).abs() > APART * libm::hypot(a.1, b.1))
    })
}

/// The run without which the others, fitted anew, and it by itself cost least; with that fit of the others.
fn odd_one(together: &[usize], itself: &[Option<ByItself>], joint: impl Fn(&[usize]) -> Option<Found>) -> Option<(usize, Found)> {
    let mut best: Option<(f64, usize, Found)> = None;
    for &run in together {
        let rest: Vec<usize> = together.iter().copied().filter(|other| *other != run).collect();
        let Some(own) = itself.get(run).and_then(|one| one.as_ref()?.cost) else { continue };
        let Some(found) = joint(&rest) else { continue };
        let shared: Option<f64> = (0..rest.len()).map(|place| settled(&found, place)).sum();
        let Some(shared) = shared else { continue };
        let cost = own + shared + found.point.prior_cost() + price(&found.point, &found.local);
        if best.as_ref().is_none_or(|best| cost < best.0) {
            best = Some((cost, run, found));
        }
    }
    best.map(|(_, run, found)| (run, found))
}

/// A run's cost where the parameters stand, with the noise that is most likely there: else one fit's noise would be compared with
/// the other's.
fn settled(found: &Found, place: usize) -> Option<f64> {
    let run = found.runs.get(place)?;
    let (theta, guess) = (found.point.theta(place), first_guess(&run.record));
    let noise = improve(&run.record, &theta, &run.noise, &guess, SWEEPS)?;
    Some(pass(&Prepared::of(&run.record, &theta), &noise, &[], true)?.cost + prior(&noise, &guess))
}

/// How many parameters that hold over all runs one run has determined by itself: what (1) is on average in healthy runs, for each
/// has lent itself to that run's noise.
fn freedom(point: &Point, local: &Local) -> f64 {
    let determined = |place: usize| {
        let (normal, _) = point.priors(place)?;
        (!point.free.contains(&place)).then(|| 1.0 - local.dispersion[(place, place)] / (normal * normal))
    };
    (0..SHARED).filter_map(determined).map(|part| part.max(0.0)).sum()
}
