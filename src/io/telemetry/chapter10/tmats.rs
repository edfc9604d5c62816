//! The setup record: TMATS attributes as text.
//!
//! Consumes bodies of packets of data type 01 ([`SetupRecord`]) or a text ([`Tmats`]); produces the attributes `CODE:VALUE;`
//! by code. A statement ends at the semicolon, wherever the lines end. Codes are compared without regard to case; white space
//! around code and value does not count. `COMMENT:...;` is skipped, but a further statement within a comment (a semicolon was
//! forgotten) is counted. Unreadable statements are counted with the place of the first; nothing is guessed from them. Where
//! a code comes twice with different values, the first counts and the contradiction is counted, save in the vendor's group V,
//! and M groups without number of their own, where that is usual. The channel specific word: bits 7-0 edition (0 before
//! 106-07, 7 is 106-07, 8 is 106-09, ...), 8 the setup has changed, 9 XML (refused).
//! Memory: [`STATEMENTS`] statements of [`STATEMENT_BYTES`] at most.
//! Source: IRIG 106-09 Chapter 9 (form of attributes); Chapter 10, 10.6.7.2 (setup record; Chapter 11, 11.2.7.2 since
//! 106-17).

use super::error::Chapter10Error;
use super::header::{data_type, u32_at};
use super::packet::Chapter10Packet;
use std::collections::{BTreeMap, BTreeSet};

/// Statements that are kept at most.
pub const STATEMENTS: usize = 1 << 18;
/// The longest statement, bytes.
pub const STATEMENT_BYTES: usize = 8192;

/// A packet with (a part of) the setup record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetupRecord<'a> {
    /// Edition of the standard after which the file is written, as its code.
    pub edition: u8,
    /// Whether the setup changed while recording.
    pub changed: bool,
    /// The text. A setup that needs several packets is the texts in order.
    pub text: &'a [u8],
}

impl<'a> SetupRecord<'a> {
    /// Reads a packet.
    ///
    /// # Errors
    /// [`Chapter10Error`] where it is another kind of packet, too short, or XML.
    pub fn parse(packet: &Chapter10Packet<'a>) -> Result<Self, Chapter10Error> {
        let found = packet.header.data_type;
        if found != data_type::SETUP_RECORD {
            return Err(Chapter10Error::DataType { expected: data_type::SETUP_RECORD, found });
        }
        let short = Chapter10Error::Short { what: "setup record", expected: 4, found: packet.body.len() as u64 };
        let word = u32_at(packet.body, 0).ok_or(short)?;
        if word >> 9 & 1 == 1 {
            return Err(Chapter10Error::SetupXml);
        }
        let text = packet.body.get(4..).ok_or(short)?;
        Ok(SetupRecord { edition: (word & 0xFF) as u8, changed: word >> 8 & 1 == 1, text })
    }
}

/// What a text held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TmatsTally {
    /// Attributes that were read.
    pub attributes: u64,
    /// Comments.
    pub comments: u64,
    /// Statements that are no attribute: no colon, a code that is none, too long, or bytes that are no text.
    pub unreadable: u64,
    /// Where the first of these began, bytes from the start of the text.
    pub first_unreadable_at: Option<u64>,
    /// Comments that hold a further statement: a semicolon was forgotten, and that statement is lost.
    pub swallowed: u64,
    /// Codes that came again with another value.
    pub contradicting: u64,
    /// Bytes behind the last semicolon.
    pub unfinished_bytes: u64,
    /// Statements beyond those that are kept.
    pub too_many: u64,
}

/// The attributes of a setup.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tmats {
    attributes: BTreeMap<String, String>,
    contradicted: BTreeSet<String>,
    tally: TmatsTally,
}

impl Tmats {
    /// Reads a text.
    pub fn parse(text: &[u8]) -> Self {
        let mut tmats = Tmats::default();
        let mut at = 0_u64;
        let mut statements = text.split(|byte| *byte == b';').peekable();
        while let Some(statement) = statements.next() {
            if statements.peek().is_none() {
                let rest = statement.trim_ascii().iter().filter(|byte| **byte != 0).count();
                tmats.tally.unfinished_bytes = rest as u64;
                break;
            }
            let blank = statement.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            if blank < statement.len() {
                tmats.statement(at + blank as u64, statement.trim_ascii());
            }
            at += statement.len() as u64 + 1;
        }
        tmats
    }

    /// What the text held.
    pub fn tally(&self) -> TmatsTally {
        self.tally
    }

    /// The value of an attribute, such as `P-1\D2`.
    pub fn get(&self, code: &str) -> Option<&str> {
        self.attributes.get(&code.to_ascii_uppercase()).map(String::as_str)
    }

