//! `sideslip watch`: the newest estimates out of shared memory, as a screen on a terminal, as lines for everything else.

mod bus_picture;
mod lines;
mod nobody;
mod repetition;
mod sample_flow;
mod screen;

use super::recordings::provenance::Provenance;
use super::terminal::console::{print_json, print_while_read};
use super::terminal::stop::stopped_by_signals;
use crate::command::{message, root_path};
use bus_picture::{BusListener, BusPicture};
use nobody::{nobody_here, running_elsewhere};
use repetition::Repetition;
use screen::open_screen::OpenScreen;
use sideslip::error::{Failure, Outcome};
use sideslip::io::bus::role_holder::RoleHolder;
use sideslip::io::bus::service::Bus;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const EXAMPLE: &str = "\
Example:
  sideslip watch
  sideslip watch --plain --count 1
  sideslip watch --json | jq --unbuffered '.estimate.modes.dutch_roll'

On a terminal it is a screen: Dutch roll, verdict on stability, ages, link, status and the newest events on the first page; the
keys 1 to 5 show overview, derivatives, modes, instruments and events, ? the help, q or ctrl-C ends it. What is out of date
says STALE. Colours are left out where NO_COLOR is set. Elsewhere, and with --plain, it prints a table for each output.

With --json each line holds age (s), sequence, incarnation, missed, status, valid, and the estimate in the form of
derivatives.json. All but `missed`, `status` and `valid` are null before
the first estimate. It ends with ctrl-C, or when nobody reads it any more.";

/// Interval of the check whether it was stopped.
const SLICE: Duration = Duration::from_millis(20);

/// Show the latest estimates of a running estimator: a screen on a terminal, else a table a second
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct WatchArgs {
    /// Directory of the run: processes and readers with the same one share its data
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// Print a JSON object a line
    #[arg(long)]
    json: bool,
    /// Print tables on a terminal too, one below the other
    #[arg(long, conflicts_with = "json")]
    plain: bool,
    /// Interval of the output, s [default: 1, of the screen 0.25]
    #[arg(long, value_name = "S", value_parser = interval)]
    every: Option<Duration>,
    /// End after so many outputs
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

fn interval(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| (0.02..=3600.0).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| format!("expected seconds from 0.02 to 3600, found `{text}`"))
}

/// Shows until it is stopped.
pub(crate) fn run(args: &WatchArgs) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    let root = root_path(args.root.as_ref());
    let on_terminal = std::io::stdout().is_terminal() && !args.json && !args.plain;
    let listener = BusListener::on(Bus::enter(&root)?, on_terminal)?;
    let mut picture = BusPicture::of(root);
    let repetition = Repetition { every: args.every, count: args.count };
    // A terminal without a keyboard has lines, too.
    match on_terminal.then(OpenScreen::open).and_then(Result::ok) {
        Some(mut opened) => screen::run(&mut opened, listener, &mut picture, repetition, &stop),
        None => print_lines(listener, &mut picture, (args.json, repetition), &stop),
    }
}

fn print_lines(
    mut listener: BusListener,
    picture: &mut BusPicture,
    (json, repetition): (bool, Repetition),
    stop: &AtomicBool,
) -> Result<Outcome, Failure> {
    // An estimate that was published before comes with the next one.
    let patience = Instant::now() + Duration::from_millis(500);
    while listener.estimate()?.is_none() && Instant::now() < patience && !stop.load(Ordering::Relaxed) {
        std::thread::sleep(SLICE);
    }
    listener.name_processes(picture);
    if picture.estimator == RoleHolder::Nobody && picture.estimate.is_none() && !json {
        picture.elsewhere = running_elsewhere(&picture.root);
        message(format_args!("watch: {}", nobody_here(picture).join("; ")));
    }
    let mut due = Instant::now();
    let mut polls = 0;
    while !stop.load(Ordering::Relaxed) && repetition.more_after(polls) {
        let now = Instant::now();
        if now < due {
            std::thread::sleep(SLICE.min(due - now));
            continue;
        }
        due = (due + repetition.every.unwrap_or(Duration::from_secs(1))).max(now);
        polls += 1;
        listener.take_in(picture)?;
        listener.name_run(picture);
        let is_read = if json {
            print_json(&Provenance::default().in_front_of(&format!("{}\n", lines::json_line(picture)?), None))?
        } else {
            print_while_read(&lines::table(picture))?
        };
        if !is_read {
            break;
        }
    }
    Ok(Outcome::Done)
}
