//! The profile on the host: a static place, samples of its own, and an allocator that stops the program.
//!
//! `firmware-profile` flies the manoeuvre and prints sizes, Dutch roll and fingerprint. `--stack BYTES` flies it in a
//! thread of that much stack: the program dies where it is too little. `--samples FILE` flies the samples of a file
//! (`examples/recorded_samples.rs`), `--c-header` prints `include/sideslip.h`.

use firmware_profile::budget::PARTS;
use firmware_profile::c_interface::SideslipSample;
use firmware_profile::c_interface::header::header;
use firmware_profile::fingerprint::Fingerprint;
use firmware_profile::manoeuvre::ManoeuvreSamples;
use firmware_profile::{Profile, SETTINGS};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::modes::record::ModesRecord;
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
static PROFILE: Mutex<Profile> = Mutex::new(Profile::new(&SETTINGS, RunGeometry::DEFAULT));

/// Flies the manoeuvre without an allocator.
fn fly() -> Result<(Option<ModesRecord>, Fingerprint), String> {
    fly_samples(ManoeuvreSamples::default())
}

/// Flies the samples without an allocator.
fn fly_samples(samples: impl Iterator<Item = Sample>) -> Result<(Option<ModesRecord>, Fingerprint), String> {
    let mut profile = PROFILE.lock().map_err(|error| error.to_string())?;
    let mut fingerprint = Fingerprint::default();
    IN_FLIGHT.store(true, Ordering::Relaxed);
    for sample in samples {
        fingerprint.take(profile.step(&sample));
    }
    let tick = profile.finish();
    fingerprint.take(tick);
    let last = tick.modes;
    IN_FLIGHT.store(false, Ordering::Relaxed);
    Ok((last, fingerprint))
}

/// The fingerprint of the samples of a file, one `SideslipSample` after the other.
fn fingerprint_of(file: &str) -> Result<String, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
    let (samples, rest) = bytes.as_chunks();
    if !rest.is_empty() {
        return Err(format!("{file}: expected samples of {} bytes, found {} left over", SideslipSample::BYTES, rest.len()));
    }
    let (_, fingerprint) = fly_samples(samples.iter().map(|bytes| Sample::from(&SideslipSample::from_le_bytes(bytes))))?;
    Ok(format!("fingerprint  {:016x}\n", fingerprint.0))
}

/// The same in a thread with that much stack.
fn within(bytes: usize) -> Result<(Option<ModesRecord>, Fingerprint), String> {
    let thread = std::thread::Builder::new().stack_size(bytes).spawn(fly).map_err(|error| error.to_string())?;
    thread.join().map_err(|_| "the thread broke off".to_owned())?
}

fn run() -> Result<String, String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (modes, fingerprint) = match arguments[..] {
        [] => fly()?,
        ["--stack", bytes] => {
            within(bytes.parse().map_err(|_| format!("expected a number of bytes after --stack, found {bytes:?}"))?)?
        }
        ["--samples", file] => return fingerprint_of(file),
        ["--c-header"] => {
            let mut text = String::new();
            return header(&mut text).map(|()| text).map_err(|error| error.to_string());
        }
        _ => return Err(format!("expected nothing, `--stack BYTES`, `--samples FILE` or `--c-header`, found {arguments:?}")),
    };
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
