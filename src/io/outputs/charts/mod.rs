//! Charts as SVG.

pub mod chart;
