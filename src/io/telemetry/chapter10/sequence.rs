//! Sequence numbers: packets that a channel lost.
//!
//! Consumes channel and sequence number of every packet in order; says how many packets are missing before it. The number is
//! one more with every packet of a channel, modulo 256, so that a loss of 256 packets, or a multiple, cannot be seen, and a
//! loss of 255 looks like a packet that came twice (and is taken for one). Memory: one number for each channel, at most
//! 65,536.
//! Source: IRIG 106-09 Chapter 10, 10.6.1.1 f; since 106-17 Chapter 11, 11.2.1.1.

use std::collections::BTreeMap;

/// What a sequence number says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequenceStep {
    /// The first of its channel.
    First,
    /// The one after the last.
    Next,
    /// So many packets are missing before it.
    Gap(u8),
    /// The same as the last.
    Repeated,
}

/// The last sequence number of every channel.
#[derive(Clone, Debug, Default)]
pub struct SequenceCheck {
    last: BTreeMap<u16, u8>,
}

impl SequenceCheck {
    /// Takes in a packet.
    pub fn step(&mut self, channel: u16, sequence: u8) -> SequenceStep {
        match self.last.insert(channel, sequence) {
            None => SequenceStep::First,
            Some(last) => match sequence.wrapping_sub(last) {
                0 => SequenceStep::Repeated,
                1 => SequenceStep::Next,
                more => SequenceStep::Gap(more - 1),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_counted_for_each_channel_and_across_the_end_of_the_numbers() {
        let mut check = SequenceCheck::default();
        let steps: Vec<_> = [(1, 254), (2, 0), (1, 255), (1, 0), (1, 3), (2, 0), (2, 255), (2, 0)]
            .into_iter()
            .map(|(channel, sequence)| check.step(channel, sequence))
            .collect();
        use SequenceStep::{First, Gap, Next, Repeated};
        assert_eq!(steps, [First, First, Next, Next, Gap(2), Repeated, Gap(254), Next]);
    }
}
