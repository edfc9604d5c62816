//! Twin Otter, elevator input: the published stepwise regression of the pitching moment and of the vertical force.

use crate::support::program::real;
use sideslip::flight::file::run_file::RecordingTarget;
use sideslip::io::telemetry::csv::CsvRecording;
use sideslip::io::telemetry::record::RecordingRow;
use sideslip::postflight::equation_error::design::{Bias, CandidateTerm, Design};
use sideslip::postflight::equation_error::expression::Expression;
use sideslip::postflight::equation_error::stepwise::{Selection, StepwiseRules, select};
use sideslip::postflight::equation_error::subset::best_subsets;
use sideslip::postflight::equation_error::table::RegressionTable;

const CANDIDATES: [&str; 11] = [
    "alpha",
    "qhat",
    "elevator",
    "alpha*elevator",
    "alpha^2",
    "alpha*qhat",
    "elevator^2",
    "qhat*elevator",
    "qhat^2",
    "alpha^3",
    "alpha*qhat*elevator",
];

/// Every column of a recording, known ones in SI and the others as they came.
fn table(path: &std::path::Path) -> RegressionTable {
    let mut recording = CsvRecording::new(path, Box::new(std::fs::File::open(path).unwrap())).unwrap();
    let columns = recording.columns().to_vec();
    let mut time_s = Vec::new();
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
    while let Some(RecordingRow { sample, others, .. }) = recording.next_row().unwrap() {
        time_s.push(sample.time_s);
        let mut others = others.iter();
        for (column, values) in columns.iter().zip(&mut values) {
            values.push(match column.target {
                RecordingTarget::Time { .. } => sample.time_s,
                RecordingTarget::Known { channel, .. } => sample.get(channel).unwrap_or(f64::NAN),
                RecordingTarget::Other => others.next().copied().flatten().unwrap_or(f64::NAN),
            });
        }
    }
    let named: Vec<(&str, &[f64])> = columns
        .iter()
        .zip(&values)
        .filter(|(column, _)| !matches!(column.target, RecordingTarget::Time { .. }))
        .map(|(column, values)| (column.name.as_str(), values.as_slice()))
        .collect();
    let mut table = RegressionTable::new();
    table.add_record(&time_s, &named).unwrap();
    table
}

fn design(table: &RegressionTable, response: &str) -> Design {
    let candidates: Vec<CandidateTerm> = CANDIDATES.iter().map(|name| CandidateTerm::offered(name).unwrap()).collect();
    Design::new(table, &Expression::parse(response).unwrap(), &candidates, &table.whole(), Bias::Shared).unwrap()
}

fn agree(selection: &Selection, published: [f64; 3]) {
    let mut names: Vec<&str> = selection.fit.terms.iter().map(|term| term.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["alpha", "elevator", "qhat"]);
    for (name, published) in ["alpha", "qhat", "elevator"].into_iter().zip(published) {
        let term = selection.fit.term(name).unwrap();
        eprintln!(
            "{}_{name} {:.5} +- {:.5} ({:.5} white), published {published}",
            selection.fit.response, term.value, term.std, term.std_white
        );
        assert!((term.value / published - 1.0).abs() < 0.002, "{name}: {} {published}", term.value);
    }
}

#[test]
fn the_published_terms_are_selected_and_no_other() {
    let Some(flight) = real("twin-otter-020213f1_018.csv") else { return };
    let table = table(&flight);
    let rules = StepwiseRules::for_candidates(CANDIDATES.len());
    let moment = select(&design(&table, "Cm"), &rules).unwrap();
    agree(&moment, [-1.47617, -36.3533, -1.86877]);
    // The published standard errors are for coloured residuals too, .0224 .689 .0204.
    for (name, published) in [("alpha", 0.0224), ("qhat", 0.689), ("elevator", 0.0204)] {
        let std = moment.fit.term(name).unwrap().std;
        assert!((std / published - 1.0).abs() < 0.2, "{name}: {std} {published}");
    }
    assert!(moment.collapse.is_none());
    let force = select(&design(&table, "CZ"), &rules).unwrap();
    agree(&force, [-6.349, -18.41, -0.626]);
}

#[test]
fn the_best_three_terms_of_all_subsets_are_those() {
    let Some(flight) = real("twin-otter-020213f1_018.csv") else { return };
    let table = table(&flight);
    for response in ["Cm", "CZ"] {
        let found = best_subsets(&design(&table, response)).unwrap();
        assert_eq!(found.subsets[3].places, [0, 1, 2]);
        assert_eq!(found.smallest_pse().unwrap().places, [0, 1, 2]);
    }
}

#[test]
fn what_is_not_there_is_named() {
    let Some(flight) = real("twin-otter-020213f1_018.csv") else { return };
    let table = table(&flight);
    let candidates = [CandidateTerm::offered("alpha*nothing").unwrap()];
    let error = Design::new(&table, &Expression::parse("Cm").unwrap(), &candidates, &table.whole(), Bias::Shared).unwrap_err();
    let said = error.to_string();
    assert!(said.starts_with("term \"alpha*nothing\": no column `nothing`; the table has") && said.contains(" CZ"), "{said}");
}
