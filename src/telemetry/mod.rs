//! x

pub mod record;
