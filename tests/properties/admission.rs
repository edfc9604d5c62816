//! Whatever telemetry brings, only numbers in order of time reach the estimator, and they reach it as they were.

use super::any_sample::{any_sample, times};
use proptest::prelude::*;
use sideslip::flight::channel::Channel;
use sideslip::realtime::estimation::admission::{Admission, Verdict};
use sideslip::realtime::estimation::record::EstimationEvent;

proptest! {
    #![proptest_config(super::cases(256))]

    #[test]
    fn only_finite_numbers_in_order_of_time_pass(
        steps in times(),
        samples in prop::collection::vec(any_sample(), 60),
        gap_s in 0.05..60.0_f64,
    ) {
        let mut admission = Admission::new(gap_s);
        let mut newest_s = None;
        for (mut sample, time_s) in samples.into_iter().zip(steps) {
            sample.time_s = time_s;
            let (before, mut events) = (sample, Vec::new());
            let verdict = admission.admit(&mut sample, |event| events.push(event));
            if verdict == Verdict::Drop {
                prop_assert_eq!(events.len(), 1, "a dropped sample is said once: {:?}", events);
                continue;
            }
            prop_assert!(sample.time_s.is_finite());
            prop_assert_eq!(sample.time_s.to_bits(), before.time_s.to_bits());
            if let (Verdict::Use, Some(newest_s)) = (verdict, newest_s) {
                prop_assert!(sample.time_s > newest_s && sample.time_s - newest_s <= gap_s);
            }
            newest_s = Some(sample.time_s);
            for channel in Channel::ALL {
                let refused = events.iter().any(|event| match event {
                    EstimationEvent::NotFinite { channel: of } => *of == channel,
                    EstimationEvent::OutOfRange { channel: of, .. } => *of == channel,
                    _ => false,
                });
                match (before.get(channel), sample.get(channel)) {
                    (None, None) => prop_assert!(!refused),
                    (Some(_), None) => prop_assert!(refused),
                    (Some(was), Some(is)) => prop_assert!(!refused && is.is_finite() && is.to_bits() == was.to_bits()),
                    (None, Some(_)) => prop_assert!(false, "{:?} was made up", channel),
                }
            }
        }
    }
}
