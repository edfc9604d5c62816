//! Tables in text: what parts their cells, how numbers and times are written, which column feeds what.
//!
//! In: the first lines of a file, cells, headers, a section of a map. Out: the layout, numbers, times in s,
//! columns. What is found out and not stated (`;`, a decimal comma, ms) is said in a sentence. Refused: a time whose
//! unit neither text nor spacing tell.

pub(crate) mod cell;
pub(crate) mod clock;
pub mod files;
pub(crate) mod header;
pub(crate) mod layout;
pub(crate) mod looks;
pub(crate) mod preamble;
