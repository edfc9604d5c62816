//! Section 2.2.5 on these flights: longitudinal terms forced into the yaw and roll equations take the confidence of the primary ones.
//!
//! Smoothed signals of the pedal run as the live regression has them, the paper's structure first (v, p, r and controls), then
//! with u, w, q and the longitudinal cyclic besides: the fit does not get worse, the partial F of the primary terms falls.

use crate::flown::recorded;
use crate::paper_cases::PAPER;
use crate::program::folder;
use sideslip::estimation::config::Config;
use sideslip::estimation::estimator::Estimator;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::regression::candidate::{SIGNALS, regressor, response, signals};
use sideslip::regression::structure::candidates::default_set;
use sideslip::regression::structure::design::{Bias, Design};
use sideslip::regression::structure::expression::Expression;
use sideslip::regression::structure::fit::Fit;
use sideslip::regression::structure::stepwise::{Rules, select};
use sideslip::regression::structure::table::Table;

#[test]
fn forced_longitudinal_terms_collapse_the_confidence() {
    let folder = folder("paper-collapse");
    for case in PAPER {
        let (geometry, samples) = recorded(&folder, &case, 1);
        let mut estimator = Estimator::new(Config::default(), geometry).unwrap();
        let mut trim = None;
        let mut rows: Vec<(f64, [f64; SIGNALS])> = Vec::new();
        for sample in &samples {
            let output = estimator.step(sample);
            trim = output.trim.or(trim);
            for smoothed in &output.smoothed {
                let z = trim.as_ref().and_then(|trim| signals(smoothed, trim));
                rows.extend(z.filter(|_| smoothed.time_s > 2.0).map(|z| (smoothed.time_s, z)));
            }
        }
        let column = |place: usize| -> Vec<f64> { rows.iter().map(|(_, z)| z[place]).collect() };
        let mut columns: Vec<(&str, Vec<f64>)> =
            Variable::ALL.map(|variable| (variable.name(ControlNames::Rotorcraft), column(regressor(variable)))).to_vec();
        columns.extend([("r_dot", column(response(Axis::N))), ("p_dot", column(response(Axis::L)))]);
        let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (*name, values.as_slice())).collect();
        let mut table = Table::new();
        table.add_record(&rows.iter().map(|(time_s, _)| *time_s).collect::<Vec<_>>(), &columns).unwrap();
        for (axis, name, primary) in [
            (Axis::N, "r_dot", [Variable::V, Variable::R, Variable::Pedal]),
            (Axis::L, "p_dot", [Variable::V, Variable::P, Variable::Pedal]),
        ] {
            let candidates = default_set(axis, ControlNames::Rotorcraft, false);
            let design =
                Design::new(&table, &Expression::parse(name).unwrap(), &candidates, &table.whole(), Bias::Shared).unwrap();
            let place = |variable: Variable| {
                design.names().iter().position(|known| known == variable.name(ControlNames::Rotorcraft)).unwrap()
            };
            let small: Vec<usize> = primary.map(place).to_vec();
            let forced = [Variable::P, Variable::R, Variable::U, Variable::W, Variable::Q].map(place);
            let mut whole = small.clone();
            let colour = Rules::of_the_paper().colour;
            for place in forced.into_iter().filter(|place| !small.contains(place)) {
                // What is a combination of the others to rounding cannot even be forced in.
                let more = [whole.as_slice(), &[place]].concat();
                if Fit::of(&design, &more, colour).is_ok() {
                    whole = more;
                }
            }
            assert!(whole.len() > small.len() + 1, "{name}");
            let (before, after) = (Fit::of(&design, &small, colour).unwrap(), Fit::of(&design, &whole, colour).unwrap());
            assert!(after.quality.r_squared >= before.quality.r_squared);
            let f = |of: &Fit, variable: Variable| {
                let name = variable.name(ControlNames::Rotorcraft);
                of.terms.iter().find(|term| term.name == name).map(|term| (term.f_white, term.f)).unwrap()
            };
            for variable in primary {
                let ((white, own), (white_after, after)) = (f(&before, variable), f(&after, variable));
                eprintln!(
                    "{} {name} {variable:?}: F {white:.0}/{own:.0}, with longitudinal terms {white_after:.0}/{after:.0}",
                    case.name
                );
                assert!(white_after < white, "{name} {variable:?}");
            }
            let explored = select(&design, &Rules::of_the_paper()).unwrap();
            eprintln!(
                "{} {name}: kept {} of {} steps; {:?}",
                case.name,
                explored.kept,
                explored.steps.len() - 1,
                explored.collapse
            );
        }
    }
}
