//! Wiring errors of channels that hardly move: increments (`coarse`) do not show them, but they feign errors of instruments.
//!
//! Consumes a run in which errors of instruments were found; tries a sign turned, and the accelerometers across gravity under
//! each other's names: each is put right and the run fitted with nothing at fault. Where the best of them does as well by
//! evidence (E of `select`, (2)) as what was found in the run as recorded, within [`RIVAL`], wiring is what is told, and no error
//! of an instrument. Wiring and an error of an instrument at once are not tried: of a channel that hardly moves its sign would
//! then be told by what the noise has of colour.

use super::fit::Run;
use super::odd::evidence_alone;
use super::record::Record;
use super::select::{Found, RIVAL, run_of, select, with_no_fault};
use super::side_by_side::side_by_side;
use crate::flight::channel::{Channel, ControlNames};

/// Channels whose signs are turned in practice, and whose errors others answer for.
const SIGNED: [Channel; 6] = [Channel::Phi, Channel::Theta, Channel::Alpha, Channel::Beta, Channel::Ax, Channel::Ay];

/// What may be wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wiring {
    Turned(Channel),
    Exchanged,
}

impl Wiring {
    fn put_right(self, record: &Record) -> Record {
        match self {
            Wiring::Turned(channel) => record.turned(channel),
            Wiring::Exchanged => record.exchanged(),
        }
    }

    fn words(self) -> String {
        match self {
            Wiring::Turned(channel) => format!("{} with its sign turned", channel.name(ControlNames::Rotorcraft)),
            Wiring::Exchanged => "ax and ay under each other's names".to_owned(),
        }
    }
}

/// The wiring error that explains a run at least as well as errors of instruments do, as a reason why it is not fit.
pub(super) fn wiring(run: &Run) -> Option<String> {
    let evidence = |found: Option<Found>| evidence_alone(&found?);
    let there = |channel: &Channel| run.record.has(*channel);
    let turned = SIGNED.into_iter().filter(there).map(Wiring::Turned);
    let exchanged = [Channel::Ax, Channel::Ay].iter().all(there).then_some(Wiring::Exchanged);
    let all: Vec<Wiring> = turned.chain(exchanged).collect();
    let tried = side_by_side(&all, |wiring| {
        let other = run_of(wiring.put_right(&run.record));
        Some((evidence(with_no_fault(&other))?, *wiring))
    });
    let (theirs, best) = tried.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let ours = evidence(select(vec![run.clone()]))?;
    let what = best.words();
    if theirs < ours - RIVAL {
        Some(format!("it reads like one with {what}: so all agree far better than with any errors of instruments"))
    } else if theirs < ours + RIVAL {
        Some(format!("it may be {what}: so all agree as well as with errors of instruments, which are not told apart from it"))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::flown;
    use super::*;

    #[test]
    fn a_sign_that_is_turned_and_accelerometers_that_are_exchanged_are_known_by_the_whole_fit() {
        let record = flown();
        assert_eq!(wiring(&run_of(record.clone())), None);
        for (wrong, words) in [
            (record.exchanged(), "ax and ay under each other's names"),
            (record.turned(Channel::Ay), "ay with its sign turned"),
            (record.turned(Channel::Theta), "theta with its sign turned"),
        ] {
            let said = wiring(&run_of(wrong)).unwrap();
            assert!(said.contains(words), "{said}");
        }
    }
}