    /// All attributes by code, in capitals.
    pub fn attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.attributes.iter().map(|(code, value)| (code.as_str(), value.as_str()))
    }

    /// The codes that came again with another value, in capitals.
    pub fn contradicted(&self) -> impl Iterator<Item = &str> {
        self.contradicted.iter().map(String::as_str)
    }

    fn statement(&mut self, at: u64, statement: &[u8]) {
        let colon = statement.iter().position(|byte| *byte == b':');
        let split = colon.and_then(|colon| Some((statement.get(..colon)?, statement.get(colon + 1..)?)));
        let texts = split
            .and_then(|(code, value)| Some((std::str::from_utf8(code).ok()?.trim(), std::str::from_utf8(value).ok()?.trim())));
        if let Some((code, _)) = split
            && code.trim_ascii().eq_ignore_ascii_case(b"COMMENT")
        {
            self.tally.comments += 1;
            if statement.split(|byte| *byte == b'\n').skip(1).any(begins_statement) {
                self.tally.swallowed += 1;
            }
            return;
        }
        match texts {
            Some((code, value)) if is_code(code) && statement.len() <= STATEMENT_BYTES => {
                if self.attributes.len() >= STATEMENTS {
                    self.tally.too_many += 1;
                    return;
                }
                self.tally.attributes += 1;
                let code = code.to_ascii_uppercase();
                match self.attributes.get(&code) {
                    None => drop(self.attributes.insert(code, value.to_owned())),
                    Some(first) if first == value || may_repeat(&code) => {}
                    Some(_) => {
                        self.contradicted.insert(code);
                        self.tally.contradicting += 1;
                    }
                }
            }
            _ => {
                self.tally.unreadable += 1;
                self.tally.first_unreadable_at.get_or_insert(at);
            }
        }
    }
}

/// Whether this is a code: a group such as `G` or `P-12`, a backslash, and a name.
fn is_code(code: &str) -> bool {
    let Some((group, name)) = code.split_once('\\') else { return false };
    let (letter, number) = group.split_once('-').map_or((group, None), |(letter, number)| (letter, Some(number)));
    letter.len() == 1
        && letter.bytes().all(|byte| byte.is_ascii_alphabetic())
        && number.is_none_or(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
        && !name.is_empty()
        && name.bytes().all(|byte| byte.is_ascii_graphic())
}

/// Whether a line looks like the start of an attribute.
fn begins_statement(line: &[u8]) -> bool {
    let code = line.split(|byte| *byte == b':').next().and_then(|code| std::str::from_utf8(code).ok());
    line.contains(&b':') && code.is_some_and(|code| is_code(code.trim()))
}

fn may_repeat(code: &str) -> bool {
    code.starts_with('V') || code.starts_with('M')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_found_by_code_and_losses_are_counted() {
        let text = b"G\\PN:TEST;\r\nP-1\\D2: 1666666 ;\r\n\r\n COMMENT: all is well;\n\
            p-1\\mf5:1111\n0000;P-1\\D2:5;P-1\\D2:1666666;\n\
            V-1\\X:1;V-1\\X:2;no colon;P-\\D1:X;12\\D1:X;G\\A:\xFF;COMMENT: forgotten\nR-1\\MRC\\E:F;\nG\\LAST:1";
        let tmats = Tmats::parse(text);
        assert_eq!((tmats.get("G\\PN"), tmats.get("p-1\\d2")), (Some("TEST"), Some("1666666")));
        assert_eq!((tmats.get("P-1\\MF5"), tmats.get("G\\LAST")), (Some("1111\n0000"), None));
        let expected = TmatsTally {
            attributes: 7,
            comments: 2,
            unreadable: 4,
            first_unreadable_at: Some(115),
            swallowed: 1,
            contradicting: 1,
            unfinished_bytes: 8,
            too_many: 0,
        };
        assert_eq!(tmats.tally(), expected);
        assert_eq!(tmats.contradicted().collect::<Vec<_>>(), ["P-1\\D2"]);
        assert_eq!(&text[115..123], b"no colon");
    }

    #[test]
    fn an_empty_text_has_nothing_and_a_filled_one_nothing_more() {
        assert_eq!(Tmats::parse(b""), Tmats::default());
        assert_eq!(Tmats::parse(b"G\\PN:A;\0\0\0").tally().unfinished_bytes, 0);
        assert_eq!(Tmats::parse(&vec![b'A'; 20_000]).tally().unfinished_bytes, 20_000);
        let long = [b"G\\PN:".to_vec(), vec![b'A'; STATEMENT_BYTES], b";".to_vec()].concat();
        assert_eq!(Tmats::parse(&long).tally().unreadable, 1);
    }
}
