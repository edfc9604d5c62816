//! `--response`: one equation by stepwise regression on the columns as they were recorded, every step shown.

use serde_json::{Value, json};
use sideslip::error::Failure;
use sideslip::io::outputs::number::{Fixed, Power, measured};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::postflight::equation_error::collinearity::Collinearity;
use sideslip::postflight::equation_error::design::{Bias, CandidateTerm, Design};
use sideslip::postflight::equation_error::expression::Expression;
use sideslip::postflight::equation_error::fit::TermEstimate;
use sideslip::postflight::equation_error::holdout::{EquationPrediction, predict};
use sideslip::postflight::equation_error::step::TermChange;
use sideslip::postflight::equation_error::stepwise::{RejectionReason, Selection, StepwiseRules, select};
use sideslip::postflight::equation_error::table::RegressionTable;
use sideslip::postflight::identification::columns::Columns;
use std::fmt::Write;

/// An equation that was selected.
pub(super) struct Equation {
    design: Design,
    selection: Selection,
    collinearity: Option<Collinearity>,
    /// Hold-out runs, each with what the equation predicts there; `None` of a run without a row behind its trim.
    holdout: Vec<(String, Option<EquationPrediction>)>,
}

impl Equation {
    /// Selects terms for the response over all runs, a bias each, and predicts the response in the hold-out runs.
    pub(super) fn select(
        runs: &[Columns],
        holdout: &[Columns],
        trim_window_s: f64,
        response: &str,
        candidates: &[String],
    ) -> Result<Self, Failure> {
        let wrong = |option: &str, what: &dyn std::fmt::Display| Failure::Input(format!("{option}: {what}"));
        if candidates.is_empty() {
            return Err(wrong("--response", &"expected --candidates beside it, such as alpha,q,elevator,alpha*elevator"));
        }
        let table = table_of(runs)?;
        let response = Expression::parse(response).map_err(|error| wrong("--response", &error))?;
        let candidates = candidates.iter().map(|text| CandidateTerm::offered(text)).collect::<Result<Vec<_>, _>>();
        let candidates = candidates.map_err(|error| wrong("--candidates", &error))?;
        let design = Design::new(&table, &response, &candidates, &table.whole(), Bias::EachRecord);
        let design = design.map_err(|error| wrong("--response, --candidates", &error))?;
        let rules = StepwiseRules::for_candidates(candidates.len());
        let selection = select(&design, &rules).map_err(|error| wrong("--candidates", &error))?;
        let places: Vec<usize> = selection.fit.terms.iter().map(|term| term.place).collect();
        let collinearity = Collinearity::of(&design, &places);
        let predicted = predict(&design, &selection.fit, &response, &table_of(holdout)?, trim_window_s);
        let predicted = predicted.map_err(|error| wrong("--holdout", &error))?;
        let holdout = holdout.iter().map(|run| run.run.clone()).zip(predicted).collect();
        Ok(Equation { design, selection, collinearity, holdout })
    }

    fn name(&self, place: usize) -> &str {
        self.design.names().get(place).map_or("", String::as_str)
    }

    /// For a person: every step, the equation, collinear terms, and why the other candidates did not enter.
    pub(super) fn text(&self, style: Style) -> String {
        let Selection { steps, kept, fit, rejected, collapse } = &self.selection;
        let mut text = format!("{}: stepwise regression, {} samples\n", style.bold(&fit.response), fit.quality.samples);
        let _ = writeln!(text, "  {:<4} {:<26} {:>7} {:>10} {:>11} {:>11}", "step", "", "R2", "F total", "PSE", "PRESS");
        for (count, step) in steps.iter().enumerate() {
            let what = match step.change {
                TermChange::Begun => "bias".to_owned(),
                TermChange::Entered(place) => format!("+ {}", self.name(place)),
                TermChange::Left(place) => format!("- {}", self.name(place)),
            };
            let mark = if count == *kept { "*" } else { " " };
            let q = &step.quality;
            let _ = writeln!(
                text,
                "  {count:<3}{mark} {what:<26} {:>7} {:>10} {:>11} {:>11}",
                Fixed(q.r_squared, 4),
                Fixed(q.f_total, 1),
                Power(q.pse, 4),
                Power(q.press, 4)
            );
        }
        let _ = writeln!(text, "  {:<18} {:>12} {:>10} {:>10} {:>12}", "term", "value", "s.e.", "partial F", "as in 1987");
        for TermEstimate { name, value, std, f, f_white, .. } in &fit.terms {
            let (value, std) = measured(*value, *std);
            let _ = writeln!(
                text,
                "  {:<18} {value:>12} {std:>10} {f:>10} {f_white:>12}",
                style.bold(name),
                f = Fixed(*f, 1),
                f_white = Fixed(*f_white, 1)
            );
        }
        if let Some(collapse) = collapse {
            let _ = writeln!(text, "  collapse: {collapse}");
        }
        for group in self.collinearity.iter().flat_map(|found| found.groups(&self.design)) {
            let names: Vec<&str> = group.terms.iter().map(|(name, _)| name.as_str()).collect();
            let (names, index) = (names.join(", "), group.index);
            let _ = writeln!(
                text,
                "  NOT distinguished: {names} (condition index {index}); {} would",
                group.split_by,
                index = Fixed(index, 0)
            );
        }
        let out = rejected.iter().map(|one| format!("{} ({})", self.name(one.place), reason(&one.reason)));
        let out: Vec<String> = out.collect();
        if !out.is_empty() {
            let _ = writeln!(text, "  not in: {}", out.join("; "));
        }
        for (run, predicted) in &self.holdout {
            let _ = match predicted {
                None => writeln!(text, "  {run} (predicted, not fitted): no sample behind its trim"),
                Some(EquationPrediction { samples, r_squared, rms, response_rms, theil }) => writeln!(
                    text,
                    "  {run} (predicted, not fitted): R2 {}, rms {} of {}, TIC {}, {samples} samples",
                    Fixed(*r_squared, 4),
                    Power(*rms, 3),
                    Power(*response_rms, 3),
                    Fixed(*theil, 3)
                ),
            };
        }
        text
    }

