//! Tables for a terminal.

pub mod manoeuvre_table;
pub mod terminal;
pub mod wrapped;
