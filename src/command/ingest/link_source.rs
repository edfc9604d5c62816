//! A link that brings MAVLink onto the bus, until it is stopped; one that breaks is opened again.
//!
//! Samples wait at first until a heartbeat has said what kind of aircraft it is, for that names the controls. Each boot of
//! the vehicle is a run of its own. A sample is as old as the vehicle's clock says, however late it was read.

use super::args::IngestArgs;
use super::notice_words::notice_words;
use super::sample_publisher::SamplePublisher;
use super::silence_monitor::{SilenceMonitor, no_motion};
use super::vehicle_file::VehicleFile;
use crate::command::options::mapping_input::read_mapping;
use crate::command::options::signing_input::{SOURCE_LINK, link_signing};
use crate::command::recordings::run_head::override_keys;
use crate::command::{message, patience, root_path};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::{newest_head, playing_since, write_head};
use sideslip::io::bus::service::Bus;
use sideslip::io::telemetry::chapter10::channel_choice::FrameDescription;
use sideslip::io::telemetry::mavlink::link::{Link, LinkError, LinkEvent, Url};
use sideslip::io::telemetry::mavlink::live::{LiveNotice, LiveTelemetry};
use sideslip::io::telemetry::mavlink::recording::passed_over;
use sideslip::io::telemetry::mavlink::senders::{Sender, SenderTally};
use sideslip::io::telemetry::mavlink::stream::{TimedSample, UnusedMessages};
use sideslip::io::telemetry::recording_config::RecordingConfig;
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The longest wait for bytes; after that, samples wait no longer for late messages. At 10 Hz every sample waits for so
/// long, and its estimate must hold until the next.
pub(super) const PATIENCE: Duration = Duration::from_millis(50);
/// Samples of a new boot come all at once, once it is sure that it is one; after so many the log needs time.
const BURST: u32 = 20;
const BREATH: Duration = Duration::from_millis(20);
const HEARTBEAT: Duration = Duration::from_secs(1);
/// The longest wait for the vehicle's heartbeat; they come once a second.
const INTRODUCTION: Duration = Duration::from_millis(1500);
/// So much of a run shows which channels come.
const ACQUAINTANCE: Duration = Duration::from_secs(1);
/// Silence that is worth a word.
const SILENCE: Duration = Duration::from_secs(3);
/// Between attempts to open a link again.
const REOPEN: Duration = Duration::from_secs(1);

/// Listens until it is stopped.
pub(super) fn listen(args: &IngestArgs, url: &Url, stop: &AtomicBool) -> Result<Outcome, Failure> {
    let RecordingConfig { mavlink: config, chapter10, .. } = read_mapping(args.config.as_deref(), &args.map)?;
    if chapter10 != FrameDescription::default() {
        return Err(Failure::Input("--config: expected messages of MAVLink, found what is for IRIG 106 Chapter 10".into()));
    }
    override_keys(&mut RunInfo::default(), &args.set)?;
    let mut bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take_within(BusRole::Telemetry, patience(args.supervised))?;
    let signing = args.signing_key.as_deref().map(|key| link_signing(key, SOURCE_LINK)).transpose()?;
    let Some(link) = open(args, url, stop)? else {
        message(format_args!("sideslip: {url}: stopped before it was open"));
        return Ok(Outcome::Done);
    };
    let names = config.names;
    let mut live = LiveTelemetry::on(link, config, PATIENCE);
    if let Some(signing) = signing {
        live.set_signing(signing);
    }
    let names_before = names_before(args, &bus)?;
    if names_before.is_some()
        && let Some((vehicle, clock)) = VehicleFile::read(bus.root())
    {
        live.resume(vehicle, &clock);
    }
    let mut station = LinkIngest {
        args,
        bus: &bus,
        publisher: SamplePublisher::new(&bus, false)?,
        names: names.or(names_before),
        live,
        file: VehicleFile::default(),
        run: None,
        changed: false,
        newest_s: 0.0,
        channels: None,
        silence: SilenceMonitor::new(),
        heard_before: 0,
        silent: true,
        wordless: false,
        vehicle_since: None,
        stood_at_s: None,
        steps_back: (0, 0.0),
        runs_fast: None,
        samples: 0,
    };
    message(format_args!("sideslip: listening at {url}"));
    let worked = station.work(stop);
    station.end_run(stop)?;
    worked?;
    let aligned = station.publisher.take_aligned();
    Ok(station.answer(aligned))
}

