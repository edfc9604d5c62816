//! Which of the causes that fit are relied upon: those that are large enough to matter and that hold-out runs do not contradict.
//!
//! With many samples every small imperfection of a model is significant, and the library's nearest effect fits it with high
//! probability, for probabilities are among the effects of the library. What tells a cause from these is what it explains, and
//! what it predicts of runs that it was not found in. A cause is
//!     small      where its share is below [`SMALL_OF_ALL`] of all the model's error (of an instrument, which errs in one channel
//!                of many, that says nothing), or below [`SMALL_SHARE`] of what larger
//!                causes leave, or below [`SMALL_SHARE_HARDLY_MOVING`] of that while it changes no channel by more than
//!                [`SMALL_MOTION`] of its motion; and its error below that which all causes leave (process noise, gusts
//!                included). Or where its share is below [`MODEST_OF_ALL`] and hold-out runs that should show its gain do not;
//!     refuted    where hold-out runs contradict it (`HoldoutEvidence::verdict`).
//! Both are reported, each with its reason, and stand neither among the causes nor in the extended model.

use super::cause_size::CauseSizes;
use crate::postflight::diagnosis::holdout::holdout_gain::{HoldoutEvidence, HoldoutVerdict};

/// Share of all the model's error below which a cause is small beside gusts and what is left unexplained.
pub const SMALL_OF_ALL: f64 = 0.01;
/// Share of all the model's error below which a cause needs hold-out runs that bear it out, where they can.
pub const MODEST_OF_ALL: f64 = 0.05;
/// Share of the error that larger causes leave below which a cause is small.
pub const SMALL_SHARE: f64 = 0.015;
/// The same of one that hardly changes the motion.
pub const SMALL_SHARE_HARDLY_MOVING: f64 = 0.2;
/// Share of a channel's motion that is hardly a change of it: what instruments inside of their specification are off by.
pub const SMALL_MOTION: f64 = 0.05;

/// Why a cause that fits is not relied upon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CauseRejection {
    /// Hold-out runs are predicted worse with it.
    Refuted,
    /// Of the channel that it should improve most hold-out runs show less than a quarter of the gain that it predicts.
    GainNotSeen,
    /// It explains next to nothing of the error.
    Small,
}

impl CauseSizes {
    /// Whether the cause at that place is small.
    pub(crate) fn is_small(&self, place: usize) -> bool {
        let Some(own) = self.of.get(place) else { return false };
        let not_larger: f64 = self.of.iter().map(|one| one.error).filter(|error| *error <= own.error).sum();
        let share = own.error / (not_larger + self.left);
        let hardly_moves = own.motion_share < SMALL_MOTION && share < SMALL_SHARE_HARDLY_MOVING;
        let all: f64 = self.of.iter().map(|one| one.error).sum::<f64>() + self.left;
        let next_to_nothing = own.error < SMALL_OF_ALL * all && !own.of_instrument;
        (share < SMALL_SHARE || next_to_nothing || hardly_moves) && own.error < self.left
    }
}

/// Whether a cause of that share of all error is too modest to be relied upon without hold-out runs that bear it out, and these
/// do not, though they should.
pub(crate) fn is_modest_and_not_seen(error_share: f64, evidence: &HoldoutEvidence) -> bool {
    error_share < MODEST_OF_ALL && evidence.is_telling() && evidence.verdict() == HoldoutVerdict::NotSeen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::postflight::diagnosis::evidence::cause_size::CauseSize;

    fn smallest(of: &[(f64, f64)], left: f64) -> bool {
        let of: Vec<CauseSize> =
            of.iter().map(|&(motion_share, error)| CauseSize { motion_share, error, of_instrument: false }).collect();
        CauseSizes { left, of }.is_small(0)
    }

    /// A weak cause beside a strong one counts where both together leave less than it explains.
    #[test]
    fn a_cause_is_small_beside_what_is_left() {
        assert!(smallest(&[(0.2, 1.0)], 100.0) && !smallest(&[(0.2, 2.0)], 100.0));
        assert!(smallest(&[(0.03, 2.0)], 100.0) && !smallest(&[(0.03, 30.0)], 100.0), "it hardly moves anything");
        assert!(!smallest(&[(0.2, 1.0)], 0.5), "what is left is smaller still");
        assert!(!smallest(&[(0.2, 1.0), (0.5, 1000.0)], 0.5), "the larger cause leaves less");
        assert!(smallest(&[(0.2, 1.0), (0.5, 1000.0)], 2.0), "next to nothing of all");
        assert!(!smallest(&[(0.2, 1.0), (0.5, 50.0)], 2.0), "of what the larger cause leaves it is half");
    }
}
