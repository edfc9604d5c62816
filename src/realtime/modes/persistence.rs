//! Persistence: an unstable mode is published once it has been unstable for a while, and the last good answer is kept.
//!
//! Consumes the modes of every publication. An unstable root is withheld until it was unstable, beyond the standard errors that
//! [`OscillatoryMode::is_resolved`] and [`RealRoot::is_resolved`] ask for, at every publication of the last `PERSISTS_S`. One
//! reading in some ten thousand of a stable aircraft in gusts is beyond those standard errors, while the first seconds of a
//! response are being taken up; an aircraft that is unstable stays so.
//! Modes whose Dutch roll was published for as long take the place of a later publication without any, as `stale` and with the
//! time of the samples that they rest on: data that tell nothing do not take back what earlier ones told. A doubted instrument
//! does: both rest on its readings.

use super::record::{ModesRecord, OscillatoryMode, RealRoot};
use crate::realtime::regression::record::Status;

/// Time for which a mode has to have been unstable, or the Dutch roll published before it is kept, s.
const PERSISTS_S: f64 = 2.0;
/// Dutch roll, coupled Dutch roll, lateral phugoid, roll, spiral.
const MODES: usize = 5;

/// Since when each mode has been unstable, and the last answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Persistence {
    unstable_since_s: [Option<f64>; MODES],
    /// Since when the Dutch roll has been published without interruption.
    answered_since_s: Option<f64>,
    kept: Option<ModesRecord>,
}

impl Persistence {
    /// Before the first publication.
    pub const START: Persistence = Persistence { unstable_since_s: [None; MODES], answered_since_s: None, kept: None };

    /// Takes up the modes of one publication: withholds what has not been unstable for long enough, and puts the last good answer
    /// where there is none.
    pub fn step(&mut self, modes: &mut ModesRecord) {
        self.withhold_new_instabilities(modes);
        self.keep_last_answer(modes);
    }

    fn withhold_new_instabilities(&mut self, modes: &mut ModesRecord) {
        let time_s = modes.time_s;
        let grows = |pair: Option<OscillatoryMode>| pair.is_some_and(|pair| pair.real > 0.0);
        let diverges = |root: Option<RealRoot>| root.is_some_and(|root| root.value > 0.0);
        let unstable = [
            grows(modes.dutch_roll),
            grows(modes.coupled),
            grows(modes.lateral_phugoid),
            diverges(modes.roll),
            diverges(modes.spiral),
        ];
        let mut is_new = [false; MODES];
        for ((since_s, unstable), is_new) in self.unstable_since_s.iter_mut().zip(unstable).zip(&mut is_new) {
            // A clock that was set back starts anew.
            *since_s = if unstable { since_s.filter(|since_s| *since_s <= time_s).or(Some(time_s)) } else { None };
            *is_new = since_s.is_some_and(|since_s| time_s - since_s < PERSISTS_S);
        }
        let [dutch_roll, coupled, lateral_phugoid, roll, spiral] = is_new;
        if dutch_roll && modes.status == Status::Converged {
            modes.status = Status::Converging;
        }
        modes.dutch_roll = modes.dutch_roll.filter(|_| !dutch_roll);
        modes.coupled = modes.coupled.filter(|_| !coupled);
        modes.lateral_phugoid = modes.lateral_phugoid.filter(|_| !lateral_phugoid);
        modes.roll = modes.roll.filter(|_| !roll);
        modes.spiral = modes.spiral.filter(|_| !spiral);
    }

