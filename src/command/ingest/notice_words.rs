//! What happens on a link of MAVLink, in words for the person at the terminal.

use sideslip::io::telemetry::mavlink::live::LiveNotice;

/// A sentence: what was found, and what it means or what to do.
pub(super) fn notice_words(notice: &LiveNotice) -> String {
    match notice {
        LiveNotice::Changed { from, to } => {
            format!("{from} has fallen silent and {to} sends motion: {to} is the vehicle now")
        }
        LiveNotice::TwoClocks(vehicle) => {
            format!("two senders use {vehicle} with different clocks: what does not fit the first's is not used")
        }
        LiveNotice::TwoNumbers(vehicle) => format!(
            "two running numbers interleave in the messages of {vehicle}: two senders of one id, which cannot be distinguished, \
             or one received over two paths"
        ),
        LiveNotice::StandsStill(at_s) => format!("the vehicle's clock stands still at {at_s} s: samples need its time"),
        LiveNotice::SteppedBack { by_s, at_s } => format!(
            "the vehicle's clock was set back by {by_s:.2} s when it had reached {at_s:.2} s: its time goes on by this machine's \
             clock from there, and what came in between is too late for its place"
        ),
        LiveNotice::RunsFast(rate) => format!(
            "the vehicle's clock runs {rate:.2} times as fast as this machine's: right for a simulation that runs so fast; of an \
             aircraft every rate of change, and so every derivative, is wrong by that factor: check its clock"
        ),
        LiveNotice::AnotherVehicle { vehicle, other } => format!(
            "{other} sends motion too; {vehicle}, who sent more or was first, is taken as the vehicle: where that is wrong, name \
             it by `system` and `component` in the file of --config"
        ),
        LiveNotice::Refused(refusal) => format!("messages {} are refused, because a key is set", refusal.words()),
        LiveNotice::ByArrival => {
            "the vehicle's clock runs slower than this machine's: the age of a sample counts from its arrival".to_owned()
        }
    }
}
