//! Estimates to a ground station, as MAVLink: one way, numbers and words alone.
//!
//! In: records of the estimator through a bounded queue that never blocks it ([`station`]). Out, on a link: HEARTBEAT of an
//! onboard computer, NAMED_VALUE_FLOAT for the names of one table ([`names`], [`numbers`]), STATUSTEXT for events and findings
//! ([`texts`]), and nothing else: what can be sent is an enumeration of these three ([`message`]), signed where a key is set.
//! Assumed: a ground station at the other end. Refused: whatever it sends; that is read, so that the link does not fill up, and
//! not looked at.

pub mod message;
pub mod names;
pub mod numbers;
pub mod station;
pub mod texts;
