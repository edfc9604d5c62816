//! Differences between the runs' trim and the model's, in words.

use crate::flight::channel::ControlNames;
use crate::io::outputs::number::estimate_text;
use crate::postflight::diagnosis::record::TrimDifference;

/// Each with its sign, standard error and SI unit.
pub fn trim_differences(differences: &[TrimDifference], naming: ControlNames) -> String {
    let one = |one: &TrimDifference| {
        format!("{} {} {}", one.channel.name(naming), estimate_text(one.value, one.std), one.channel.si_unit())
    };
    differences.iter().map(one).collect::<Vec<_>>().join(", ")
}
