//! Admission: range and time checks of a sample before the estimator, with an event for what is refused.
//!
//! Consumes a received sample; produces the same sample without invalid channels, and a verdict on its time. Nothing is
//! repaired: a channel that is not finite or out of its range counts as not sampled, a sample out of order is dropped, and
//! each is an event.

use super::record::EstimationEvent;
use crate::flight::channel::Channel;
use crate::flight::sample::Sample;

/// Consecutive samples, in order among themselves but before the newest one, that begin a new segment.
const RESTART_AFTER: u32 = 10;

/// What to do with a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Use it.
    Use,
    /// Use it after starting again: silence, or a clock that was set back.
    Restart,
    /// Drop it.
    Drop,
}

/// State of the time check.
#[derive(Clone, Debug)]
pub struct Admission {
    gap_s: f64,
    newest_s: Option<f64>,
    before_s: f64,
    before: u32,
}

/// Smallest and largest value of a channel that counts as a measurement, SI.
pub(crate) fn range(channel: Channel) -> (f64, f64) {
    match channel {
        Channel::Ax | Channel::Ay | Channel::Az => (-500.0, 500.0),
        Channel::P | Channel::Q | Channel::R => (-20.0, 20.0),
        Channel::Phi | Channel::Theta => (-3.2, 3.2),
        // Heading may count turns; in degrees it is soon beyond.
        Channel::Psi => (-100.0, 100.0),
        Channel::Alpha | Channel::Beta => (-1.6, 1.6),
        Channel::Tas => (-5.0, 1000.0),
        Channel::Altitude => (-2000.0, 60_000.0),
        // A surface or a blade stalls far below a radian; a collective may be the angle of a lever.
        Channel::LonCyclic | Channel::LatCyclic | Channel::Pedal => (-1.05, 1.05),
        Channel::Collective => (-1.6, 1.6),
        Channel::TailPitch | Channel::Flap0 | Channel::Flap1c | Channel::Flap1s => (-3.2, 3.2),
        Channel::RotorSpeed => (-1.0, 2000.0),
        Channel::Torque => (-1e8, 1e8),
        Channel::Rho => (1e-4, 10.0),
    }
}

impl Admission {
    /// Silence longer than `gap_s` is a gap.
    pub const fn new(gap_s: f64) -> Self {
        Admission { gap_s, newest_s: None, before_s: 0.0, before: 0 }
    }

    /// Checks the sample's time and removes invalid channels; events go to `notice`.
    pub fn admit(&mut self, sample: &mut Sample, mut notice: impl FnMut(EstimationEvent)) -> Verdict {
        if !sample.time_s.is_finite() {
            notice(EstimationEvent::TimeNotFinite);
            return Verdict::Drop;
        }
        let verdict = self.order(sample.time_s, &mut notice);
        if verdict == Verdict::Drop {
            return verdict;
        }
        for channel in Channel::ALL {
            let Some(value) = sample.get(channel) else { continue };
            let (low, high) = range(channel);
            if !value.is_finite() {
                notice(EstimationEvent::NotFinite { channel });
                sample.clear(channel);
            } else if value < low || value > high {
                notice(EstimationEvent::OutOfRange { channel, value });
                sample.clear(channel);
            }
        }
        verdict
    }

    fn order(&mut self, time_s: f64, notice: &mut impl FnMut(EstimationEvent)) -> Verdict {
        let Some(newest_s) = self.newest_s else {
            self.newest_s = Some(time_s);
            return Verdict::Use;
        };
        let step = time_s - newest_s;
        if step > 0.0 {
            self.before = 0;
            self.newest_s = Some(time_s);
            if step > self.gap_s {
                notice(EstimationEvent::Gap { seconds: step });
                return Verdict::Restart;
            }
            return Verdict::Use;
        }
        if step < 0.0 {
            self.before = if self.before > 0 && time_s > self.before_s { self.before + 1 } else { 1 };
            self.before_s = time_s;
            if self.before >= RESTART_AFTER {
                self.before = 0;
                self.newest_s = Some(time_s);
                notice(EstimationEvent::SegmentRestart);
                return Verdict::Restart;
            }
            notice(EstimationEvent::TimeWentBack { by_s: -step });
        } else {
            notice(EstimationEvent::DuplicateTime);
        }
        Verdict::Drop
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn admit(admission: &mut Admission, time_s: f64) -> (Verdict, Vec<EstimationEvent>) {
        let mut events = Vec::new();
        let verdict = admission.admit(&mut Sample::new(time_s), |event| events.push(event));
        (verdict, events)
    }

    #[test]
    fn time_that_does_not_increase_is_dropped_with_an_event() {
        let mut admission = Admission::new(1.0);
        assert_eq!(admit(&mut admission, 5.0), (Verdict::Use, vec![]));
        assert_eq!(admit(&mut admission, 5.0), (Verdict::Drop, vec![EstimationEvent::DuplicateTime]));
        assert_eq!(admit(&mut admission, 4.5), (Verdict::Drop, vec![EstimationEvent::TimeWentBack { by_s: 0.5 }]));
        assert_eq!(admit(&mut admission, f64::NAN), (Verdict::Drop, vec![EstimationEvent::TimeNotFinite]));
        assert_eq!(admit(&mut admission, 5.5), (Verdict::Use, vec![]));
        assert_eq!(admit(&mut admission, 10.5), (Verdict::Restart, vec![EstimationEvent::Gap { seconds: 5.0 }]));
    }

    #[test]
    fn a_clock_that_was_set_back_begins_a_new_segment() {
        let mut admission = Admission::new(1.0);
        assert_eq!(admit(&mut admission, 100.0).0, Verdict::Use);
        for i in 0..RESTART_AFTER - 1 {
            assert_eq!(admit(&mut admission, 0.01 * f64::from(i)).0, Verdict::Drop);
        }
        assert_eq!(admit(&mut admission, 0.5), (Verdict::Restart, vec![EstimationEvent::SegmentRestart]));
        assert_eq!(admit(&mut admission, 0.51).0, Verdict::Use);
    }

    #[test]
    fn an_invalid_channel_counts_as_not_sampled() {
        let mut admission = Admission::new(1.0);
        let mut sample = Sample::new(0.0);
        sample.set(Channel::Beta, 13.0);
        sample.set(Channel::P, f64::NAN);
        sample.set(Channel::R, 0.1);
        let mut events = Vec::new();
        assert_eq!(admission.admit(&mut sample, |event| events.push(event)), Verdict::Use);
        assert_eq!(events[0], EstimationEvent::NotFinite { channel: Channel::P });
        assert_eq!(events[1], EstimationEvent::OutOfRange { channel: Channel::Beta, value: 13.0 });
        assert_eq!((sample.get(Channel::P), sample.get(Channel::Beta), sample.get(Channel::R)), (None, None, Some(0.1)));
    }
}
