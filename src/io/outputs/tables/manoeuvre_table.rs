//! The preliminary interpretation as text: tables of at most [`WIDTH`] columns, then the sentences.

use crate::flight::channel::{Channel, ControlNames};
use crate::io::outputs::number::{Fixed, short_measured_text};
use crate::io::outputs::tables::wrapped::wrapped;
use crate::io::outputs::words::manoeuvre_sentences::{self, point_words, side_words};
use crate::io::outputs::words::printable::printable;
use crate::postflight::manoeuvres::record::{
    Interpretation, LineTest, Linearity, Manoeuvre, Measured, NotEstimable, Plane, RUNS_A_POINT, Response, RunInterpretation,
    TestPoint, on_axis,
};
use std::fmt::Write;

/// Columns of a terminal that the table fits.
pub const WIDTH: usize = 130;

/// The whole, ended by a line feed.
pub fn text(all: &Interpretation) -> String {
    let mut lines = vec!["Preliminary interpretation (values +- standard errors; SI, radians)".to_owned()];
    for run in &all.runs {
        lines.push(String::new());
        lines.extend(run_lines(run));
    }
    let controls = all.runs.first().map_or(ControlNames::default(), |run| run.controls);
    if !all.points.is_empty() {
        lines.push(String::new());
        lines.push("Test points".to_owned());
        lines.extend(rows(
            all.points.iter().map(|point| point_cells(point, controls)),
            &["what", "runs", "scatter of the response, in % (by noise)"],
        ));
    }
    if all.linearity.iter().any(|one| one.line.is_ok()) {
        lines.push(String::new());
        lines.push("Linearity with amplitude".to_owned());
        let titles = ["what", "response", "rad", "runs", "a rad", "growth", "offset", "right over left", ""];
        let told = all.linearity.iter().filter(|one| one.line.is_ok());
        lines.extend(rows(told.map(|one| line_cells(one, controls)), &titles));
    }
    let sentences = manoeuvre_sentences::of_all(all);
    if !sentences.is_empty() {
        lines.push(String::new());
    }
    lines.extend(sentences.iter().flat_map(|sentence| item_lines(sentence)));
    let mut text = String::new();
    for line in lines {
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// Aligned columns under titles; words on the left.
fn rows(cells: impl Iterator<Item = Vec<String>>, titles: &[&str]) -> Vec<String> {
    let all: Vec<Vec<String>> = std::iter::once(titles.iter().map(|&title| title.to_owned()).collect()).chain(cells).collect();
    let width = |place: usize| all.iter().filter_map(|row| row.get(place)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..titles.len()).map(width).collect();
    let line = |row: &Vec<String>| row.iter().zip(&widths).map(|(cell, width)| format!("  {cell:<width$}")).collect::<String>();
    all.iter().map(line).collect()
}

/// A sentence on as many lines as it takes.
fn item_lines(sentence: &str) -> Vec<String> {
    let lines = wrapped(sentence, WIDTH - 4).into_iter().enumerate();
    lines.map(|(place, line)| format!("  {} {line}", if place == 0 { '-' } else { ' ' })).collect()
}

fn percent(value: f64) -> String {
    if value.abs() < 0.1 { Fixed(100.0 * value, 1).to_string() } else { Fixed(100.0 * value, 0).to_string() }
}

fn run_lines(run: &RunInterpretation) -> Vec<String> {
    let mut lines = vec![printable(&run.run).into_owned()];
    if let Some(nothing) = &run.nothing {
        lines.push(format!("  no manoeuvre: {nothing}"));
        return lines;
    }
    let titles = ["s", "control", "shape", "first, rad", "m/s", "climb", "kg/m^3", "p q r in trim, rad/s", "trim"];
    lines.extend(rows(run.manoeuvres.iter().map(|one| manoeuvre_cells(one, run.controls)), &titles));
    let titles = ["s", "after", "plane", "omega, rad/s", "zeta", "zeta by peaks", "free response, s", "cycles", "explained"];
    lines.extend(rows(run.manoeuvres.iter().map(|one| oscillation_cells(one, run.controls)), &titles));
    let titles =
        ["s", "response to", "axis", "rad/s^2 per rad", "rad/s per rad", "peak after", "ratio to on-axis", "exceeds 0.25 after"];
    let answers = run.manoeuvres.iter().flat_map(|one| answer_cells(one, run.controls));
    lines.extend(rows(answers, &titles));
    lines.extend(manoeuvre_sentences::of_run(run).iter().flat_map(|sentence| item_lines(sentence)));
    lines
}

fn manoeuvre_cells(one: &Manoeuvre, controls: ControlNames) -> Vec<String> {
    let mut cells = vec![
        Fixed(one.start_s, 1).to_string(),
        one.control.name(controls).to_owned(),
        one.shape.to_string(),
        format!("{:+}", Fixed(one.amplitude, 4)),
    ];
    match &one.trim {
        Ok(trim) => {
            let number = |value: Option<f64>, places: usize| value.map_or("-".to_owned(), |value| format!("{value:.places$}"));
            cells.push(number(trim.tas.map(|tas| tas.value), 1));
            cells.push(trim.climb.map_or("-".to_owned(), |climb| format!("{:+}", Fixed(climb.value, 1))));
            cells.push(number(trim.rho, 3));
            cells.push(trim.rates.map(|rate| number(rate, 4)).join(" "));
            cells.push(if trim.unsteady.is_empty() { "steady".to_owned() } else { "not steady".to_owned() });
        }
        Err(_) => cells.extend(["-", "-", "-", "-", "none"].map(String::from)),
    }
    cells
}

fn oscillation_cells(one: &Manoeuvre, controls: ControlNames) -> Vec<String> {
    let name = one.control.name(controls).to_owned();
    let mut cells = vec![Fixed(one.start_s, 1).to_string(), name, Plane::of(one.control).word().to_owned()];
    match &one.oscillation {
        Ok(found) => cells.extend([
            short_measured_text(found.omega),
            short_measured_text(found.zeta),
            found.decrement.map_or("-".to_owned(), |(_, zeta)| short_measured_text(zeta)),
            format!("{} to {}", Fixed(found.from_s, 1), Fixed(found.to_s, 1)),
            Fixed(found.cycles, 1).to_string(),
            format!("{} %", Fixed(100.0 * found.explained, 0)),
        ]),
        Err(reason) => {
            let short = match reason {
                NotEstimable::StillMoves(..) => "still moves",
                NotEstimable::TooFewCycles(..) => "few cycles",
                NotEstimable::NoOscillation(..) => "none seen",
                NotEstimable::Uncertain(..) => "uncertain",
                _ => "not determined",
            };
            cells.extend([short, "-", "-", "-", "-", "-"].map(String::from));
        }
    }
    cells
}

fn answer_cells(one: &Manoeuvre, controls: ControlNames) -> Vec<Vec<String>> {
    let on = on_axis(one.control);
    let row = |channel: Channel| {
        let sensitivity = one.sensitivities.iter().find(|axis| axis.channel == channel)?;
        let coupling = one.couplings.as_ref().ok().and_then(|all| all.iter().find(|axis| axis.channel == channel));
        let mark = |text: String| if sensitivity.significant { text } else { format!("({text})") };
        Some(vec![
            Fixed(one.start_s, 1).to_string(),
            one.control.name(controls).to_owned(),
            channel.name(controls).to_owned(),
            sensitivity.acceleration.map_or("-".to_owned(), |value| mark(short_measured_text(value))),
            mark(short_measured_text(sensitivity.rate)),
            if sensitivity.significant { format!("{} s", Fixed(sensitivity.after_s, 2)) } else { "-".to_owned() },
            match coupling {
                None if channel == on => "on-axis".to_owned(),
                None => "-".to_owned(),
                Some(axis) if axis.significant => short_measured_text(axis.ratio),
                Some(axis) => format!("({})", short_measured_text(axis.ratio)),
            },
            coupling
                .and_then(|axis| axis.exceeds_after_s)
                .map_or("-".to_owned(), |after_s| format!("{after_s} s", after_s = Fixed(after_s, 2))),
        ])
    };
    [on, Channel::P, Channel::Q, Channel::R]
        .into_iter()
        .enumerate()
        .filter(|(place, channel)| *place == 0 || *channel != on)
        .filter_map(|(_, channel)| row(channel))
        .collect()
}

fn point_cells(point: &TestPoint, controls: ControlNames) -> Vec<String> {
    let scatter = match &point.scatter {
        Err(reason) => reason.to_string(),
        Ok(all) => all
            .iter()
            .map(|one| format!("{} {} ({})", one.channel.name(controls), percent(one.scatter.value), percent(one.noise)))
            .collect::<Vec<_>>()
            .join(", "),
    };
    vec![point_words(point, controls), format!("{} of {RUNS_A_POINT}", point.members.len()), scatter]
}

fn line_cells(one: &Linearity, controls: ControlNames) -> Vec<String> {
    let what = format!("{} {}{}", one.control.name(controls), one.shape, side_words(one.side));
    let response = match one.response {
        Response::Initial => format!("first {}", one.channel.name(controls)),
        Response::Span => format!("{} span", one.channel.name(controls)),
    };
    let mut cells =
        vec![what, response, format!("{} to {}", Fixed(one.amplitudes.0, 4), Fixed(one.amplitudes.1, 4)), one.runs.to_string()];
    if let Ok(line) = &one.line {
        let test = |test: Option<LineTest>, plus: f64| {
            test.map_or("-".to_owned(), |test| {
                short_measured_text(Measured { value: test.found.value + plus, std: test.found.std })
            })
        };
        cells.push(short_measured_text(line.slope));
        cells.push(short_measured_text(line.growth));
        cells.push(test(line.offset, 0.0));
        cells.push(test(line.asymmetry, 1.0));
        cells.push(if line.nonlinear { "not linear".to_owned() } else { "linear".to_owned() });
    }
    cells
}
