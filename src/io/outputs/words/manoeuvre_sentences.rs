//! The preliminary interpretation in words: one sentence for each result that matters.

use crate::flight::channel::{Channel, ControlNames};
use crate::io::outputs::number::short_measured_text;
use crate::postflight::manoeuvres::record::{
    Coupling, FreeOscillation, Interpretation, Linearity, Manoeuvre, Measured, NotEstimable, Plane, RUNS_A_POINT, Response,
    ResponseLine, RunInterpretation, TestPoint, on_axis,
};

/// Off-axis over on-axis response that is worth a sentence.
const STRONG: f64 = 0.3;
/// Motion of the control meanwhile, of its travel, that is worth a word.
const RESTLESS: f64 = 0.03;
/// Scatter between runs that is worth a word, of the response.
const SCATTERED: f64 = 0.1;

/// A manoeuvre in words: `pedal 3211 of +0.0200 rad at 2.0 s`.
pub fn manoeuvre_words(manoeuvre: &Manoeuvre, controls: ControlNames) -> String {
    let name = manoeuvre.control.name(controls);
    format!("{name} {} of {:+.4} rad at {:.1} s", manoeuvre.shape, manoeuvre.amplitude, manoeuvre.start_s)
}

/// Two numbers that differ by more than three of their errors and by that part.
fn differ(a: Measured, b: Measured, part: f64) -> bool {
    let std = libm::sqrt(a.std * a.std + b.std * b.std);
    (a.value - b.value).abs() > 3.0 * std && (a.value - b.value).abs() > part
}

/// Sentences of one run.
pub fn of_run(run: &RunInterpretation) -> Vec<String> {
    if let Some(nothing) = &run.nothing {
        return vec![format!("No manoeuvre: {nothing}.")];
    }
    run.manoeuvres.iter().flat_map(|manoeuvre| of_manoeuvre(manoeuvre, run.controls)).collect()
}

fn of_manoeuvre(manoeuvre: &Manoeuvre, controls: ControlNames) -> Vec<String> {
    let what = manoeuvre_words(manoeuvre, controls);
    let mut said = Vec::new();
    match &manoeuvre.trim {
        Ok(trim) if !trim.unsteady.is_empty() => {
            said.push(format!("Trim before {what} is not steady: {}.", trim.unsteady.join(", ")))
        }
        Ok(_) => {}
        Err(reason) => said.push(format!("Trim before {what}: {reason}.")),
    }
    if !manoeuvre.others.is_empty() {
        let others = manoeuvre.others.iter().map(|(control, travel)| format!("{} by {travel:.4} rad", control.name(controls)));
        said.push(format!("During {what} other controls move too: {}.", others.collect::<Vec<_>>().join(", ")));
    }
    match &manoeuvre.oscillation {
        Ok(found) => said.extend(of_oscillation(found, &what, manoeuvre, controls)),
        Err(NotEstimable::StillMoves(control, longest_s)) => said.push(format!(
            "No damping and frequency after {what}: {} still moves (still for {longest_s:.1} s at most).",
            control.name(controls)
        )),
        Err(reason) => said.push(format!("No damping and frequency after {what}: {reason}.")),
    }
    if let Ok(couplings) = &manoeuvre.couplings {
        let strong: Vec<String> = couplings
            .iter()
            .filter(|one| one.significant && one.ratio.value > STRONG)
            .map(|one| coupling_words(one, controls))
            .collect();
        if !strong.is_empty() {
            let on = on_axis(manoeuvre.control).name(controls);
            said.push(format!("Strong coupling to {what}: {} as {on}.", strong.join(" and ")));
        }
    }
    said
}

fn coupling_words(coupling: &Coupling, controls: ControlNames) -> String {
    format!("{} responds {} times as much", coupling.channel.name(controls), short_measured_text(coupling.ratio))
}

fn of_oscillation(found: &FreeOscillation, what: &str, manoeuvre: &Manoeuvre, controls: ControlNames) -> Vec<String> {
    let plane = Plane::of(manoeuvre.control).word();
    let (omega, zeta) = (found.omega, found.zeta);
    let mut said = vec![format!(
        "After {what} the {plane} oscillation has omega {} rad/s, zeta {} (free from {:.1} s, {:.1} cycles seen).",
        short_measured_text(omega),
        short_measured_text(zeta),
        found.from_s,
        found.cycles
    )];
    if zeta.value + 3.0 * zeta.std < 0.0 {
        said.push(format!("The {plane} oscillation after {what} grows."));
    }
    if let Some((from_s, early)) = found.earlier {
        said.push(format!(
            "A start at {from_s:.1} s gives zeta {:.3} +- {:.3}: from {:.1} s on it no longer changes.",
            early.value, early.std, found.from_s
        ));
    }
    if let Some((_, by_peaks)) = found.decrement
        && differ(by_peaks, zeta, 0.02)
    {
        said.push(format!(
            "The logarithmic decrement gives zeta {:.3} +- {:.3} there: the decay is not that of one damped sine.",
            by_peaks.value, by_peaks.std
        ));
    }
    if found.control_motion > RESTLESS {
        said.push(format!(
            "Meanwhile {} moves by {:.1} % of its travel in the manoeuvre.",
            manoeuvre.control.name(controls),
            100.0 * found.control_motion
        ));
    }
    said
}

