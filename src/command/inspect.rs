//! `sideslip inspect`.

use sideslip::error::{Failure, Outcome};

/// x
#[derive(clap::Args)]
pub(crate) struct Args {}

/// x
pub(crate) fn run(_args: &Args) -> Result<Outcome, Failure> {
    Err(Failure::Running("not written yet".into()))
}
