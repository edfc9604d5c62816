//! Proof that what is written can be read: by an independent reader, after a cut, after a kill, and by no trick of bytes.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a proof that cannot go on has failed")]

mod example;
mod foreign;
mod hostile;
mod independent;
mod killed;
mod killed_program;
mod mavlink_logs;
mod rotation;
mod round_trip;
mod truncation;
