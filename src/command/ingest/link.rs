//! A link that brings MAVLink onto the bus, until it is stopped; one that breaks is opened again.
//!
//! Samples wait at first until a heartbeat has said what kind of aircraft it is, for that names the controls. Each boot of
//! the vehicle is a run of its own.

use super::super::mapping_input::read_mapping;
use super::super::{message, root_path};
use super::feed::Feed;
use super::{Args, override_keys};
use sideslip::bus::clock::monotonic_ns;
use sideslip::bus::root::Role;
use sideslip::bus::run_head::{newest_head, playing_since, write_head};
use sideslip::bus::service::Bus;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::log_head::LogHead;
use sideslip::flight::run_file::RunInfo;
use sideslip::telemetry::mavlink::link::{Link, LinkError, Received, Url};
use sideslip::telemetry::mavlink::live::Live;
use sideslip::telemetry::mavlink::recording::passed_over;
use sideslip::telemetry::mavlink::senders::{Sender, SenderTally};
use sideslip::telemetry::mavlink::stream::Timed;
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The longest wait for bytes; after that, samples wait no longer for late messages.
const PATIENCE: Duration = Duration::from_millis(100);
/// Between our heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);
/// The longest wait for the vehicle's heartbeat; they come once a second.
const INTRODUCTION: Duration = Duration::from_millis(1500);
/// Silence that is worth a word.
const SILENCE: Duration = Duration::from_secs(3);
/// Between attempts to open a link again.
const REOPEN: Duration = Duration::from_secs(1);

/// Listens until it is stopped.
pub(super) fn listen(args: &Args, url: &Url, stop: &AtomicBool) -> Result<Outcome, Failure> {
    let config = read_mapping(args.config.as_deref())?;
    override_keys(&mut RunInfo::default(), &args.set)?;
    let bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take(Role::Telemetry)?;
    let link = open(args, url)?;
    let now = Instant::now();
    let mut station = Station {
        args,
        bus: &bus,
        feed: Feed::new(&bus, false)?,
        names: config.names.or(names_before(args, &bus)?),
        live: Live::on(link, config, PATIENCE),
        run: None,
        newest_s: 0.0,
        heard: now,
        silent: true,
        vehicle_since: None,
        samples: 0,
    };
    message(format_args!("sideslip: listening at {url}"));
    let worked = station.work(stop);
    station.end_run(stop)?;
    worked?;
    Ok(station.answer())
}

fn open(args: &Args, url: &Url) -> Result<Link, Failure> {
    let opened = if args.held {
        let held = std::io::stdout().as_fd().try_clone_to_owned();
        held.map_err(|source| LinkError::Io { url: url.to_string(), source })
            .and_then(|held| Link::on_held(url.clone(), held, PATIENCE))
    } else {
        Link::open(url.clone(), PATIENCE)
    };
    opened.map_err(|wrong| Failure::Running(wrong.to_string()))
}

/// How the controls were called by the telemetry whose place this one takes.
fn names_before(args: &Args, bus: &Bus) -> Result<Option<ControlNames>, Failure> {
    let now_ns = monotonic_ns();
    if !args.resume || playing_since(bus.root(), now_ns)? == now_ns {
        return Ok(None);
    }
    Ok(newest_head(bus.root())?.map(|head| head.controls))
}

struct Station<'a> {
    args: &'a Args,
    bus: &'a Bus,
    feed: Feed,
    live: Live,
    /// How the controls are called, once that is known.
    names: Option<ControlNames>,
    /// The boot whose samples are being published.
    run: Option<u32>,
    newest_s: f64,
    heard: Instant,
    silent: bool,
    vehicle_since: Option<Instant>,
    samples: u64,
}