    pub(super) fn document(&self) -> Value {
        let Selection { steps, kept, fit, rejected, collapse } = &self.selection;
        let terms = |terms: &[TermEstimate]| -> Vec<Value> {
            let one = |term: &TermEstimate| {
                json!({ "name": term.name, "value": term.value, "std": term.std, "std_white": term.std_white,
                        "partial_f": term.f, "partial_f_white": term.f_white })
            };
            terms.iter().map(one).collect()
        };
        let steps = steps.iter().map(|step| {
            let change = match step.change {
                TermChange::Begun => json!({ "begun": true }),
                TermChange::Entered(place) => json!({ "entered": self.name(place) }),
                TermChange::Left(place) => json!({ "left": self.name(place) }),
            };
            let q = &step.quality;
            json!({ "change": change, "terms": terms(&step.terms), "r2": q.r_squared, "f_total": q.f_total, "pse": q.pse,
                    "press": q.press, "residual_std": q.residual_std, "collinearity": q.condition_index })
        });
        let groups = self.collinearity.iter().flat_map(|found| found.groups(&self.design)).map(|group| {
            let names: Vec<String> = group.terms.into_iter().map(|(name, _)| name).collect();
            json!({ "terms": names, "condition_index": group.index, "split_by": group.split_by })
        });
        json!({ "regression": {
            "response": fit.response,
            "steps": steps.collect::<Vec<_>>(),
            "kept": kept,
            "terms": terms(&fit.terms),
            "biases": fit.biases,
            "r2": fit.quality.r_squared,
            "f_total": fit.quality.f_total,
            "samples": fit.quality.samples,
            "collapse": collapse.as_ref().map(ToString::to_string),
            "holdout": self.holdout.iter().map(|(run, predicted)| json!({
                "run": run,
                "r2": predicted.map(|one| one.r_squared),
                "rms": predicted.map(|one| one.rms),
                "response_rms": predicted.map(|one| one.response_rms),
                "theil": predicted.map(|one| one.theil),
                "samples": predicted.map(|one| one.samples),
            })).collect::<Vec<_>>(),
            "not_told_apart": groups.collect::<Vec<_>>(),
            "not_in": rejected.iter().map(|one| json!({ "name": self.name(one.place), "reason": reason(&one.reason) })).collect::<Vec<_>>(),
        }})
    }
}

fn table_of(runs: &[Columns]) -> Result<RegressionTable, Failure> {
    let mut table = RegressionTable::new();
    for run in runs {
        let names = run.names().iter().filter_map(|name| Some((name.as_str(), run.raw(name).ok()?)));
        let columns: Vec<(&str, &[f64])> = names.collect();
        table.add_record(&run.times_s, &columns).map_err(|error| Failure::Input(format!("{}: {error}", run.run)))?;
    }
    Ok(table)
}

fn reason(reason: &RejectionReason) -> String {
    match reason {
        RejectionReason::Still => "does not move".to_owned(),
        RejectionReason::Explained(part) => format!("{} % of its variance is explained by the others", Fixed(100.0 * part, 1)),
        RejectionReason::Rise(rise) => format!("R2 would rise by {rise}", rise = Fixed(*rise, 4)),
        RejectionReason::PartialF(f) => format!("partial F {f}", f = Fixed(*f, 1)),
        RejectionReason::Predicts => "it predicts no better".to_owned(),
        RejectionReason::Left(step) => format!("left at step {step}"),
        RejectionReason::Collapse => "collapse".to_owned(),
        RejectionReason::Ended => "not tried".to_owned(),
    }
}
