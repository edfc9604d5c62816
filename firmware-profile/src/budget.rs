//! The budget: how many bytes each part may take; numbers from `budget.toml`, asserted as the crate compiles.

use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::ekf::Ekf;
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::pipeline::{Pipeline, Tick};
use sideslip::realtime::regression::recursive::Recursive;

include!(concat!(env!("OUT_DIR"), "/budget.rs"));

/// A part with what it takes and what it may take, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name, as in `budget.toml`.
    pub name: &'static str,
    /// What it takes.
    pub bytes: usize,
    /// What it may take.
    pub limit: usize,
}

const fn part<T>(name: &'static str, limit: usize) -> Part {
    Part { name, bytes: size_of::<T>(), limit }
}

/// Every part.
pub const PARTS: [Part; 7] = [
    part::<crate::Profile>("profile", PROFILE_BYTES),
    part::<Pipeline>("pipeline", PIPELINE_BYTES),
    part::<Estimator>("estimator", ESTIMATOR_BYTES),
    part::<Ekf>("filter", FILTER_BYTES),
    part::<Recursive>("regression", REGRESSION_BYTES),
    part::<Tick>("tick", TICK_BYTES),
    part::<Sample>("sample", SAMPLE_BYTES),
];

const fn within(place: usize) -> bool {
    PARTS[place].bytes <= PARTS[place].limit
}

const _: () = assert!(within(0), "Profile is larger than `profile` in firmware-profile/budget.toml");
const _: () = assert!(within(1), "Pipeline is larger than `pipeline` in firmware-profile/budget.toml");
const _: () = assert!(within(2), "Estimator is larger than `estimator` in firmware-profile/budget.toml");
const _: () = assert!(within(3), "Ekf is larger than `filter` in firmware-profile/budget.toml");
const _: () = assert!(within(4), "Recursive is larger than `regression` in firmware-profile/budget.toml");
const _: () = assert!(within(5), "Tick is larger than `tick` in firmware-profile/budget.toml");
const _: () = assert!(within(6), "Sample is larger than `sample` in firmware-profile/budget.toml");
