//! What forcing longitudinal terms into the yawing equation does to the partial F of the lateral ones, on the paper's flights.
//!
//! The paper saw the partial F of v, p, r and the pedal fall as alpha, q and theta entered while the fit still improved. Here
//! those three are put in whatever their F: in flights of the paper's lateral models, whose longitudinal axes are not coupled to
//! them, and of the Level-1 Puma trimmed on the same path, whose are. In the first q hardly moves, and the partial F of v, p, r
//! fall by a third while R2 rises: the beginning of it, no collapse. In the second one of them falls by 8 to 28.

use crate::support::manoeuvre::LEAD_S;
use crate::support::paper_cases::PAPER;
use sideslip::flight::channel::Channel;
use sideslip::flight::run::RunGeometry;
use sideslip::postflight::equation_error::coloured_errors::ErrorModelOrder;
use sideslip::postflight::equation_error::design::{Bias, CandidateTerm, Design};
use sideslip::postflight::equation_error::expression::Expression;
use sideslip::postflight::equation_error::fit::EquationFit;
use sideslip::postflight::equation_error::table::RegressionTable;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::simulation::fly::{Flight, Inputs, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;

const LATERAL: [&str; 4] = ["v", "p", "r", "pedal"];
/// Names of their own: `q` that moves by less than counts as excitation would be refused.
const FORCED: [&str; 3] = ["incidence", "pitch_rate", "pitch"];
/// A fall that is a collapse (`regression::structure::collapse`).
const COLLAPSED: f64 = 4.0;
const RATE_HZ: f64 = 100.0;
const AFTER_S: f64 = 10.0;

/// The flight with a pedal doublet, as the live regression has it smoothed, from the input on.
fn table(mut flight: Flight, seed: u64) -> RegressionTable {
    let spec = InputSpec::parse("pedal:doublet:0.0175:1").unwrap();
    let mut inputs = Inputs::at_trim(&flight.model);
    let place = Channel::CONTROLS.iter().position(|&control| control == spec.channel).unwrap();
    inputs.controls[place] = inputs.controls[place].plus(1.0, &spec.deviation(LEAD_S));
    let times_s = uniform_times(0.0, LEAD_S + AFTER_S, RATE_HZ).unwrap();
    flight =
        Flight { inputs: inputs.sampled(&times_s), times_s, seed, instruments: InstrumentSet::flight_quality(1.0), ..flight };
    let mut estimator = Estimator::new(EstimationConfig::default(), RunGeometry::default()).unwrap();
    let mut rows: Vec<(f64, [f64; 8])> = Vec::new();
    for sample in &flight.fly().unwrap().samples {
        for smoothed in estimator.step(sample).smoothed.iter().filter(|smoothed| smoothed.time_s > LEAD_S) {
            let ([u, v, w], [p, q, r], [_, theta]) = (smoothed.velocity, smoothed.rates, smoothed.attitude);
            let row = [v, p, r, smoothed.controls[3], w.atan2(u), q, theta, smoothed.angular_acceleration[2]];
            rows.push((smoothed.time_s, row));
        }
    }
    let names = LATERAL.iter().chain(&FORCED).chain(&["r_dot"]);
    let columns: Vec<(&str, Vec<f64>)> =
        names.enumerate().map(|(place, name)| (*name, rows.iter().map(|(_, row)| row[place]).collect())).collect();
    let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (*name, values.as_slice())).collect();
    let time_s: Vec<f64> = rows.iter().map(|(time_s, _)| *time_s).collect();
    let mut table = RegressionTable::new();
    table.add_record(&time_s, &columns).unwrap();
    table
}

/// R2 before and after, and by lateral term the partial F for white residuals and for coloured ones, before over after.
fn forced(table: &RegressionTable, who: &str) -> ([f64; 2], Vec<[f64; 2]>) {
    let candidates: Vec<CandidateTerm> =
        LATERAL.iter().chain(&FORCED).map(|name| CandidateTerm::offered(name).unwrap()).collect();
    let response = Expression::parse("r_dot").unwrap();
    let design = Design::new(table, &response, &candidates, &table.whole(), Bias::Shared).unwrap();
    let of = |count: usize| EquationFit::of(&design, &(0..count).collect::<Vec<_>>(), ErrorModelOrder::default()).unwrap();
    let (before, after) = (of(LATERAL.len()), of(LATERAL.len() + FORCED.len()));
    let falls = LATERAL.map(|name| {
        let (one, other) = (before.term(name).unwrap(), after.term(name).unwrap());
        eprintln!(
            "{who} {name:6} F {:9.0} to {:9.0} ({:7.0} to {:7.0} coloured), value {:8.4} to {:8.4}",
            one.f_white, other.f_white, one.f, other.f, one.value, other.value
        );
        [one.f_white / other.f_white, one.f / other.f]
    });
    let r_squared = [before.quality.r_squared, after.quality.r_squared];
    let index = [before.quality.condition_index, after.quality.condition_index];
    eprintln!("{who} R2 {r_squared:.6?}, condition index {index:.1?}, partial F falls by {falls:.2?} (white, coloured)");
    (r_squared, falls.to_vec())
}

#[test]
fn longitudinal_terms_that_are_forced_in_take_the_partial_f_of_the_lateral_ones() {
    for case in PAPER {
        let of_paper = forced(&table(Flight::of(case.model()), 1), &format!("{}, the paper's model:", case.name));
        let coupled = forced(&table(case.simulation().flight(), 1), &format!("{}, Level 1:", case.name));
        for (r_squared, _) in [&of_paper, &coupled] {
            assert!(r_squared[1] > r_squared[0], "the fit improves");
        }
        // Of v, p, r, white as in the paper.
        let white = |falls: &[[f64; 2]]| falls.iter().take(3).map(|fall| fall[0]).collect::<Vec<_>>();
        let (mild, deep) = (white(of_paper.1.as_slice()), white(coupled.1.as_slice()));
        assert!(mild.iter().all(|fall| (1.2..2.5).contains(fall)), "{mild:?}");
        assert!(deep.iter().copied().fold(0.0, f64::max) > COLLAPSED, "{deep:?}");
    }
}
