//! Decommutation and encoding allocate nothing after the start.

#[path = "line.rs"]
#[allow(dead_code, reason = "slips are for other tests")]
mod line;

use crate::support::allocations::during;
use line::{Random, add_errors, format, sent};
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;

#[test]
fn decommutation_allocates_nothing_after_the_start() {
    let _turn = crate::alone();
    let format = format("rnrz_l", "odd");
    let mut random = Random(51);
    let mut line = sent(&format, 2000, true, &mut random).line;
    // Noise between: search, check, lock, flywheel and loss.
    line.extend((0..5000).map(|_| random.next() as u8));
    line.extend(sent(&format, 2000, false, &mut random).line);
    add_errors(&mut line, 1e-3, &mut random);
    let mut decoder = PcmDecoder::new(&format, 0.0);
    let mut samples = 0_u64;
    let allocated = during(|| {
        for piece in line.chunks(777) {
            decoder.feed(piece, |_| samples += 1);
        }
        decoder.finish(|_| samples += 1);
    });
    assert_eq!(allocated, 0);
    let counters = decoder.synchronizer.counters();
    assert!(samples > 100_000 && counters.locks >= 2 && counters.losses >= 1, "{samples} {counters:?}");
    let mut encoder = PcmEncoder::new(&format, 0.0).unwrap();
    let mut line = Vec::with_capacity(100_000);
    let allocated = during(|| (0..1000).for_each(|_| encoder.minor_frame(|_, _| 5.0, &mut line).unwrap()));
    assert_eq!(allocated, 0);
}
