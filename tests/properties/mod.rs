//! What must hold for every input: round trips, order, symmetry.
#![allow(clippy::float_cmp, reason = "bits are compared")]

use proptest::test_runner::{Config, RngSeed};

mod admission;
mod any_sample;
mod covariance;
mod filter_covariance;
mod kernel;
mod mavlink_frames;
mod missing;
mod pipeline;
mod run_files;

/// The seed of every run that asks for no other by `PROPTEST_RNG_SEED`.
const SEED: u64 = 20_261_129;

/// So many cases, unless `PROPTEST_CASES` asks for another number; a gate must not depend on chance.
fn cases(count: u32) -> Config {
    let asked_for = Config::default();
    let is_asked = |name: &str| std::env::var_os(name).is_some();
    Config {
        failure_persistence: None,
        cases: if is_asked("PROPTEST_CASES") { asked_for.cases } else { count },
        rng_seed: if is_asked("PROPTEST_RNG_SEED") { asked_for.rng_seed } else { RngSeed::Fixed(SEED) },
        ..asked_for
    }
}
