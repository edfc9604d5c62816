//! Faults: wrong files and wrong data are told from right ones, with the place and the reason.

mod model_files;
