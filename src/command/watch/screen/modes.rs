//! Page of the modes: of the lateral subsystem and of the whole aircraft, by regression and by output error.

use super::super::bus_picture::BusPicture;
use super::ink::{Ink, labelled, line};
use super::link_words::{self, is_current};
use super::mode_lines::{oscillation, output_error, slow_modes};
use ratatui::style::Style;
use ratatui::text::Line;
use sideslip::io::outputs::words::status_text::{DUTCH_ROLL_WITHHELD, WHOLE_NOT_AVAILABLE, status_in_words};

/// The page.
pub(super) fn lines(picture: &BusPicture, width: usize, ink: Ink) -> Vec<Line<'static>> {
    let Some(estimate) = &picture.estimate else {
        return link_words::estimate(picture).labelled("Estimate", width, ink);
    };
    let (modes, current) = (&estimate.modes, is_current(picture));
    let style = ink.numbers(current);
    let stale = if current { String::new() } else { format!("STALE, {}: ", link_words::age(estimate.age)) };
    let mut lines = vec![line(&format!("{stale}lateral modes at {:.2} s", modes.time_s), style.patch(Ink::bold()))];
    lines.extend(labelled("Status", &status_in_words(modes.status, picture.controls), ink.status(modes.status), width));
    match &modes.dutch_roll {
        Some(pair) => lines.extend(oscillation("Dutch roll (lat.)", pair, style, ink)),
        None => lines.extend(labelled("Dutch roll", DUTCH_ROLL_WITHHELD, ink.stale(), width)),
    }
    match &modes.coupled {
        Some(pair) => lines.extend(oscillation("Dutch roll whole", pair, style, ink)),
        None => lines.extend(labelled("  whole", WHOLE_NOT_AVAILABLE, ink.stale(), width)),
    }
    lines.extend(slow_modes(modes, style, ink));
    lines.push(Line::default());
    match &picture.output_error {
        Some(record) => lines.extend(output_error(record, estimate.derivatives.time_s, width, ink)),
        None => lines.push(line("Output error: nothing yet", Style::new())),
    }
    lines
}
