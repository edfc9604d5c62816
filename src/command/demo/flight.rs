//! The test flight: a model whose derivatives are known, flown with instruments of flight-test quality, and its radio.

use ::replay::{MonotonicClock, Pace, Player};
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::control::Control;
use sideslip::flight::model::LinearModel;
use sideslip::flight::model_file::ModelFile;
use sideslip::simulation::fly::{Inputs, simulate};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::Instruments;
use sideslip::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::telemetry::mavlink::link::{Link, Received, Url};
use sideslip::telemetry::mavlink::mapping::Config;
use sideslip::telemetry::record::Sample;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// The aircraft.
const MODEL: &str = include_str!("../../../replay/models/puma-like.toml");
/// Control, shape, amplitude rad, clock s, start s.
const INPUTS: [&str; 4] =
    ["pedal:3211:0.02:0.7:2", "lat_cyclic:3211:0.008:0.5:12", "lon_cyclic:3211:0.01:0.5:20", "collective:doublet:0.01:0.8:28"];
const DURATION_S: f64 = 36.0;
/// Samples a second.
pub(super) const RATE_HZ: f64 = 50.0;
/// Between looks for somebody who calls.
const LISTEN: Duration = Duration::from_millis(5);

/// A flight and what is true of it.
pub(super) struct TestFlight {
    pub(super) truth: LinearModel,
    pub(super) samples: Vec<Sample>,
}

impl TestFlight {
    /// Flies it with that seed of the instruments' noise.
    pub(super) fn fly(seed: u64) -> Result<Self, Failure> {
        let failed = |what: &dyn std::fmt::Display| Failure::Running(format!("the test flight: {what}"));
        let truth = ModelFile::parse(MODEL).map_err(|misread| failed(&misread.what))?.linear;
        let mut inputs = Inputs::at_trim(&truth);
        for text in INPUTS {
            let spec = InputSpec::parse(text).map_err(|wrong| failed(&wrong))?;
            for (control, history) in Control::ALL.into_iter().zip(&mut inputs.controls) {
                if control.channel() == spec.channel {
                    *history = history.plus(1.0, &spec.deviation(0.0));
                }
            }
        }
        let instruments = Instruments::flight_quality(1.0);
        let flown = simulate(&truth, &inputs, &instruments, DURATION_S, RATE_HZ, seed).map_err(|refused| failed(&refused))?;
        Ok(TestFlight { truth, samples: flown.samples })
    }

    /// What the pilot does, in words.
    pub(super) fn inputs(&self) -> String {
        let named = INPUTS.map(|text| text.split(':').take(2).collect::<Vec<_>>().join(" "));
        named.join(", ")
    }

    /// s.
    pub(super) fn duration_s(&self) -> f64 {
        DURATION_S
    }
}

/// The flying vehicle's end of the link.
pub(super) struct Vehicle {
    url: String,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    /// Told to end.
    land: AtomicBool,
    /// Everything was sent, or it was told to end.
    landed: AtomicBool,
    /// Time of the last sample that was sent, us.
    flown_us: AtomicU64,
}

impl Vehicle {
    /// Listens on the loopback; once somebody calls, it flies.
    pub(super) fn ready(samples: Vec<Sample>, speed: f64) -> Result<Self, Failure> {
        let failed = |what: &dyn std::fmt::Display| Failure::Running(format!("the vehicle's link: {what}"));
        let link = Link::open(Url::UdpIn("127.0.0.1:0".into()), LISTEN).map_err(|wrong| failed(&wrong))?;
        let address = link.local_address().ok_or_else(|| failed(&"it has no address"))?;
        let shared = Arc::new(Shared::default());
        let flying = Arc::clone(&shared);
        let fly = move || {
            send(link, &samples, speed, &flying);
            flying.landed.store(true, Ordering::Relaxed);
        };
        std::thread::Builder::new().name("sideslip-vehicle".to_owned()).spawn(fly).map_err(|error| failed(&error))?;
        Ok(Vehicle { url: format!("udpout://{address}"), shared })
    }

    /// Where it can be called.
    pub(super) fn url(&self) -> String {
        self.url.clone()
    }

    /// How far it has flown, s.
    pub(super) fn flown_s(&self) -> f64 {
        Duration::from_micros(self.shared.flown_us.load(Ordering::Relaxed)).as_secs_f64()
    }

    /// Whether the flight is over.
    pub(super) fn has_landed(&self) -> bool {
        self.shared.landed.load(Ordering::Relaxed)
    }

    /// Ends the flight.
    pub(super) fn land(&self) {
        self.shared.land.store(true, Ordering::Relaxed);
    }
}

fn send(mut link: Link, samples: &[Sample], speed: f64, shared: &Shared) {
    let go_on = || !shared.land.load(Ordering::Relaxed);
    let mut heartbeat = [0; 512];
    while go_on() && !matches!(link.receive(&mut heartbeat), Ok(Received::Bytes(_))) {}
    let mut encoder = Encoder::new(ME, Config::default(), ControlNames::Rotorcraft);
    let mut player = Player::<MonotonicClock>::new(Pace::Factor(speed));
    for sample in samples {
        if !player.wait_for(sample.time_s, go_on) {
            return;
        }
        // As on a radio, nobody learns here of a frame that does not arrive; a value that does not fit ends the flight.
        if encoder.sample(sample, |frame| drop(link.send(frame))).is_err() {
            return;
        }
        let flown = Duration::try_from_secs_f64(sample.time_s).unwrap_or_default();
        shared.flown_us.store(u64::try_from(flown.as_micros()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
}
