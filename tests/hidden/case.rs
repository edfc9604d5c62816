//! A sealed case: a model file as a user would give it, runs of an aircraft that differs from it, and what was hidden.
//!
//! Everything is drawn from the case's kind and seed. A draw that is not to be seen, or that the aircraft does not survive, is
//! drawn again; sizes are from large, plainly visible, down to a quarter of that.

use super::draw::{Hidden, Truth, draw};
use super::flights::{Manoeuvres, fly};
use super::motion::Motion;
use sideslip::flight::effect::{Effect, Family};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::model::LinearModel;
use sideslip::flight::sample::Sample;

/// What sort of thing is hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sort {
    /// One effect of that family.
    Single(Family),
    /// Two effects at once.
    Double,
    /// Nothing.
    Healthy,
    /// A cause that no effect describes.
    Outside,
}

/// The families that a single flight condition can show, in the order in which cases take turns.
pub(crate) const FAMILIES: [Family; 6] =
    [Family::Derivative, Family::Nonlinear, Family::Control, Family::Rotor, Family::Disturbance, Family::Instrument];

/// One run as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recorded {
    pub(crate) name: String,
    /// What the run says of itself: geometry, blades, manoeuvre.
    pub(crate) info: RunInfo,
    pub(crate) samples: Vec<Sample>,
}

/// A sealed case.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Case {
    pub(crate) seed: u64,
    /// The model file.
    pub(crate) model_text: String,
    /// Runs to look at.
    pub(crate) fit: Vec<Recorded>,
    /// Runs to judge by.
    pub(crate) holdout: Vec<Recorded>,
    /// What the aircraft or its instruments have and the model has not.
    pub(crate) hidden: Vec<Effect>,
    /// The cause in words, where no effect describes it.
    pub(crate) outside_library: Option<String>,
    /// Size of each hidden thing, of large.
    pub(crate) share: Vec<f64>,
    /// Whether every derivative is a little off besides, within the model's tolerance.
    pub(crate) off: bool,
}

/// The project's own model, which users find in its files.
pub(crate) const BASELINE: &str = include_str!("../../replay/models/puma-like.toml");

/// How many draws a case may take.
const DRAWS: u64 = 60;

/// Least peak difference that what is hidden makes to some channel, in standard deviations of its noise.
const VISIBLE: f64 = 4.0;

/// Everything of a case but its samples.
pub(crate) struct Plan {
    pub(crate) manoeuvres: Manoeuvres,
    pub(crate) truth: Truth,
    pub(crate) hidden: Hidden,
    pub(crate) seed: u64,
}

impl Plan {
    /// The same aircraft, manoeuvres and noise, and nothing hidden.
    pub(crate) fn without(&self) -> Plan {
        Plan { manoeuvres: self.manoeuvres.clone(), truth: self.truth.clone(), hidden: Hidden::default(), seed: self.seed }
    }
}

/// The model of the file.
pub(crate) fn baseline() -> LinearModel {
    ModelFile::parse(BASELINE).unwrap().linear
}

/// The case of that sort and seed.
pub(crate) fn case(sort: Sort, seed: u64) -> Case {
    drawn(sort, seed).unwrap_or_else(|| nothing_drawn(sort, seed))
}

fn nothing_drawn(sort: Sort, seed: u64) -> ! {
    panic!("{sort:?} {seed}: nothing drawn in {DRAWS} draws is to be seen")
}

/// The same; `None` where nothing that is drawn is to be seen.
pub(crate) fn drawn(sort: Sort, seed: u64) -> Option<Case> {
    let plan = planned(sort, seed)?;
    let (fit, holdout) = fly(&plan).expect("a plan was flown before");
    Some(Case {
        seed,
        model_text: BASELINE.to_owned(),
        fit,
        holdout,
        hidden: plan.hidden.effects.clone(),
        outside_library: plan.hidden.law.as_ref().map(|law| law.said.clone()),
        share: plan.hidden.share.clone(),
        off: plan.truth.off,
    })
}

/// Whether the seed's aircraft is off: half of every family's and kind's, in no step with their turns.
pub(crate) fn is_off(seed: u64) -> bool {
    (seed / FAMILIES.len() as u64).count_ones() % 2 == 1
}

/// What is flown in that case.
pub(crate) fn plan(sort: Sort, seed: u64) -> Plan {
    planned(sort, seed).unwrap_or_else(|| nothing_drawn(sort, seed))
}

/// The same; `None` where nothing that is drawn is to be seen.
fn planned(sort: Sort, seed: u64) -> Option<Plan> {
    let manoeuvres = Manoeuvres::draw(seed);
    let truth = Truth::draw(seed, is_off(seed));
    let healthy = Plan { manoeuvres, truth, hidden: Hidden::default(), seed };
    let (clean, _) = fly(&healthy).expect("the healthy aircraft survives");
    let motion = Motion::of(&healthy);
    if sort == Sort::Healthy {
        return Some(healthy);
    }
    for attempt in 0..DRAWS {
        let Some(hidden) = draw(sort, seed, attempt, &motion) else { continue };
        // Each of several is to be seen by itself.
        let alone = hidden.each().into_iter().all(|one| {
            let plan = Plan { hidden: one, ..healthy.without() };
            fly(&plan).is_some_and(|(fit, _)| peak_difference(&fit, &clean) >= VISIBLE)
        });
        let plan = Plan { hidden, ..healthy.without() };
        if alone && fly(&plan).is_some() {
            return Some(plan);
        }
    }
    None
}

/// Largest difference between recordings of the same noise, in standard deviations of each channel's noise.
pub(crate) fn peak_difference(some: &[Recorded], others: &[Recorded]) -> f64 {
    let mut peak: f64 = 0.0;
    for (one, other) in some.iter().zip(others) {
        for (a, b) in one.samples.iter().zip(&other.samples) {
            for (channel, std) in super::flights::noise_stds() {
                if let (Some(a), Some(b)) = (a.get(channel), b.get(channel)) {
                    peak = peak.max((a - b).abs() / std);
                }
            }
        }
    }
    peak
}
