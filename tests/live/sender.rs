//! A vehicle on the loopback: sends a recording as MAVLink at its own pace to whoever calls it.

use crate::support::patience::until;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::io::telemetry::mavlink::link::{Link, LinkEvent, Url};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The samples of a recording.
pub(crate) fn samples(path: &Path) -> Vec<Sample> {
    let mut recording = Recording::open(path).unwrap();
    let mut samples = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        samples.push(row.sample);
    }
    samples
}

/// A vehicle that is flying.
pub(crate) struct Vehicle {
    url: String,
    landed: Arc<AtomicBool>,
    flying: Option<JoinHandle<usize>>,
}

impl Vehicle {
    /// It waits until it is called, then sends; with `speed` times its own pace.
    pub(crate) fn start(flight: Vec<Sample>, speed: f64) -> Self {
        let mut link = Link::open(Url::UdpIn("127.0.0.1:0".into()), Duration::from_millis(5)).unwrap();
        let url = format!("udpout://{}", link.local_address().unwrap());
        let landed = Arc::new(AtomicBool::new(false));
        let land = Arc::clone(&landed);
        let flying = std::thread::spawn(move || {
            let mut buffer = [0; 512];
            let called = |link: &mut Link, buffer: &mut [u8]| matches!(link.receive(buffer), Ok(LinkEvent::Bytes(_)));
            while !called(&mut link, &mut buffer) && !land.load(Ordering::Relaxed) {}
            let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::Rotorcraft);
            let begun = Instant::now();
            let (mut sent, mut flown_s, mut last_s) = (0, 0.0, f64::INFINITY);
            for sample in &flight {
                // A boot, where time goes back, takes no time.
                flown_s += (sample.time_s - last_s).max(0.0);
                last_s = sample.time_s;
                std::thread::sleep(Duration::from_secs_f64(flown_s / speed).saturating_sub(begun.elapsed()));
                if land.load(Ordering::Relaxed) {
                    break;
                }
                encoder.sample(sample, |frame| drop(link.send(frame))).unwrap();
                sent += 1;
            }
            sent
        });
        Vehicle { url, landed, flying: Some(flying) }
    }

    /// Where it can be called.
    pub(crate) fn url(&self) -> &str {
        &self.url
    }

    /// Waits until it has sent everything.
    pub(crate) fn flown(&mut self) -> usize {
        until("the end of the flight", || self.flying.as_ref().is_some_and(JoinHandle::is_finished));
        self.flying.take().unwrap().join().unwrap()
    }
}

impl Drop for Vehicle {
    fn drop(&mut self) {
        self.landed.store(true, Ordering::Relaxed);
        if let Some(flying) = self.flying.take() {
            let _ = flying.join();
        }
    }
}
