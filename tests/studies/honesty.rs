//! Estimate error against measurement noise and record length: bias, scatter, reported standard error, Cramer-Rao bound.
//!
//! The aircraft is the linear model of the Level-1 Puma at 100 kn, flown by the nonlinear kinematics: its derivatives are known
//! exactly, and no aerodynamic nonlinearity is mistaken for an error of the method. Pedal 3211, then lateral cyclic 3211.

use super::bound::{DERIVATIVES, bounds};
use super::flown::{deviations, fly, puma};
use super::score::{Estimate, Score};
use super::sheet::{Sheet, draw};
use crate::support::asked::seeds;
use crate::support::manoeuvre::{DURATION_S, INPUTS, LEAD_S, RATE_HZ, over_seeds};
use sideslip::flight::model::LinearModel;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::charts::chart::{Curve, Mark, Marks, Panel};
use sideslip::realtime::modes::lateral;
use sideslip::realtime::modes::record::ModesRecord;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::realtime::regression::record::{DerivativesRecord, LateralDerivatives, Status};
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::InstrumentSet;

/// What is judged, with its unit.
pub(crate) const QUANTITIES: [(&str, &str); 5] =
    [("N_r", "1/s"), ("N_v", "rad/(s m)"), ("L_p", "1/s"), ("omega", "rad/s"), ("zeta", "1")];

/// Columns that every table of this study has after its first.
const COLUMNS: [&str; 16] = [
    "quantity",
    "x",
    "seeds",
    "estimates",
    "truth",
    "bias",
    "scatter",
    "reported_std",
    "cramer_rao_std",
    "scatter_over_bound",
    "z_mean",
    "z_spread",
    "within_2",
    "within_3",
    "converged",
    "z_spread_converged",
];

/// Estimates of [`QUANTITIES`].
pub(crate) type Found = [Option<Estimate>; 5];

pub(crate) fn truth(model: &LinearModel) -> [f64; 5] {
    let modes = lateral::modes(0.0, Status::Converged, &LateralDerivatives::of(model)).unwrap();
    let dutch_roll = modes.dutch_roll.unwrap();
    let [n_r, n_v, l_p] = DERIVATIVES.map(|(axis, variable)| model.derivative(axis, variable));
    [n_r, n_v, l_p, dutch_roll.omega, dutch_roll.zeta]
}

fn found(derivatives: &DerivativesRecord, modes: &ModesRecord) -> Found {
    let [n_r, n_v, l_p] = DERIVATIVES.map(|(axis, variable)| {
        let term = derivatives.equations[axis.index()].term(variable)?;
        let converged = derivatives.equations[axis.index()].status == Status::Converged;
        Some(Estimate { value: term.value, std: term.std, converged })
    });
    let of =
        |value: f64, std: f64| std.is_finite().then_some(Estimate { value, std, converged: modes.status == Status::Converged });
    let dutch_roll = modes.dutch_roll;
    let omega = dutch_roll.and_then(|found| of(found.omega, found.std_omega));
    let zeta = dutch_roll.and_then(|found| of(found.zeta, found.std_zeta));
    [n_r, n_v, l_p, omega, zeta]
}

/// The last word of the pipeline at each of those times.
pub(crate) fn at_times(samples: &[Sample], times_s: &[f64]) -> Vec<Found> {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let (mut last, mut all): (Found, Vec<Found>) = ([None; 5], Vec::new());
    for sample in samples {
        if all.len() < times_s.len() && sample.time_s > times_s[all.len()] + 1e-6 {
            all.push(last);
        }
        let tick = pipeline.step(sample);
        if let (Some(derivatives), Some(modes)) = (&tick.derivatives, &tick.modes) {
            last = found(derivatives, modes);
        }
    }
    all.resize(times_s.len(), last);
    all
}

/// Scores by point and quantity, written as a table and drawn as two panels a quantity.
struct Points<'a> {
    name: &'static str,
    /// Name of the abscissa with its unit.
    along: &'a str,
    x: &'a [f64],
    scores: Vec<[Score; 5]>,
    bounds: Vec<[f64; 5]>,
    truth: [f64; 5],
    seeds: u64,
    /// Draw decimal logarithms of the errors.
    logarithmic: bool,
}

