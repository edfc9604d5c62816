//! The test flights: aircraft whose derivatives are known, flown with instruments of flight-test quality, and their radio.

use ::replay::{MonotonicClock, Pace, Player};
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::control::Control;
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::LinearModel;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::io::telemetry::mavlink::link::{Link, LinkEvent, Url};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::simulation::fly::{Inputs, simulate};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

pub(super) struct DemoTestPoint {
    pub(super) name: &'static str,
    model: &'static str,
}

/// 100 kn at 1.024 kg/m^3, as in section 4 of Padfield et al. 1987.
pub(super) const TEST_POINTS: [DemoTestPoint; 3] = [
    DemoTestPoint { name: "descent", model: include_str!("../../../replay/models/puma-flight-descent.toml") },
    DemoTestPoint { name: "level", model: include_str!("../../../replay/models/puma-flight-level.toml") },
    DemoTestPoint { name: "climb", model: include_str!("../../../replay/models/puma-flight-climb.toml") },
];
/// Air density, kg/m^3.
pub(super) const DENSITY: &str = "1.024";

/// A run: what the pilot does (control, shape, amplitude rad, clock s, start s), and for how long.
pub(super) struct RunPlan {
    pub(super) name: &'static str,
    inputs: [&'static str; 2],
    pub(super) duration_s: f64,
}

/// The one that is fitted, and the hold-out run.
pub(super) const RUNS: [RunPlan; 2] = [
    RunPlan { name: "fit", inputs: ["pedal:3211:0.012:0.7:2", "lat_cyclic:3211:0.009:0.5:8"], duration_s: 16.0 },
    RunPlan { name: "kept", inputs: ["pedal:doublet:-0.012:0.8:2", "lat_cyclic:doublet:-0.006:0.6:8"], duration_s: 14.0 },
];
pub(super) const RATE_HZ: f64 = 50.0;
/// Polling interval of a caller.
const LISTEN: Duration = Duration::from_millis(5);

/// A flight and what is true of it.
pub(super) struct TestFlight {
    pub(super) truth: LinearModel,
    pub(super) samples: Vec<Sample>,
}

impl TestFlight {
    /// Flies a run at a test point with that seed of the instruments' noise.
    pub(super) fn fly(point: &DemoTestPoint, run: &RunPlan, seed: u64) -> Result<Self, Failure> {
        let failed = |what: &dyn std::fmt::Display| Failure::Running(format!("the test flight: {what}"));
        let truth = ModelFile::parse(point.model).map_err(|misread| failed(&misread.what))?.linear;
        let mut inputs = Inputs::at_trim(&truth);
        for text in run.inputs {
            let spec = InputSpec::parse(text).map_err(|wrong| failed(&wrong))?;
            for (control, history) in Control::ALL.into_iter().zip(&mut inputs.controls) {
                if control.channel() == spec.channel {
                    *history = history.plus(1.0, &spec.deviation(0.0));
                }
            }
        }
        let instruments = InstrumentSet::flight_quality(1.0);
        let flown = simulate(&truth, &inputs, &instruments, run.duration_s, RATE_HZ, seed).map_err(|refused| failed(&refused))?;
        Ok(TestFlight { truth, samples: flown.samples })
    }
}

impl RunPlan {
    /// What the pilot does, in words.
    pub(super) fn inputs(&self) -> String {
        let named = self.inputs.map(|text| text.split(':').take(2).collect::<Vec<_>>().join(" "));
        named.join(", ")
    }
}

/// The flying vehicle's end of the link.
pub(super) struct SimulatedVehicle {
    pub(super) url: String,
    pub(super) shared: Arc<VehicleState>,
}

#[derive(Default)]
pub(super) struct VehicleState {
    pub(super) land: AtomicBool,
    /// Everything was sent, or it was told to end.
    pub(super) landed: AtomicBool,
    /// Time of the last sample that was sent, us.
    flown_us: AtomicU64,
}

impl VehicleState {
    /// A sample of that time was sent.
    pub(super) fn note_flown(&self, time_s: f64) {
        let flown = Duration::try_from_secs_f64(time_s).unwrap_or_default();
        self.flown_us.store(u64::try_from(flown.as_micros()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
}

impl SimulatedVehicle {
    /// Listens on the loopback; once somebody calls, it flies.
    pub(super) fn ready(samples: Vec<Sample>, speed: f64) -> Result<Self, Failure> {
        let failed = |what: &dyn std::fmt::Display| Failure::Running(format!("the vehicle's link: {what}"));
        let link = Link::open(Url::UdpIn("127.0.0.1:0".into()), LISTEN).map_err(|wrong| failed(&wrong))?;
        let address = link.local_address().ok_or_else(|| failed(&"it has no address"))?;
        let shared = Arc::new(VehicleState::default());
        let flying = Arc::clone(&shared);
        let fly = move || {
            send(link, &samples, speed, &flying);
            flying.landed.store(true, Ordering::Relaxed);
        };
        std::thread::Builder::new().name("sideslip-flight".to_owned()).spawn(fly).map_err(|error| failed(&error))?;
        Ok(SimulatedVehicle { url: format!("udpout://{address}"), shared })
    }

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

    pub(super) fn land(&self) {
        self.shared.land.store(true, Ordering::Relaxed);
    }
}

fn send(mut link: Link, samples: &[Sample], speed: f64, shared: &VehicleState) {
    let go_on = || !shared.land.load(Ordering::Relaxed);
    let mut heartbeat = [0; 512];
    while go_on() && !matches!(link.receive(&mut heartbeat), Ok(LinkEvent::Bytes(_))) {}
    let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::Rotorcraft);
    let mut datagram = Vec::with_capacity(1024);
    let mut player = Player::<MonotonicClock>::new(Pace::Factor(speed));
    for sample in samples {
        if !player.wait_for(sample.time_s, go_on) {
            return;
        }
        // The messages of a sample are one datagram: a pause of this process does not come between them. As on a radio, nobody
        // learns here of what does not arrive; a value that does not fit ends the flight.
        datagram.clear();
        if encoder.sample(sample, |frame| datagram.extend_from_slice(frame)).is_err() {
            return;
        }
        drop(link.send(&datagram));
        shared.note_flown(sample.time_s);
    }
}
