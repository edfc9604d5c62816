//! What the environment asks of a study; without it every test runs at its own, small size.

/// The number in that variable.
pub(crate) fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok().and_then(|text| text.parse().ok())
}

/// How many seeds: the number that `SIDESLIP_SEEDS` names, for long studies; the test's own otherwise.
pub(crate) fn seeds(usual: u64) -> u64 {
    number("SIDESLIP_SEEDS").unwrap_or(usual)
}

/// The first seed: the test's own, moved by `SIDESLIP_SEEDS_FROM`, so that a study can fly seeds that nobody has seen.
pub(crate) fn first_seed(usual: u64) -> u64 {
    usual + number("SIDESLIP_SEEDS_FROM").unwrap_or(0)
}

/// Whether a study is asked for, of whatever size.
pub(crate) fn is_study() -> bool {
    std::env::var_os("SIDESLIP_SEEDS").is_some()
}
