//! `--force` of every command that writes files.

use sideslip::error::Failure;
use std::path::Path;

/// Names of the streams that a process is started with, and of whatever else it was given open.
const STREAMS: [&str; 4] = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc/self/fd"];

/// Whether files that exist may be replaced.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub(crate) struct ReplaceOption {
    /// Replace output files that exist
    #[arg(long)]
    pub(crate) force: bool,
}

impl ReplaceOption {
    /// The option in the call of another command.
    pub(crate) const FORCE: &str = "--force";

    /// Before any work: refuses to write over a file that exists. Standard output, by whatever name and wherever a shell directs
    /// it, pipes and devices are none.
    pub(crate) fn refuse(self, option: &str, output: &Path) -> Result<(), Failure> {
        let is_stream = output.as_os_str() == "-" || STREAMS.iter().any(|stream| output.starts_with(stream));
        if self.force || is_stream || !output.metadata().is_ok_and(|found| found.is_file()) {
            return Ok(());
        }
        Err(Failure::file(output, format_args!("{option}: exists already; --force replaces it")))
    }

    /// The same for what is written under these names into a folder.
    pub(crate) fn refuse_in(
        self,
        option: &str,
        folder: &Path,
        names: impl IntoIterator<Item = impl AsRef<Path>>,
    ) -> Result<(), Failure> {
        names.into_iter().try_for_each(|name| self.refuse(option, &folder.join(name)))
    }

    /// The same for options that may be left out.
    pub(crate) fn refuse_each<'o>(self, outputs: impl IntoIterator<Item = (&'o str, Option<&'o Path>)>) -> Result<(), Failure> {
        outputs.into_iter().try_for_each(|(option, output)| output.map_or(Ok(()), |output| self.refuse(option, output)))
    }
}
