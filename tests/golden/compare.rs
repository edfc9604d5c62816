//! Two texts line by line: what differs first, with what stands before it, and how much more.

use std::fmt::Write;

/// Differing lines that are shown, unchanged lines before them, characters of a line.
const SHOWN: usize = 16;
const CONTEXT: usize = 2;
const WIDTH: usize = 300;
/// Largest table of the longest common subsequence; beyond it lines are compared place by place.
const TABLE: usize = 4_000_000;

/// A line of the comparison.
enum Step<'a> {
    Same(&'a str),
    Missing(&'a str),
    New(&'a str),
}

/// `None` where the texts are the same, else the first differences.
pub(crate) fn difference(expected: &str, found: &str) -> Option<String> {
    if expected == found {
        return None;
    }
    let (old, new): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), found.lines().collect());
    let ahead = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let behind = old[ahead..].iter().rev().zip(new[ahead..].iter().rev()).take_while(|(a, b)| a == b).count();
    let steps = steps(&old[ahead..old.len() - behind], &new[ahead..new.len() - behind]);
    let mut section = old[..ahead].iter().rev().find(|line| line.starts_with('[') || line.starts_with("== ")).copied();
    let mut text = String::new();
    let (mut shown, mut more, mut line) = (0, 0, ahead);
    let mut before: Vec<&str> = old[ahead.saturating_sub(CONTEXT)..ahead].to_vec();
    let mut new_hunk = true;
    for step in &steps {
        let (sign, content) = match step {
            Step::Same(same) => {
                line += 1;
                new_hunk = true;
                if same.starts_with('[') || same.starts_with("== ") {
                    section = Some(same);
                }
                before.push(same);
                if before.len() > CONTEXT {
                    before.remove(0);
                }
                continue;
            }
            Step::Missing(missing) => ('-', missing),
            Step::New(new) => ('+', new),
        };
        if shown == SHOWN {
            more += 1;
            continue;
        }
        if std::mem::take(&mut new_hunk) {
            let _ = writeln!(text, "  line {}, in {}", line + 1, section.unwrap_or("the first section"));
            for same in before.drain(..) {
                let _ = writeln!(text, "    {}", cut(same));
            }
        }
        let _ = writeln!(text, "  {sign} {}", cut(content));
        shown += 1;
        line += usize::from(sign == '-');
    }
    if shown == 0 {
        let _ = writeln!(text, "  the last line ends differently");
    }
    if more > 0 {
        let _ = writeln!(text, "  ... and {more} more differing lines");
    }
    Some(text)
}

fn cut(line: &str) -> String {
    if line.chars().count() <= WIDTH { line.to_owned() } else { line.chars().take(WIDTH).chain("...".chars()).collect() }
}

/// What leads from one text to the other.
fn steps<'a>(old: &[&'a str], new: &[&'a str]) -> Vec<Step<'a>> {
    let width = new.len() + 1;
    let mut steps = Vec::new();
    if (old.len() + 1).saturating_mul(width) > TABLE {
        for place in 0..old.len().max(new.len()) {
            match (old.get(place), new.get(place)) {
                (Some(a), Some(b)) if a == b => steps.push(Step::Same(a)),
                (a, b) => {
                    steps.extend(a.map(|line| Step::Missing(line)));
                    steps.extend(b.map(|line| Step::New(line)));
                }
            }
        }
        return steps;
    }
    let mut common = vec![0_u32; (old.len() + 1) * width];
    for i in (0..old.len()).rev() {
        for j in (0..new.len()).rev() {
            common[i * width + j] = if old[i] == new[j] {
                common[(i + 1) * width + j + 1] + 1
            } else {
                common[(i + 1) * width + j].max(common[i * width + j + 1])
            };
        }
    }
    let (mut i, mut j) = (0, 0);
    while i < old.len() || j < new.len() {
        if i < old.len() && j < new.len() && old[i] == new[j] {
            steps.push(Step::Same(old[i]));
            (i, j) = (i + 1, j + 1);
        } else if j == new.len() || (i < old.len() && common[(i + 1) * width + j] >= common[i * width + j + 1]) {
            steps.push(Step::Missing(old[i]));
            i += 1;
        } else {
            steps.push(Step::New(new[j]));
            j += 1;
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "== answer.json\n[a]\nx = 0.1\ny = 0.2\n[b]\nz = 0.3\nwhy = \"it is so\"\n";

    #[test]
    fn the_same_is_no_difference() {
        assert_eq!(difference(TEXT, TEXT), None);
    }

    #[test]
    fn one_altered_digit_is_shown_with_its_place() {
        let told = difference(TEXT, &TEXT.replace("0.3", "0.30000000000000004")).unwrap();
        assert_eq!(told, "  line 6, in [b]\n    y = 0.2\n    [b]\n  - z = 0.3\n  + z = 0.30000000000000004\n");
    }

    #[test]
    fn a_missing_line_is_one_line_of_difference() {
        let told = difference(TEXT, &TEXT.replace("y = 0.2\n", "")).unwrap();
        assert_eq!(told, "  line 4, in [a]\n    [a]\n    x = 0.1\n  - y = 0.2\n");
    }

    #[test]
    fn an_altered_word_and_a_lost_end_of_line_are_differences() {
        assert!(difference(TEXT, &TEXT.replace("is so", "was so")).unwrap().contains("+ why = \"it was so\""));
        assert!(difference(TEXT, TEXT.trim_end()).unwrap().contains("ends differently"));
    }

    #[test]
    fn many_differences_are_counted() {
        let lines = |offset: usize| (0..100).map(|i| format!("{}\n", i + offset)).collect::<String>();
        let told = difference(&lines(0), &lines(1000)).unwrap();
        assert!(told.contains("and 184 more") && told.lines().count() < 25, "{told}");
    }
}
