//! Identify: derivatives and modes from whole runs, against recordings with known answers and flights whose truth is known.

mod calls;
mod frequency;
mod live;
mod no_answer;
mod recordings;
mod report;
