//! The bus: telemetry, estimator and readers as processes of their own, joined by shared memory (iceoryx2).
//!
//! In and out: the records of the stages as `#[repr(C)]` payloads ([`payload`]), bit for bit. A process enters a root
//! directory ([`root`]) and finds every service there ([`service`]); whoever only wants the newest estimate takes a
//! [`reader::Reader`].
//!
//! Assumed: one machine, one user. There is no access control besides the directory's own mode 0700.
//! Refused: a second publisher of the same role, another schema under the same service name, a root of another user; each
//! with one sentence. A publisher never waits for a subscriber: one that is slow loses the oldest messages and is told
//! how many. Nothing here restarts anything; locks are the kernel's and vanish with their process, however it ends.

pub mod clock;
pub mod error;
pub mod payload;
pub mod reader;
pub mod root;
pub mod run_head;
pub mod service;
