//! What takes longer than a sample (output error, the diagnosis) on a thread of its own: the sample path hands samples over and
//! takes records back, and never waits.
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

/// How much more the thread gives way than others: where processors are few, samples and estimates come first.
const GIVES_WAY: i32 = 15;

/// What follows a flight.
pub trait Follow: Send + 'static {
    /// What it says: of fixed size, so that taking it allocates nothing.
    type Record: Send + 'static;
    /// Name of its thread.
    const THREAD: &'static str;
    /// Samples that may wait: by 128 a second, four minutes of work at 32768.
    const WAITING: usize;
    /// Records that may wait; of more the newest are lost, and come again with the next ones.
    const RECORDS: usize;

    /// How it stands, with nothing new: the first word, and the last where no work is due.
    fn stand(&mut self, say: &mut dyn FnMut(Self::Record));
    /// A sample as it came.
    fn sample(&mut self, sample: &Sample);
    /// What the regression said.
    fn seen(&mut self, seen: &Seen, say: &mut dyn FnMut(Self::Record));
    /// Whether there is work.
    fn is_due(&self) -> bool;
    /// Does it.
    fn work(&mut self, say: &mut dyn FnMut(Self::Record));
    /// The run is over: a manoeuvre that goes on ends.
    fn finish(&mut self);
    /// The word for a thread that has ended before its time.
    fn ended() -> Self::Record;

    /// A sample with what the regression said of it, and the work that is due then: in step with a recording.
    fn step(&mut self, sample: &Sample, seen: Option<&Seen>, say: &mut dyn FnMut(Self::Record)) {
        self.sample(sample);
        if let Some(seen) = seen {
            self.seen(seen, say);
        }
        if self.is_due() {
            self.work(say);
        }
    }

    /// The run is over: its last work, or how it stands where none is due.
    fn end(&mut self, say: &mut dyn FnMut(Self::Record)) {
        self.finish();
        if self.is_due() { self.work(say) } else { self.stand(say) }
    }
}

impl Follow for Live {
    type Record = OutputErrorRecord;
    const THREAD: &'static str = "sideslip-output-error";
    const WAITING: usize = 4096;
    const RECORDS: usize = 8;

    fn stand(&mut self, say: &mut dyn FnMut(OutputErrorRecord)) {
        say(self.record().clone());
    }

    fn sample(&mut self, sample: &Sample) {
        Live::sample(self, sample);
    }

    fn seen(&mut self, seen: &Seen, say: &mut dyn FnMut(OutputErrorRecord)) {
        if let Some(record) = Live::seen(self, seen) {
            say(record.clone());
        }
    }

    fn is_due(&self) -> bool {
        Live::is_due(self)
    }

    fn work(&mut self, say: &mut dyn FnMut(OutputErrorRecord)) {
        say(self.refit().clone());
    }

    fn finish(&mut self) {
        Live::finish(self);
    }

    fn ended() -> OutputErrorRecord {
        let mut record = OutputErrorRecord { progress: Progress::Failed, ..OutputErrorRecord::EMPTY };
        record.explain("the thread that fits has ended");
        record
    }
}

enum Fed {
    Sample(Sample),
    Seen(Seen),
}

/// The sample path's end.
#[derive(Debug)]
pub struct Follower<F: Follow> {
    to: Sender<Fed>,
    from: Receiver<F::Record>,
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

impl<F: Follow> Follower<F> {
    /// Starts the thread. Everything that the sample path needs is allocated here.
    ///
    /// # Errors
    /// Where there is no thread to be had.
    pub fn spawn(follow: F) -> io::Result<Self> {
        let (to, fed) = bounded(F::WAITING);
        let (say, from) = bounded(F::RECORDS);
        std::thread::Builder::new().name(F::THREAD.to_owned()).spawn(move || work(follow, &fed, &say))?;
        Ok(Follower { to, from, lost: 0, ended: false })
    }

