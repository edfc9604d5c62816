//! Faults of instruments that are put into samples, simulated or recorded.

use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;

/// What is wrong with the readings of some channels.
#[derive(Clone, Copy, Debug)]
pub(super) enum Fault {
    /// They read so many times the truth.
    Factor(f64),
    /// They stand still from the first time to the second, s.
    Frozen(f64, f64),
    /// They go no further than this from zero.
    Clipped(f64),
    /// The first two are exchanged.
    Exchanged,
    /// One reading in fifty, by chance, is off by this one way or the other.
    Spiky(f64),
}

/// A number made of the bits of a time, as good as random.
fn hashed(time_s: f64) -> u64 {
    time_s.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40
}

/// Puts the fault into a sample; `held` are the readings at the beginning of a freeze.
pub(super) fn spoil(sample: &mut Sample, channels: &[Channel], fault: Fault, held: &mut [Option<f64>; 3]) {
    if let (Fault::Exchanged, [one, other, ..]) = (fault, channels)
        && let (Some(a), Some(b)) = (sample.get(*one), sample.get(*other))
    {
        sample.set(*one, b);
        sample.set(*other, a);
    }
    for (&channel, held) in channels.iter().zip(held) {
        let Some(value) = sample.get(channel) else { continue };
        let spoiled = match fault {
            Fault::Factor(factor) => factor * value,
            Fault::Frozen(from_s, to_s) if (from_s..to_s).contains(&sample.time_s) => *held.get_or_insert(value),
            Fault::Frozen(..) | Fault::Exchanged => value,
            Fault::Clipped(most) => value.clamp(-most, most),
            Fault::Spiky(size) => match hashed(sample.time_s) % 100 {
                0 => value + size,
                1 => value - size,
                _ => value,
            },
        };
        sample.set(channel, spoiled);
    }
}
