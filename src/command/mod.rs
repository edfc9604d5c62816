//! The commands, one file each: they join readers, pipeline, simulation and outputs; no mathematics here.

pub(crate) mod inspect;
pub(crate) mod linearise;
mod mapping_input;
mod model_input;
mod output_file;
pub(crate) mod replay;
mod run_controls;
pub(crate) mod simulate;
mod simulated_run;

use std::fmt::Arguments;
use std::io::Write;

/// A line for the person at the terminal, on standard error; a closed terminal is no reason to stop.
pub(crate) fn message(line: Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
