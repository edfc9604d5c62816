//! Whether a file is the program's own: a rerun may replace what the program wrote and nobody changed since, and never what a user
//! made or edited.
//!
//! A text says so in a comment, with the SHA-256 of the rest; a JSON document in its `provenance`; a log by its writer, unless it
//! was recorded live, for no rerun brings a flight back; a simulated log of an autopilot by what it says of itself, a simulated
//! tlog by its first stamp, a stream of PCM by the format beside it. What is empty holds nothing that could be lost.

use crate::command::recordings::simulated_run::{SIMULATED, TLOG_START_US, format_beside};
use serde_json::{Deserializer, Value};
use sha2::{Digest, Sha256};
use sideslip::io::outputs::log::mcap_log::program;
use std::fs::File;
use std::io::{Read, Result as IoResult};
use std::path::Path;

/// First key of every JSON document, and the key in it of the digest of the document without that block.
pub(crate) const BLOCK: &str = "provenance";
pub(crate) const DIGEST: &str = "sha256_of_the_rest";

const MARK: &str = "written by sideslip ";
const OF_THE_REST: &str = "; SHA-256 of the rest: ";

/// So much of a binary file is looked at, bytes: the head of a log names its columns before its call.
const HEAD: u64 = 1 << 20;
const MCAP: &[u8] = b"\x89MCAP0\r\n";
const ULOG: &[u8] = b"ULog\x01\x12\x35";
const DATAFLASH: &[u8] = &[0xa3, 0x95];
/// Commands whose logs are of a flight as it was flown.
const RECORDING: [&[u8]; 2] = [b"sideslip estimate", b"sideslip live"];

/// A text by its comments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextKind {
    Toml,
    /// A run file: its preamble is TOML behind `#`.
    RunFile,
    /// HTML, SVG: the comment stands last.
    Markup,
    Manual,
}

impl TextKind {
    /// The text with the mark in it.
    pub(crate) fn marked(self, text: &[u8]) -> Vec<u8> {
        let ended;
        let text = match text.last() {
            // The last line is the mark's alone.
            Some(last) if self == TextKind::Markup && *last != b'\n' => {
                ended = [text, b"\n"].concat();
                &ended
            }
            _ => text,
        };
        let mark = format!("{MARK}{}{OF_THE_REST}{}", version(), sha256(text));
        let line = match self {
            TextKind::Toml => format!("# {mark}\n"),
            TextKind::RunFile => format!("# # {mark}\n"),
            TextKind::Markup => format!("<!-- {mark} -->\n"),
            TextKind::Manual => format!(".\\\" {mark}\n"),
        };
        if self == TextKind::Markup { [text, line.as_bytes()].concat() } else { [line.as_bytes(), text].concat() }
    }
}

/// First line of a text without comments that the program makes for another process to write to.
pub(crate) fn first_line() -> String {
    format!("{MARK}{}\n", version())
}

fn version() -> String {
    program().split_once(' ').map(|(_, version)| version.to_owned()).unwrap_or_default()
}

/// SHA-256 in hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Whether a rerun may replace the file; what cannot be read is not the program's.
pub(crate) fn is_unchanged_output(path: &Path) -> bool {
    looked_at(path).unwrap_or(false)
}

fn looked_at(path: &Path) -> IoResult<bool> {
    let mut file = File::open(path)?;
    let mut bytes = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut bytes)?;
    if bytes.is_empty() {
        return Ok(true);
    }
    if bytes.starts_with(MCAP) {
        return Ok(is_own_log(&bytes));
    }
    let says_simulated = || contains(&bytes, SIMULATED.as_bytes());
    let is_tlog = |stamp: &[u8]| stamp == TLOG_START_US.to_be_bytes();
    if (bytes.starts_with(ULOG) || bytes.starts_with(DATAFLASH)) && says_simulated() || bytes.get(..8).is_some_and(is_tlog) {
        return Ok(true);
    }
    if path.extension().is_some_and(|ending| ending == "pcm") {
        let format = format_beside(path);
        return Ok(format.is_file() && is_unchanged_output(&format));
    }
    file.read_to_end(&mut bytes)?;
    Ok(is_own_text(&bytes))
}

fn contains(bytes: &[u8], words: &[u8]) -> bool {
    bytes.windows(words.len()).any(|window| window == words)
}

/// The writer's name stands in the first record, the call in the metadata.
fn is_own_log(head: &[u8]) -> bool {
    let key = b"command_line";
    let call = head.windows(key.len()).position(|window| window == key).and_then(|place| head.get(place + key.len() + 4..));
    head.get(..64).is_some_and(|first| contains(first, b"sideslip "))
        && call.is_some_and(|call| !RECORDING.iter().any(|command| call.starts_with(command)))
}

fn is_own_text(bytes: &[u8]) -> bool {
    if bytes.first() == Some(&b'{') {
        return std::str::from_utf8(bytes).is_ok_and(|text| is_own_document(text) == Some(true));
    }
    let line_end = bytes.iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |end| end + 1);
    let (first, after) = bytes.split_at(line_end);
    let body = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    let (before, last) = bytes.split_at(body.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1));
    first.starts_with(MARK.as_bytes()) || is_marked(first, after) || is_marked(last, before)
}

/// Whether the line is a mark, and its digest that of the rest.
fn is_marked(line: &[u8], rest: &[u8]) -> bool {
    let line = String::from_utf8_lossy(line);
    let Some((_, mark)) = line.split_once(MARK) else { return false };
    mark.split_once(OF_THE_REST).is_some_and(|(_, digest)| digest.starts_with(&sha256(rest)))
}

/// Whether the digest in the first key is that of the document without it.
fn is_own_document(text: &str) -> Option<bool> {
    let text = text.strip_prefix('{')?.trim_start().strip_prefix(&format!("\"{BLOCK}\""))?.trim_start().strip_prefix(':')?;
    let mut values = Deserializer::from_str(text).into_iter::<Value>();
    let block = values.next()?.ok()?;
    let rest = text.get(values.byte_offset()..)?;
    let rest = format!("{{{}", rest.strip_prefix(',').unwrap_or(rest));
    Some(block[DIGEST].as_str()? == sha256(rest.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_marked_text_is_known_until_a_byte_of_it_changes() {
        for kind in [TextKind::Toml, TextKind::RunFile, TextKind::Markup, TextKind::Manual] {
            for text in ["a = 1\nb = 2\n", "a", "", "a\n\n", "a = 1\nb = 2"] {
                let whole = kind.marked(text.as_bytes());
                assert!(is_own_text(&whole), "{kind:?} {text:?}");
                for place in 0..text.len() {
                    let mut edited = whole.clone();
                    let at = if kind == TextKind::Markup { place } else { whole.len() - text.len() + place };
                    edited[at] ^= 1;
                    assert!(!is_own_text(&edited), "{kind:?} {text:?} {place}");
                }
                assert!(!is_own_text(&[&whole[..], b"c = 3\n"].concat()));
            }
        }
        for theirs in ["", "a = 1\n", "{}", "{\"provenance\": {}}", "{\"provenance\": {\"sha256_of_the_rest\": \"\"}, \"x\": 1}", "{"] {
            assert!(!is_own_text(theirs.as_bytes()), "{theirs}");
        }
    }
}
