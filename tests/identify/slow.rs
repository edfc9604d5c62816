//! The slow part: whole aircraft from several runs.

mod banked;
mod flights;
mod instruments;
