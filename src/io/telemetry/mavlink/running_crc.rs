//! Checksums of overlapping pieces of one stream at a cost that does not grow with their length.
//!
//! Consumes the bytes of a stream; produces the checksum (CRC-16/MCRF4XX, as MAVLink defines it) of any piece in reach. With Z
//! the step of the register over a zero byte and S(n) the register after n bytes of the stream, begun at zero, linearity gives
//! for the bytes from a to b
//!     crc = S(b) + Z^(b-a) (S(a) + 0xFFFF)                                                                        (1)
//! over GF(2), so that each byte is summed once however many false start markers stand before it.
//! Memory: [`REACH`] registers, and one table of Z^n for every length of a frame.

/// Registers that are kept: more than the framer's window has bytes.
const REACH: usize = 8192;
/// The longest piece, bytes: the header without its marker, and the payload.
const LONGEST: usize = 9 + 255;
const SEED: u16 = 0xFFFF;

/// Z^n of each bit, for n from 0 to [`LONGEST`].
static ZERO_STEPS: [[u16; 16]; LONGEST + 1] = zero_steps();

const fn step(register: u16, byte: u8) -> u16 {
    let mut mixed = byte ^ register.to_le_bytes()[0];
    mixed ^= mixed << 4;
    let mixed = mixed as u16;
    (register >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
}

const fn zero_steps() -> [[u16; 16]; LONGEST + 1] {
    let mut table = [[0; 16]; LONGEST + 1];
    let mut bit = 0;
    while bit < 16 {
        let (mut register, mut steps) = (1_u16 << bit, 0);
        while steps <= LONGEST {
            table[steps][bit] = register;
            register = step(register, 0);
            steps += 1;
        }
        bit += 1;
    }
    table
}

/// The registers of a stream.
pub(super) struct RunningCrc {
    registers: Box<[u16]>,
    /// Up to this place in the stream they are known.
    known_to: u64,
}

impl RunningCrc {
    /// Nothing summed yet.
    pub(super) fn new() -> Self {
        RunningCrc { registers: vec![0; REACH].into(), known_to: 0 }
    }

    /// The checksum of `bytes[from..to]` followed by `extra`, where the first of the bytes stands at `position` in the stream;
    /// `None` where that is no piece of them, or one that is longer than any frame. Positions never decrease.
    pub(super) fn of(&mut self, position: u64, bytes: &[u8], (from, to): (usize, usize), extra: u8) -> Option<u16> {
        let shift = ZERO_STEPS.get(to.checked_sub(from)?)?;
        self.sum(position, bytes.get(..to)?);
        let begun = self.register(position + from as u64) ^ SEED;
        let shifted = shift.iter().enumerate().fold(0, |sum, (bit, column)| sum ^ (column * (begun >> bit & 1)));
        Some(step(self.register(position + to as u64) ^ shifted, extra))
    }

    fn sum(&mut self, position: u64, bytes: &[u8]) {
        // What was passed without being summed is in no piece that follows: any register will do.
        self.known_to = self.known_to.max(position);
        let known = usize::try_from(self.known_to - position).unwrap_or(usize::MAX);
        let mut register = self.register(self.known_to);
        for byte in bytes.iter().skip(known) {
            register = step(register, *byte);
            self.known_to += 1;
            if let Some(place) = self.registers.get_mut(place(self.known_to)) {
                *place = register;
            }
        }
    }

    fn register(&self, at: u64) -> u16 {
        self.registers.get(place(at)).copied().unwrap_or_default()
    }
}

fn place(at: u64) -> usize {
    usize::try_from(at % REACH as u64).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_has_the_checksum_that_its_bytes_have_alone() {
        let mut random = 0x9E37_79B9_u32;
        let mut next = || {
            random ^= random << 13;
            random ^= random >> 17;
            random ^= random << 5;
            random
        };
        let stream: Vec<u8> = (0..3 * REACH).map(|_| next().to_le_bytes()[1]).collect();
        let (mut sums, mut position) = (RunningCrc::new(), 0);
        while position + 4096 <= stream.len() {
            let window = &stream[position..position + 4096];
            for _ in 0..20 {
                let from = next() as usize % 3000;
                let to = from + next() as usize % (LONGEST + 1);
                let extra = next().to_le_bytes()[0];
                let expected = mavlink::calculate_crc(&window[from..to], extra);
                assert_eq!(sums.of(position as u64, window, (from, to), extra), Some(expected), "{position} {from} {to}");
            }
            position += next() as usize % 700;
        }
        assert_eq!(sums.of(position as u64, &stream[position..], (0, LONGEST + 1), 0), None);
    }
}
