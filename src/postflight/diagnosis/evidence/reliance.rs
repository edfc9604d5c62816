//! Which of the causes that fit are relied upon: those that are large enough to matter and that hold-out runs do not contradict.
//!
//! With many samples every small imperfection of a model is significant, and the library's nearest effect fits it with high
//! probability, for probabilities are among the effects of the library. What tells a cause from these is what it explains, and
//! what it predicts of runs that it was not found in. A cause is
//!     small      where of the error that larger causes leave its share is below [`SMALL_SHARE`], or below
//!                [`SMALL_SHARE_HARDLY_MOVING`] while it changes no channel by more than [`SMALL_MOTION`] of its motion; and its
//!                error below that which all causes leave (process noise, gusts included);
//!     refuted    where hold-out runs contradict it (`HoldoutEvidence::verdict`).
//! Both are reported, each with its reason, and stand neither among the causes nor in the extended model.

use super::cause_size::CauseSizes;

/// Share of the model's error below which a cause is small beside gusts and what is left unexplained.
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
        (share < SMALL_SHARE || hardly_moves) && own.error < self.left
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::postflight::diagnosis::evidence::cause_size::CauseSize;

    fn smallest(of: &[(f64, f64)], left: f64) -> bool {
        let of: Vec<CauseSize> = of.iter().map(|&(motion_share, error)| CauseSize { motion_share, error }).collect();
        CauseSizes { left, of }.is_small(0)
    }

    /// A weak cause beside a strong one counts where both together leave less than it explains.
    #[test]
    fn a_cause_is_small_beside_what_is_left() {
        assert!(smallest(&[(0.2, 1.0)], 100.0) && !smallest(&[(0.2, 2.0)], 100.0));
        assert!(smallest(&[(0.03, 2.0)], 100.0) && !smallest(&[(0.03, 30.0)], 100.0), "it hardly moves anything");
        assert!(!smallest(&[(0.2, 1.0)], 0.5), "what is left is smaller still");
        assert!(!smallest(&[(0.2, 1.0), (0.5, 1000.0)], 2.0), "of what the larger cause leaves it is half");
    }
}