    /// Hands over a sample and what the regression said of it; the next record, where there is one.
    pub fn step(&mut self, sample: &Sample, seen: Option<Seen>) -> Option<F::Record> {
        self.sample(sample);
        if let Some(seen) = seen {
            self.seen(seen);
        }
        self.next_record()
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
    pub fn next_record(&mut self) -> Option<F::Record> {
        match self.from.try_recv() {
            Ok(record) => Some(record),
            Err(TryRecvError::Disconnected) if !self.ended => {
                self.ended = true;
                Some(F::ended())
            }
            Err(_) => None,
        }
    }

    /// The run is over: its last records, waited for so long.
    pub fn finish(self, patience: Duration) -> impl Iterator<Item = F::Record> {
        let Follower { to, from, .. } = self;
        drop(to);
        let until = std::time::Instant::now() + patience;
        std::iter::from_fn(move || from.recv_deadline(until).ok())
    }
}

fn work<F: Follow>(mut follow: F, fed: &Receiver<Fed>, to: &Sender<F::Record>) {
    // Of this thread alone, on Linux. Refused, it works all the same.
    let _ = rustix::process::nice(GIVES_WAY);
    let mut say = |record: F::Record| {
        let _ = to.try_send(record);
    };
    follow.stand(&mut say);
    while let Ok(first) = fed.recv() {
        // All that is there before the next work, so that it is of the newest; no more than there is room for, so that it comes.
        for one in std::iter::once(first).chain(fed.try_iter().take(F::WAITING)) {
            match one {
                Fed::Sample(sample) => follow.sample(&sample),
                Fed::Seen(seen) => follow.seen(&seen, &mut say),
            }
        }
        if follow.is_due() {
            follow.work(&mut say);
        }
    }
    follow.end(&mut say);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::AXES;
    use crate::flight::run::RunGeometry;
    use crate::identification::live::Config;
    use std::time::Instant;

    /// Output error with another way to fit.
    struct Odd(Live, fn());

    impl Follow for Odd {
        type Record = OutputErrorRecord;
        const THREAD: &'static str = "odd";
        const WAITING: usize = 4096;
        const RECORDS: usize = 8;
        fn stand(&mut self, say: &mut dyn FnMut(OutputErrorRecord)) {
            self.0.stand(say);
        }
        fn sample(&mut self, sample: &Sample) {
            Follow::sample(&mut self.0, sample);
        }
        fn seen(&mut self, seen: &Seen, say: &mut dyn FnMut(OutputErrorRecord)) {
            Follow::seen(&mut self.0, seen, say);
        }
        fn is_due(&self) -> bool {
            self.0.is_due()
        }
        fn work(&mut self, _: &mut dyn FnMut(OutputErrorRecord)) {
            self.1();
        }
        fn finish(&mut self) {
            Follow::finish(&mut self.0);
        }
        fn ended() -> OutputErrorRecord {
            Live::ended()
        }
    }

    fn live() -> Live {
        Live::new(Config::default(), RunGeometry::DEFAULT)
    }

    /// A flight of a minute at 128 Hz, excited all along but at its end; how long the sample path took at most.
    fn fly<F: Follow<Record = OutputErrorRecord>>(follower: &mut Follower<F>) -> (Duration, Vec<OutputErrorRecord>) {
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
        let mut follower = Follower::spawn(Odd(live(), || std::thread::sleep(Duration::from_secs(3600)))).unwrap();
        let (longest, _) = fly(&mut follower);
        assert!(longest < Duration::from_millis(500), "{longest:?}");
        assert!(follower.lost() > 0, "what finds no room is counted");
        let begun = Instant::now();
        let _ = follower.finish(Duration::from_millis(50)).last();
        assert!(begun.elapsed() < Duration::from_secs(2));
    }

    #[test]
    fn a_fit_that_panics_is_said_once() {
        let mut follower = Follower::spawn(Odd(live(), || panic!("on purpose"))).unwrap();
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
        let last = follower.finish(Duration::from_secs(60)).last().or(first.last().cloned()).unwrap();
        assert_eq!(last.progress, Progress::Failed);
    }
}
