//! The program `sideslip`: reads the call, runs one command, turns its end into an exit status.

mod command;

#[cfg(test)]
#[path = "../tests/support/allocations.rs"]
mod allocations;

#[cfg(test)]
#[global_allocator]
static ALLOCATOR: allocations::Counted = allocations::Counted;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "sideslip", version, about, arg_required_else_help = true)]
struct Call {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(command::demo::Args),
    Live(command::live::Args),
    Ingest(command::ingest::Args),
    Estimate(command::estimate::Args),
    Watch(command::watch::Args),
    Replay(command::replay::Args),
    Check(command::check::Args),
    Compare(command::compare::Args),
    Identify(command::identify::Args),
    Simulate(command::simulate::Args),
    Linearise(command::linearise::Args),
    Design(command::design::Args),
    Diagnose(command::diagnose::Args),
    Inspect(command::inspect::Args),
}

fn main() -> ExitCode {
    let ended = match Call::parse().command {
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
    };
    match ended {
        Ok(outcome) => ExitCode::from(outcome.exit_status()),
        Err(failure) => {
            command::message(format_args!("sideslip: {failure}"));
            ExitCode::from(failure.exit_status())
        }
    }
}
