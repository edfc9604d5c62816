//! Recordings of other programs: which of their columns or fields is which channel, in which unit.
//!
//! In: a map in TOML, or the headers of a recording. Out: [`map_file::ChannelMap`], by which a table or an MCAP log is read;
//! guesses by name ([`header_guess`]), which are shown to the user and never acted upon. Refused: a channel whose unit is stated
//! neither in the map nor in the header.

pub mod header_guess;
pub mod map_file;
pub mod template;
pub mod unit_text;
