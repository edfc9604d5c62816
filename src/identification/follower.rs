//! Output error on a thread of its own: the sample path hands samples over and takes records back, and never waits.
//!
//! Both ways are bounded, and the thread gives way to every other. Where the thread does not keep up, samples find no room and
//! are counted, and the manoeuvre that lacks them says so by its gap; a thread that hangs or has ended costs its numbers and
//! nothing else: at the end of a run it is waited for so long and no longer, and then left to itself.

use super::live::{Live, Seen};
use super::record::{OutputErrorRecord, Progress};
use crate::telemetry::record::Sample;
use crossbeam::channel::{Receiver, Sender, TryRecvError, bounded};
use std::io;
use std::time::Duration;

/// Samples that may wait: half a minute at 128 Hz.
const WAITING: usize = 4096;
/// How much more the thread gives way than others: where processors are few, samples and estimates come first.
const GIVES_WAY: i32 = 15;
/// Records that may wait; of more the newest are lost, and come again with the next fit.
const RECORDS: usize = 8;

enum Fed {
    Sample(Sample),
    Seen(Seen),
}

/// The sample path's end.
#[derive(Debug)]
pub struct Follower {
    to: Sender<Fed>,
    from: Receiver<OutputErrorRecord>,
    lost: u64,
    ended: bool,
}

impl std::fmt::Debug for Fed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Fed::Sample(_) => "sample",
            Fed::Seen(_) => "seen",
        })
    }
}

impl Follower {
    /// Starts the thread. Everything that the sample path needs is allocated here.
    ///
    /// # Errors
    /// Where there is no thread to be had.
    pub fn spawn(live: Live) -> io::Result<Self> {
        Follower::spawn_with(live, |live| {
            live.refit();
        })
    }

    /// The same with another way to fit.
    ///
    /// # Errors
    /// Where there is no thread to be had.
    pub fn spawn_with(live: Live, refit: impl FnMut(&mut Live) + Send + 'static) -> io::Result<Self> {
        let (to, fed) = bounded(WAITING);
        let (say, from) = bounded(RECORDS);
        std::thread::Builder::new().name("sideslip-output-error".to_owned()).spawn(move || work(live, refit, &fed, &say))?;
        Ok(Follower { to, from, lost: 0, ended: false })
    }

    /// Hands a sample over, where there is room.
    pub fn sample(&mut self, sample: &Sample) {
        self.lost += u64::from(self.to.try_send(Fed::Sample(*sample)).is_err());
    }

    /// Hands over what the regression said.
    pub fn seen(&mut self, seen: Seen) {
        self.lost += u64::from(self.to.try_send(Fed::Seen(seen)).is_err());
    }

    /// What found no room so far.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// The next record, where there is one. A thread that has ended is said once.
    pub fn next_record(&mut self) -> Option<OutputErrorRecord> {
        match self.from.try_recv() {
            Ok(record) => Some(record),
            Err(TryRecvError::Disconnected) if !self.ended => {
                self.ended = true;
                let mut record = OutputErrorRecord { progress: Progress::Failed, ..OutputErrorRecord::EMPTY };
                record.explain("the thread that fits has ended");
                Some(record)
            }
            Err(_) => None,
        }
    }

    /// The run is over: its last record, waited for so long.
    pub fn finish(self, patience: Duration) -> Option<OutputErrorRecord> {
        let Follower { to, from, .. } = self;
        drop(to);
        let until = std::time::Instant::now() + patience;
        let mut last = None;
        while let Ok(record) = from.recv_deadline(until) {
            last = Some(record);
        }
        last
    }
}

fn work(mut live: Live, mut refit: impl FnMut(&mut Live), fed: &Receiver<Fed>, say: &Sender<OutputErrorRecord>) {
    // Of this thread alone, on Linux. Refused, it fits all the same.
    let _ = rustix::process::nice(GIVES_WAY);
    let _ = say.try_send(live.record().clone());
    let take = |live: &mut Live, one: &Fed| match one {
        Fed::Sample(sample) => live.sample(sample),
        Fed::Seen(seen) => {
            if let Some(record) = live.seen(seen) {
                let _ = say.try_send(record.clone());
            }
        }
    };
    while let Ok(first) = fed.recv() {
        take(&mut live, &first);
        // All that is there before the next fit, so that it is of the newest; no more than there is room for, so that it comes.
        for one in fed.try_iter().take(WAITING) {
            take(&mut live, &one);
        }
        if live.is_due() {
            refit(&mut live);
            let _ = say.try_send(live.record().clone());
        }
    }
    live.finish();
    if live.is_due() {
        refit(&mut live);
    }
    let _ = say.try_send(live.record().clone());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::AXES;
    use crate::flight::run::RunGeometry;
    use crate::identification::live::Config;
    use std::time::Instant;

    fn live() -> Live {
        Live::new(Config::default(), RunGeometry::DEFAULT)
    }

    /// A flight of a minute at 128 Hz, excited all along but at its end; how long the sample path took at most.
    fn fly(follower: &mut Follower) -> (Duration, Vec<OutputErrorRecord>) {
        let (mut longest, mut records) = (Duration::ZERO, Vec::new());
        for k in 0..7680_u32 {
            let time_s = f64::from(k) / 128.0;
            let begun = Instant::now();
            follower.sample(&Sample::new(time_s));
            if k % 8 == 0 {
                follower.seen(Seen { time_s, excited: k < 7000, terms: [7; AXES] });
            }
            records.extend(follower.next_record());
            longest = longest.max(begun.elapsed());
        }
        (longest, records)
    }

    #[test]
    fn a_fit_that_hangs_costs_its_numbers_and_nothing_else() {
        let mut follower = Follower::spawn_with(live(), |_| std::thread::sleep(Duration::from_secs(3600))).unwrap();
        let (longest, _) = fly(&mut follower);
        assert!(longest < Duration::from_millis(500), "{longest:?}");
        assert!(follower.lost() > 0, "what finds no room is counted");
        let begun = Instant::now();
        let _ = follower.finish(Duration::from_millis(50));
        assert!(begun.elapsed() < Duration::from_secs(2));
    }

    #[test]
    fn a_fit_that_panics_is_said_once() {
        let mut follower = Follower::spawn_with(live(), |_| panic!("on purpose")).unwrap();
        let (_, mut records) = fly(&mut follower);
        let until = Instant::now() + Duration::from_secs(20);
        let mut time_s = 60.0;
        while records.last().is_none_or(|last| last.progress != Progress::Failed) && Instant::now() < until {
            // The manoeuvre's end may have found no room: it is said until the thread hears it.
            time_s += 0.1;
            follower.seen(Seen { time_s, excited: false, terms: [7; AXES] });
            std::thread::sleep(Duration::from_millis(1));
            records.extend(follower.next_record());
        }
        assert!(records.last().unwrap().reason.contains("has ended"));
        assert!(follower.next_record().is_none());
    }

    #[test]
    fn what_cannot_be_fitted_is_said_at_the_end_too() {
        let mut follower = Follower::spawn(live()).unwrap();
        let (_, first) = fly(&mut follower);
        let last = follower.finish(Duration::from_secs(60)).or(first.last().cloned()).unwrap();
        assert_eq!(last.progress, Progress::Failed);
    }
}
