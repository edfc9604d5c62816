//! First page: verdict on stability, Dutch roll, ages, link, status, model error and the newest events.

use super::super::bus_picture::BusPicture;
use super::super::nobody::nobody_here;
use super::event_lines::event_lines;
use super::ink::{Ink, heading, labelled};
use super::link_words::{self, is_current};
use super::mode_lines::{oscillation, slow_modes};
use ratatui::text::{Line, Span};
use sideslip::io::bus::role_holder::RoleHolder;
use sideslip::io::outputs::words::stability_text::{LateralStability, StabilityVerdict, lateral_verdict};
use sideslip::io::outputs::words::status_text::{StatusText, status_in_words};
use sideslip::postflight::diagnosis::record::FindingStatus;
use sideslip::realtime::regression::record::Status;

/// The page.
pub(super) fn lines(picture: &BusPicture, width: usize, ink: Ink) -> Vec<Line<'static>> {
    let current = is_current(picture);
    let mut lines = verdict(picture, current, width, ink);
    lines.push(Line::default());
    if let Some(estimate) = &picture.estimate {
        let (modes, style) = (&estimate.modes, ink.numbers(current));
        if let Some(pair) = &modes.coupled {
            lines.extend(oscillation("Dutch roll whole", pair, style, ink));
        } else if let Some(pair) = &modes.dutch_roll {
            lines.extend(oscillation("Dutch roll (lat.)", pair, style, ink));
        } else {
            lines.extend(labelled("Dutch roll", "no number yet", ink.stale(), width));
        }
        lines.extend(slow_modes(modes, style, ink));
        lines.push(Line::default());
        lines.extend(labelled("Modes", &status_in_words(modes.status, picture.controls), ink.status(modes.status), width));
        lines.extend(axes(picture, ink));
    }
    lines.extend(link_words::estimate(picture).labelled("Estimate", width, ink));
    lines.extend(link_words::link(picture).labelled("Link", width, ink));
    let found = picture.findings().iter().filter(|finding| finding.standing == FindingStatus::Found);
    for (place, finding) in found.enumerate() {
        let label = if place == 0 { "Model error" } else { "" };
        lines.extend(labelled(label, &finding.statement, ink.stale(), width));
    }
    lines.push(Line::default());
    lines.push(heading("Newest events"));
    lines.extend(event_lines(picture, width, ink));
    lines
}

fn verdict(picture: &BusPicture, current: bool, width: usize, ink: Ink) -> Vec<Line<'static>> {
    let Some(estimate) = &picture.estimate else {
        let why = match picture.estimator {
            RoleHolder::Nobody => nobody_here(picture),
            _ => vec!["NOT KNOWN YET, because there is no estimate yet".to_owned()],
        };
        let labelled_why = why.iter().enumerate();
        return labelled_why
            .flat_map(|(i, why)| labelled(if i == 0 { "Stability" } else { "" }, why, ink.bad(), width))
            .collect();
    };
    let StabilityVerdict { verdict, reason } = lateral_verdict(&estimate.modes, picture.controls);
    if current {
        let mark = if verdict == LateralStability::NotKnown { "," } else { ":" };
        return labelled("Stability", &format!("{}{mark} {reason}", verdict.words()), ink.verdict(verdict), width);
    }
    let age = link_words::age(estimate.age);
    let last = verdict.words();
    labelled("Stability", &format!("STALE, {age}: last {last}, {reason}"), ink.stale().patch(Ink::bold()), width)
}

/// The six equations, each with its status in a word; forces and moments apart.
fn axes(picture: &BusPicture, ink: Ink) -> [Line<'static>; 2] {
    [("Forces", true), ("Moments", false)].map(|(label, forces)| {
        let mut spans = vec![Span::styled(format!("{label:<12}"), Ink::bold())];
        let equations = picture.estimate.iter().flat_map(|estimate| &estimate.derivatives.equations);
        for equation in equations.filter(|equation| equation.axis.is_force() == forces) {
            let word = match equation.status {
                Status::NotIdentifiable(_) => "none".to_owned(),
                status => StatusText { status, controls: picture.controls }.to_string(),
            };
            spans.push(Span::raw(format!("{} ", equation.axis.name())));
            spans.push(Span::styled(format!("{word}  "), ink.status(equation.status)));
        }
        Line::from(spans)
    })
}
