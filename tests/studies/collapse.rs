//! The collapse, as the structure stage tells it: Level-1 Puma at 80 kn, a pedal doublet, whole record and free response.
//!
//! The smoothed signals that the live regression takes one by one stand here as a table; the paper's rules are let run on, so
//! that every step is there to be drawn, and the model kept is the one before the collapse. By its own rules the stage ends
//! earlier and has no collapse to tell.

use super::flown::{fly, puma};
use crate::support::equation::{linear_candidates, rules_of_the_paper};
use crate::support::manoeuvre::LEAD_S;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::postflight::equation_error::collinearity::Collinearity;
use sideslip::postflight::equation_error::design::{Bias, Design};
use sideslip::postflight::equation_error::expression::Expression;
use sideslip::postflight::equation_error::stepwise::{Selection, StepwiseRules, select};
use sideslip::postflight::equation_error::table::RegressionTable;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::regression::candidate::{SIGNALS, regressor, response, signals};
use sideslip::simulation::instrument::InstrumentSet;

/// Smoothed signals of a flight from its input on.
fn table(samples: &[Sample]) -> RegressionTable {
    let mut estimator = Estimator::new(EstimationConfig::default(), RunGeometry::default()).unwrap();
    let mut trim = None;
    let mut rows: Vec<(f64, [f64; SIGNALS])> = Vec::new();
    for sample in samples {
        let output = estimator.step(sample);
        trim = output.trim.or(trim);
        for smoothed in &output.smoothed {
            let z = trim.as_ref().and_then(|trim| signals(smoothed, trim));
            rows.extend(z.filter(|_| smoothed.time_s > LEAD_S).map(|z| (smoothed.time_s, z)));
        }
    }
    let column = |place: usize| -> Vec<f64> { rows.iter().map(|(_, z)| z[place]).collect() };
    let mut columns: Vec<(&str, Vec<f64>)> =
        Variable::ALL.map(|variable| (variable.name(ControlNames::Rotorcraft), column(regressor(variable)))).to_vec();
    columns.push(("r_dot", column(response(Axis::N))));
    let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (*name, values.as_slice())).collect();
    let time_s: Vec<f64> = rows.iter().map(|(time_s, _)| *time_s).collect();
    let mut table = RegressionTable::new();
    table.add_record(&time_s, &columns).unwrap();
    table
}

fn told(name: &str, selection: &Selection) {
    eprintln!("{name}: kept step {} of {}", selection.kept, selection.steps.len() - 1);
    for step in &selection.steps {
        let terms: Vec<String> = step
            .terms
            .iter()
            .map(|term| format!("{} {:+.4} +- {:.4} F {:.0}/{:.0}", term.name, term.value, term.std, term.f_white, term.f))
            .collect();
        let quality = &step.quality;
        eprintln!(
            "  R2 {:.6} index {:5.1} PRESS {:.2e}; {}",
            quality.r_squared,
            quality.condition_index,
            quality.press,
            terms.join(", ")
        );
    }
    if let Some(collapse) = &selection.collapse {
        eprintln!("  {collapse}");
    }
}

#[test]
fn the_model_stops_before_the_collapse() {
    let model = puma(80.0);
    let truth = |variable| model.linear().derivative(Axis::N, variable);
    for (name, factor) in [("noise-free", 0.0), ("flight noise", 1.0)] {
        let instruments = InstrumentSet::flight_quality(factor);
        let samples = fly(&model.flight(), &["pedal:doublet:0.0175:1".to_owned()], &instruments, LEAD_S + 12.0, 1);
        let table = table(&samples);
        let candidates = linear_candidates(Axis::N);
        let of =
            |mask: &[bool]| Design::new(&table, &Expression::parse("r_dot").unwrap(), &candidates, mask, Bias::Shared).unwrap();
        let whole = of(&table.whole());
        let explored = select(&whole, &rules_of_the_paper()).unwrap();
        told(name, &explored);
        let collapse = explored.collapse.as_ref().unwrap();
        let last = explored.steps.last().unwrap();
        assert!(last.quality.r_squared > explored.fit.quality.r_squared, "the fit still improves");
        assert!(explored.kept + 1 < explored.steps.len() && explored.fit.term("p").is_none(), "{collapse}");
        // What is kept is nearer to the truth than what the last step has.
        let off = |terms: &[sideslip::postflight::equation_error::fit::TermEstimate], variable: Variable| {
            let found = terms.iter().find(|term| term.name == variable.name(ControlNames::Rotorcraft)).unwrap();
            (found.value - truth(variable)).abs()
        };
        assert!(off(&explored.fit.terms, Variable::R) < off(&last.terms, Variable::R), "N_r");
        let own = select(&whole, &StepwiseRules::for_candidates(candidates.len())).unwrap();
        told("  by its own rules", &own);
        assert!(own.fit.terms.iter().all(|term| term.f > 12.0));
        // In the free response p, r and v keep one ratio and phase; the controls do not move and are said so.
        let free = of(&table.still(&[("pedal", 1e-4)]).unwrap());
        let still: Vec<usize> = free.still().collect();
        let motion = [Variable::V, Variable::P, Variable::R, Variable::W, Variable::U].map(Variable::index);
        let moving: Vec<usize> = motion.into_iter().filter(|place| !still.contains(place)).collect();
        let groups = Collinearity::of(&free, &moving).unwrap().groups(&free);
        eprintln!("  free response, {} rows: {groups:?}", free.rows().len());
        let names = |name: &str| groups.iter().any(|group| group.terms.iter().any(|(term, _)| term == name));
        assert!(names("v") && names("p") && names("r"), "{groups:?}");
    }
}
