//! What the header of a message must look like: the kinds that ULog defines and the sizes that each can have.
//!
//! Consumes a size and a kind; says whether they can belong together. Nothing else in a header shows damage.

/// Bytes before the payload: size (2) and kind (1).
pub(super) const HEADER: usize = 3;
/// The eight bytes of a synchronisation message.
pub(super) const SYNC: [u8; 8] = [0x2F, 0x73, 0x13, 0x20, 0x25, 0x0C, 0xBB, 0x12];
/// Longest message of an unknown kind, and longest out of step, bytes: 'M' with text from a console is the longest known.
pub(super) const LONG: usize = 4096;

/// Size and kind that stand at the start of the bytes.
pub(super) fn header(window: &[u8]) -> Option<(usize, u8)> {
    let [low, high, kind] = *window.first_chunk::<HEADER>()?;
    Some((usize::from(u16::from_le_bytes([low, high])), kind))
}

/// The sizes that a kind can have, least and most; `None` of an unknown kind.
pub(super) fn sizes(kind: u8) -> Option<(usize, usize)> {
    const MOST: usize = 65_535;
    Some(match kind {
        b'B' => (40, 1024),
        b'F' => (4, MOST),
        b'I' | b'P' => (4, MOST),
        b'M' | b'Q' => (5, MOST),
        b'A' => (4, 3 + 255),
        b'R' | b'O' => (2, 2),
        b'D' => (3, MOST),
        b'L' => (9, MOST),
        b'C' => (11, MOST),
        b'S' => (8, 8),
        _ => return None,
    })
}

/// Whether the kind is known and the size one of its own.
pub(super) fn fits(size: usize, kind: u8) -> bool {
    sizes(kind).is_some_and(|(least, most)| (least..=most).contains(&size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirteen_kinds_are_known() {
        let known: String = (0..=255).filter(|kind| sizes(*kind).is_some()).map(char::from).collect();
        assert_eq!(known, "ABCDFILMOPQRS");
        assert!(fits(8, b'S') && !fits(9, b'S') && !fits(2, b'D') && !fits(8, b'X'));
        assert_eq!([header(&[1, 2, b'D', 9]), header(&[1, 2])], [Some((513, b'D')), None]);
    }
}