impl Points<'_> {
    fn write(&self) {
        let mut sheet = Sheet::new(self.name, &COLUMNS);
        for (quantity, (name, _)) in QUANTITIES.iter().enumerate() {
            for ((x, scores), bounds) in self.x.iter().zip(&self.scores).zip(&self.bounds) {
                let (score, bound) = (&scores[quantity], bounds[quantity]);
                let numbers = [
                    *x,
                    self.seeds as f64,
                    score.count as f64,
                    self.truth[quantity],
                    score.bias,
                    score.scatter,
                    score.reported,
                    bound,
                    score.scatter / bound,
                    score.z_mean,
                    score.z_spread,
                    score.within_two,
                    score.within_three,
                    score.converged as f64,
                    score.z_spread_converged,
                ];
                sheet.row(&[name], &numbers);
                eprintln!(
                    "{name:6} at {x:5}: {:3} of {}; bias {:+.5}, scatter {:.5}, reported {:.5}, bound {bound:.5}; z {:+.2} +- {:.2}, within 2: {:.2}, 3: {:.2}; {} converged, their z +- {:.2}",
                    score.count,
                    self.seeds,
                    score.bias,
                    score.scatter,
                    score.reported,
                    score.z_mean,
                    score.z_spread,
                    score.within_two,
                    score.within_three,
                    score.converged,
                    score.z_spread_converged
                );
            }
        }
        sheet.write();
        draw(self.name, &(0..5).map(|quantity| self.errors(quantity)).collect::<Vec<_>>());
        draw(&format!("{}-z", self.name), &[self.spreads(), self.means()]);
    }

    fn curve(&self, name: &str, of: impl Fn(usize) -> f64) -> Curve {
        Curve { name: name.into(), points: self.x.iter().enumerate().map(|(place, &x)| (x, of(place))).collect() }
    }

    /// Bias with two standard errors of the mean, beside scatter, reported standard error and bound.
    fn errors(&self, quantity: usize) -> (Panel, Vec<Marks>) {
        let (name, unit) = QUANTITIES[quantity];
        let score = |place: usize| &self.scores[place][quantity];
        let drawn = |error: f64| if self.logarithmic { error.abs().log10() } else { error };
        let y = if self.logarithmic { format!("log10 of {name} error, {unit}") } else { format!("error of {name}, {unit}") };
        let panel = Panel {
            title: format!("{name}: truth {:.4} {unit}, {} seeds", self.truth[quantity], self.seeds),
            x: self.along.to_owned(),
            y,
            curves: vec![
                self.curve("scatter of the estimates", |place| drawn(score(place).scatter)),
                self.curve("reported standard error", |place| drawn(score(place).reported)),
                self.curve("Cramer-Rao bound", |place| drawn(self.bounds[place][quantity])),
            ],
        };
        let mark = |(place, &x): (usize, &f64)| {
            let own = 2.0 * score(place).scatter / (score(place).count as f64).sqrt();
            // A logarithm has no bar of its own on both sides.
            Mark { point: (x, drawn(score(place).bias)), either_way: if self.logarithmic { 0.0 } else { own } }
        };
        let name = if self.logarithmic { "size of the mean error" } else { "mean error, +- 2 of its own" };
        let bias = Marks { name: name.into(), marks: self.x.iter().enumerate().map(mark).collect() };
        (panel, vec![bias])
    }

    fn over_quantities(&self, title: &str, y: &str, right: f64, of: impl Fn(&Score) -> f64) -> (Panel, Vec<Marks>) {
        let mut curves: Vec<Curve> = QUANTITIES
            .iter()
            .enumerate()
            .map(|(quantity, (name, _))| self.curve(name, |place| of(&self.scores[place][quantity])))
            .collect();
        curves.push(self.curve("right", |_| right));
        (Panel { title: title.into(), x: self.along.to_owned(), y: y.into(), curves }, Vec::new())
    }

    fn spreads(&self) -> (Panel, Vec<Marks>) {
        let title = "Spread of error/standard error: above 1 the standard errors are too small";
        self.over_quantities(title, "standard deviation of z", 1.0, |score| score.z_spread)
    }

    fn means(&self) -> (Panel, Vec<Marks>) {
        self.over_quantities("Mean of error/standard error: off 0 is bias", "mean of z", 0.0, |score| score.z_mean)
    }

    /// What holds in the short form; in the long form, for records of 15 s and more, also what tests/recovery asks.
    fn judge(&self) {
        let coverage = self.coverage();
        eprintln!("{}: within 3 standard errors over all points and quantities: {coverage:.3}", self.name);
        assert!(coverage > 0.9, "{}: {coverage} within 3 standard errors", self.name);
        let all = self.x.iter().zip(&self.scores).zip(&self.bounds);
        for ((x, scores), bounds) in all.filter(|(_, bounds)| bounds[0] > 0.0) {
            // Of a record too short for a number there is no score, and a single number has no scatter.
            let reported = scores.iter().zip(bounds).zip(QUANTITIES).filter(|((score, _), _)| score.count > 1);
            for ((score, bound), (name, _)) in reported {
                assert!(score.scatter > *bound, "{name} at {x}: scatter {} beats the bound {bound}", score.scatter);
                if self.seeds >= 50 && (self.name == "noise" || *x >= 15.0) {
                    assert!(score.z_spread < 1.5 && score.z_mean.abs() < 0.75, "{name} at {x}: {score:?}");
                }
            }
        }
    }

    /// Over every point and quantity with noise: the share of the estimates within three standard errors.
    fn coverage(&self) -> f64 {
        let there = self.scores.iter().flatten().filter(|score| score.reported > 0.0);
        let (within, count) =
            there.fold((0.0, 0.0), |(w, n), score| (w + score.within_three * score.count as f64, n + score.count as f64));
        within / count
    }
}

