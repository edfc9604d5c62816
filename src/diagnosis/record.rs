//! The published vocabulary of the diagnosis while the flight goes on: what the model gets wrong, said, refined, taken back.

use crate::flight::effect::Effect;
use heapless::String;

/// Bytes of a statement.
pub const STATEMENT: usize = 240;

/// How a finding stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Nothing has been flown yet that could be diagnosed.
    Waiting,
    /// It holds by the newest manoeuvres.
    Found,
    /// It held before; the newest manoeuvres do not show it.
    TakenBack,
    /// The last look came to nothing, for the reason that the statement gives; findings before it stand as they did.
    Failed,
}

impl Standing {
    /// Every one, in the order of their places.
    pub const ALL: [Standing; 4] = [Standing::Waiting, Standing::Found, Standing::TakenBack, Standing::Failed];

    /// Its place in [`Standing::ALL`].
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Standing::Waiting => "waiting",
            Standing::Found => "found",
            Standing::TakenBack => "taken back",
            Standing::Failed => "failed",
        }
    }
}

/// One finding as it stands, or that there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct FindingRecord {
    /// Time of the newest sample that it rests on, s.
    pub time_s: f64,
    /// How it stands.
    pub standing: Standing,
    /// Which finding of this run, from 1: the same while its cause is the same. 0 for what is no finding.
    pub number: u32,
    /// The cause; `none` where the model explains what was flown, `unknown` where no effect explains it.
    pub effect: Effect,
    /// Standard error of its main number; NaN where it has none.
    pub std: f64,
    /// How likely this is the cause; NaN where that cannot be said.
    pub probability: f64,
    /// Other causes that the data do not rule out.
    pub rivals: u32,
    /// Manoeuvres that it rests on.
    pub manoeuvres: u32,
    /// One sentence for a person.
    pub statement: String<STATEMENT>,
}

impl FindingRecord {
    /// Nothing yet.
    pub const EMPTY: FindingRecord = FindingRecord {
        time_s: 0.0,
        standing: Standing::Waiting,
        number: 0,
        effect: Effect::None,
        std: f64::NAN,
        probability: f64::NAN,
        rivals: 0,
        manoeuvres: 0,
        statement: String::new(),
    };

    /// Puts a statement in, cut where there is no room for it.
    pub fn say(&mut self, statement: &str) {
        self.statement.clear();
        for letter in statement.chars() {
            if self.statement.push(letter).is_err() {
                break;
            }
        }
    }
}

/// Findings in order of their numbers; the newest of each, and the newest word that is of none. Of more than there is room for
/// the last are not kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FindingsSoFar {
    kept: heapless::Vec<FindingRecord, 16>,
}

impl FindingsSoFar {
    /// None yet.
    pub const fn new() -> Self {
        FindingsSoFar { kept: heapless::Vec::new() }
    }

    /// Takes the place of what was said of it before.
    pub fn hear(&mut self, record: &FindingRecord) {
        // What a look found ends the word that there was nothing to look at, and the word of one that failed.
        if record.number > 0 {
            self.kept.retain(|one| one.number > 0);
        }
        match self.kept.iter_mut().find(|one| one.number == record.number) {
            Some(before) => before.clone_from(record),
            None => {
                if self.kept.push(record.clone()).is_ok() {
                    self.kept.sort_unstable_by_key(|one| one.number);
                }
            }
        }
    }

    /// Every one.
    pub fn records(&self) -> &[FindingRecord] {
        &self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_word_of_each_finding_is_kept() {
        let word = |number, standing| FindingRecord { number, standing, ..FindingRecord::EMPTY };
        let mut so_far = FindingsSoFar::new();
        so_far.hear(&FindingRecord::EMPTY);
        assert_eq!(so_far.records().len(), 1);
        for (number, standing) in [(2, Standing::Found), (1, Standing::Found), (2, Standing::TakenBack), (0, Standing::Failed)] {
            so_far.hear(&word(number, standing));
        }
        let kept: Vec<_> = so_far.records().iter().map(|one| (one.number, one.standing)).collect();
        assert_eq!(kept, [(0, Standing::Failed), (1, Standing::Found), (2, Standing::TakenBack)]);
        for number in 3..100 {
            so_far.hear(&word(number, Standing::Found));
        }
        assert_eq!(so_far.records().len(), 16);
    }

    #[test]
    fn a_statement_is_cut_between_letters() {
        let mut record = FindingRecord::EMPTY;
        record.say(&"a\u{e9}".repeat(100));
        assert_eq!(record.statement.len(), STATEMENT);
    }
}
