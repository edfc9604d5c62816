//! Estimate, link and processes in words: current or STALE, how old, how fast.

use super::super::bus_picture::BusPicture;
use super::ink::{Ink, labelled};
use ratatui::style::Style;
use ratatui::text::Line;
use sideslip::io::bus::reader::VALID_FOR;
use sideslip::io::bus::role_holder::RoleHolder;
use sideslip::io::outputs::number::Digits;
use std::time::Duration;

/// Samples that are older are no stream any more.
pub(super) const SILENT: Duration = Duration::from_secs(1);

/// Words, and whether what they are about is in order.
pub(super) struct Said {
    pub(super) words: String,
    pub(super) good: bool,
}

impl Said {
    /// Behind a label.
    pub(super) fn labelled(&self, label: &str, width: usize, ink: Ink) -> Vec<Line<'static>> {
        labelled(label, &self.words, if self.good { Style::new() } else { ink.stale() }, width)
    }
}

/// An age in words; seconds to two digits after the point, minutes from a hundred seconds on.
pub(super) fn age(age: Duration) -> String {
    let seconds = age.as_secs_f64();
    match seconds {
        _ if seconds < 100.0 => format!("{seconds:.2} s old"),
        _ if seconds < 6000.0 => format!("{:.0} min old", seconds / 60.0),
        _ => format!("{:.1} h old", seconds / 3600.0),
    }
}

fn process(holder: RoleHolder) -> String {
    match holder {
        RoleHolder::Process(number) => format!(" (process {number})"),
        RoleHolder::Nobody | RoleHolder::Unknown => String::new(),
    }
}

/// Whether the numbers are of now: an estimate young enough to hold.
pub(super) fn is_current(picture: &BusPicture) -> bool {
    picture.estimate.as_ref().is_some_and(|estimate| estimate.age <= VALID_FOR)
}

/// The estimate and its estimator.
pub(super) fn estimate(picture: &BusPicture) -> Said {
    let nobody = picture.estimator == RoleHolder::Nobody;
    let (words, good) = match (&picture.estimate, nobody) {
        (None, true) => ("NO ESTIMATOR in this root".to_owned(), false),
        (None, false) => (format!("WAITING: the estimator{} has not estimated yet", process(picture.estimator)), false),
        (Some(estimate), _) => {
            let current = is_current(picture);
            let word = if current { "CURRENT" } else { "STALE" };
            let gone = if nobody { ", the estimator has ended" } else { "" };
            let (age, number, missed) = (age(estimate.age), estimate.sequence, estimate.missed);
            (format!("{word}, {age}{gone}; number {number}, {missed} missed{}", process(picture.estimator)), current)
        }
    };
    Said { words, good }
}

/// The samples and their telemetry.
pub(super) fn link(picture: &BusPicture) -> Said {
    let flow = &picture.flow;
    let missed = if flow.missed > 0 { format!(", {} missed by this reader", flow.missed) } else { String::new() };
    let (words, good) = match (flow.age(), picture.telemetry) {
        (None, RoleHolder::Nobody) => ("NO TELEMETRY in this root".to_owned(), false),
        (None, holder) => (format!("WAITING: telemetry{} has sent no sample yet", process(holder)), false),
        (Some(newest), _) if flow.ended => (format!("ENDED: the source ended the run; last sample {}", age(newest)), false),
        (Some(newest), RoleHolder::Nobody) => (format!("STALE, telemetry has ended; last sample {}", age(newest)), false),
        (Some(newest), holder) if newest > SILENT => {
            (format!("STALE, silent; last sample {}{missed}{}", age(newest), process(holder)), false)
        }
        (Some(newest), holder) => {
            let rate = flow.rate_hz().map_or_else(String::new, |rate| format!("{} samples/s, ", Digits(rate, 3)));
            (format!("CURRENT, {rate}newest {}{missed}{}", age(newest), process(holder)), true)
        }
    };
    Said { words, good }
}
