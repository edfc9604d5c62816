//! Measured and simulated, channel by channel over one time, the controls above them.

use super::Compared;
use sideslip::diagnosis::free_run::{Predicted, Prediction};
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::outputs::chart::{ChartError, Curve, Panel, svg_with_marks};

/// Most points of a curve; more cannot be told apart on the page.
const MOST_POINTS: usize = 1500;

/// Every run's panels, one below the other.
///
/// # Errors
/// [`ChartError`] where a panel cannot be drawn.
pub(super) fn svg(runs: &[&Compared]) -> Result<String, ChartError> {
    let several = runs.len() > 1;
    let panels: Vec<_> = runs
        .iter()
        .flat_map(|one| panels(one, if several { format!("{}: ", one.name) } else { String::new() }))
        .map(|panel| (panel, Vec::new()))
        .collect();
    svg_with_marks(&panels)
}

fn panels(one: &Compared, before: String) -> Vec<Panel> {
    let names = one.info.geometry().controls;
    let controls: Vec<Curve> = Channel::CONTROLS
        .into_iter()
        .filter_map(|channel| {
            let points: Vec<(f64, f64)> =
                one.samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?))).collect();
            let first = points.first()?.1;
            Some(curve(channel.name(names), points.iter().map(|&(time_s, value)| (time_s, value - first)), points.len()))
        })
        .collect();
    let panel = |title: String, y: String, curves| Panel { title, x: "time, s".to_owned(), y, curves };
    let mut panels = Vec::new();
    if !controls.is_empty() {
        panels.push(panel(format!("{before}controls"), "from the first value, rad".to_owned(), controls));
    }
    for predicted in &one.model.channels {
        let (name, unit) = (predicted.channel.name(names), predicted.channel.si_unit());
        let measured_at_trim = predicted.at_trim + predicted.offset;
        let measured = predicted.times_s.iter().zip(&predicted.measured).map(|(&time_s, z)| (time_s, z - measured_at_trim));
        let mut curves = vec![curve("measured", measured, predicted.times_s.len()), simulated("model", predicted, &one.model)];
        if let Some(beside) = &one.beside
            && let Some(predicted) = beside.channels.iter().find(|other| other.channel == predicted.channel)
        {
            curves.push(simulated("model beside", predicted, beside));
        }
        panels.push(panel(format!("{before}{name}"), format!("{name}, deviation from trim, {unit}"), curves));
    }
    panels
}

/// What was predicted as a deviation from trim; where a bias is at stake, from what was measured in trim.
fn simulated(name: &str, predicted: &Predicted, of: &Prediction) -> Curve {
    let biased = of.effects.iter().any(|one| matches!(one, Effect::SensorBias { channel, .. } if *channel == predicted.channel));
    let at_trim = predicted.at_trim + if biased { predicted.offset } else { 0.0 };
    let points = predicted.times_s.iter().zip(&predicted.predicted).map(|(&time_s, y)| (time_s, y - at_trim));
    curve(name, points, predicted.times_s.len())
}

fn curve(name: &str, points: impl Iterator<Item = (f64, f64)>, count: usize) -> Curve {
    Curve { name: name.to_owned(), points: points.step_by(count.div_ceil(MOST_POINTS).max(1)).collect() }
}
