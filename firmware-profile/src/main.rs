//! The profile on the host: a static place, samples of its own, and an allocator that stops the program.
//!
//! `firmware-profile` flies the manoeuvre and prints sizes, Dutch roll and fingerprint. `--stack BYTES` flies it in a
//! thread of that much stack (started elsewhere), `--start-stack BYTES` starts there too: the program dies where it is too
//! little.

use firmware_profile::Profile;
use firmware_profile::budget::PARTS;
use firmware_profile::fingerprint::Fingerprint;
use firmware_profile::manoeuvre::Manoeuvre;
use sideslip::flight::run::RunGeometry;
use sideslip::modes::record::ModesRecord;
use sideslip::pipeline::Config;
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator while the program starts and ends; in flight there is none.
struct GroundOnly;

static IN_FLIGHT: AtomicBool = AtomicBool::new(false);

fn on_ground_only() {
    if IN_FLIGHT.load(Ordering::Relaxed) {
        std::process::abort();
    }
}

#[expect(unsafe_code, reason = "a global allocator has no safe form; this one only passes on what it was asked to the system's")]
// SAFETY: every method keeps the contract of `GlobalAlloc` because it hands its arguments unchanged to `System`, which does;
// the check before it neither allocates nor unwinds.
unsafe impl GlobalAlloc for GroundOnly {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        on_ground_only();
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        on_ground_only();
        // SAFETY: `block` came from `System` with this layout, for nothing else allocates here.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: GroundOnly = GroundOnly;

/// All the memory of the pipeline.
static PROFILE: Mutex<Profile> = Mutex::new(Profile::new());

fn start() -> Result<(), String> {
    let mut profile = PROFILE.lock().map_err(|error| error.to_string())?;
    profile.start(&Config::default(), RunGeometry::default()).map_err(|error| error.to_string())
}

/// Flies the manoeuvre without an allocator.
fn fly() -> Result<(Option<ModesRecord>, Fingerprint), String> {
    let mut profile = PROFILE.lock().map_err(|error| error.to_string())?;
    let mut fingerprint = Fingerprint::default();
    IN_FLIGHT.store(true, Ordering::Relaxed);
    for sample in Manoeuvre::default() {
        if let Some(tick) = profile.step(&sample) {
            fingerprint.take(tick);
        }
    }
    let last = profile.finish().and_then(|tick| {
        fingerprint.take(tick);
        tick.modes
    });
    IN_FLIGHT.store(false, Ordering::Relaxed);
    Ok((last, fingerprint))
}

/// The function's answer, from a thread with that much stack.
fn within<T: Send + 'static>(bytes: usize, run: fn() -> Result<T, String>) -> Result<T, String> {
    let thread = std::thread::Builder::new().stack_size(bytes).spawn(run).map_err(|error| error.to_string())?;
    thread.join().map_err(|_| "the thread broke off".to_owned())?
}

fn run() -> Result<String, String> {
    let mut arguments = std::env::args().skip(1);
    let (mut fly_in, mut start_in) = (None, None);
    while let Some(argument) = arguments.next() {
        let bytes = arguments.next().and_then(|bytes| bytes.parse::<usize>().ok());
        let bytes = bytes.ok_or_else(|| format!("expected a number of bytes after {argument}"))?;
        match argument.as_str() {
            "--stack" => fly_in = Some(bytes),
            "--start-stack" => start_in = Some(bytes),
            _ => return Err(format!("expected --stack or --start-stack, found {argument}")),
        }
    }
    start_in.map_or_else(start, |bytes| within(bytes, start))?;
    let (modes, fingerprint) = fly_in.map_or_else(fly, |bytes| within(bytes, fly))?;
    let mut text = String::from("part             bytes      limit\n");
    for part in PARTS {
        text += &format!("{:<12} {:>9} {:>10}\n", part.name, part.bytes, part.limit);
    }
    let dutch_roll = modes.and_then(|modes| modes.dutch_roll).ok_or("no Dutch roll")?;
    text += &format!(
        "Dutch roll   omega {:.3} +- {:.3} rad/s, zeta {:.3} +- {:.3}\n",
        dutch_roll.omega, dutch_roll.std_omega, dutch_roll.zeta, dutch_roll.std_zeta
    );
    text += &format!("fingerprint  {:016x}\n", fingerprint.0);
    Ok(text)
}

fn main() -> ExitCode {
    let outcome = run();
    let written = match &outcome {
        Ok(text) => std::io::stdout().write_all(text.as_bytes()),
        Err(error) => std::io::stderr().write_all(format!("firmware-profile: {error}\n").as_bytes()),
    };
    if outcome.is_ok() && written.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
