//! Events as lines, the newest first.

use super::super::bus_picture::BusPicture;
use super::ink::{Ink, beside, line};
use ratatui::style::Style;
use ratatui::text::Line;
use sideslip::io::outputs::words::event_text::{EventText, Severity, event_severity};

/// Time of the last one, how much it matters, how often it came, and the sentence.
pub(super) fn event_lines(picture: &BusPicture, width: usize, ink: Ink) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    for event in picture.events.entries().iter().rev() {
        let severity = event_severity(&event.kind);
        let often = if event.count > 1 { format!(" ({} times)", event.count) } else { String::new() };
        let name = if severity == Severity::Info { "" } else { severity.name() };
        let text = EventText { kind: &event.kind, controls: picture.controls };
        let when = format!("{:>9.2} s {name:<9}  ", event.last_s);
        lines.extend(beside(&when, &format!("{text}{often}"), ink.severity(severity), width));
    }
    if lines.is_empty() {
        lines.push(line("  none yet", Style::new()));
    }
    lines
}
