//! Builds packets for tests, straight from the layout in the standard.

/// One packet: the body, filled up with `filler` zeros as needed, and a data checksum of `checksum` (flag bits 1-0).
pub(super) fn packet(channel: u16, data_type: u8, sequence: u8, rtc: u64, body: &[u8], checksum: u8) -> Vec<u8> {
    let width = [0, 1, 2, 4][usize::from(checksum)];
    let mut trailer = body.to_vec();
    while !(trailer.len() + width).is_multiple_of(4) {
        trailer.push(0);
    }
    let length = 24 + trailer.len() + width;
    let mut bytes = vec![0x25, 0xEB];
    bytes.extend(channel.to_le_bytes());
    bytes.extend((length as u32).to_le_bytes());
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend([3, sequence, checksum, data_type]);
    bytes.extend(&rtc.to_le_bytes()[..6]);
    let sum: u32 = bytes.chunks(2).map(|word| u32::from(word[0]) + 256 * u32::from(word[1])).sum();
    bytes.extend((sum as u16).to_le_bytes());
    let mut sum: u64 = 0;
    for word in trailer.chunks(width.max(1)) {
        sum += word.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte));
    }
    bytes.extend(&trailer);
    bytes.extend(&sum.to_le_bytes()[..width]);
    bytes
}

/// Deterministic noise (xorshift).
pub(super) struct Noise(pub(super) u64);

impl Noise {
    /// The next number.
    pub(super) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// A number below a bound.
    pub(super) fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }
}
