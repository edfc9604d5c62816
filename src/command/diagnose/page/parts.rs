//! Parts of the page that several sections have: text, figures, units, and the axes that they are about.

use crate::command::diagnose::answer::Answer;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::io::outputs::charts::chart::{ChartError, Curve, Figure, Marks, Panel, figure};

/// A figure of curves and marks on the page.
pub(super) fn plot(page: &mut String, panel: &Panel, marks: &[Marks], layout: &Figure) -> Result<(), ChartError> {
    page.push_str(&figure(panel, marks, layout)?);
    page.push('\n');
    Ok(())
}

pub(super) fn curve(name: impl Into<String>, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: name.into(), points }
}

/// Unit of an axis's force or moment.
pub(super) fn axis_unit(axis: Axis) -> &'static str {
    if axis.is_force() { "m/s^2" } else { "rad/s^2" }
}

pub(super) fn variable_unit(variable: Variable) -> &'static str {
    match variable {
        Variable::U | Variable::V | Variable::W => "m/s",
        Variable::P | Variable::Q | Variable::R => "rad/s",
        _ => "rad",
    }
}

/// The axes that the answer is about, or where nothing is found the one whose residual stands highest over its noise.
pub(super) fn axes_at_stake(answer: &Answer) -> Vec<Axis> {
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
