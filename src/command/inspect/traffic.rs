//! Who sent which messages, for a person: a line of sums, then each sender with its messages by name.

use sideslip::io::telemetry::mavlink::recording::Traffic;
use std::fmt::Write;

/// How wide a line of messages may become, characters.
const WIDTH: usize = 116;

pub(super) fn lines(traffic: &Traffic) -> Vec<String> {
    let tally = traffic.tally;
    let mut sums = format!("  {} messages", tally.good);
    for (count, what) in [
        (tally.bad_checksum, "frames with a wrong checksum"),
        (tally.unknown, "frames of unknown messages"),
        (tally.garbage_bytes, "bytes of garbage"),
    ] {
        if count > 0 {
            let _ = write!(sums, ", {count} {what}");
        }
    }
    let mut lines = vec![sums];
    for (sender, tally) in traffic.senders.iter() {
        let part = match (sender == traffic.vehicle, traffic.boots) {
            (false, _) => String::new(),
            (true, 1) => ", the vehicle".into(),
            (true, boots) => format!(", the vehicle, booted {boots} times"),
        };
        lines.push(format!("  sender {sender}{part}: {} messages", tally.total()));
        let mut line = String::from("   ");
        for (name, count) in tally.by_name() {
            let entry = format!(" {name} {count}");
            if line.len() + entry.len() > WIDTH {
                lines.push(std::mem::replace(&mut line, String::from("   ")));
            }
            line.push_str(&entry);
        }
        lines.push(line);
    }
    if traffic.senders.others > 0 {
        lines.push(format!("  further senders: {} messages", traffic.senders.others));
    }
    lines
}
