//! `--force` of every command that writes files.

use crate::command::terminal::written_mark::is_unchanged_output;
use sideslip::error::Failure;
use std::path::Path;

/// Whether files of a user may be replaced.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub(crate) struct ReplaceOption {
    /// Replace files that the program did not write, or that were changed since; what it wrote itself a rerun replaces without
    #[arg(long)]
    pub(crate) force: bool,
}

impl ReplaceOption {
    /// Before any work: refuses to write over a file that a user made or edited. Standard output, pipes and devices are none.
    pub(crate) fn refuse(self, option: &str, output: &Path) -> Result<(), Failure> {
        let stands = || output.as_os_str() != "-" && output.metadata().is_ok_and(|found| found.is_file());
        if self.force || !stands() || is_unchanged_output(output) {
            return Ok(());
        }
        let expected = "expected a new name, or a result of sideslip that nobody changed";
        let found = "found another file or a log of a flight; --force replaces it";
        Err(Failure::file(output, format_args!("{option}: {expected}, {found}")))
    }

    /// The same option for a call of another command.
    pub(crate) fn call(self) -> Option<String> {
        self.force.then(|| "--force".to_owned())
    }

    /// The same for options that may be left out.
    pub(crate) fn refuse_each<'o>(self, outputs: impl IntoIterator<Item = (&'o str, Option<&'o Path>)>) -> Result<(), Failure> {
        outputs.into_iter().try_for_each(|(option, output)| output.map_or(Ok(()), |output| self.refuse(option, output)))
    }
}
