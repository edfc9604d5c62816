//! Words of others made fit for a terminal: what would steer it is shown instead, ordinary Unicode stays as it is.
//!
//! Shown as an escape are control characters (C0, DEL, C1), those that change the direction of text or hide it (bidirectional
//! embeddings, overrides, isolates and marks), line and paragraph separators, and the byte order mark; all others pass.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a terminal obeys the character, or shows text in another order for it.
pub fn steers(c: char) -> bool {
    let turns_or_hides = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{206f}');
    let separates = matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}');
    c.is_control() || turns_or_hides || separates
}

/// A name or a word in one line: every such character shown, `\x1b`, `\n`, `\u{202e}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    shown(text, |_| false)
}

/// Text of several lines: the same, with line ends and tabs left as they are.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    shown(text, |c| matches!(c, '\n' | '\t'))
}

/// A JSON text in which no string steers a terminal: the same document, such characters written as `\u009b`. The serialiser
/// escapes C0 already; line ends between tokens stay.
pub fn printable_json(text: &str) -> Cow<'_, str> {
    let wrong = |c: char| steers(c) && (c == '\x7f' || !c.is_ascii());
    if !text.contains(wrong) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if wrong(c) {
            // All of them are in the basic plane, so that one unit says each.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

fn shown(text: &str, kept: impl Fn(char) -> bool) -> Cow<'_, str> {
    let wrong = |c: char| steers(c) && !kept(c);
    if !text.contains(wrong) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if !wrong(c) {
            shown.push(c);
        } else if let '\n' | '\r' | '\t' = c {
            shown.extend(c.escape_default());
        } else if c.is_ascii() {
            // A string takes every character.
            let _ = write!(shown, "\\x{:02x}", u32::from(c));
        } else {
            shown.extend(c.escape_unicode());
        }
    }
    Cow::Owned(shown)
}

/// Digits in a row that are shown as they stand; no number that means something has more.
const DIGITS_SHOWN: usize = 40;

/// A text for people in which no number fills lines: one of more digits, as 1e300 is written in full, as a power of ten.
pub fn with_short_numbers(text: &str) -> Cow<'_, str> {
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    if !text.split(|c| !is_number(c)).any(|number| number.len() > DIGITS_SHOWN) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(is_number) {
        let (before, from) = rest.split_at(at);
        let (number, after) = from.split_at(from.find(|c| !is_number(c)).unwrap_or(from.len()));
        let long = number.len() > DIGITS_SHOWN && !before.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        // A sentence ends with a full stop.
        let plain = number.trim_end_matches('.');
        let value = if long { plain.parse::<f64>().ok() } else { None };
        shown.push_str(before);
        match value {
            Some(value) if value.is_finite() => {
                // A string takes every character.
                let _ = write!(shown, "{value:.4e}{}", number.get(plain.len()..).unwrap_or_default());
            }
            Some(_) => {
                let _ = write!(shown, "a number of {} digits", plain.len());
            }
            None => shown.push_str(number),
        }
        rest = after;
    }
    shown.push_str(rest);
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_hundreds_of_digits_is_a_power_of_ten_and_ordinary_ones_stay() {
        let huge = format!("flown at {:.1} m/s, not {}.", 1.5e300, -2.5e-300);
        assert_eq!(with_short_numbers(&huge), "flown at 1.5000e300 m/s, not -2.5000e-300.");
        assert_eq!(with_short_numbers(&"7".repeat(400)), "a number of 400 digits");
        let hash = format!("{}a{}", "1".repeat(30), "2".repeat(41));
        for plain in ["", "at 1.5 s, 20 rows.", "1767225600000000 us", "...", "0.0001234567890123456789", hash.as_str()] {
            assert_eq!(with_short_numbers(plain), plain);
        }
    }

    #[test]
    fn what_steers_a_terminal_is_shown_and_ordinary_unicode_stays() {
        let cases = [
            ("Flug 7, \u{f6}\u{3b1}\u{65e5} \u{1f681}", "Flug 7, \u{f6}\u{3b1}\u{65e5} \u{1f681}"),
            ("\x1b[2J\x1b]0;x\x07", "\\x1b[2J\\x1b]0;x\\x07"),
            ("a\r\nb\tc\x7f\u{0}", "a\\r\\nb\\tc\\x7f\\x00"),
            ("\u{9b}31m", "\\u{9b}31m"),
            ("run\u{202e}vsc.\u{2066}x\u{200f}", "run\\u{202e}vsc.\\u{2066}x\\u{200f}"),
            ("\u{5e9}\u{5dc}\u{5d5}\u{5dd} \u{200d}", "\u{5e9}\u{5dc}\u{5d5}\u{5dd} \u{200d}"),
        ];
        for (text, expected) in cases {
            assert_eq!(printable(text), expected);
        }
        assert_eq!(printable_json("{\"a\": \"\u{9b}\u{7f}\u{202e}\u{f6}\"}\n"), "{\"a\": \"\\u009b\\u007f\\u202e\u{f6}\"}\n");
        assert!(matches!(printable("plain"), Cow::Borrowed(_)));
        assert_eq!(printable_lines("a\n\tb\r\x1b"), "a\n\tb\\r\\x1b");
    }
}
