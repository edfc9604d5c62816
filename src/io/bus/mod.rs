//! Shared memory between processes (iceoryx2): telemetry source, estimator and readers run as separate processes.
//!
//! In and out: the records of the stages as `#[repr(C)]` payloads ([`payload`]), copied bit for bit. A process opens a root
//! directory ([`root`]) and finds all services there ([`service`]); a program that needs only the newest estimate uses
//! [`reader::Reader`].
//!
//! Assumed: one machine, one user. Access control is the mode of the directory, 0700.
//! Refused, each with one sentence: a second publisher of the same role, another schema under the same service name, a root that
//! belongs to another user. A publisher never waits for a subscriber: a slow subscriber loses the oldest messages and gets their
//! count. Nothing here restarts a process; locks are the kernel's (`flock`) and end with the process that holds them.

pub mod clock;
pub mod error;
pub mod payload;
pub mod reader;
pub mod role_holder;
pub mod root;
pub mod run_head;
pub mod service;
