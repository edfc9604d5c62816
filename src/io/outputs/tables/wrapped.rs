//! Text broken into lines of a given width.

/// The text in lines of at most that many characters, broken at spaces; a longer word has a line of its own.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    lines_of(text.split(' '), width)
}

/// The same of a list with commas between its items, none of them broken.
pub fn wrapped_list(items: &[String], width: usize) -> Vec<String> {
    let last = items.len().saturating_sub(1);
    let comma = |place| if place < last { "," } else { "" };
    lines_of(items.iter().enumerate().map(|(place, item)| format!("{item}{}", comma(place))), width)
}

/// Parts with a space between, in lines.
fn lines_of(parts: impl Iterator<Item = impl AsRef<str>>, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut used = 0;
    for part in parts {
        let part = part.as_ref();
        let length = part.chars().count();
        let gap = usize::from(used > 0);
        if used + gap + length > width && used > 0 {
            lines.push(String::new());
            used = 0;
        }
        if let Some(line) = lines.last_mut() {
            if used > 0 {
                line.push(' ');
                used += 1;
            }
            line.push_str(part);
            used += length;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_width_and_what_is_longer_stands_alone() {
        assert_eq!(wrapped("roll rate and yaw rate", 9), ["roll rate", "and yaw", "rate"]);
        assert_eq!(wrapped("the \u{b5}-coefficient x", 5), ["the", "\u{b5}-coefficient", "x"]);
        assert_eq!(wrapped("", 5), [""]);
        let items = ["p bias", "q bias", "r"].map(str::to_owned);
        assert_eq!(wrapped_list(&items, 15), ["p bias, q bias,", "r"]);
        assert_eq!(wrapped_list(&items, 14), ["p bias,", "q bias, r"]);
    }
}
