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
        };
        sample.set(channel, spoiled);
    }
}
