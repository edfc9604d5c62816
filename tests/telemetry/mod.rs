//! Telemetry formats: PCM through a noisy line, Chapter 10 recordings and logs of autopilots against independent readers.

mod chapter10;
mod chapter10_damage;
mod chapter10_flight;
mod chapter10_merge;
mod chapter10_rows;
mod chapter10_setup;
mod clock_pairs;
mod clock_relation;
mod derivatives;
mod latencies;
mod line;
mod logs_damage;
mod logs_expected;
mod logs_mapping;
mod logs_recordings;
mod map_logs;
mod maps;
mod pcm_bit_errors;
mod pcm_false_lock;
mod pcm_flight;
mod pcm_hostile;
mod pcm_link;
mod pcm_noise;
mod pcm_recordings;
mod simulated_logs;
mod sources;