/// Opens the link; a connection or a line that cannot be opened yet is tried again until that succeeds. `None` where it
/// was stopped before.
pub(super) fn open(args: &IngestArgs, url: &Url, stop: &AtomicBool) -> Result<Option<Link>, Failure> {
    let opened = match url {
        Url::UdpIn(_) | Url::UdpOut(_) if args.held => {
            let held = std::io::stdout().as_fd().try_clone_to_owned();
            held.map_err(|source| LinkError::Io { url: url.to_string(), source })
                .and_then(|held| Link::on_held(url.clone(), held, PATIENCE))
        }
        Url::UdpIn(_) | Url::UdpOut(_) => Link::open(url.clone(), PATIENCE),
        Url::Tcp(_) | Url::Serial { .. } => {
            return Ok(until_open(Instant::now(), stop, || Link::open(url.clone(), PATIENCE)));
        }
    };
    opened.map(Some).map_err(|wrong| Failure::Running(wrong.to_string()))
}

/// Tries to open a link from `due` on, and again; the same refusal is said once. `None` where it was stopped before.
pub(super) fn until_open<T>(mut due: Instant, stop: &AtomicBool, mut open: impl FnMut() -> Result<T, LinkError>) -> Option<T> {
    let mut said = String::new();
    while !stop.load(Ordering::Relaxed) {
        if Instant::now() < due {
            std::thread::sleep(Duration::from_millis(10));
            continue;
        }
        match open() {
            Ok(opened) => return Some(opened),
            Err(wrong) => {
                let wrong = wrong.to_string();
                if wrong != said {
                    message(format_args!("sideslip: {wrong}; it is tried again"));
                    said = wrong;
                }
            }
        }
        due = Instant::now() + REOPEN;
    }
    None
}

/// How the controls were called by the telemetry whose place this one takes.
fn names_before(args: &IngestArgs, bus: &Bus) -> Result<Option<ControlNames>, Failure> {
    let now_ns = monotonic_ns();
    if !args.resume || playing_since(bus.root(), now_ns)? == now_ns {
        return Ok(None);
    }
    Ok(newest_head(bus.root())?.map(|head| head.controls))
}

struct LinkIngest<'a> {
    args: &'a IngestArgs,
    bus: &'a Bus,
    publisher: SamplePublisher,
    live: LiveTelemetry,
    file: VehicleFile,
    /// How the controls are called, once that is known.
    names: Option<ControlNames>,
    /// The boot whose samples are being published.
    run: Option<u32>,
    /// Whether the next run is of another vehicle than the last.
    changed: bool,
    newest_s: f64,
    /// Since when the run goes on, and which channels came, until that has been said.
    channels: Option<(Instant, u32)>,
    /// Without samples.
    silence: SilenceMonitor,
    /// Messages when the last sample came.
    heard_before: u64,
    silent: bool,
    /// Whether it was said that messages come but no motion.
    wordless: bool,
    vehicle_since: Option<Instant>,
    /// Where the vehicle's clock stood still, s.
    stood_at_s: Option<f64>,
    /// How often it was set back, and by how much in all, s.
    steps_back: (u64, f64),
    /// How many times as fast as this machine's it runs, where that is too fast.
    runs_fast: Option<f64>,
    samples: u64,
}

