//! Live: real processes over shared memory, killed at the worst moments. Each test has a root of its own.

mod chapter10_link;
mod demo;
mod ground_station;
mod kills;
mod latencies;
mod latency;
mod links;
mod payload;
mod pcm_link;
mod processes;
mod real_time;
mod sender;
mod services;
mod signing;
pub(crate) mod stage;
pub(crate) mod station_peer;
mod stopped_terminal;
mod watch_screen;
