//! Page of the derivatives: all six equations with standard errors and status.

use super::super::bus_picture::BusPicture;
use super::ink::{Ink, heading, line, sentence};
use super::link_words::{self, is_current};
use ratatui::style::Style;
use ratatui::text::Line;
use sideslip::flight::channel::ControlNames;
use sideslip::io::outputs::number::{Digits, measured};
use sideslip::io::outputs::words::status_text::{DerivativeLabel, derivative_unit, status_in_words};
use sideslip::realtime::regression::record::{EquationRecord, TermRecord};

/// Lines above all axes, then those of the forces and of the moments.
pub(super) struct DerivativePage {
    pub(super) head: Vec<Line<'static>>,
    pub(super) forces: Vec<Line<'static>>,
    pub(super) moments: Vec<Line<'static>>,
}

/// The page; `width` is that of the axes' column.
pub(super) fn page(picture: &BusPicture, width: usize, ink: Ink) -> DerivativePage {
    let mut page = DerivativePage { head: Vec::new(), forces: Vec::new(), moments: Vec::new() };
    let Some(estimate) = &picture.estimate else {
        page.head.extend(link_words::estimate(picture).labelled("Estimate", width, ink));
        return page;
    };
    let current = is_current(picture);
    let stale = if current { String::new() } else { format!("STALE, {}: ", link_words::age(estimate.age)) };
    let excited = if estimate.derivatives.excited { ", excited" } else { "" };
    let title = format!("{stale}at {:.2} s{excited}; SI and radians, with standard errors", estimate.derivatives.time_s);
    page.head.push(line(&title, ink.numbers(current).patch(Ink::bold())));
    for equation in &estimate.derivatives.equations {
        let side = if equation.axis.is_force() { &mut page.forces } else { &mut page.moments };
        side.extend(axis(equation, picture.controls, (width, current), ink));
    }
    page
}

fn axis(equation: &EquationRecord, controls: ControlNames, (width, current): (usize, bool), ink: Ink) -> Vec<Line<'static>> {
    let status = format!("{}  {}", equation.axis.name(), status_in_words(equation.status, controls));
    let mut lines = sentence(&status, ink.status(equation.status).patch(Ink::bold()), width, 3);
    if equation.terms.is_empty() {
        return lines;
    }
    let unit = if equation.axis.is_force() { "m/s^2" } else { "rad/s^2" };
    let (r_squared, residual) = (Digits(equation.r_squared, 3), Digits(equation.residual_std, 2));
    lines.push(line(&format!("   R2 {r_squared}, residual {residual} {unit}, {:.0} samples", equation.samples), Style::new()));
    for term in &equation.terms {
        lines.push(line(&row(equation, term, controls), ink.numbers(current)));
    }
    if let Some((variable, apart)) = equation.disagreement() {
        let name = DerivativeLabel { axis: equation.axis, variable: Some(variable), controls };
        let apart = apart.abs();
        let agrees = apart <= EquationRecord::AGREE_WITHIN;
        let (word, style) = if agrees { ("agrees", Style::new()) } else { ("DISAGREES", ink.stale()) };
        lines.extend(sentence(
            &format!("   frequency domain {word}: {} s.e. apart in {name}", Digits(apart, 2)),
            style,
            width,
            3,
        ));
    }
    let unresolved = equation.unresolved_variables();
    let unresolved: Vec<String> = unresolved
        .map(|variable| DerivativeLabel { axis: equation.axis, variable: Some(variable), controls }.to_string())
        .collect();
    if !unresolved.is_empty() {
        lines.extend(sentence(&format!("   not resolved: {}", unresolved.join(" ")), ink.stale(), width, 3));
    }
    lines
}

fn row(equation: &EquationRecord, term: &TermRecord, controls: ControlNames) -> String {
    let name = DerivativeLabel { axis: equation.axis, variable: term.variable, controls }.to_string();
    let (value, std) = measured(term.value, term.std);
    format!("   {name:<14} {value:>10} +- {std:<9} {}", derivative_unit(equation.axis, term.variable))
}

/// The two halves below each other.
pub(super) fn one_column(page: DerivativePage) -> Vec<Line<'static>> {
    let mut lines = page.head;
    for (title, side) in [("Moments", page.moments), ("Forces", page.forces)] {
        if !side.is_empty() {
            lines.push(heading(title));
            lines.extend(side);
        }
    }
    lines
}
