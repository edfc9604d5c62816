//! One run of a test point: flown, telemetered, estimated by `live`, read through shared memory.

use super::child_guard::stopped_early;
use super::live_child::LiveChild;
use super::live_table::LiveTable;
use super::test_flight::{DemoTestPoint, RunPlan, SimulatedVehicle, TestFlight};
use crate::command::terminal::console::{clear_terminal, print_while_read};
use sideslip::error::{Failure, Outcome};
use sideslip::io::bus::reader::{NewestEstimate, Reader};
use sideslip::io::bus::root::BusRoot;
use sideslip::io::bus::service::Bus;
use sideslip::io::outputs::tables::terminal::Style;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Polling interval of the estimates.
const POLL: Duration = Duration::from_millis(10);
/// Between two pictures on the terminal.
const PICTURE: Duration = Duration::from_millis(250);
/// After the flight, until the last sample has been estimated and seen.
const AFTER: Duration = Duration::from_millis(600);
/// The longest wait for the first estimate.
const FIRST: Duration = Duration::from_secs(20);

/// What the folder of a run by PCM ends in, and the numbers of a run.
pub(super) const BY_PCM: &str = "-pcm";
pub(super) const NUMBERS: &str = "derivatives.json";

pub(super) struct FlownRun {
    pub(super) flight: TestFlight,
    pub(super) estimate: NewestEstimate,
    pub(super) log: PathBuf,
    /// The last estimates, in the form of `derivatives.json`.
    pub(super) numbers: PathBuf,
    pub(super) outcome: Outcome,
}

/// How the vehicle sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DemoLink {
    Mavlink,
    Pcm,
}

/// Flies a run and waits until it is estimated and its log closed.
pub(super) fn fly_run(
    (point, run, link): (&DemoTestPoint, &RunPlan, DemoLink),
    out: &Path,
    (speed, seed): (f64, u64),
    stop: &AtomicBool,
) -> Result<FlownRun, Failure> {
    let flight = TestFlight::fly(point, run, seed)?;
    let by = if link == DemoLink::Pcm { BY_PCM } else { "" };
    let name = format!("{}-{}{by}", point.name, run.name);
    let folder = out.join(&name);
    std::fs::create_dir_all(&folder).map_err(|error| Failure::io(&folder, &error))?;
    // Everybody in it is gone before this process leaves it, and takes it along.
    let bus = Bus::enter_private(&BusRoot::private_path())?;
    let numbers = folder.join(NUMBERS);
    let vehicle = match link {
        DemoLink::Mavlink => SimulatedVehicle::ready(flight.samples.clone(), speed)?,
        DemoLink::Pcm => SimulatedVehicle::ready_by_pcm(flight.samples.clone(), speed, &folder)?,
    };
    let mut live = LiveChild::start(&format!("run={name}"), &vehicle.url(), bus.root().path(), &folder, &numbers)?;
    let watched = watch(&bus, (&name, run, &flight), &vehicle, &mut live, speed, stop);
    // Whatever happened, the log is closed.
    vehicle.land();
    let ended = live.end();
    let (mut reader, mut newest) = watched?;
    newest = reader.latest()?.or(newest);
    drop(reader);
    let outcome = ended?;
    drop(bus);
    if stop.load(Ordering::Relaxed) {
        return Err(stopped_early());
    }
    let estimate = newest.ok_or_else(|| Failure::Running(format!("no estimate came; see {}", live.log().display())))?;
    Ok(FlownRun { flight, estimate, log: live.recording(), numbers, outcome })
}

/// Reads estimates until the flight is over; the reader, and the newest estimate.
fn watch(
    bus: &Bus,
    (name, run, flight): (&str, &RunPlan, &TestFlight),
    vehicle: &SimulatedVehicle,
    live: &mut LiveChild,
    speed: f64,
    stop: &AtomicBool,
) -> Result<(Reader, Option<NewestEstimate>), Failure> {
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
            let table =
                LiveTable { truth: &flight.truth, estimate: newest.as_ref(), style: Style::of_stream(&std::io::stdout()) };
            clear_terminal()?;
            print_while_read(&format!(
                "{name}: flown {:.1} of {:.0} s, {speed} times real time; to watch it elsewhere: sideslip watch --root {}\n\n{table}",
                vehicle.flown_s(),
                run.duration_s,
                bus.root().path().display()
            ))?;
        }
        std::thread::sleep(POLL);
    }
    if on_terminal {
        clear_terminal()?;
    }
    Ok((reader, newest))
}