impl Station<'_> {
    fn work(&mut self, stop: &AtomicBool) -> Result<(), Failure> {
        let mut beat = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            if Instant::now() >= beat {
                beat = Instant::now() + HEARTBEAT;
                // One that cannot be sent shows in the next read.
                let _ = self.live.heartbeat();
            }
            match self.live.poll(|| Some(monotonic_ns() / 1000)) {
                Ok(Received::Bytes(_)) => self.heard = Instant::now(),
                Ok(Received::Silence) => self.notice_silence(),
                Ok(Received::Closed) => self.reopen("the other end has closed it", stop),
                Err(error) => self.reopen(&error.to_string(), stop),
            }
            if self.is_introduced() {
                while let Some(timed) = self.live.next_sample() {
                    self.sample(&timed, stop)?;
                }
            }
        }
        Ok(())
    }

    fn notice_silence(&mut self) {
        if !self.silent && self.heard.elapsed() >= SILENCE {
            self.silent = true;
            message(format_args!("sideslip: nothing has come from {} for {} s", self.live.link().url(), SILENCE.as_secs()));
        }
    }

    fn reopen(&mut self, why: &str, stop: &AtomicBool) {
        message(format_args!("sideslip: {}: {why}; it is opened again", self.live.link().url()));
        let mut due = Instant::now() + REOPEN;
        let mut said = String::new();
        while !stop.load(Ordering::Relaxed) {
            if Instant::now() < due {
                std::thread::sleep(Duration::from_millis(10));
                continue;
            }
            let Err(wrong) = self.live.reopen() else {
                message(format_args!("sideslip: {} is open again", self.live.link().url()));
                return;
            };
            // The same refusal is said once.
            let wrong = wrong.to_string();
            if wrong != said {
                message(format_args!("sideslip: {wrong}"));
                said = wrong;
            }
            due = Instant::now() + REOPEN;
        }
    }

    /// The vehicle and what it sent.
    fn vehicle(&self) -> Option<(Sender, &SenderTally)> {
        let vehicle = self.live.stream().vehicle()?;
        Some((vehicle, self.live.senders().of(vehicle)?))
    }

    /// Whether it is known how the controls are called.
    fn is_introduced(&mut self) -> bool {
        if self.names.is_some() {
            return true;
        }
        let Some((_, tally)) = self.vehicle() else { return false };
        let (introduced, fixed_wing) = (tally.has_introduced_itself(), tally.fixed_wing);
        let since = *self.vehicle_since.get_or_insert_with(Instant::now);
        if introduced || since.elapsed() >= INTRODUCTION {
            self.names = Some(if fixed_wing { ControlNames::FixedWing } else { ControlNames::Rotorcraft });
            if !introduced {
                message(format_args!("sideslip: no heartbeat says what it is: its controls are called as a rotorcraft's"));
            }
        }
        self.names.is_some()
    }

    fn sample(&mut self, timed: &Timed, stop: &AtomicBool) -> Result<(), Failure> {
        if self.run != Some(timed.boot) {
            self.begin_run(timed.boot, stop)?;
        }
        if self.silent {
            self.silent = false;
            message(format_args!("sideslip: telemetry comes from {}", self.live.link().url()));
        }
        self.newest_s = timed.sample.time_s;
        self.samples += 1;
        self.feed.sample(&timed.sample, &[], stop)?;
        Ok(())
    }

    fn begin_run(&mut self, boot: u32, stop: &AtomicBool) -> Result<(), Failure> {
        if self.run.is_some() {
            message(format_args!("sideslip: the vehicle has started again: a new run"));
        }
        self.end_run(stop)?;
        let vehicle = self.live.stream().vehicle().map(|vehicle| vehicle.to_string()).unwrap_or_default();
        let wrong = |what: String| Failure::Running(format!("the head of the run: {what}"));
        let text = format!("source = \"MAVLink, sender {vehicle}\"\n");
        let mut info = RunInfo::from_toml(&text).map_err(|place| wrong(place.to_string()))?;
        let names = self.names.unwrap_or(ControlNames::Rotorcraft);
        info.set_controls(names);
        override_keys(&mut info, &self.args.set)?;
        write_head(self.bus.root(), self.bus.incarnation(), &LogHead::every_channel(info.to_toml(), names))?;
        self.run = Some(boot);
        message(format_args!("sideslip: vehicle {vehicle}"));
        Ok(())
    }

    fn end_run(&mut self, stop: &AtomicBool) -> Result<(), Failure> {
        if self.run.take().is_some() {
            self.feed.end(self.newest_s, stop)?;
        }
        Ok(())
    }

    /// What came and what did not.
    fn answer(&self) -> Outcome {
        let messages = self.live.tally().good;
        message(format_args!("sideslip: {messages} messages of {} senders, {} samples", self.senders(), self.samples));
        let mut losses: Vec<String> = passed_over(self.live.tally(), self.live.unused()).into_iter().collect();
        if let Some((vehicle, tally)) = self.vehicle().filter(|(_, tally)| tally.missing > 0) {
            let (missing, all) = (tally.missing, tally.missing + tally.total());
            losses.push(format!("{missing} of {all} messages of {vehicle} never came, by their numbers"));
        }
        for loss in &losses {
            message(format_args!("sideslip: {loss}"));
        }
        if losses.is_empty() { Outcome::Done } else { Outcome::DataLost }
    }

    fn senders(&self) -> usize {
        self.live.senders().iter().count()
    }
}
