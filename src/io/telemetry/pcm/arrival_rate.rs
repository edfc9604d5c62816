//! How fast a stream of bits comes, and whether it holds more of them than its time has.
//!
//! Consumes, for each datagram or read, when it arrived, its last bit's time by the stream, and its length; produces the ratio
//!     r = (time of the bits that came)/(time in which they came)                                      (1)
//! after [`ENOUGH_US`], and by how much the stream's time leads its arrival:
//!     lead = d_0 - min d, the delay d = arrival - stream time, d_0 its least value over the first [`FIRST_US`]      (2)
//! A delay falls below what the way takes only where bits came that are not of the stream's time: datagrams that came twice, out
//! of order, or from another sender. Clocks that drift do so by less than [`DRIFT`].

/// The stream is watched for so long before (1) is formed, us.
pub const ENOUGH_US: i64 = 5_000_000;
/// Length of the first window, us.
pub const FIRST_US: i64 = 2_000_000;
/// Clocks drift apart by less.
pub const DRIFT: f64 = 1e-3;
/// Leads below this are jitter, us.
const LEAST_LEAD_US: i64 = 2_000;
/// A rate this far from that of the format is another one.
pub const RATE_TOLERANCE: f64 = 0.03;

/// What a link has brought since it began.
#[derive(Clone, Copy, Debug, Default)]
pub struct ArrivalRate {
    first_us: Option<i64>,
    last_us: i64,
    bits_us: i64,
    first_delay_us: Option<i64>,
    least_delay_us: Option<i64>,
}

impl ArrivalRate {
    /// Takes in bits of that length that arrived at that host time, the last of them at that time of the stream.
    pub fn arrived(&mut self, host_us: i64, stream_us: i64, length_us: i64) {
        let first_us = match self.first_us {
            Some(first_us) => {
                self.bits_us = self.bits_us.saturating_add(length_us);
                first_us
            }
            None => *self.first_us.insert(host_us),
        };
        self.last_us = host_us;
        let delay_us = host_us.saturating_sub(stream_us);
        let least = if host_us - first_us <= FIRST_US { &mut self.first_delay_us } else { &mut self.least_delay_us };
        *least = Some(least.map_or(delay_us, |before| before.min(delay_us)));
    }

    /// (1), where it is far from one.
    #[expect(clippy::cast_precision_loss, reason = "a ratio")]
    pub fn other_rate(&self) -> Option<f64> {
        let host_us = self.last_us - self.first_us?;
        let ratio = self.bits_us as f64 / host_us as f64;
        (host_us >= ENOUGH_US && (ratio - 1.0).abs() > RATE_TOLERANCE).then_some(ratio)
    }

    /// (2), s, where it is more than jitter and drift.
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "microseconds of a flight")]
    pub fn lead_s(&self) -> Option<f64> {
        let lead_us = self.first_delay_us? - self.least_delay_us?;
        let drift_us = (DRIFT * (self.last_us - self.first_us?) as f64) as i64;
        (lead_us > LEAST_LEAD_US + drift_us).then_some(lead_us as f64 * 1e-6)
    }

    /// Forgets what came: the stream begins anew.
    pub fn clear(&mut self) {
        *self = ArrivalRate::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Datagrams of 20 ms for twenty seconds that arrive every `interval_us`; each `copies` times.
    fn after(interval_us: i64, delay_us: impl Fn(i64) -> i64, copies: impl Fn(i64) -> i64) -> ArrivalRate {
        let (mut rate, mut stream_us) = (ArrivalRate::default(), 0);
        for k in 0..1000 {
            for _ in 0..copies(k) {
                stream_us += 20_000;
                rate.arrived(interval_us * (k + 1) + delay_us(k), stream_us, 20_000);
            }
        }
        rate
    }

    #[test]
    fn a_stream_at_its_rate_is_not_remarked_late_or_not() {
        for delay in [|_| 0, |k| k % 7 * 3_000, |k| if (300..400).contains(&k) { 20_000 * (400 - k) } else { 0 }, |k| 20 * k] {
            let rate = after(20_000, delay, |_| 1);
            assert_eq!((rate.other_rate(), rate.lead_s()), (None, None));
        }
    }

    #[test]
    fn another_rate_and_bits_too_many_are_told() {
        let slow = after(25_000, |_| 0, |_| 1);
        assert!((slow.other_rate().unwrap() - 0.8).abs() < 1e-3);
        let fast = after(10_000, |_| 0, |_| 1);
        assert!((fast.other_rate().unwrap() - 2.0).abs() < 1e-2);
        // One datagram in a hundred twice: ten in twenty seconds, two of them in the first two.
        let twice = after(20_000, |k| k % 5 * 500, |k| if k % 100 == 50 { 2 } else { 1 });
        assert_eq!(twice.other_rate(), None);
        let lead_s = twice.lead_s().unwrap();
        assert!((0.16..=0.2).contains(&lead_s), "{lead_s}");
        assert_eq!(after(20_000, |_| 0, |k| if k == 10 { 0 } else { 1 }).lead_s(), None, "one that is lost");
    }
}
