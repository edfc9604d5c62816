//! The radio of a test flight as PCM: the same samples as by MAVLink, a minor frame each.

use super::test_flight::{RATE_HZ, SimulatedVehicle, VehicleState};
use ::replay::{MonotonicClock, Pace, Player};
use sideslip::error::Failure;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use std::fmt::Write as _;
use std::io::Write as _;
use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// The format of the frames, beside the run.
pub(super) const FRAMES: &str = "frame.toml";
/// Words of 32 bits in a minor frame, the sync pattern counted as one: 819,200 bits a second, so that the words of a frame stand
/// within a millisecond.
const WORDS: u32 = 512;
/// Polling interval of a caller.
const LISTEN: Duration = Duration::from_millis(5);

/// The format of frames that carry these channels, as a file; rates first, for a row of the recording holds half a millisecond.
fn format_of(channels: &[Channel]) -> String {
    let bit_rate = RATE_HZ * f64::from(32 * WORDS);
    let mut text = format!(
        "name = \"test flight\"\nbit_rate = {bit_rate}\nwords = {WORDS}\nword_bits = 32\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n"
    );
    for (word, channel) in (1..).zip(channels) {
        let (name, unit) = (channel.name(ControlNames::Rotorcraft), channel.si_unit());
        let _ =
            write!(text, "[[parameter]]\nname = \"{name}\"\nunit = \"{unit}\"\nword = {word}\nencoding = \"ieee754_single\"\n");
    }
    text
}

impl SimulatedVehicle {
    /// Listens on the loopback; once somebody connects, it flies. The format of its frames goes into `folder`.
    pub(super) fn ready_by_pcm(samples: Vec<Sample>, speed: f64, folder: &Path) -> Result<Self, Failure> {
        let failed = |what: &dyn std::fmt::Display| Failure::Running(format!("the vehicle's PCM link: {what}"));
        let present = samples.iter().fold(u32::MAX, |present, sample| present & sample.present);
        let mut channels: Vec<Channel> =
            Channel::ALL.into_iter().filter(|channel| present & (1 << channel.index()) != 0).collect();
        channels.sort_by_key(|channel| !Channel::GYROS.contains(channel));
        let (text, file) = (format_of(&channels), folder.join(FRAMES));
        std::fs::write(&file, &text).map_err(|error| Failure::io(&file, &error))?;
        let format = PcmFormat::from_toml(&text).map_err(|wrong| failed(&wrong))?;
        let encoder = PcmEncoder::new(&format, 0.0).map_err(|wrong| failed(&wrong))?;
        let listener = TcpListener::bind("127.0.0.1:0").map_err(|error| failed(&error))?;
        let address = listener.local_addr().map_err(|error| failed(&error))?;
        listener.set_nonblocking(true).map_err(|error| failed(&error))?;
        let shared = Arc::new(VehicleState::default());
        let flying = Arc::clone(&shared);
        let fly = move || {
            send(&listener, encoder, &channels, &samples, speed, &flying);
            flying.landed.store(true, Ordering::Relaxed);
        };
        std::thread::Builder::new().name("sideslip-flight".to_owned()).spawn(fly).map_err(|error| failed(&error))?;
        let url = format!("pcm+tcp://{address}?format={}", file.display());
        Ok(SimulatedVehicle { url, shared })
    }
}

fn send(
    listener: &TcpListener,
    mut encoder: PcmEncoder,
    channels: &[Channel],
    samples: &[Sample],
    speed: f64,
    shared: &VehicleState,
) {
    let go_on = || !shared.land.load(Ordering::Relaxed);
    let mut stream = loop {
        match listener.accept() {
            Ok((stream, _)) => break stream,
            Err(_) if go_on() => std::thread::sleep(LISTEN),
            Err(_) => return,
        }
    };
    let mut player = Player::<MonotonicClock>::new(Pace::Factor(speed));
    let mut frame = Vec::new();
    for sample in samples {
        if !player.wait_for(sample.time_s, go_on) {
            return;
        }
        frame.clear();
        let value = |parameter: usize, _| channels.get(parameter).and_then(|channel| sample.get(*channel)).unwrap_or_default();
        if encoder.minor_frame(value, &mut frame).is_err() || stream.write_all(&frame).is_err() {
            return;
        }
        shared.note_flown(sample.time_s);
    }
    // The next pattern confirms the last frame; the connection stays open until the flight is over.
    frame.clear();
    let pattern_alone = encoder.minor_frame(|_, _| 0.0, &mut frame).is_ok();
    let _ = pattern_alone && frame.get(..8).is_some_and(|pattern| stream.write_all(pattern).is_ok());
    shared.landed.store(true, Ordering::Relaxed);
    while go_on() {
        std::thread::sleep(LISTEN);
    }
}
