//! Page of help: the keys, and what the words mean.

use super::ink::{Ink, heading, labelled};
use ratatui::style::Style;
use ratatui::text::Line;

const KEYS: [(&str, &str); 7] = [
    ("1 to 5", "overview, derivatives, modes, instruments, events"),
    ("left right", "the page before, the next; tab too"),
    ("up down", "a line; PgUp and PgDn a page, Home and End to the ends"),
    ("?", "this page"),
    ("ctrl-L", "draws the screen anew"),
    ("ctrl-Z", "stops it and gives the terminal back; `fg` goes on"),
    ("q ctrl-C", "ends; the estimator and telemetry go on"),
];

const WORDS: [(&str, &str); 9] = [
    ("STABLE", "Dutch roll, roll and spiral decay, each by three standard errors"),
    ("UNSTABLE", "one of them grows by three standard errors"),
    ("NOT KNOWN", "neither is certain yet, or there are no numbers: the reason follows"),
    ("CURRENT", "the estimate is younger than 0.2 s, the samples than 1 s"),
    ("STALE", "it is older, and shown as it was last; or no test input has excited the aircraft for a while"),
    ("waiting", "no test input has excited the aircraft yet; small or slow ones do not count"),
    ("converging", "there are numbers; they still move or are still uncertain"),
    ("converged", "the numbers have settled within their standard errors"),
    ("disagree", "frequency domain or output error give other numbers"),
];

/// The page.
pub(super) fn lines(width: usize) -> Vec<Line<'static>> {
    let mut lines = vec![heading("Keys")];
    lines.extend(KEYS.iter().flat_map(|(key, does)| labelled(key, does, Style::new(), width)));
    lines.push(Line::styled("Words", Ink::bold()));
    lines.extend(WORDS.iter().flat_map(|(word, means)| labelled(word, means, Style::new(), width)));
    lines
}
