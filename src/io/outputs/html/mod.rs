//! Pages of HTML.

pub mod page;
