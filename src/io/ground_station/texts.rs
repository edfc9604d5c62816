//! Events and findings as STATUSTEXT: in chunks of 50 bytes, at a bounded rate, repeats folded.
//!
//! Consumes words under a subject; produces [`StationMessage`]s when they are due. [`BURST`] texts go at once and then one
//! every [`PERIOD`]; the same subject is said again after [`QUIET`] at the earliest, with its newest words and how often it
//! came. What finds no room among the [`WAITING`] that wait is counted. Other letters than ASCII go as `?`.

use super::message::{CHUNK, StationMessage, StationSeverity, filled};
use std::collections::BTreeMap;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Texts that may go at once.
pub const BURST: u32 = 4;
/// Between texts from then on.
pub const PERIOD: Duration = Duration::from_secs(1);
/// Between two texts of one subject.
pub const QUIET: Duration = Duration::from_secs(10);
/// Texts that may wait.
pub const WAITING: usize = 32;
/// Bytes of a text; more are cut off.
pub const TEXT_MAX: usize = 300;

/// What a text is about: of the same, only the newest is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TextSubject {
    /// A kind of event, by its place, and its channel or axis.
    Event(usize, Option<&'static str>),
    /// A finding, by its number.
    Finding(u32),
    /// The run.
    Run,
    /// Messages that found no room on the way here.
    Lost,
}

#[derive(Debug)]
struct WaitingText {
    subject: TextSubject,
    severity: StationSeverity,
    words: String,
    count: u32,
}

/// Texts that wait, and when which was said.
#[derive(Debug)]
pub struct StatusTexts {
    waiting: VecDeque<WaitingText>,
    said: BTreeMap<TextSubject, Instant>,
    /// How many may go, since when.
    allowance: u32,
    since: Instant,
    id: u16,
    dropped: u64,
}

impl StatusTexts {
    /// Nothing said yet.
    pub fn new(now: Instant) -> Self {
        StatusTexts { waiting: VecDeque::new(), said: BTreeMap::new(), allowance: BURST, since: now, id: 0, dropped: 0 }
    }

    /// Takes words in; they take the place of those that wait under the same subject.
    pub fn push(&mut self, subject: TextSubject, severity: StationSeverity, words: String) {
        if let Some(before) = self.waiting.iter_mut().find(|one| one.subject == subject) {
            before.count = before.count.saturating_add(1);
            (before.severity, before.words) = (severity, words);
        } else if self.waiting.len() < WAITING {
            self.waiting.push_back(WaitingText { subject, severity, words, count: 1 });
        } else {
            self.dropped += 1;
        }
    }

    /// Texts that found no room so far.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Texts that wait.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Everything that is due now.
    pub fn due(&mut self, now: Instant, send: &mut impl FnMut(StationMessage)) {
        while self.allowance < BURST && now.saturating_duration_since(self.since) >= PERIOD {
            self.allowance += 1;
            self.since += PERIOD;
        }
        self.said.retain(|_, said| now.saturating_duration_since(*said) < QUIET);
        while self.allowance > 0 {
            let Some(place) = self.waiting.iter().position(|one| !self.said.contains_key(&one.subject)) else { break };
            let Some(text) = self.waiting.remove(place) else { break };
            if self.allowance == BURST {
                self.since = now;
            }
            self.allowance -= 1;
            self.said.insert(text.subject, now);
            self.say(&text, send);
        }
    }

