//! Studies of the method on simulated data, whose truth is known: numbers and pictures, see README.md.

mod amplitude;
mod bound;
mod budget;
mod collapse;
mod convergence;
mod flown;
mod honesty;
mod lag;
mod score;
mod sheet;
mod steps;
mod time_to_answer;
