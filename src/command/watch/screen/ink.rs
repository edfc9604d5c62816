//! How words stand out on the screen: by colour where colour is wanted, and never by colour alone.

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use sideslip::io::outputs::tables::wrapped::wrapped;
use sideslip::io::outputs::words::event_text::Severity;
use sideslip::io::outputs::words::printable::{printable, with_short_numbers};
use sideslip::io::outputs::words::stability_text::LateralStability;
use sideslip::realtime::regression::record::Status;

/// Columns of the labels on the left.
const LABELS: usize = 12;

/// Whether there is colour.
#[derive(Clone, Copy)]
pub(super) struct Ink {
    pub(super) colour: bool,
}

impl Ink {
    fn of(self, colour: Color) -> Style {
        if self.colour { Style::new().fg(colour) } else { Style::new() }
    }

    pub(super) fn bold() -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// The bars at the top and at the foot.
    pub(super) fn bar() -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    pub(super) fn good(self) -> Style {
        self.of(Color::Green).add_modifier(Modifier::BOLD)
    }

    /// Out of date, or in doubt; the word stands beside it.
    pub(super) fn stale(self) -> Style {
        self.of(Color::Yellow)
    }

    pub(super) fn bad(self) -> Style {
        self.of(Color::Red).add_modifier(Modifier::BOLD)
    }

    /// Numbers that hold, or are out of date.
    pub(super) fn numbers(self, current: bool) -> Style {
        if current { Style::new() } else { self.stale() }
    }

    pub(super) fn verdict(self, verdict: LateralStability) -> Style {
        match verdict {
            LateralStability::Stable => self.good(),
            LateralStability::Unstable => self.bad(),
            LateralStability::NotKnown => self.stale().add_modifier(Modifier::BOLD),
        }
    }

    pub(super) fn status(self, status: Status) -> Style {
        match status {
            Status::Converged => self.good(),
            Status::Converging | Status::Waiting | Status::Exciting => Style::new(),
            Status::Stale | Status::Disagree | Status::DependsOnAmplitude | Status::NotIdentifiable(_) => self.stale(),
        }
    }

    pub(super) fn severity(self, severity: Severity) -> Style {
        match severity {
            Severity::Info => Style::new(),
            Severity::Warning => self.stale(),
            Severity::DataLost => self.bad(),
        }
    }
}

/// A line of words that may be somebody else's.
pub(super) fn line(text: &str, style: Style) -> Line<'static> {
    Line::from(Span::styled(printable(&with_short_numbers(text)).into_owned(), style))
}

/// A heading.
pub(super) fn heading(text: &str) -> Line<'static> {
    line(text, Ink::bold())
}

/// A label on the left and what it is about, in as many lines as the width needs.
pub(super) fn labelled(label: &str, text: &str, style: Style, width: usize) -> Vec<Line<'static>> {
    let room = width.saturating_sub(LABELS).max(20);
    let rest = wrapped(&printable(text), room).into_iter().enumerate().map(|(place, part)| {
        let label = if place == 0 { label } else { "" };
        Line::from(vec![Span::styled(format!("{label:<LABELS$}"), Ink::bold()), Span::styled(part, style)])
    });
    rest.collect()
}

/// A sentence to the right of what it belongs to, in as many lines as the width needs.
pub(super) fn beside(left: &str, text: &str, style: Style, width: usize) -> Vec<Line<'static>> {
    let columns = left.chars().count();
    let parts = wrapped(&printable(text), width.saturating_sub(columns).max(20)).into_iter().enumerate();
    let of_place = |(place, part)| {
        let left = if place == 0 { left } else { "" };
        Line::from(Span::styled(format!("{left:<columns$}{part}"), style))
    };
    parts.map(of_place).collect()
}

/// A sentence in as many lines as the width needs; the first keeps its own indentation, the later ones have that one.
pub(super) fn sentence(text: &str, style: Style, width: usize, indent: usize) -> Vec<Line<'static>> {
    let text = printable(text);
    let bare = text.trim_start_matches(' ');
    let first = text.len() - bare.len();
    let room = width.saturating_sub(indent.max(first)).max(20);
    let parts = wrapped(bare, room).into_iter().enumerate();
    parts
        .map(|(place, part)| Line::from(Span::styled(format!("{:1$}{part}", "", if place == 0 { first } else { indent }), style)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_keeps_to_the_right_of_what_it_belongs_to_and_uses_the_width() {
        let lines = beside("1.20 s  ", "the aircraft is being excited", Style::new(), 28);
        let texts: Vec<String> = lines.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["1.20 s  the aircraft is", "        being excited"]);
    }
}
