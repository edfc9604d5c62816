//! Identify: derivatives and modes from whole runs, against recordings with known answers and flights whose truth is known.

mod banked;
mod calls;
mod flights;
mod frequency;
mod instruments;
mod live;
mod recordings;
