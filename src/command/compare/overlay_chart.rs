//! Measured and simulated, channel by channel over one time, the controls above them.

use crate::command::compare::comparison::ComparedRun;
use crate::command::recordings::free_run_curves::{controls, overlay};
use sideslip::io::outputs::charts::chart::{ChartError, Panel, svg_with_marks};
use sideslip::postflight::validation::free_run::FreeRunPrediction;

/// Most points of a curve; more are not resolved on the page.
const MOST_POINTS: usize = 1500;

/// Every run's panels, one below the other.
///
/// # Errors
/// [`ChartError`] where a panel cannot be drawn.
pub(super) fn svg(runs: &[&ComparedRun]) -> Result<String, ChartError> {
    let several = runs.len() > 1;
    let panels: Vec<_> = runs
        .iter()
        .flat_map(|one| panels(one, if several { format!("{}: ", one.name) } else { String::new() }))
        .map(|panel| (panel, Vec::new()))
        .collect();
    svg_with_marks(&panels)
}

fn panels(one: &ComparedRun, before: String) -> Vec<Panel> {
    let names = one.info.geometry().controls;
    let controls = controls(&one.samples, names, MOST_POINTS);
    let panel = |title: String, y: String, curves| Panel { title, x: "time, s".to_owned(), y, curves };
    let mut panels = Vec::new();
    if !controls.is_empty() {
        panels.push(panel(format!("{before}controls"), "from the first value, rad".to_owned(), controls));
    }
    let mut beside: Vec<(&str, &FreeRunPrediction)> = vec![("model", &one.model)];
    beside.extend(one.beside.as_ref().map(|other| ("model beside", other)));
    for predicted in &one.model.channels {
        let (name, unit) = (predicted.channel.name(names), predicted.channel.si_unit());
        let curves = overlay(predicted, &beside, MOST_POINTS);
        panels.push(panel(format!("{before}{name}"), format!("{name}, deviation from trim, {unit}"), curves));
    }
    panels
}
