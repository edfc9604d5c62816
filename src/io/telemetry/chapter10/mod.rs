//! Recordings and streams after IRIG 106 Chapter 10 (since 106-17 partly Chapter 11), and the setup (TMATS, Chapter 9) in
//! them.
//!
//! In: bytes of a recording, in pieces of any size ([`packet`]), or datagrams ([`udp_receiver`]). Out: packets; of PCM data
//! minor frames with their times, or bits ([`pcm_data`]); the relation of the relative time counter to the time
//! ([`time_relation`]); the format of a channel as the setup says it ([`tmats_pcm`]), and where that contradicts the data
//! ([`tmats_check`]); what the recording holds ([`summary`]). Assumed: nothing of the bytes. Refused: what the standard does
//! not allow, each with its place and counted; data behind damage are read on. Not read: the bodies of other data than PCM,
//! format 1, time, format 1, and setup records; index packets, which a reader from front to back does not need; setups in
//! XML.

pub mod channel_choice;
pub mod channel_decoder;
pub mod channel_rows;
mod error;
pub mod frame_rate;
pub mod header;
pub mod measurement_map;
pub mod packet;
#[cfg(test)]
mod packet_test;
pub mod pcm_data;
pub mod pcm_layout;
pub mod recorded_words;
pub mod recording;
mod recording_start;
mod rtc_clock;
pub mod sequence;
pub mod summary;
pub mod survey;
pub mod sync_search;
pub mod time;
pub mod time_relation;
pub mod tmats;
pub mod tmats_check;
pub mod tmats_format;
pub mod tmats_measurements;
pub mod tmats_pcm;
pub mod udp;
pub mod udp_receiver;
pub mod udp_segments;

pub use error::Chapter10Error;
