//! The bit rate that the recorder's times show.
//!
//! Consumes the times of the minor frames of each packet (packed and unpacked mode), or those of packets that follow each other
//! (throughput mode); produces, with b bits between the first of them at t_1 and the last at t_n,
//!     rate = max over packets, or over every `PACKETS`, of b/(t_n - t_1)                            (1)
//! What a recorder drops makes it look slower, never faster: so the largest counts. Where two agree on another rate than the one
//! that is written, they are right: words stand at their times within a frame, and frames within a packet, by (1) from then on.

/// Minor frames of a packet, at least: the counter that dates them has steps of 0.1 us.
const FRAMES: u32 = 4;
/// Packets of throughput mode: they may be dated by a millisecond off.
const PACKETS: u32 = 4;
/// How far the rate that is written may be off.
const SHARE: f64 = 0.02;

/// The rates of packets, the largest two.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecordedFrameRate {
    largest: [f64; 2],
    packet: Option<(f64, f64, u32)>,
    /// Of packets that follow each other: time of the first, bits since, how many.
    packets: Option<(f64, f64, u32)>,
}

impl RecordedFrameRate {
    /// Takes in a minor frame that begins at that time.
    pub(super) fn frame(&mut self, start_s: f64) {
        self.packet = Some(match self.packet {
            Some((first_s, _, count)) => (first_s, start_s, count + 1),
            None => (start_s, start_s, 1),
        });
    }

    /// The packet has ended; a minor frame has so many bits.
    pub(super) fn packet_ends(&mut self, frame_bits: f64) {
        let Some((first_s, last_s, count)) = self.packet.take().filter(|(.., count)| *count >= FRAMES) else { return };
        self.rate(f64::from(count - 1) * frame_bits / (last_s - first_s));
    }

    /// A packet of throughput mode begins at that time; it follows the one before, of so many bits, where these are given.
    pub(super) fn packet_begins(&mut self, start_s: f64, bits_before: Option<f64>) {
        let (Some(before), Some((first_s, bits, count))) = (bits_before, self.packets) else {
            self.packets = Some((start_s, 0.0, 0));
            return;
        };
        if count + 1 < PACKETS {
            self.packets = Some((first_s, bits + before, count + 1));
        } else {
            self.rate((bits + before) / (start_s - first_s));
            self.packets = Some((start_s, 0.0, 0));
        }
    }

    fn rate(&mut self, rate: f64) {
        let [most, next] = self.largest;
        if rate.is_finite() {
            self.largest = [most.max(rate), next.max(most.min(rate))];
        }
    }

    /// (1), 1/s, where two agree on one that is not the written one.
    pub fn contradicts(&self, written: f64) -> Option<f64> {
        let [most, next] = self.largest;
        let agree = next > 0.0 && most - next <= SHARE * most;
        (agree && (most - written).abs() > SHARE * most).then_some(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(interval_s: impl Fn(u32) -> f64) -> RecordedFrameRate {
        let (mut rate, mut time_s) = (RecordedFrameRate::default(), 0.0);
        for packet in 0..5 {
            for frame in 0..10 {
                rate.frame(time_s);
                time_s += interval_s(10 * packet + frame);
            }
            rate.packet_ends(1000.0);
        }
        rate
    }

    #[test]
    fn the_rate_is_that_of_packets_without_missing_frames() {
        let even = rate(|_| 0.01);
        assert_eq!(even.contradicts(100_000.0), None);
        assert_eq!(even.contradicts(101_000.0), None);
        assert!((even.contradicts(160_000.0).unwrap() - 100_000.0).abs() < 1.0);
        assert!((even.contradicts(40_000.0).unwrap() - 100_000.0).abs() < 1.0);
        // Three packets of five lack a frame.
        assert_eq!(rate(|k| if k < 30 && k % 10 == 5 { 0.02 } else { 0.01 }).contradicts(100_000.0), None);
        // One packet with a time that is wrong, and frames all at one time.
        assert_eq!(rate(|k| if k < 10 { 0.005 } else { 0.01 }).contradicts(100_000.0), None);
        assert_eq!(rate(|_| 0.0).contradicts(100_000.0), None);
    }
}
