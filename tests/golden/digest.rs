//! Strong hashes of what is too long to be written out.

use sha2::{Digest, Sha256};

/// Characters of the hash that are written: 128 bits.
const WRITTEN: usize = 32;

/// SHA-256 of the bytes as hexadecimal digits, the first half of them.
pub(crate) fn sha256(bytes: impl AsRef<[u8]>) -> String {
    let mut text: String = Sha256::digest(bytes.as_ref()).iter().map(|byte| format!("{byte:02x}")).collect();
    text.truncate(WRITTEN);
    text
}

/// Places of about `wanted` entries of `count`, evenly from the first, and the last.
pub(crate) fn spread(count: usize, wanted: usize) -> Vec<usize> {
    let step = count.div_ceil(wanted.max(1)).max(1);
    let mut places: Vec<usize> = (0..count).step_by(step).collect();
    if places.last().is_some_and(|&last| last + 1 < count) {
        places.push(count - 1);
    }
    places
}

#[test]
fn a_hash_is_that_of_the_standard() {
    assert_eq!(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223");
    assert_eq!(spread(10, 4), [0, 3, 6, 9]);
    assert_eq!(spread(9, 4), [0, 3, 6, 8]);
    assert!(spread(0, 4).is_empty());
}
