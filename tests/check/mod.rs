//! Check: errors put into simulated instruments are found and sized, healthy ones are left alone, real recordings say what is
//! known of them.

mod coarse;
mod errors;
mod flown;
mod gaps;
mod injected;
mod odd;
mod recordings;
mod score;
mod simulated;
mod sortie;