    fn say(&mut self, text: &WaitingText, send: &mut impl FnMut(StationMessage)) {
        let mut words = format!("Sideslip: {}", text.words);
        if text.count > 1 {
            words.push_str(&format!(" ({} times)", text.count));
        }
        let ascii = |letter: char| if letter.is_ascii_graphic() || letter == ' ' { letter as u8 } else { b'?' };
        let bytes: Vec<u8> = words.chars().map(ascii).take(TEXT_MAX).collect();
        let severity = text.severity;
        if bytes.len() <= CHUNK {
            return send(StationMessage::Text { severity, text: filled(&bytes), id: 0, chunk: 0 });
        }
        self.id = self.id.checked_add(1).unwrap_or(1);
        // A chunk with a zero in it is the last: a text that fills its last chunk is followed by an empty one.
        let end = bytes.len().is_multiple_of(CHUNK);
        let chunks = bytes.chunks(CHUNK).chain(end.then_some(&[][..]));
        for (chunk, part) in (0..).zip(chunks) {
            send(StationMessage::Text { severity, text: filled(part), id: self.id, chunk });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is due then, put together as a receiver does.
    fn due(texts: &mut StatusTexts, now: Instant) -> Vec<String> {
        let (mut whole, mut open) = (Vec::new(), (0, String::new()));
        texts.due(now, &mut |message| {
            let StationMessage::Text { text, id, chunk, .. } = message else { panic!("{message:?}") };
            let part: String = text.iter().take_while(|byte| **byte != 0).map(|byte| *byte as char).collect();
            let last = part.len() < CHUNK || id == 0;
            if chunk == 0 {
                open = (id, String::new());
            }
            assert_eq!(open.0, id);
            open.1.push_str(&part);
            if last {
                whole.push(std::mem::take(&mut open.1));
            }
        });
        assert_eq!(open.1, "", "a text without an end");
        whole
    }

    fn event(place: usize) -> TextSubject {
        TextSubject::Event(place, None)
    }

    #[test]
    fn a_text_of_any_length_arrives_whole() {
        let mut now = Instant::now();
        let mut texts = StatusTexts::new(now);
        let own = "Sideslip: ".len();
        for length in [0, 1, CHUNK - own, CHUNK - own + 1, 2 * CHUNK - own, 2 * CHUNK - own + 1, TEXT_MAX - own, 2000] {
            texts.push(event(length), StationSeverity::Info, "x".repeat(length));
            now += PERIOD;
            let arrived = due(&mut texts, now);
            assert_eq!(arrived, [format!("Sideslip: {}", "x".repeat(length.min(TEXT_MAX - own)))]);
        }
        texts.push(event(1), StationSeverity::Info, "80 \u{b0}C\n".into());
        now += QUIET;
        assert_eq!(due(&mut texts, now), ["Sideslip: 80 ?C?"]);
    }

    #[test]
    fn a_flood_is_held_to_the_rate_and_repeats_are_folded() {
        let begun = Instant::now();
        let mut texts = StatusTexts::new(begun);
        let mut said = Vec::new();
        // A minute in which four subjects come a hundred times a second.
        for k in 0..6000_u32 {
            for subject in 0..4 {
                texts.push(event(subject), StationSeverity::Warning, format!("{subject} at {k}"));
            }
            said.extend(due(&mut texts, begun + Duration::from_millis(10) * k));
        }
        assert_eq!(said.len(), 4 * 6, "each subject once in ten seconds");
        assert_eq!((&said[0][..], &said[4][..]), ("Sideslip: 0 at 0", "Sideslip: 0 at 1000 (1000 times)"));
        // Many subjects: a burst, then one a second; what has no room is counted.
        let mut texts = StatusTexts::new(begun);
        let mut said = Vec::new();
        for place in 0..100 {
            texts.push(event(place), StationSeverity::Warning, String::new());
        }
        assert_eq!((texts.waiting(), texts.dropped()), (WAITING, 100 - WAITING as u64));
        for k in 0..=1000_u32 {
            said.push(due(&mut texts, begun + Duration::from_millis(10) * k).len());
        }
        assert_eq!((said[0], said.iter().sum::<usize>()), (4, 14), "in ten seconds");
    }

    #[test]
    fn the_number_of_a_chunked_text_is_never_zero() {
        let now = Instant::now();
        let mut texts = StatusTexts::new(now);
        texts.id = u16::MAX;
        texts.push(TextSubject::Run, StationSeverity::Info, "x".repeat(60));
        texts.due(now, &mut |message| assert!(matches!(message, StationMessage::Text { id: 1, .. }), "{message:?}"));
    }
}
