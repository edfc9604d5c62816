//! Controls that were recorded as commands (pulse widths, stick positions): by which scale they are angles.

use crate::flight::control::Control;
use crate::flight::file::run_file::RunInfo;

/// What a derivative by a control of assumed scale is told in, beside its number.
pub const PER_COMMAND: &str = "per unit of command, scale assumed";

/// Names of the controls whose scale a run assumes, as the run calls them.
pub fn assumed_names(info: &RunInfo) -> Vec<String> {
    let naming = info.geometry().controls;
    let assumed = Control::ALL.into_iter().zip(info.assumed_scale()).filter(|(_, assumed)| *assumed);
    assumed.map(|(control, _)| control.name(naming).to_owned()).collect()
}

/// The sentence about them; none where every scale is known.
pub fn assumed_scale(info: &RunInfo) -> Option<String> {
    let names = assumed_names(info);
    let first = names.first()?;
    Some(format!(
        "the scale of {} is assumed (500 us of pulse width, or a full stick, is 10 deg): their angles are commands, and a \
         derivative by one of them is {PER_COMMAND}; where the true scale is known, state it in the file of --config, \
         `[controls.{first}]` with full_us and full_deg",
        names.join(", ")
    ))
}
