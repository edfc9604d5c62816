//! The slow part: the firmware profile is built and run.

mod firmware;
