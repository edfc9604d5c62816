//! What the live estimates of a simulated flight reported, second by second, against the derivatives of its model.

use super::{L_P, N_R, N_V, WANTED};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::model::LinearModel;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::estimation::record::EstimationEvent;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::realtime::regression::record::Status;
use sideslip::simulation::fly::Flight;

/// What one flight reported.
#[derive(Default)]
pub(super) struct Reported {
    /// The derivatives of `WANTED` every second from the first number on, and their errors in standard errors.
    pub scores: Vec<((Axis, Variable), f64)>,
    /// Errors beyond four standard errors under the status `converged`, of any derivative.
    pub converged_and_wrong: usize,
    /// Numbers of any kind under that status.
    pub converged: usize,
    /// Errors beyond four standard errors under any status, of any derivative.
    pub beyond_four: usize,
    /// Unstable modes of the stable aircraft.
    pub unstable: usize,
    /// Numbers of any kind.
    pub numbers: usize,
    /// Instruments blamed, of which none is at fault.
    pub blamed: usize,
    /// Which derivatives of `WANTED` had a number in the end.
    pub last: [bool; WANTED.len()],
    /// Whether the Dutch roll had one.
    pub dutch_roll: bool,
    /// Which of N_v, N_r, L_p and the Dutch roll had a number when the test input was over.
    pub after_input: [bool; 4],
}

impl Reported {
    /// Which of N_v, N_r, L_p and the Dutch roll had a number in the end.
    fn in_the_end(&self) -> [bool; 4] {
        [self.last[N_V], self.last[N_R], self.last[L_P], self.dutch_roll]
    }
}

/// Time by which the test inputs are over and their answer is known, s.
const AFTER_INPUT_S: f64 = 22.0;

/// What the pipeline reported of a flight, every second.
pub(super) fn watched(flight: &Flight, model: &LinearModel) -> Reported {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut found = Reported::default();
    let mut due_s = 1.0;
    for sample in &flight.fly().unwrap().samples {
        let tick = pipeline.step(sample);
        let blames =
            |event: &&EstimationEvent| matches!(event, EstimationEvent::GrossError { .. } | EstimationEvent::StandsStill { .. });
        for event in tick.estimation_events.iter().filter(blames) {
            found.blamed += 1;
            eprintln!("{:.0} s, seed {}: {event:?} of instruments that are right", sample.time_s, flight.seed);
        }
        let (Some(derivatives), Some(modes)) = (&tick.derivatives, &tick.modes) else { continue };
        if sample.time_s < due_s {
            continue;
        }
        due_s += 1.0;
        for equation in &derivatives.equations {
            for term in &equation.terms {
                let Some(variable) = term.variable else { continue };
                let score = (term.value - model.derivative(equation.axis, variable)) / term.std;
                found.numbers += 1;
                found.beyond_four += usize::from(score.abs() > 4.0);
                found.converged += usize::from(equation.status == Status::Converged);
                if score.abs() > 4.0 {
                    found.converged_and_wrong += usize::from(equation.status == Status::Converged);
                    eprintln!(
                        "{:.0} s, seed {}: {}_{variable:?} {score:.1} standard errors off, {:?}",
                        sample.time_s,
                        flight.seed,
                        equation.axis.name(),
                        equation.status
                    );
                }
                let doubted = matches!(equation.status, Status::DependsOnAmplitude | Status::Disagree);
                if WANTED.contains(&(equation.axis, variable)) && !doubted {
                    found.scores.push(((equation.axis, variable), score));
                }
            }
        }
        let unstable = [modes.dutch_roll.map(|pair| pair.real), modes.roll.map(|root| root.value)];
        for real in unstable.into_iter().flatten().filter(|real| *real > 0.0) {
            found.unstable += 1;
            eprintln!("{:.0} s, seed {}: an unstable mode, {real:.2} 1/s", sample.time_s, flight.seed);
        }
        for (last, (axis, variable)) in found.last.iter_mut().zip(WANTED) {
            *last = derivatives.equations[axis.index()].term(variable).is_some();
        }
        found.dutch_roll = modes.dutch_roll.is_some();
        if sample.time_s <= AFTER_INPUT_S {
            found.after_input = found.in_the_end();
        }
    }
    found
}

/// Part of the flights in which N_v, N_r, L_p and the Dutch roll had a number in the end.
pub(super) fn shares(all: &[Reported]) -> [f64; 4] {
    let count = |place: usize| all.iter().filter(|one| one.in_the_end()[place]).count();
    std::array::from_fn(|place| count(place) as f64 / all.len() as f64)
}

/// In how many flights they had one after the test input, and in how many of those in the end.
pub(super) fn kept(all: &[Reported]) -> [(usize, usize); 4] {
    std::array::from_fn(|place| {
        let answered = all.iter().filter(|one| one.after_input[place]);
        (answered.clone().filter(|one| one.in_the_end()[place]).count(), answered.count())
    })
}

/// Root mean square of the scores of all derivatives that the condition holds for.
pub(super) fn rms(all: &[Reported], holds: impl Fn(Axis) -> bool) -> f64 {
    let scores = all.iter().flat_map(|one| &one.scores).filter(|((axis, _), _)| holds(*axis)).map(|(_, score)| *score);
    let (sum, count) = scores.fold((0.0, 0usize), |(sum, count), score| (sum + score * score, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// Whether more flights have a `converged` number beyond four standard errors than right standard errors of normal errors give
/// once in a thousand runs: some 15 numbers of a flight do not depend on each other, 6.3e-5 of them are beyond four, and the
/// count of such flights is Poisson's.
pub(super) fn too_many_converged_and_wrong(all: &[Reported]) -> bool {
    let flights = all.iter().filter(|one| one.converged_and_wrong > 0).count();
    flights > poisson_quantile(all.len() as f64 * 15.0 * 6.3e-5, 0.999)
}

/// The least count that is not exceeded with that probability.
fn poisson_quantile(mean: f64, probability: f64) -> usize {
    let (mut count, mut term, mut sum) = (0, (-mean).exp(), (-mean).exp());
    while sum < probability {
        count += 1;
        term *= mean / count as f64;
        sum += term;
    }
    count
}

/// Tables of the Poisson distribution: of the mean 1, P(X <= 3) = 0.9810 and P(X <= 4) = 0.9963; of 0.1, P(X <= 1) = 0.9953.
#[test]
fn quantiles_of_poisson_are_the_tabulated_ones() {
    let found = [(1.0, 0.98), (1.0, 0.99), (0.1, 0.995), (0.1, 0.996), (0.1, 0.9)].map(|(mean, p)| poisson_quantile(mean, p));
    assert_eq!(found, [3, 4, 1, 2, 0]);
}
