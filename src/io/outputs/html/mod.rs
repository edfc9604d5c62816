//! HTML pages for people.

pub mod page;
pub mod table;