impl LinkIngest<'_> {
    fn work(&mut self, stop: &AtomicBool) -> Result<(), Failure> {
        let mut beat = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            if Instant::now() >= beat {
                beat = Instant::now() + HEARTBEAT;
                // One that cannot be sent shows in the next read.
                let _ = self.live.heartbeat();
                if let Some(fault) = self.live.take_signing_fault() {
                    message(format_args!("sideslip: {fault}; nothing is sent that cannot be signed"));
                }
                if let Some(lead_s) = self.live.take_signing_lead_s() {
                    message(format_args!(
                        "sideslip: timestamps of this signing key are {lead_s:.0} s ahead of this clock, by a signed frame or by \
                         the record beside the key: streams by the clock are refused as more than a minute behind; set the \
                         clocks and make a new key"
                    ));
                }
            }
            match self.live.poll(|| Some(monotonic_ns() / 1000)) {
                Ok(LinkEvent::Bytes(_) | LinkEvent::Silence) => {}
                Ok(LinkEvent::Closed) => self.reopen("the other end has closed it", stop),
                Err(error) => self.reopen(&error.to_string(), stop),
            }
            self.pass_on_notices();
            if self.is_introduced() {
                let mut at_once = 0;
                while let Some(timed) = self.live.next_sample() {
                    self.sample(&timed, stop)?;
                    at_once += 1;
                    if at_once % BURST == 0 {
                        std::thread::sleep(BREATH);
                    }
                }
            }
            self.notice_silence();
            if self.channels.is_some_and(|(since, _)| since.elapsed() >= ACQUAINTANCE) {
                self.say_who_it_is();
            }
        }
        Ok(())
    }

    fn pass_on_notices(&mut self) {
        while let Some(notice) = self.live.next_notice() {
            message(format_args!("sideslip: {}", notice_words(&notice)));
            match notice {
                LiveNotice::Changed { .. } => {
                    self.changed = true;
                    self.names = self.live.config().names;
                    self.vehicle_since = None;
                }
                LiveNotice::StandsStill(at_s) => self.stood_at_s = Some(at_s),
                LiveNotice::SteppedBack { by_s, .. } => {
                    self.steps_back.0 += 1;
                    self.steps_back.1 += by_s;
                }
                LiveNotice::RunsFast(rate) => self.runs_fast = Some(rate),
                _ => {}
            }
        }
    }

    fn notice_silence(&mut self) {
        let lasted = self.silence.elapsed();
        let others = self.live.accepted() - self.heard_before;
        if self.samples == 0 && others == 0 {
            // Nobody has begun to talk.
            self.silence.reset();
        }
        if lasted < SILENCE {
            return;
        }
        let (url, seconds) = (self.live.link().url(), SILENCE.as_secs());
        if !self.silent {
            self.silent = true;
            match self.vehicle().filter(|_| others > 0) {
                None if self.live.refused().total() > 0 => {
                    message(format_args!("sideslip: nothing that is rightly signed has come from {url} for {seconds} s"));
                }
                None => message(format_args!("sideslip: nothing has come from {url} for {seconds} s")),
                Some((vehicle, _)) => message(format_args!(
                    "sideslip: no sample of {vehicle} has come from {url} for {seconds} s, but {others} other messages"
                )),
            }
        } else if self.samples == 0 && others > 0 && !self.wordless && self.vehicle().is_none() {
            self.wordless = true;
            message(format_args!("sideslip: {}", no_motion(&self.live)));
        }
    }

    fn reopen(&mut self, why: &str, stop: &AtomicBool) {
        let url = self.live.link().url().to_string();
        message(format_args!("sideslip: {url}: {why}; it is opened again"));
        if until_open(Instant::now() + REOPEN, stop, || self.live.reopen()).is_some() {
            message(format_args!("sideslip: {url} is open again"));
        }
        self.silence.elapsed();
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
        if self.live.stream().vehicle().is_none() {
            return false;
        }
        let tally = self.vehicle().map(|(_, tally)| tally);
        let introduced = tally.is_some_and(SenderTally::has_introduced_itself);
        let fixed_wing = tally.is_some_and(|tally| tally.fixed_wing);
        let since = *self.vehicle_since.get_or_insert_with(Instant::now);
        if introduced || since.elapsed() >= INTRODUCTION {
            self.names = Some(if fixed_wing { ControlNames::FixedWing } else { ControlNames::Rotorcraft });
            if !introduced {
                message(format_args!("sideslip: no heartbeat says what it is: its controls are called as a rotorcraft's"));
            }
        }
        self.names.is_some()
    }

    fn sample(&mut self, timed: &TimedSample, stop: &AtomicBool) -> Result<(), Failure> {
        if self.run != Some(timed.boot) {
            self.begin_run(timed.boot, stop)?;
        }
        if self.silent {
            self.silent = false;
            message(format_args!("sideslip: telemetry comes from {}", self.live.link().url()));
        }
        self.newest_s = timed.sample.time_s;
        self.samples += 1;
        if let Some((_, channels)) = &mut self.channels {
            *channels |= timed.sample.present;
        }
        self.silence.reset();
        self.heard_before = self.live.accepted();
        let sampled_ns = timed.sent_us.and_then(|us| u64::try_from(us).ok()?.checked_mul(1000));
        self.publisher.sample(&timed.sample, &[], sampled_ns.map(|sampled_ns| sampled_ns.min(monotonic_ns())), stop)?;
        if let Some((vehicle, clock)) = self.live.remembered() {
            self.file.write(self.bus.root(), vehicle, &clock);
        }
        Ok(())
    }

    /// Says what kind of aircraft it is and which channels come, once a run.
    fn say_who_it_is(&mut self) {
        let Some((_, channels)) = self.channels.take() else { return };
        let Some((vehicle, tally)) = self.vehicle() else { return };
        let names = self.names.unwrap_or(ControlNames::Rotorcraft);
        let came = Channel::ALL.into_iter().filter(|channel| channels & (1 << channel.index()) != 0);
        let came: Vec<&str> = came.map(|channel| channel.name(names)).collect();
        let aircraft = tally.aircraft().unwrap_or_else(|| "of a kind that no heartbeat names".to_owned());
        message(format_args!("sideslip: vehicle {vehicle}, {aircraft}: {}", came.join(" ")));
    }

    fn begin_run(&mut self, boot: u32, stop: &AtomicBool) -> Result<(), Failure> {
        if self.run.is_some() && !self.changed {
            message(format_args!("sideslip: the vehicle has started again: a new run"));
        }
        self.changed = false;
        self.end_run(stop)?;
        let source = self.live.stream().vehicle().map(Sender::as_source).unwrap_or_default();
        let wrong = |what: String| Failure::Running(format!("the head of the run: {what}"));
        let text = format!("source = \"{source}\"\n");
        let mut info = RunInfo::from_toml(&text).map_err(|place| wrong(place.to_string()))?;
        let names = self.names.unwrap_or(ControlNames::Rotorcraft);
        info.set_controls(names);
        info.set_assumed_scale(self.live.config().assumed_scale());
        override_keys(&mut info, &self.args.set)?;
        self.publisher.begin_run(&mut info, 0)?;
        write_head(self.bus.root(), self.bus.incarnation(), &LogHead::every_channel(info.to_toml(), names))?;
        self.run = Some(boot);
        self.channels = Some((Instant::now(), 0));
        self.file.is_due();
        Ok(())
    }

    fn end_run(&mut self, stop: &AtomicBool) -> Result<(), Failure> {
        if self.run.take().is_some() {
            self.say_who_it_is();
            self.publisher.end(self.newest_s, stop)?;
        }
        Ok(())
    }

    /// What came and what did not.
    fn answer(&self, (unplaced, noted): (Vec<String>, Vec<String>)) -> Outcome {
        let messages = self.live.accepted();
        message(format_args!("sideslip: {messages} messages of {} senders, {} samples", self.senders(), self.samples));
        noted.iter().for_each(|what| message(format_args!("sideslip: {what}")));
        let unused = self.live.unused();
        if unused.no_clock > 0 {
            message(format_args!(
                "sideslip: {} messages at the start came before the vehicle's clock was known",
                unused.no_clock
            ));
        }
        let mut losses: Vec<String> =
            passed_over(self.live.tally(), UnusedMessages { no_clock: 0, ..unused }).into_iter().collect();
        losses.extend(unplaced);
        for (refusal, count) in self.live.refused().iter() {
            let sentence = format!("refused: {count} messages {}", refusal.words());
            match refusal.is_loss() {
                true => losses.push(sentence),
                false => message(format_args!("sideslip: {sentence}")),
            }
        }
        if let Some(at_s) = self.stood_at_s {
            losses.push(format!("the vehicle's clock stood still at {at_s} s: what came then is not used"));
        }
        if let (steps @ 1.., by_s) = self.steps_back {
            losses.push(format!(
                "the vehicle's clock was set back by {by_s:.2} s in all ({steps} times): what came until that was sure is too late"
            ));
        }
        if let Some(rate) = self.runs_fast {
            message(format_args!("sideslip: times are the vehicle's, whose clock ran {rate:.2} times as fast as this machine's"));
        }
        if let others @ 1.. = self.live.motion_of_others() {
            message(format_args!("sideslip: {others} messages of motion of other senders than the vehicle were not used"));
        }
        if self.samples == 0 && messages > 0 {
            losses.push(match self.live.stream().clock().newest_us() {
                _ if self.live.stream().vehicle().is_none() => no_motion(&self.live),
                None => "no sample: the vehicle's messages carry no time".to_owned(),
                Some(_) => "no sample: no message of the vehicle could be used".to_owned(),
            });
        }
        if let Some((vehicle, late)) = self.vehicle().map(|(vehicle, tally)| (vehicle, tally.late)).filter(|(_, late)| *late > 0)
        {
            message(format_args!("sideslip: {late} messages of {vehicle} came after later ones, by their numbers"));
        }
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
