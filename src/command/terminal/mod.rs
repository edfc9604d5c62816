//! The terminal and the process: progress, stop, files that are whole or not there.

pub(crate) mod console;
pub(crate) mod output_file;
pub(crate) mod progress_line;
pub(crate) mod stop;
