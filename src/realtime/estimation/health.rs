//! Health of an aid: whether its innovations are fused, and whether they are as large as the filter expects.
//!
//! Consumes the innovations of one aid; produces an event where its health changes. The running mean of the normalised
//! innovation squared nu^2/s is 1 where the noise is as configured:
//!     m <- m + max(g, 1/n) (nu^2/s - m)                                                              (1)

use super::record::{EstimationEvent, Innovation};

/// Weight g of the newest normalised innovation in its running mean.
const NIS_GAIN: f64 = 0.01;
/// Mean normalised innovation squared above which the innovations are too large.
const NIS_LARGE: f64 = 4.0;
/// Least number of innovations for that.
const NIS_COUNT: u32 = 100;
/// Weight of the newest innovation in the rejected fraction, and least number of innovations for it.
const PART_GAIN: f64 = 0.02;
const TRUST_COUNT: u32 = 20;
/// Time without rejections after which a rejection is an event again, s.
const REPORT_AGAIN_S: f64 = 2.0;

/// Health of one aid.
#[derive(Clone, Copy, Debug)]
pub struct AidHealth {
    mean_nis: f64,
    count: u32,
    rejected_s: Option<f64>,
    /// Running mean of 1 where rejected, 0 where fused.
    rejected_part: f64,
    reported: bool,
}

impl AidHealth {
    /// Before the first innovation.
    pub const NEW: AidHealth = AidHealth { mean_nis: 1.0, count: 0, rejected_s: None, rejected_part: 0.0, reported: false };

    /// Whether it is fused most of the time.
    pub fn is_trusted(&self) -> bool {
        self.count < TRUST_COUNT || self.rejected_part < 0.5
    }

    /// Whether its mean normalised innovation squared is not too large.
    pub fn is_as_expected(&self) -> bool {
        !self.reported
    }

    /// Takes an innovation in, with the variance s that it should have; the event where the aid's health has changed.
    pub fn judge(&mut self, innovation: &Innovation, expected_var: f64) -> Option<EstimationEvent> {
        let aid = innovation.aid;
        let nis = innovation.innovation * innovation.innovation / expected_var;
        self.count = self.count.saturating_add(1);
        self.mean_nis += NIS_GAIN.max(1.0 / f64::from(self.count)) * (nis - self.mean_nis);
        let rejected = if innovation.fused { 0.0 } else { 1.0 };
        self.rejected_part += PART_GAIN.max(1.0 / f64::from(self.count)) * (rejected - self.rejected_part);
        let mut event = None;
        if innovation.fused {
            if self.rejected_s.is_some_and(|since| innovation.time_s - since > REPORT_AGAIN_S) {
                self.rejected_s = None;
                event = Some(EstimationEvent::AidAccepted { aid });
            }
        } else {
            if self.rejected_s.is_none() {
                event = Some(EstimationEvent::AidRejected { aid, test_ratio: innovation.test_ratio });
            }
            self.rejected_s = Some(innovation.time_s);
        }
        if self.count > NIS_COUNT && self.mean_nis > NIS_LARGE && !self.reported {
            self.reported = true;
            event = event.or(Some(EstimationEvent::InnovationsTooLarge { aid, mean_nis: self.mean_nis }));
        }
        event
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::Aid;
    use super::*;

    fn innovation(time_s: f64, size: f64, fused: bool) -> Innovation {
        Innovation {
            time_s,
            aid: Aid::Bank,
            observation: 0.0,
            observation_var: 1.0,
            innovation: size,
            innovation_var: 1.0,
            test_ratio: size * size / 25.0,
            fused,
        }
    }

    #[test]
    fn a_rejection_is_one_event_until_none_for_a_while() {
        let mut health = AidHealth::NEW;
        assert_eq!(health.judge(&innovation(0.0, 1.0, true), 1.0), None);
        let said = Some(EstimationEvent::AidRejected { aid: Aid::Bank, test_ratio: 1.44 });
        assert_eq!(health.judge(&innovation(1.0, 6.0, false), 1.0), said);
        assert_eq!(health.judge(&innovation(1.5, 6.0, false), 1.0), None);
        assert_eq!(health.judge(&innovation(3.0, 1.0, true), 1.0), None, "not yet two seconds");
        assert_eq!(health.judge(&innovation(3.6, 1.0, true), 1.0), Some(EstimationEvent::AidAccepted { aid: Aid::Bank }));
        assert_eq!(health.judge(&innovation(4.0, 6.0, false), 1.0), said);
    }

    #[test]
    fn innovations_three_times_too_large_are_one_event() {
        let mut health = AidHealth::NEW;
        let events: Vec<_> = (0..300).filter_map(|i| health.judge(&innovation(f64::from(i), 3.0, true), 1.0)).collect();
        assert_eq!(events.len(), 1);
        let EstimationEvent::InnovationsTooLarge { aid: Aid::Bank, mean_nis } = events[0] else { panic!("{events:?}") };
        assert!((mean_nis - 9.0).abs() < 1e-9, "the mean of equal numbers is that number: {mean_nis}");
    }
}
