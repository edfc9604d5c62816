//! The page for a sceptic: the answer, the evidence for it, every run beside both models, the gain, what the data cannot tell.
//!
//! Consumes the answer and the runs; produces one page of `outputs::page` without scripts, fonts or network. Names come from
//! files and are made safe wherever they stand.

mod answer;
mod causes;
mod flights;
mod gained;
mod residuals;

use crate::command::diagnose::{Answer, Flights};
use sideslip::error::Failure;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::io::outputs::charts::chart::{ChartError, Curve, Figure, Marks, Panel, figure};
use sideslip::io::outputs::html::page::{FOOT, escaped, head};
use std::fmt::Write;

/// The page.
pub(super) fn text(answer: &Answer, flights: &Flights<'_>) -> Result<String, Failure> {
    let drawn = |error: ChartError| Failure::Running(error.to_string());
    let name = format!("Diagnosis of {}", answer.model.file.name);
    let mut page = head(&name);
    let _ = writeln!(page, "<h1>{}</h1>", escaped(&name));
    let names = |runs: &[sideslip::postflight::diagnosis::data::run::RecordedRun]| {
        runs.iter().map(|run| escaped(&run.name)).collect::<Vec<_>>().join(", ")
    };
    let kept = if flights.holdout.is_empty() { "none".to_owned() } else { names(flights.holdout) };
    let _ = writeln!(page, "<p class=\"faint\">Runs looked at: {}. Runs kept back: {kept}.</p>", names(flights.fit));
    answer::section(&mut page, answer);
    causes::section(&mut page, answer).map_err(drawn)?;
    flights::section(&mut page, answer, flights)?;
    residuals::section(&mut page, answer).map_err(drawn)?;
    gained::section(&mut page, answer, flights).map_err(drawn)?;
    answer::limits(&mut page, answer, flights);
    page.push_str(FOOT);
    Ok(page)
}

/// Text for the page, plus and minus as one sign.
fn words(text: &str) -> String {
    escaped(&text.replace("+-", "\u{b1}"))
}

/// A figure of curves and marks on the page.
fn plot(page: &mut String, panel: &Panel, marks: &[Marks], look: &Figure) -> Result<(), ChartError> {
    page.push_str(&figure(panel, marks, look)?);
    page.push('\n');
    Ok(())
}

fn curve(name: impl Into<String>, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: name.into(), points }
}

/// Unit of an axis's force or moment.
fn axis_unit(axis: Axis) -> &'static str {
    if axis.is_force() { "m/s^2" } else { "rad/s^2" }
}

fn variable_unit(variable: Variable) -> &'static str {
    match variable {
        Variable::U | Variable::V | Variable::W => "m/s",
        Variable::P | Variable::Q | Variable::R => "rad/s",
        _ => "rad",
    }
}

/// The axes that the answer is about, or where nothing is found the one whose residual stands highest over its noise.
fn axes_at_stake(answer: &Answer) -> Vec<Axis> {
    let diagnosis = &answer.diagnosis;
    let of_cause = diagnosis.findings.iter().filter_map(|finding| match finding.regressor_plot.as_ref()?.ordinate {
        sideslip::postflight::diagnosis::evidence::regressor_plot::Ordinate::Axis(axis) => Some(axis),
        sideslip::postflight::diagnosis::evidence::regressor_plot::Ordinate::Channel(_) => {
            sideslip::postflight::diagnosis::search::score_test::acts_on(&finding.cause.effect)
        }
    });
    let mut axes: Vec<Axis> = diagnosis.unknown.iter().map(|unknown| unknown.axis).chain(of_cause).collect();
    let over_noise = |axis: &Axis| {
        let own = diagnosis.discrepancy.iter().find(|one| one.axis == *axis);
        own.map_or(0.0, |one| one.rms / one.noise.max(1e-12))
    };
    if axes.is_empty() {
        axes.extend(Axis::ALL.into_iter().max_by(|a, b| over_noise(a).total_cmp(&over_noise(b))));
    }
    let mut once: Vec<Axis> = Vec::new();
    axes.into_iter().for_each(|axis| {
        if !once.contains(&axis) {
            once.push(axis);
        }
    });
    once
}
