//! What each run of several says alone of what holds over all of them.
//!
//! Consumes runs and their joint minimum; fits each run by itself from there, with its noise and the same parameters let go,
//! to its own minimum: one linearisation about the joint one would carry the joint answer into each run's. What stands over
//! all runs as a bias is there the run's own.

use super::fit::{Local, Point, Run, minimise, parameter_at, place_of};
use super::parameter::{BIAS, Kind, PARAMETERS, Parameter, STANDING};
use super::side_by_side::side_by_side;

/// One run's own minimum.
#[derive(Clone, Debug)]
pub struct Alone {
    run: Run,
    point: Point,
    local: Local,
}

impl Alone {
    /// Fits one run; `None` where its motion cannot be followed.
    fn of(runs: &[Run], joint: &Point, number: usize) -> Option<Alone> {
        let (run, point) = apart(runs, joint, number)?;
        let (point, local) = minimise(std::slice::from_ref(&run), &point)?;
        Some(Alone { run, point, local })
    }

    /// Each of several runs alone; nothing of one.
    pub fn each(runs: &[Run], joint: &Point) -> Vec<Option<Alone>> {
        let numbers: Vec<usize> = if runs.len() > 1 { (0..runs.len()).collect() } else { Vec::new() };
        side_by_side(&numbers, |&number| Alone::of(runs, joint, number))
    }

    /// A parameter and its standard error, a factor as such; `None` where it does not act on this run.
    pub fn says(&self, parameter: Parameter) -> Option<(f64, f64)> {
        let place = place_of(0, parameter.index);
        let value = *self.local.minimum(&self.point).get(place)?;
        let colour = self.local.colour(std::slice::from_ref(&self.run), &[place]);
        let std = libm::sqrt(colour * self.local.variance_of(&[place]));
        let shown = if parameter.kind == Kind::Scale { 1.0 + value } else { value };
        self.run.active.contains(&parameter.index).then_some((shown, std))
    }
}

/// One run of several, and where the joint parameters put it by itself.
pub(super) fn apart(runs: &[Run], joint: &Point, number: usize) -> Option<(Run, Point)> {
    let mut run = runs.get(number)?.clone();
    run.active.retain(|&index| index < STANDING);
    let mut point = Point::zero(std::slice::from_ref(&run));
    (point.lag, point.sample_s) = (joint.lag, joint.sample_s);
    let own = |index: usize| if index >= STANDING { BIAS + index - STANDING } else { index };
    for (index, value) in joint.theta(number).values.into_iter().enumerate().take(PARAMETERS) {
        point.values[place_of(0, own(index))] += value;
    }
    for &place in &joint.free {
        let (parameter, whose) = parameter_at(place);
        let here = place_of(0, own(parameter.index));
        if whose.is_none_or(|whose| whose == number) && !point.free.contains(&here) {
            point.free.push(here);
        }
    }
    Some((run, point))
}
