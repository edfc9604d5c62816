//! Every derivative that the program has in closed form, against derivatives found in another way.
#![allow(clippy::float_cmp, reason = "a structural zero is compared as such")]

mod aids;
mod dual;
mod linear_model;
mod process;
mod states;
