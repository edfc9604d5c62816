//! Changes of inputs as damage and malice make them: flipped bits, wild numbers, cuts, repeats, parts of other inputs.

/// Numbers at the edges of lengths and counts.
const WILD: [u64; 12] =
    [0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFF_FFFF, 0xFFFF_FFFF, 1 << 40, i64::MAX.cast_unsigned(), u64::MAX];
/// Inputs do not grow beyond that, bytes.
const LONGEST: usize = 64 << 10;

/// Changes inputs; the same for the same seed (SplitMix64).
pub(super) struct Mutator(u64);

impl Mutator {
    pub(super) fn new(seed: u64) -> Self {
        Mutator(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit.max(1) as u64) as usize
    }

    /// A stretch of the bytes, more often a short one.
    fn stretch(&mut self, length: usize) -> std::ops::Range<usize> {
        let from = self.below(length);
        let longest = if self.below(4) == 0 { length } else { 16 };
        from..(from + 1 + self.below(longest)).min(length)
    }

    /// One of the inputs with one to five changes.
    pub(super) fn change(&mut self, inputs: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = inputs[self.below(inputs.len())].clone();
        for _ in 0..=self.below(5) {
            if bytes.is_empty() {
                break;
            }
            let (at, part) = (self.below(bytes.len()), self.stretch(bytes.len()));
            match self.below(9) {
                0 => bytes[at] ^= 1 << self.below(8),
                1 => bytes[at] = self.bits() as u8,
                2 => {
                    let wild = WILD[self.below(WILD.len())];
                    let (little, big) = (wild.to_le_bytes(), wild.to_be_bytes());
                    let width = [1, 2, 4, 8][self.below(4)].min(bytes.len() - at);
                    let number = if self.below(3) > 0 { &little[..width] } else { &big[8 - width..] };
                    bytes[at..at + width].copy_from_slice(number);
                }
                3 => bytes.truncate(at),
                4 => drop(bytes.drain(part)),
                5 => {
                    let repeated = bytes[part].repeat(1 + self.below(8));
                    drop(bytes.splice(at..at, repeated));
                }
                6 => {
                    let other = &inputs[self.below(inputs.len())];
                    let taken = self.stretch(other.len());
                    drop(bytes.splice(part, other[taken].iter().copied()));
                }
                7 => {
                    // A digit of a text.
                    if let Some(digit) = bytes.get_mut(at..).and_then(|rest| rest.iter_mut().find(|byte| byte.is_ascii_digit())) {
                        *digit = b"0123456789-.e\"[]"[self.below(16)];
                    }
                }
                _ => bytes[part].fill([0, 0xFF][self.below(2)]),
            }
            bytes.truncate(LONGEST);
        }
        bytes
    }
}
