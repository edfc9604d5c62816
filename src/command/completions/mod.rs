//! `sideslip completions`: what a shell completes of calls, as a script of that shell.

use super::terminal::console::print;
use clap_complete::Shell;
use sideslip::error::{Failure, Outcome};

const EXAMPLE: &str = "\
Example:
  sideslip completions bash > sideslip.bash && . ./sideslip.bash
  sideslip completions zsh > _sideslip
  sideslip completions fish > sideslip.fish

The script belongs where the shell looks for it: bash ~/.local/share/bash-completion/completions/sideslip, zsh a folder of $fpath,
fish ~/.config/fish/completions/sideslip.fish.";

/// Write the completions of a shell to standard output
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Writes the script of this program.
pub(crate) fn run(args: &CompletionsArgs, program: &mut clap::Command) -> Result<Outcome, Failure> {
    let name = program.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(args.shell, program, name, &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}
