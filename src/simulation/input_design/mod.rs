//! Input design: what a test input excites, and how well the derivatives will be known after it.
//!
//! In: a linear model, the instruments, a control's deviation over time ([`crate::flight::signal::piecewise_linear::History`]).
//! Out: its energy spectrum ([`spectrum`]); Fisher information ([`information`]) and the standard errors to be expected
//! ([`dispersion`]); the multistep that makes them least within what hand and aircraft may do ([`search`]).
//! Assumed: small deviations about trim, white noise on every channel, the start in trim. Refused: a derivative that the input
//! leaves without information; it is named.

pub mod dispersion;
pub mod information;
pub(crate) mod response;
pub mod search;
pub mod spectrum;
