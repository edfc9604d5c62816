//! Every run, measured and flown free by both models, in the channels that matter, the controls that moved beneath.

use crate::command::diagnose::answer::{Answer, Flights};
use crate::command::diagnose::page::parts::plot;
use crate::command::recordings::free_run_curves::{controls, overlay};
use sideslip::error::Failure;
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::io::outputs::charts::chart::{Curve, Figure, Panel};
use sideslip::io::outputs::html::page::escaped;
use sideslip::postflight::diagnosis::evidence::regressor_plot::Ordinate;
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::postflight::validation::free_run::{FreeRunPrediction, ValidationRun, predict};
use std::fmt::Write;

const CHANNELS: usize = 4;
const MOST_POINTS: usize = 350;
/// A predicted curve is drawn up to so many times the largest deviation that was measured.
const BEYOND: f64 = 3.0;
/// A control moves that goes so far of what the farthest does.
const MOVES: f64 = 0.2;

/// A run with both predictions.
struct Shown<'r> {
    run: &'r RecordedRun,
    how: &'static str,
    before: FreeRunPrediction,
    after: FreeRunPrediction,
}

pub(super) fn section(page: &mut String, answer: &Answer, flights: &Flights<'_>) -> Result<(), Failure> {
    let mut shown = Vec::new();
    let own = answer.model.file.own_effects();
    let found: Vec<Effect> = answer.diagnosis.findings.iter().map(|finding| finding.cause.effect).collect();
    let all: Vec<Effect> = own.iter().chain(&found).copied().collect();
    let set_aside = |run: &&RecordedRun| !answer.diagnosis.set_aside.iter().any(|(name, _)| *name == run.name);
    let mut not_flown = Vec::new();
    let fitted = flights.fit.iter().filter(set_aside).map(|run| (run, "fitted"));
    for (run, how) in fitted.chain(flights.holdout.iter().map(|run| (run, "hold-out"))) {
        let flown = ValidationRun::of(&run.samples, &run.geometry);
        match (predict(&answer.model, &own, &flown), predict(&answer.model, &all, &flown)) {
            (Ok(before), Ok(after)) => shown.push(Shown { run, how, before, after }),
            (Err(why), _) | (_, Err(why)) => not_flown.push((run, why)),
        }
    }
    let channels = channels(answer, &shown, !found.is_empty());
    page.push_str(
        "<h2>Flight and simulation</h2>\n<p class=\"faint\">Free runs: the model starts in its trim and flies the measured \
         controls; nothing is fitted to the run. Deviations from the run's own trim; points are means of the samples around \
         them, and a curve ends where it exceeds the measured range several times.</p>\n<div class=\"side runs\">\n",
    );
    for one in &shown {
        let _ = writeln!(page, "<section aria-label=\"{0} ({1})\"><h3>{0} ({1})</h3>", escaped(&one.run.name), one.how);
        for panel in panels(answer, one, &channels, !found.is_empty()) {
            plot(page, &panel, &[], &Figure { size: (560, 180), ..Figure::OF_A_PAGE })
                .map_err(|error| Failure::Running(error.to_string()))?;
        }
        page.push_str("</section>\n");
    }
    page.push_str("</div>\n");
    for (run, why) in not_flown {
        let _ = writeln!(page, "<p>{} has no free run: {}.</p>", escaped(&run.name), escaped(&why.to_string()));
    }
    Ok(())
}

/// The channels in which both models differ most, over noise; where there is but one, in which it is farthest off.
fn channels(answer: &Answer, shown: &[Shown<'_>], extended: bool) -> Vec<Channel> {
    let mut scores: Vec<(Channel, f64)> = Vec::new();
    for one in shown {
        for before in &one.before.channels {
            let Some(after) = one.after.channels.iter().find(|after| after.channel == before.channel) else { continue };
            // The errors of these grow with time, whatever is wrong.
            if matches!(before.channel, Channel::Altitude | Channel::Tas | Channel::Psi) || !(before.noise_std > 0.0) {
                continue;
            }
            let pairs = before.errors(false).zip(after.errors(false));
            let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), (before, after)| {
                let by = if extended { before - after } else { before };
                (sum + by * by, count + 1.0)
            });
            let score = sum / f64::max(count, 1.0) / (before.noise_std * before.noise_std);
            match scores.iter_mut().find(|(channel, _)| *channel == before.channel) {
                Some((_, sum)) => *sum += score,
                None => scores.push((before.channel, score)),
            }
        }
    }
    scores.sort_by(|a, b| b.1.total_cmp(&a.1));
    // What an instrument gets wrong is shown on what it reads, however small it is there.
    let own = answer.diagnosis.findings.iter().filter_map(|finding| match finding.regressor_plot.as_ref()?.ordinate {
        Ordinate::Channel(channel) => Some(channel),
        Ordinate::Axis(_) => None,
    });
    let mut channels: Vec<Channel> = Vec::new();
    for channel in own.chain(scores.into_iter().map(|(channel, _)| channel)) {
        if channels.len() < CHANNELS && !channels.contains(&channel) {
            channels.push(channel);
        }
    }
    channels.sort_by_key(|channel| channel.index());
    channels
}

fn panels(answer: &Answer, one: &Shown<'_>, channels: &[Channel], extended: bool) -> Vec<Panel> {
    let names = one.run.geometry.controls;
    let mut predictions: Vec<(&str, &FreeRunPrediction)> = vec![("model as given", &one.before)];
    if extended {
        predictions.push((if answer.extension.is_empty() { "with the causes" } else { "model extended" }, &one.after));
    }
    let panel = |title: &str, y: String, curves| Panel { title: title.to_owned(), x: "time, s".to_owned(), y, curves };
    let mut panels = Vec::new();
    for measured in channels.iter().filter_map(|channel| one.before.channels.iter().find(|own| own.channel == *channel)) {
        let (name, unit) = (measured.channel.name(names), measured.channel.si_unit());
        panels.push(panel(name, format!("{name}, {unit}"), within(overlay(measured, &predictions, MOST_POINTS))));
    }
    let controls = controls(&one.run.samples, names, MOST_POINTS);
    let goes = |curve: &Curve| {
        let ends = curve.points.iter().fold((0.0, 0.0), |(low, high), (_, y)| (f64::min(low, *y), f64::max(high, *y)));
        ends.1 - ends.0
    };
    let farthest = controls.iter().map(goes).fold(0.0, f64::max);
    let moved: Vec<Curve> = controls.into_iter().filter(|curve| goes(curve) >= MOVES * farthest).collect();
    if !moved.is_empty() {
        panels.push(panel("controls that moved", "from start, rad".to_owned(), moved));
    }
    panels
}

/// Ends predicted curves where they go beyond [`BEYOND`] of what was measured, the first of them.
fn within(mut curves: Vec<Curve>) -> Vec<Curve> {
    let Some((measured, predicted)) = curves.split_first_mut() else { return curves };
    let most = BEYOND * measured.points.iter().map(|(_, y)| libm::fabs(*y)).fold(1e-6, f64::max);
    for curve in predicted {
        let until = curve.points.iter().position(|(_, y)| !(libm::fabs(*y) <= most)).unwrap_or(curve.points.len());
        curve.points.truncate(until);
    }
    curves
}
