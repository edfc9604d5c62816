//! What a live vehicle's clock is known to be, from one telemetry to the next that takes its place.

use crate::command::message;
use sideslip::io::bus::root::BusRoot;
use sideslip::io::bus::run_head::{read_vehicle, write_vehicle};
use sideslip::io::telemetry::mavlink::clock_monitor::SavedClock;
use sideslip::io::telemetry::mavlink::senders::Sender;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

const EVERY: Duration = Duration::from_secs(1);

/// The file of the vehicle in a root.
#[derive(Debug, Default)]
pub(super) struct VehicleFile {
    written: Option<Instant>,
    failed: bool,
}

impl VehicleFile {
    /// What the telemetry before this one knew; what cannot be understood is said and not used.
    pub(super) fn read(root: &BusRoot) -> Option<(Sender, SavedClock)> {
        let numbers = match read_vehicle(root) {
            Ok(numbers) => numbers?,
            Err(wrong) => {
                message(format_args!("sideslip: {wrong}; the vehicle's clock is estimated anew"));
                return None;
            }
        };
        let found = understood(&numbers);
        if found.is_none() {
            message(format_args!("sideslip: the stored state of the vehicle cannot be read: its clock is estimated anew"));
        }
        found
    }

    /// Writes it down where that is due; a failure is said once, for it costs no more than a run that is split later.
    pub(super) fn write(&mut self, root: &BusRoot, vehicle: Sender, clock: &SavedClock) {
        if self.written.is_some_and(|written| written.elapsed() < EVERY) {
            return;
        }
        self.written = Some(Instant::now());
        if let Err(wrong) = write_vehicle(root, &numbers(vehicle, clock))
            && !self.failed
        {
            self.failed = true;
            message(format_args!("sideslip: {wrong}"));
        }
    }

    /// Writes it down next time.
    pub(super) fn is_due(&mut self) {
        self.written = None;
    }
}

fn numbers(vehicle: Sender, clock: &SavedClock) -> BTreeMap<&'static str, i64> {
    BTreeMap::from([
        ("system", i64::from(vehicle.system)),
        ("component", i64::from(vehicle.component)),
        ("boot", i64::from(clock.boot)),
        ("segment_us", clock.segment_us),
        ("newest_us", clock.newest_us),
        ("heard_us", clock.heard_us),
        ("offset_us", clock.offset_us),
        ("first_offset_us", clock.first_offset_us),
    ])
}

fn understood(numbers: &BTreeMap<String, i64>) -> Option<(Sender, SavedClock)> {
    let number = |name: &str| numbers.get(name).copied();
    let time = |name: &str| number(name).filter(|us| us.unsigned_abs() < 1 << 56);
    let vehicle = Sender { system: u8::try_from(number("system")?).ok()?, component: u8::try_from(number("component")?).ok()? };
    let clock = SavedClock {
        boot: u32::try_from(number("boot")?).ok()?,
        segment_us: time("segment_us")?,
        newest_us: time("newest_us")?,
        heard_us: time("heard_us")?,
        offset_us: time("offset_us")?,
        first_offset_us: time("first_offset_us")?,
    };
    Some((vehicle, clock))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_understood_and_what_is_out_of_range_is_not() {
        let vehicle = Sender { system: 1, component: 7 };
        let clock = SavedClock { boot: 3, segment_us: -5, newest_us: 6, heard_us: 7, offset_us: 8, first_offset_us: -9 };
        let written: BTreeMap<String, i64> =
            numbers(vehicle, &clock).into_iter().map(|(name, number)| (name.to_owned(), number)).collect();
        assert_eq!(understood(&written), Some((vehicle, clock)));
        for (name, wrong) in [("system", Some(256)), ("boot", Some(-1)), ("newest_us", Some(i64::MAX)), ("heard_us", None)] {
            let mut numbers = written.clone();
            match wrong {
                Some(wrong) => numbers.insert(name.to_owned(), wrong),
                None => numbers.remove(name),
            };
            assert_eq!(understood(&numbers), None, "{name}");
        }
    }
}