/// Sentences over runs.
pub fn of_all(all: &Interpretation) -> Vec<String> {
    let controls = all.runs.first().map_or(ControlNames::default(), |run| run.controls);
    let mut said: Vec<String> = all.points.iter().flat_map(|point| of_point(point, controls)).collect();
    let complete = all.points.iter().filter(|point| point.members.len() >= RUNS_A_POINT).count();
    if complete < all.points.len() {
        let points = all.points.len();
        said.push(format!("{complete} of {points} test points have the {RUNS_A_POINT} runs required."));
    }
    said.extend(all.linearity.iter().filter_map(|one| of_line(one, controls)));
    said
}

/// A test point in words: `pedal 3211 of 0.020 rad at 51.3 m/s`.
pub fn point_words(point: &TestPoint, controls: ControlNames) -> String {
    let speed = point.tas.map_or(String::new(), |tas| format!(" at {tas:.1} m/s"));
    let climb =
        point.climb.filter(|climb| climb.abs() > 1.0).map_or(String::new(), |climb| format!(", climbing {climb:+.1} m/s"));
    format!("{} {} of {:.4} rad{speed}{climb}", point.control.name(controls), point.shape, point.amplitude)
}

fn of_point(point: &TestPoint, controls: ControlNames) -> Vec<String> {
    let what = point_words(point, controls);
    let runs = point.members.len();
    let mut said = Vec::new();
    if let Ok(scatter) = &point.scatter
        && let Some(on) = scatter.iter().find(|one| one.channel == on_axis(point.control))
    {
        let judged = if on.scatter.value < 1.5 * on.noise { ", no more than noise" } else { "" };
        said.push(format!(
            "{what}: {runs} runs repeat within {:.1} % in {} (noise alone {:.1} %{judged}).",
            100.0 * on.scatter.value,
            on.channel.name(controls),
            100.0 * on.noise
        ));
        let bad = |channel: Channel| channel != on.channel;
        let wide: Vec<String> = scatter
            .iter()
            .filter(|one| bad(one.channel) && one.scatter.value > SCATTERED.max(3.0 * one.noise))
            .map(|one| format!("{} {:.0} %", one.channel.name(controls), 100.0 * one.scatter.value))
            .collect();
        if !wide.is_empty() {
            said.push(format!("{what}: less repeatable in {}.", wide.join(", ")));
        }
    }
    said
}

fn of_line(one: &Linearity, controls: ControlNames) -> Option<String> {
    let Ok(line) = &one.line else { return None };
    let side = side_words(one.side);
    let channel = one.channel.name(controls);
    let what = match one.response {
        Response::Initial => format!("first {channel}"),
        Response::Span => format!("{channel} span"),
    };
    let head = format!("{} {}{side}, {what}", one.control.name(controls), one.shape);
    let mut said = Vec::new();
    if line.nonlinear {
        said.push(growth_words(line, one.amplitudes));
    } else if one.side == 0 || line.asymmetry.is_none() {
        said.push(format!(
            "in proportion from {:.4} to {:.4} rad within {:.1} % (standard error)",
            one.amplitudes.0,
            one.amplitudes.1,
            100.0 * line.curvature.found.std
        ));
    }
    let departs = |found: Measured| found.value.abs() > crate::postflight::manoeuvres::record::MATERIAL;
    if let Some(test) = line.offset.filter(|test| test.significant() && departs(test.found)) {
        said.push(format!(
            "the line misses zero by {:+.1} +- {:.1} % of the largest response",
            100.0 * test.found.value,
            100.0 * test.found.std
        ));
    }
    if let Some(test) = line.asymmetry.filter(|test| test.significant() && departs(test.found)) {
        said.push(format!(
            "the response to the positive side is {:+.1} +- {:.1} % larger than to the negative one",
            100.0 * test.found.value,
            100.0 * test.found.std
        ));
    }
    Some(format!("{head}: {}.", said.join("; ")))
}

/// The side of a line in words.
pub fn side_words(side: i8) -> &'static str {
    match side {
        1 => ", positive side",
        -1 => ", negative side",
        _ => "",
    }
}

fn growth_words(line: &ResponseLine, amplitudes: (f64, f64)) -> String {
    let how = if line.growth.value < 1.0 { "less" } else { "more" };
    format!(
        "response grows {how} than the input: {:.4} rad gives {} of what {:.4} rad predicts",
        amplitudes.1,
        short_measured_text(line.growth),
        amplitudes.0
    )
}
