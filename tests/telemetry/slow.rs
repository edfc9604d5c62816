//! The slow part: the relation of two clocks over many simulated pairs, wrong bits on a PCM link in many flights.

mod clock_coverage;
mod clock_pairs;
mod derivatives;
#[allow(dead_code, reason = "streams of random words are for other tests")]
mod line;
mod pcm_bit_errors;
mod pcm_link;
