//! A vehicle on the loopback: sends the frames of a recorded MAVLink stream over TCP, which loses nothing.

use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

/// Bytes of the receiver's time before each frame of a recorded stream, us since 1970.
const STAMP: usize = 8;

/// The frames of a recorded stream with the time of each from the first, s.
pub(crate) fn frames(recorded: &[u8]) -> Vec<(f64, Vec<u8>)> {
    let mut frames = Vec::new();
    let mut rest = recorded;
    let mut first_us = None;
    while rest.len() > STAMP + 12 {
        let (stamp, frame) = rest.split_at(STAMP);
        let stamp_us = u64::from_be_bytes(stamp.try_into().unwrap());
        // The start of a frame, its version, and the length of its payload.
        let signature = if frame[2] & 1 == 1 { 13 } else { 0 };
        let length = match frame[0] {
            0xfd => 12 + usize::from(frame[1]) + signature,
            0xfe => 8 + usize::from(frame[1]),
            other => panic!("no frame begins with {other:#x}"),
        };
        let first_us = *first_us.get_or_insert(stamp_us);
        frames.push(((stamp_us - first_us) as f64 * 1e-6, frame[..length].to_vec()));
        rest = &frame[length..];
    }
    assert!(rest.is_empty(), "{} bytes are no frame", rest.len());
    frames
}

/// Waits for a caller.
pub(crate) fn answer(listener: &TcpListener, patience: Duration) -> TcpStream {
    listener.set_nonblocking(true).unwrap();
    let begun = Instant::now();
    loop {
        if let Ok((stream, _)) = listener.accept() {
            stream.set_nonblocking(false).unwrap();
            stream.set_nodelay(true).unwrap();
            return stream;
        }
        assert!(begun.elapsed() < patience, "nobody has called");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends the frames: at their own pace until that file is there, by which the estimator has taken its first sample, then
/// `speed` times as fast.
pub(crate) fn fly(stream: &mut TcpStream, frames: &[(f64, Vec<u8>)], speed: f64, until: &Path) {
    let (mut begun, mut from_s, mut hurries) = (Instant::now(), 0.0, false);
    for (time_s, frame) in frames {
        if !hurries && until.exists() {
            (begun, from_s, hurries) = (Instant::now(), *time_s, true);
        }
        let due = Duration::from_secs_f64((time_s - from_s).max(0.0) / if hurries { speed } else { 1.0 });
        std::thread::sleep(due.saturating_sub(begun.elapsed()));
        stream.write_all(frame).unwrap();
    }
}
