//! Time without messages while this process was awake: a pause of its own is no silence of the vehicle.

use sideslip::io::telemetry::mavlink::live::LiveTelemetry;
use sideslip::io::telemetry::mavlink::senders::Senders;
use sideslip::io::telemetry::mavlink::stream::admits;
use std::time::{Duration, Instant};

/// Between two polls this process was awake for so long at most.
const AWAKE: Duration = Duration::from_millis(300);

const NAMED: usize = 8;

/// Time without something, while awake.
#[derive(Debug)]
pub(super) struct SilenceMonitor {
    polled: Instant,
    lasted: Duration,
}

impl SilenceMonitor {
    /// From now on.
    pub(super) fn new() -> Self {
        SilenceMonitor { polled: Instant::now(), lasted: Duration::ZERO }
    }

    pub(super) fn elapsed(&mut self) -> Duration {
        self.lasted += self.polled.elapsed().min(AWAKE);
        self.polled = Instant::now();
        self.lasted
    }

    /// It is over.
    pub(super) fn reset(&mut self) {
        self.lasted = Duration::ZERO;
    }
}

/// Who sends what, where nothing of it is motion of the vehicle.
pub(super) fn no_motion(live: &LiveTelemetry) -> String {
    let senders = live.senders();
    let strangers = senders.vehicle(|sender| !admits(live.config(), sender));
    if let Some(stranger) = strangers.filter(|_| senders.vehicle(|sender| admits(live.config(), sender)).is_none()) {
        return format!("{stranger} sends motion, but the configuration names another vehicle");
    }
    format!(
        "no message of motion has come, only {}: one of SCALED_IMU, RAW_IMU, HIGHRES_IMU, ATTITUDE, ATTITUDE_QUATERNION is \
         needed, at 8 Hz or more",
        named(senders)
    )
}

fn named(senders: &Senders) -> String {
    let mut counts: Vec<(u64, String)> = Vec::new();
    for (sender, tally) in senders.iter() {
        counts.extend(tally.by_name().into_iter().map(|(name, count)| (count, format!("{count} {name} of {sender}"))));
    }
    counts.sort_by(|one, two| two.0.cmp(&one.0).then_with(|| one.1.cmp(&two.1)));
    let more = counts.len().saturating_sub(NAMED);
    let mut words: Vec<String> = counts.into_iter().take(NAMED).map(|(_, word)| word).collect();
    if more > 0 {
        words.push(format!("{more} more kinds"));
    }
    if words.is_empty() { "what is not known here".to_owned() } else { words.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::SilenceMonitor;
    use std::time::{Duration, Instant};

    #[test]
    fn a_pause_of_our_own_counts_next_to_nothing() {
        let mut silence = SilenceMonitor::new();
        // As if it had been stopped for a minute.
        let Some(before) = Instant::now().checked_sub(Duration::from_secs(60)) else { return };
        silence.polled = before;
        assert_eq!(silence.elapsed(), super::AWAKE);
        silence.reset();
        assert!(silence.elapsed() < super::AWAKE);
    }
}