/// The manoeuvre.
pub(crate) fn inputs() -> [String; 2] {
    INPUTS.map(str::to_owned)
}

#[test]
fn error_against_measurement_noise() {
    let model = puma(100.0).linear().clone();
    let seeds_run = seeds(8);
    let factors: &[f64] = if seeds_run > 8 { &[0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0] } else { &[0.0, 1.0, 4.0] };
    let truth = truth(&model);
    let aircraft = Flight::of(model.clone());
    let scores = factors.iter().map(|&factor| {
        let one = |seed| {
            let samples = fly(&aircraft, &inputs(), &InstrumentSet::flight_quality(factor), DURATION_S, seed);
            at_times(&samples, &[DURATION_S])[0]
        };
        // Without noise every seed is the same flight.
        let all = if factor > 0.0 { over_seeds(seeds_run, one) } else { vec![one(0)] };
        std::array::from_fn(|quantity| Score::of(all.iter().map(|found| found[quantity]), truth[quantity]))
    });
    let scores: Vec<[Score; 5]> = scores.collect();
    let unit = bounds(&model, &deviations(&inputs()), &InstrumentSet::flight_quality(1.0), DURATION_S, RATE_HZ);
    let bounds = factors.iter().map(|factor| unit.map(|bound| factor * bound)).collect();
    let along = "noise and biases, multiples of flight-test quality";
    let points = Points { name: "noise", along, x: factors, scores, bounds, truth, seeds: seeds_run, logarithmic: false };
    points.write();
    points.judge();
    for (quantity, (name, _)) in QUANTITIES.into_iter().enumerate() {
        let at =
            |factor: f64| points.scores[factors.iter().position(|x| x.total_cmp(&factor).is_eq()).unwrap()][quantity].scatter;
        let growth = at(4.0) / at(1.0);
        assert!((2.0..8.0).contains(&growth), "{name}: four times the noise scatters {growth} times as much");
    }
}

#[test]
fn error_against_record_length() {
    let model = puma(100.0).linear().clone();
    let seeds_run = seeds(8);
    let lengths: &[f64] =
        if seeds_run > 8 { &[4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 40.0] } else { &[4.0, 10.0, 20.0, 40.0] };
    let truth = truth(&model);
    let aircraft = Flight::of(model.clone());
    let times_s: Vec<f64> = lengths.iter().map(|length| LEAD_S + length).collect();
    let last_s = times_s.last().copied().unwrap();
    let instruments = InstrumentSet::flight_quality(1.0);
    let all = over_seeds(seeds_run, |seed| at_times(&fly(&aircraft, &inputs(), &instruments, last_s, seed), &times_s));
    let scores: Vec<[Score; 5]> = (0..lengths.len())
        .map(|place| std::array::from_fn(|quantity| Score::of(all.iter().map(|one| one[place][quantity]), truth[quantity])))
        .collect();
    let controls = deviations(&inputs());
    let bounds = times_s.iter().map(|&end_s| bounds(&model, &controls, &instruments, end_s, RATE_HZ)).collect();
    let along = "record from the first input on, s";
    let points = Points { name: "length", along, x: lengths, scores, bounds, truth, seeds: seeds_run, logarithmic: true };
    points.write();
    points.judge();
    for (quantity, (name, _)) in QUANTITIES.into_iter().enumerate() {
        // The shortest record is too short for a number.
        let first = points.scores.iter().map(|scores| scores[quantity]).find(|score| score.count > 1).unwrap();
        let last = points.scores[lengths.len() - 1][quantity];
        // Roll is fast: its damping is known from the first seconds, and what is left is the state estimate's own error.
        // What curvature may hide does not shrink with the noise.
        let gain = if name == "L_p" { 1.0 } else { 0.6 };
        assert!(last.reported < gain * first.reported, "{name}: a longer record knows more");
    }
}
