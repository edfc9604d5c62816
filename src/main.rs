//! The program `sideslip`: reads the call, runs one command, turns its end into an exit status.

mod command;

#[cfg(test)]
#[allow(dead_code, reason = "each binary uses its part")]
#[path = "../tests/support/allocations.rs"]
mod allocations;

#[cfg(test)]
#[global_allocator]
static ALLOCATOR: allocations::Counted = allocations::Counted;

use clap::{CommandFactory, Parser, Subcommand};
use sideslip::io::outputs::words::printable::{printable, printable_lines};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "sideslip", version, about, arg_required_else_help = true)]
struct Call {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(command::demo::DemoArgs),
    Live(command::live::LiveArgs),
    Ingest(command::ingest::IngestArgs),
    Estimate(command::estimate::EstimateArgs),
    Watch(command::watch::WatchArgs),
    Replay(command::replay::ReplayArgs),
    Check(command::check::CheckArgs),
    Compare(command::compare::CompareArgs),
    Identify(command::identify::IdentifyArgs),
    Simulate(command::simulate::SimulateArgs),
    Linearise(command::linearise::LineariseArgs),
    Design(command::design::DesignArgs),
    Diagnose(command::diagnose::DiagnoseArgs),
    Inspect(command::inspect::InspectArgs),
    Convert(command::convert::ConvertArgs),
    Completions(command::completions::CompletionsArgs),
    Man(command::man::ManArgs),
}

fn main() -> ExitCode {
    command::file_size_limit_is_an_error();
    let status = status_of_call();
    command::finish();
    status
}

fn status_of_call() -> ExitCode {
    let call = match Call::try_parse() {
        Ok(call) => call,
        Err(refused) => return say_refused(&refused),
    };
    let ended = match call.command {
        Command::Demo(args) => command::demo::run(&args),
        Command::Live(args) => command::live::run(&args),
        Command::Ingest(args) => command::ingest::run(&args),
        Command::Estimate(args) => command::estimate::run(&args),
        Command::Watch(args) => command::watch::run(&args),
        Command::Replay(args) => command::replay::run(&args),
        Command::Check(args) => command::check::run(&args),
        Command::Compare(args) => command::compare::run(&args),
        Command::Identify(args) => command::identify::run(&args),
        Command::Simulate(args) => command::simulate::run(&args),
        Command::Linearise(args) => command::linearise::run(&args),
        Command::Design(args) => command::design::run(&args),
        Command::Diagnose(args) => command::diagnose::run(&args),
        Command::Inspect(args) => command::inspect::run(&args),
        Command::Convert(args) => command::convert::run(&args),
        Command::Completions(args) => command::completions::run(&args, &mut Call::command()),
        Command::Man(args) => command::man::run(&args, &Call::command()),
    };
    match ended {
        Ok(outcome) => ExitCode::from(outcome.exit_status()),
        Err(failure) => {
            command::message(format_args!("sideslip: {failure}"));
            ExitCode::from(failure.exit_status())
        }
    }
}

/// What is wrong with the call, or the help that was asked for; arguments cannot steer the terminal, and make no line of their
/// own.
fn say_refused(refused: &clap::Error) -> ExitCode {
    let mut said = refused.render().to_string();
    let given = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    let parts = given.flat_map(|argument| [argument.clone(), argument.split('=').next_back().unwrap_or_default().to_owned()]);
    let parts: Vec<String> = parts.filter(|part| part.contains('\n')).collect();
    if parts.is_empty() && printable_lines(&said) == said {
        refused.exit();
    }
    parts.iter().for_each(|part| said = said.replace(part, &printable(part)));
    command::message_text(said.trim_end());
    ExitCode::from(2)
}
