//! Selection of the vehicle among several senders on a live link, and reselection when it becomes silent.
//!
//! Consumes sender and time of each message of motion; produces the selection. The vehicle is the sender of at least [`CLEAR`]
//! such messages and twice as many as the next; after [`LISTEN_US`] the sender of most, at least [`FEW`] (of two with equal
//! counts the one with the lower ids). If it sends none for [`SILENT_US`] while another sends [`CLEAR`], that one becomes the
//! vehicle. Time counts only while this process was running, because after a pause the queued messages of all senders arrive at
//! once. Memory is bounded.

use super::senders::{SENDERS_MAX, Sender};
use std::collections::BTreeMap;

/// Messages of motion that make a choice clear.
pub const CLEAR: u32 = 10;
/// Fewer are a stray.
pub const FEW: u32 = 3;
/// After so long who leads is chosen, us.
pub const LISTEN_US: u64 = 1_000_000;
/// A vehicle that is silent for so long gives way to another, us.
pub const SILENT_US: u64 = 5_000_000;
/// Between two messages this process was awake for so long at most, us.
const AWAKE_US: u64 = 200_000;

/// The choice.
#[derive(Clone, Debug, Default)]
pub struct VehicleSelection {
    chosen: Option<Sender>,
    /// Messages of motion: of everybody before the choice, of the others since the chosen one's last after it.
    counts: BTreeMap<Sender, u32>,
    /// How long this has been so, while awake, us.
    waited_us: u64,
    newest_us: Option<u64>,
}

impl VehicleSelection {
    /// A choice that is made already.
    pub fn made(vehicle: Sender) -> Self {
        VehicleSelection { chosen: Some(vehicle), ..VehicleSelection::default() }
    }

    /// Who is chosen.
    pub fn chosen(&self) -> Option<Sender> {
        self.chosen
    }

    /// Takes in a message of motion.
    pub fn motion(&mut self, sender: Sender) {
        if self.chosen == Some(sender) {
            self.counts.clear();
            self.waited_us = 0;
            return;
        }
        if self.counts.len() >= SENDERS_MAX && !self.counts.contains_key(&sender) {
            let least = self.counts.iter().min_by_key(|(_, count)| **count).map(|(sender, _)| *sender);
            least.and_then(|least| self.counts.remove(&least));
        }
        let count = self.counts.entry(sender).or_insert(0);
        *count = count.saturating_add(1);
    }

    /// The vehicle, where it is another than before; `host_us` is the host's time now.
    pub fn change(&mut self, host_us: u64) -> Option<Sender> {
        let elapsed_us = self.newest_us.map_or(0, |newest| host_us.saturating_sub(newest));
        self.newest_us = Some(host_us);
        if self.chosen.is_none() && self.counts.is_empty() {
            return None;
        }
        self.waited_us = self.waited_us.saturating_add(elapsed_us.min(AWAKE_US));
        let (leader, most) =
            self.counts.iter().rev().max_by_key(|(_, count)| **count).map(|(sender, count)| (*sender, *count))?;
        let next = self.counts.iter().filter(|(sender, _)| **sender != leader).map(|(_, count)| *count).max().unwrap_or(0);
        let ready = match self.chosen {
            None => most >= CLEAR.max(2 * next) || (most >= FEW && self.waited_us >= LISTEN_US),
            Some(_) => most >= CLEAR && self.waited_us >= SILENT_US,
        };
        if !ready {
            return None;
        }
        self.chosen = Some(leader);
        self.counts.clear();
        self.waited_us = 0;
        Some(leader)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sender(system: u8) -> Sender {
        Sender { system, component: 1 }
    }

    #[test]
    fn a_stray_that_comes_first_is_not_the_vehicle() {
        let mut choice = VehicleSelection::default();
        choice.motion(sender(7));
        assert_eq!(choice.change(0), None);
        let chosen = (1..100).find_map(|k| {
            choice.motion(sender(1));
            choice.change(20_000 * k).map(|vehicle| (k, vehicle))
        });
        assert_eq!(chosen, Some((u64::from(CLEAR), sender(1))));
    }

    #[test]
    fn of_two_who_sends_more_in_a_second_and_of_equals_the_lower_id() {
        for (rates, vehicle) in [([2, 3], 2), ([2, 2], 1)] {
            let mut choice = VehicleSelection::default();
            let chosen = (0..200).find_map(|k| {
                (0..rates[0]).for_each(|_| choice.motion(sender(1)));
                (0..rates[1]).for_each(|_| choice.motion(sender(2)));
                choice.change(20_000 * k).map(|vehicle| (k, vehicle))
            });
            assert_eq!(chosen, Some((50, sender(vehicle))));
        }
    }

    #[test]
    fn one_that_falls_silent_gives_way_but_not_because_we_slept() {
        let mut choice = VehicleSelection::made(sender(1));
        for k in 0..500 {
            choice.motion(sender(1));
            choice.motion(sender(2));
            assert_eq!(choice.change(20_000 * k), None);
        }
        // Ten seconds of sleep, then the backlog of the other.
        for k in 0..100 {
            choice.motion(sender(2));
            assert_eq!(choice.change(20_000_000 + k), None);
        }
        choice.motion(sender(1));
        let changed = (1..500).find_map(|k| {
            choice.motion(sender(2));
            choice.change(20_000_000 + 20_000 * k).map(|vehicle| (k, vehicle))
        });
        assert_eq!(changed, Some((251, sender(2))), "the first step is a tenth of a millisecond short");
        // Nobody else: it stays.
        assert!((0..1000).all(|k| choice.change(30_000_000 + 100_000 * k).is_none()));
    }

    #[test]
    fn strangers_do_not_make_it_grow() {
        let mut choice = VehicleSelection::default();
        for k in 0..60_000_u32 {
            let [_, _, system, component] = k.to_be_bytes();
            choice.motion(Sender { system, component });
            choice.motion(sender(1));
        }
        assert!(choice.counts.len() <= SENDERS_MAX);
        assert_eq!(choice.change(0), Some(sender(1)));
    }
}
