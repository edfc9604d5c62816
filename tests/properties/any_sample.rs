//! Samples as they should not be: any bits, any channels, any times.

use proptest::prelude::*;
use sideslip::flight::channel::{CHANNELS, Channel};
use sideslip::flight::sample::Sample;

/// A reading: any bits, some number of flight, or the edge of what counts as one.
fn reading(channel: usize) -> impl Strategy<Value = f64> {
    let size = match Channel::ALL[channel] {
        Channel::Ax | Channel::Ay | Channel::Az => 30.0,
        Channel::Tas => 120.0,
        Channel::Altitude => 3e3,
        Channel::RotorSpeed => 30.0,
        Channel::Torque => 1e4,
        _ => 1.5,
    };
    prop_oneof![
        6 => -size..size,
        2 => any::<u64>().prop_map(f64::from_bits),
        1 => prop::sample::select(vec![0.0, -0.0, 5e-324, 500.0, -500.0, 20.0, -20.0, 3.2, -3.2, 1.6, -1.6, 1000.0, 6e4, -2e3]),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN]),
    ]
}

/// A sample with some of its channels set, bits that belong to no channel among them; its time is 0.
pub(crate) fn any_sample() -> impl Strategy<Value = Sample> {
    let values: Vec<_> = (0..CHANNELS).map(reading).collect();
    let present = prop_oneof![any::<u32>(), Just(u32::MAX), Just((1 << CHANNELS) - 1)];
    (present, values).prop_map(|(present, values)| {
        let mut sample = Sample::new(0.0);
        sample.present = present;
        sample.values.copy_from_slice(&values);
        sample
    })
}

/// 60 times that mostly run on and sometimes stand, jump, go back, or are any bits.
pub(crate) fn times() -> impl Strategy<Value = Vec<f64>> {
    let step = prop_oneof![
        12 => (1e-4..0.05_f64).prop_map(Some),
        2 => (-2.0..5.0_f64).prop_map(Some),
        1 => Just(Some(0.0)),
        1 => prop::sample::select(vec![1e-300, 1e-17, 1e6, -1e6, 1e17, -1e17]).prop_map(Some),
        1 => Just(None),
    ];
    (prop::collection::vec(step, 60), any::<u64>()).prop_map(|(steps, bits)| {
        let mut now = 0.0;
        let any_bits = f64::from_bits(bits);
        let run_on = |step: Option<f64>| {
            now += step.unwrap_or(0.0);
            if step.is_some() { now } else { any_bits }
        };
        steps.into_iter().map(run_on).collect()
    })
}
