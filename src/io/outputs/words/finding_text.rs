//! Findings of the live diagnosis in words: the model's errors, printed below the estimates.

use crate::io::outputs::tables::terminal::Style;
use crate::postflight::diagnosis::record::{FindingRecord, FindingStatus};
use std::fmt;

/// The findings that stand, and those that were taken back.
#[derive(Clone, Copy, Debug)]
pub struct FindingsTable<'a> {
    /// What is shown.
    pub findings: &'a [FindingRecord],
    /// Whether it is coloured.
    pub style: Style,
}

impl fmt::Display for FindingsTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let standing = self.findings.iter().filter(|one| one.standing == FindingStatus::Found);
        let heading = match (standing.max_by(|a, b| a.time_s.total_cmp(&b.time_s)), self.findings) {
            (_, []) => return Ok(()),
            (None, _) => "Model error: nothing found".to_owned(),
            (Some(newest), _) => format!("Model error at {:.2} s, from {} manoeuvre(s)", newest.time_s, newest.manoeuvres),
        };
        writeln!(f, "{}", self.style.bold(heading))?;
        for one in self.findings {
            let number = if one.number == 0 { "-".to_owned() } else { one.number.to_string() };
            write!(f, "  {number:>2} {}", one.statement)?;
            let mut said = Vec::new();
            if one.standing == FindingStatus::Found && one.probability.is_finite() {
                said.push(format!("probability {:.2}", one.probability));
            }
            if one.standing == FindingStatus::Found && one.rivals > 0 {
                said.push(format!("{} other(s) not ruled out", one.rivals));
            }
            if one.standing == FindingStatus::Retracted {
                said.push(format!("at {:.2} s", one.time_s));
            }
            match said.is_empty() {
                true => writeln!(f)?,
                false => writeln!(f, " ({})", said.join(", "))?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_finding_has_a_line_with_how_sure_it_is() {
        let mut found = FindingRecord { time_s: 20.0, standing: FindingStatus::Found, number: 2, ..FindingRecord::EMPTY };
        (found.probability, found.manoeuvres) = (0.97, 3);
        found.set_statement("r is measured late");
        let mut back = FindingRecord { time_s: 15.0, standing: FindingStatus::Retracted, number: 1, ..FindingRecord::EMPTY };
        back.set_statement("taken back");
        let text = FindingsTable { findings: &[back, found], style: Style::Plain }.to_string();
        assert_eq!(
            text,
            "Model error at 20.00 s, from 3 manoeuvre(s)\n   1 taken back (at 15.00 s)\n   2 r is measured late (probability 0.97)\n"
        );
        assert_eq!(FindingsTable { findings: &[], style: Style::Plain }.to_string(), "");
    }
}
