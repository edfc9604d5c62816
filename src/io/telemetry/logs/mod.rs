//! Logs that autopilots write on board: ArduPilot dataflash (.bin) and PX4 ULog (.ulg).
//!
//! In: bytes in pieces of any size. Out: every message with its typed fields ([`dataflash`], [`ulog`]), and of both the
//! channels of the aircraft in SI with their time ([`mapping`]). The reverse, logs from values: [`encode`].
//! Assumed: body axes x forward, y right, z down, as both autopilots use; one clock for each log, microseconds since it
//! started.
//! Refused and counted, never fatal: damaged bytes, messages cut short, definitions that contradict themselves, times that
//! contradict the others. Fatal are only bytes that are no ULog at all, and a ULog whose flags forbid that it is read.

pub mod dataflash;
pub mod encode;
pub mod mapping;
pub mod recording;
pub mod ulog;
