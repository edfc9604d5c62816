//! Events as lines, the newest first.

use super::super::bus_picture::BusPicture;
use super::ink::{Ink, line, sentence};
use ratatui::style::Style;
use ratatui::text::Line;
use sideslip::io::outputs::words::event_text::{EventText, Severity, event_severity};

/// Columns of time and severity.
const INDENT: usize = 22;

/// Time of the last one, how much it matters, how often it came, and the sentence.
pub(super) fn event_lines(picture: &BusPicture, width: usize, ink: Ink) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    for event in picture.events.entries().iter().rev() {
        let severity = event_severity(&event.kind);
        let often = if event.count > 1 { format!(" ({} times)", event.count) } else { String::new() };
        let name = if severity == Severity::Info { "" } else { severity.name() };
        let text = EventText { kind: &event.kind, controls: picture.controls };
        let said = format!("{:>9.2} s {name:<9}  {text}{often}", event.last_s);
        lines.extend(sentence(&said, ink.severity(severity), width, INDENT));
    }
    if lines.is_empty() {
        lines.push(line("  none yet", Style::new()));
    }
    lines
}
