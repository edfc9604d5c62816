//! The cost of MAVLink is by bytes, whatever they are: a start marker in each place is no exception.

use crate::support::processor_clock::Clock;
use sideslip::io::telemetry::mavlink::packet::{Framer, Framing};

/// Bytes of one measurement.
const BYTES: usize = 1 << 22;
/// How many times as much as other bytes they may cost: it was more than a hundred times.
const DEARER: f64 = 30.0;

/// Measurements: the kernel may tell processor time in steps of some ms.
const TIMES: usize = 5;

/// Processor time for a stream of one byte, s.
fn cost(byte: u8) -> f64 {
    let stream = vec![byte; BYTES];
    let once = || {
        let clock = Clock::new();
        let begun = clock.seconds();
        let mut framer = Framer::new(Framing::Bare);
        let mut rest = stream.as_slice();
        while !rest.is_empty() {
            let taken = framer.take(rest);
            rest = &rest[taken..];
            while framer.next_packet().is_some() {}
        }
        assert_eq!(framer.tally().good, 0);
        clock.seconds() - begun
    };
    (0..TIMES).map(|_| once()).sum::<f64>() / TIMES as f64
}

#[test]
fn start_markers_cost_no_hundred_times_what_other_bytes_cost() {
    let (other, marker_1, marker_2) = (cost(0x55), cost(0xFE), cost(0xFD));
    let ns = |seconds: f64| 1e9 * seconds / BYTES as f64;
    eprintln!("{:.1} ns for a byte 0x55, {:.1} ns for 0xFE, {:.1} ns for 0xFD", ns(other), ns(marker_1), ns(marker_2));
    assert!(marker_1 < DEARER * other && marker_2 < DEARER * other, "{other} {marker_1} {marker_2}");
}
