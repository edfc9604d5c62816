//! Kinematic compatibility of a run's instruments (data compatibility, flight path reconstruction): the command `check`.
//!
//! In: samples of one or several runs, and where their instruments are said to stand. Out: biases, factors, lags, skews and
//! places of instruments that are not what they should be, each with its standard error and with what else it may be; what
//! these runs cannot tell; a verdict a run.
//! Assumed: a rigid body in air that moves steadily; gusts widen the errors. Refused: to name one cause where two fit alike.

pub mod agreement;
pub mod alone;
pub mod balance;
#[cfg(test)]
mod checks;
pub mod coarse;
pub mod correction;
pub mod filter;
pub mod fit;
mod judge;
pub mod motion;
pub mod noise;
pub mod observable;
pub mod odd;
pub mod parameter;
pub mod readings;
pub mod record;
mod refusal;
pub mod select;
pub mod series;
pub mod side_by_side;
pub mod verdict;
mod wiring;
