//! Telemetry by pulse code modulation, IRIG 106 Chapter 4 class I: a stream of bits to samples of parameters, and back.
//!
//! ```text
//! bytes of the line -> FrameSynchronizer -> minor frames -> Decommutator -> samples   (both: PcmDecoder)
//!                                         PcmFormat                              |  -> PcmRows -> rows of channels
//! bytes of the line <- PcmEncoder        <------------------------------- values of parameters
//! ```
//!
//! In come bytes, in pieces of any size, whose minor frames begin at any bit and in either polarity, NRZ-L or RNRZ-L; out
//! come samples with parameter, raw bits, engineering value, flags, and the time of the word's own first bit. The format is
//! read from TOML ([`format_file`]), made for the samples of a flight ([`sample_stream`]), or built from
//! [`PcmFormatSpec`](format::PcmFormatSpec); each is validated.
//!
//! Taken for granted: a constant bit rate, words sent most significant bit first, the pattern at the start of the minor
//! frame. Refused: formats that change, asynchronous embedded formats, words of more than 32 bits, minor frames of more than
//! 16,384 bits. Nothing is repaired: minor frames and samples that may be wrong say so, losses are counted. No stage
//! allocates after its start.

pub mod arrival;
pub mod arrival_rate;
pub mod bit_buffer;
pub mod bits;
pub mod calibration;
pub mod decoder;
pub mod decommutator;
pub mod encoder;
pub mod encoding;
pub mod format;
pub mod format_error;
pub mod format_file;
mod format_tables;
pub mod frame_sync;
pub mod layout;
pub mod parity_check;
mod polynomial;
pub mod recording;
pub mod rows;
pub mod sample_stream;
pub mod step_check;
pub mod subframe;
pub mod sync_pattern;
#[cfg(test)]
mod test_random;