    fn keep_last_answer(&mut self, modes: &mut ModesRecord) {
        let time_s = modes.time_s;
        // A clock that was set back starts anew.
        self.kept = self.kept.filter(|kept| kept.time_s <= time_s);
        self.answered_since_s = self.answered_since_s.filter(|since_s| *since_s <= time_s);
        if modes.dutch_roll.is_some() {
            let since_s = *self.answered_since_s.get_or_insert(time_s);
            if time_s - since_s >= PERSISTS_S && modes.status.rank() >= Status::Converging.rank() {
                self.kept = Some(*modes);
            }
            return;
        }
        self.answered_since_s = None;
        if matches!(modes.status, Status::NotIdentifiable(reason) if reason.is_of_an_instrument()) {
            self.kept = None;
        } else if modes.status.rank() < Status::Stale.rank()
            && let Some(kept) = self.kept
        {
            *modes = ModesRecord { status: Status::Stale, ..kept };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::regression::record::Reason;

    fn published(persistence: &mut Persistence, time_s: f64, real: f64) -> ModesRecord {
        let pair = OscillatoryMode { real, imag: 1.4, omega: 1.4, zeta: -real / 1.4, std_omega: 0.01, std_zeta: 0.001 };
        let root = RealRoot { value: real, std: 0.001 };
        let mut modes = ModesRecord {
            dutch_roll: Some(pair),
            roll: Some(RealRoot { value: -1.0, std: 0.1 }),
            spiral: Some(root),
            ..ModesRecord::empty(time_s, Status::Converged)
        };
        persistence.step(&mut modes);
        modes
    }

    #[test]
    fn an_instability_is_published_after_two_seconds_without_interruption() {
        let mut persistence = Persistence::START;
        for tenth in 0..20 {
            let modes = published(&mut persistence, 0.1 * f64::from(tenth), 0.2);
            assert_eq!((modes.dutch_roll, modes.spiral, modes.status), (None, None, Status::Converging));
            assert!(modes.roll.is_some(), "what is stable is published at once");
        }
        let modes = published(&mut persistence, 2.0, 0.2);
        assert!(modes.dutch_roll.is_some() && modes.spiral.is_some() && modes.status == Status::Converged);
        assert!(published(&mut persistence, 2.1, -0.2).dutch_roll.is_some());
        assert!(published(&mut persistence, 2.2, 0.2).dutch_roll.is_none(), "counted anew");
        assert!(published(&mut persistence, 0.0, 0.2).dutch_roll.is_none(), "a clock that was set back");
        assert!(published(&mut persistence, 2.0, 0.2).dutch_roll.is_some());
    }

    #[test]
    fn the_last_good_answer_is_kept_until_an_instrument_is_doubted() {
        let pair = OscillatoryMode { real: -0.2, imag: 1.4, omega: 1.41, zeta: 0.14, std_omega: 0.01, std_zeta: 0.01 };
        let answer = |time_s: f64| ModesRecord { dutch_roll: Some(pair), ..ModesRecord::empty(time_s, Status::Converging) };
        let through = |persistence: &mut Persistence, mut modes: ModesRecord| {
            persistence.step(&mut modes);
            modes
        };
        let waiting = |time_s| ModesRecord::empty(time_s, Status::Waiting);
        let mut persistence = Persistence::START;
        through(&mut persistence, answer(5.0));
        through(&mut persistence, answer(6.9));
        assert_eq!(through(&mut persistence, waiting(7.0)), waiting(7.0), "published for less than two seconds");
        through(&mut persistence, answer(8.0));
        through(&mut persistence, answer(10.0));
        let kept = ModesRecord { status: Status::Stale, ..answer(10.0) };
        for status in [Status::Waiting, Status::Exciting, Status::NotIdentifiable(Reason::Unresolved)] {
            assert_eq!(through(&mut persistence, ModesRecord::empty(11.0, status)), kept);
        }
        // Two methods that contradict each other are an answer, as is a motion without an oscillation.
        for status in [Status::Disagree, Status::Converging] {
            assert_eq!(through(&mut persistence, ModesRecord::empty(12.0, status)), ModesRecord::empty(12.0, status));
        }
        let doubted = ModesRecord::empty(13.0, Status::NotIdentifiable(Reason::InstrumentDoubted { channel: None }));
        assert_eq!(through(&mut persistence, doubted), doubted);
        assert_eq!(through(&mut persistence, waiting(14.0)), waiting(14.0), "not after the doubt either");
        through(&mut persistence, answer(15.0));
        through(&mut persistence, answer(17.0));
        assert_eq!(through(&mut persistence, waiting(3.0)), waiting(3.0), "a clock that was set back");
    }
}
