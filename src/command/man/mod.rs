//! `sideslip man`: the manual pages, one of the program and one of each command.

use super::options::replace_option::ReplaceOption;
use super::terminal::console::print;
use super::terminal::output_file::write_whole;
use clap_mangen::Man;
use sideslip::error::{Failure, Outcome};
use std::path::PathBuf;

const EXAMPLE: &str = "\
Example:
  sideslip man --out man1
  sideslip man diagnose > sideslip-diagnose.1

With --out the pages of the program and of every command are written, sideslip.1, sideslip-check.1 and so on, as
~/.local/share/man/man1 takes them; without it one page goes to standard output.";

/// Write the manual pages
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct ManArgs {
    /// The command that the page is about [default: the program]
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    command: Option<String>,
    /// Write every page to this directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Writes the pages of this program.
pub(crate) fn run(args: &ManArgs, program: &clap::Command) -> Result<Outcome, Failure> {
    let Some(folder) = &args.out else {
        let page = match &args.command {
            None => page_of(program.clone()),
            Some(name) => {
                commands(program).find(|(own, _)| own == name).map(|(_, command)| page_of(command)).ok_or_else(|| {
                    let names: Vec<String> = commands(program).map(|(name, _)| name).collect();
                    Failure::Input(format!("expected one of the commands {}, found `{name}`", names.join(", ")))
                })?
            }
        };
        print(&page?)?;
        return Ok(Outcome::Done);
    };
    std::fs::create_dir_all(folder).map_err(|error| Failure::io(folder, &error))?;
    let all = commands(program).map(|(_, command)| command).chain([program.clone()]);
    let pages: Vec<(PathBuf, clap::Command)> = all
        .map(|command| (folder.join(format!("{}.1", command.get_display_name().unwrap_or(command.get_name()))), command))
        .collect();
    pages.iter().try_for_each(|(file, _)| args.replace.refuse("--out", file))?;
    for (file, command) in pages {
        let page = page_of(command)?;
        write_whole(&file, |file| file.write_all(page.as_bytes()))?;
    }
    Ok(Outcome::Done)
}

/// Each command by name, called as its page is: `sideslip-check`.
fn commands(program: &clap::Command) -> impl Iterator<Item = (String, clap::Command)> {
    let of_program = program.get_subcommands().filter(|command| !command.is_hide_set());
    of_program.map(|command| {
        let (name, page) = (command.get_name().to_owned(), format!("{}-{}", program.get_name(), command.get_name()));
        let call = format!("{} {}", program.get_name(), command.get_name());
        (name, command.clone().version(env!("CARGO_PKG_VERSION")).display_name(page).bin_name(call))
    })
}

fn page_of(command: clap::Command) -> Result<String, Failure> {
    let mut page = Vec::new();
    Man::new(command).render(&mut page).map_err(|error| Failure::Running(error.to_string()))?;
    Ok(String::from_utf8_lossy(&page).into_owned())
}
