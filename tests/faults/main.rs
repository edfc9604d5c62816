//! The fault matrix: broken inputs give a clear end, never a panic and never a guess.

mod run_files;
