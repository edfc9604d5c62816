//! `sideslip demo`: the main job on this machine, nothing to set up.
//!
//! A simulated helicopter whose derivatives are known flies test inputs and sends MAVLink over the loopback, as its radio
//! would; `live` takes it up in processes of its own and estimates; this process looks on through shared memory, as any
//! reader can, and in the end puts the estimate beside the truth.

mod flight;
mod live;
mod table;

use super::message;
use super::output_file::{print, write_json};
use super::stop::stopped_by_signals;
use flight::{TestFlight, Vehicle};
use live::LiveChild;
use sideslip::bus::reader::{Estimate, Reader};
use sideslip::bus::root::Root;
use sideslip::bus::service::Bus;
use sideslip::error::{Failure, Outcome};
use sideslip::outputs::terminal::Style;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use table::Table;

const EXAMPLE: &str = "\
Example:
  sideslip demo
  sideslip demo --speed 1 --seed 3 --out trial/

On a terminal the estimates are shown while they come; it ends with a table of truth and estimate and the paths of the log
and of the numbers. Everything stays on this machine (127.0.0.1). While it runs, `sideslip watch --root DIR` with the root
that it names shows the same to anybody.

Exit status: 0 done; 1 failed while running; 2 the call is wrong; 3 done, with data lost (said how much).";

/// Between looks at the estimates.
const LOOK: Duration = Duration::from_millis(10);
/// Between two pictures on the terminal.
const PICTURE: Duration = Duration::from_millis(250);
/// After the flight, until the last sample has been estimated and seen.
const AFTER: Duration = Duration::from_millis(600);
/// The longest wait for the first estimate.
const FIRST: Duration = Duration::from_secs(20);

/// Fly a simulated helicopter, telemeter it as MAVLink, estimate live, and compare with the truth
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Directory for the log and the numbers (made where it is missing)
    #[arg(long, value_name = "DIR", default_value = "sideslip-demo")]
    out: PathBuf,
    /// How many times faster than real time it flies
    #[arg(long, value_name = "N", default_value = "2", value_parser = speed)]
    speed: f64,
    /// Seed of the instruments' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the last estimates as JSON to this file too, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

fn speed(text: &str) -> Result<f64, String> {
    let factor = text.parse::<f64>().ok().filter(|factor| (0.25..=20.0).contains(factor));
    factor.ok_or_else(|| format!("expected a factor from 0.25 to 20, found `{text}`"))
}

/// Flies, estimates, compares.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    let flight = TestFlight::fly(args.seed)?;
    std::fs::create_dir_all(&args.out).map_err(|error| Failure::io(&args.out, &error))?;
    // Everybody in it is gone before this process leaves it, and takes it along.
    let bus = Bus::enter_private(&Root::private_path())?;
    let root = bus.root().path().to_owned();
    let json = args.out.join("derivatives.json");
    let vehicle = Vehicle::ready(flight.samples.clone(), args.speed)?;
    message(format_args!(
        "A helicopter flies for {:.0} s, {} times real time: {}\nIts telemetry is MAVLink at {:.0} Hz, called at {}; estimates are in \
         shared memory, root {}",
        flight.duration_s(),
        args.speed,
        flight.inputs(),
        flight::RATE_HZ,
        vehicle.url(),
        root.display()
    ));
    let mut live = LiveChild::start(&vehicle.url(), &root, &args.out, &json)?;
    let watched = watch(&bus, &flight, &vehicle, &mut live, args.speed, &stop);
    // Whatever happened, the log is closed.
    vehicle.land();
    let ended = live.end();
    let (mut reader, mut newest) = watched?;
    newest = reader.latest()?.or(newest);
    drop(reader);
    let outcome = ended?;
    drop(bus);
    let stopped = stop.load(Ordering::Relaxed);
    if stopped && newest.is_none() {
        return Err(stopped_early());
    }
    let newest = newest.ok_or_else(|| Failure::Running(format!("no estimate came; see {}", live.log().display())))?;
    let to_standard_output = args.json.as_ref().is_some_and(|json| json.as_os_str() == "-");
    let style = if to_standard_output { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let mut closing = Table { truth: &flight.truth, estimate: Some(&newest), style, last: true }.to_string();
    closing.push_str(&format!("\nlog      {}\nnumbers  {}\n", live.recording().display(), json.display()));
    if to_standard_output {
        message(format_args!("{}", closing.trim_end()));
    } else {
        print(&closing)?;
    }
    if let Some(copy) = &args.json {
        write_json(copy, &std::fs::read_to_string(&json).map_err(|error| Failure::io(&json, &error))?)?;
    }
    if stopped { Err(stopped_early()) } else { Ok(outcome) }
}

fn stopped_early() -> Failure {
    Failure::Running("stopped by a signal before the flight was over; the log is closed".to_owned())
}

/// Looks on until the flight is over; the reader, and the newest estimate that it saw.
fn watch(
    bus: &Bus,
    flight: &TestFlight,
    vehicle: &Vehicle,
    live: &mut LiveChild,
    speed: f64,
    stop: &AtomicBool,
) -> Result<(Reader, Option<Estimate>), Failure> {
    let mut reader = Reader::on(bus)?;
    let (begun, on_terminal) = (Instant::now(), std::io::stdout().is_terminal());
    let mut newest = None;
    let mut due = begun;
    let mut over_since: Option<Instant> = None;
    while !stop.load(Ordering::Relaxed) && over_since.is_none_or(|since| since.elapsed() < AFTER) {
        live.must_run()?;
        if let Some(estimate) = reader.latest()? {
            newest = Some(estimate);
        } else if begun.elapsed() > FIRST {
            return Err(Failure::Running(format!("no estimate within {} s; see {}", FIRST.as_secs(), live.log().display())));
        }
        if vehicle.has_landed() {
            over_since.get_or_insert_with(Instant::now);
        }
        if on_terminal && Instant::now() >= due {
            due = Instant::now() + PICTURE;
            let table = Table {
                truth: &flight.truth,
                estimate: newest.as_ref(),
                style: Style::of_stream(&std::io::stdout()),
                last: false,
            };
            let flown_s = vehicle.flown_s();
            print(&format!(
                "\x1b[H\x1b[2JFlown {flown_s:.1} of {:.0} s, {speed} times real time\n\n{table}",
                flight.duration_s()
            ))?;
        }
        std::thread::sleep(LOOK);
    }
    if on_terminal {
        print("\x1b[H\x1b[2J")?;
    }
    Ok((reader, newest))
}
