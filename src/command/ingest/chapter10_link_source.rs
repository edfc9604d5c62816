//! A link that brings packets of IRIG 106 Chapter 10 onto the bus, until it is stopped.
//!
//! Where no file says the format of the frames, the setup record is waited for: packets that come before it are counted, those
//! that come with its end are read. It is written down for an `ingest` that takes the place of this one, as it may not come
//! again, with the count at which time is zero. Time is that of the relative time counter, from the first packet that came; a
//! lost datagram or a silence leaves a gap of its own length. Where the recorder starts again, its time goes on by this
//! machine's clock. One recorder sends: datagrams do not say who.

use super::args::IngestArgs;
use super::link_source::{PATIENCE, open, until_open};
use super::recording_source::fitted;
use super::row_publisher::{RowPublisher, host_us};
use super::sample_publisher::SamplePublisher;
use super::silence_monitor::SilenceMonitor;
use crate::command::options::mapping_input::read_mapping;
use crate::command::options::telemetry_source::note_setup;
use crate::command::recordings::run_head::{head_with, override_keys};
use crate::command::{message, patience, root_path};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::file::run_file::{RecordingColumn, RunInfo};
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::{playing_since, read_counter, read_setup, write_counter, write_head, write_setup};
use sideslip::io::bus::service::Bus;
use sideslip::io::telemetry::chapter10::channel_choice::FrameDescription;
use sideslip::io::telemetry::chapter10::channel_rows::ChannelRows;
use sideslip::io::telemetry::chapter10::header::{PacketLimits, data_type};
use sideslip::io::telemetry::chapter10::packet::Chapter10Packet;
use sideslip::io::telemetry::chapter10::tmats::SetupRecord;
use sideslip::io::telemetry::chapter10::udp::LinkFormat;
use sideslip::io::telemetry::chapter10::udp_receiver::UdpReceiver;
use sideslip::io::telemetry::mavlink::link::{DATAGRAM_MAX, Link, LinkEvent, Url};
use sideslip::io::telemetry::record::RecordingRow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Between attempts to open a link again.
const REOPEN: Duration = Duration::from_secs(1);
/// Silence that is worth a word.
const SILENCE: Duration = Duration::from_secs(3);
/// The longest setup that is waited for, bytes.
const SETUP_MAX: usize = 4 << 20;
/// Packets of other data than PCM that are held between the setup and the first PCM packet at most.
const HELD: usize = 32;

/// Listens until it is stopped.
pub(super) fn listen(args: &IngestArgs, url: &Url, format: Option<&Path>, stop: &AtomicBool) -> Result<Outcome, Failure> {
    let description = match format {
        Some(format) => FrameDescription::read(format)?,
        None => read_mapping(args.config.as_deref(), &args.map)?.chapter10,
    };
    override_keys(&mut RunInfo::default(), &args.set)?;
    let mut bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take_within(BusRole::Telemetry, patience(args.supervised))?;
    let Some(link) = open(args, url, stop)? else {
        message(format_args!("sideslip: {url}: stopped before it was open"));
        return Ok(Outcome::Done);
    };
    let mut ingest = Chapter10Ingest {
        args,
        bus: &bus,
        stop,
        description,
        link,
        receiver: UdpReceiver::new(LinkFormat::OneOrThree, PacketLimits::default()),
        setup: Vec::new(),
        held: Vec::new(),
        run: None,
        before_setup: 0,
        silence: SilenceMonitor::new(),
        silent: false,
        silences: 0,
    };
    message(format_args!("sideslip: listening at {url} for packets of IRIG 106 Chapter 10"));
    if args.resume
        && let Some(setup) = read_setup(bus.root())?
    {
        ingest.setup = setup;
    }
    if !ingest.description.needs_setup() || !ingest.setup.is_empty() {
        ingest.begin_run()?;
    }
    let worked = ingest.work();
    let ended = ingest.end();
    worked.and(ended)?;
    Ok(ingest.answer())
}

/// What is published, once the format is known.
struct PublishedRun<'s> {
    rows: ChannelRows,
    out: RowPublisher<'s>,
    /// Time of the first packet, s; `None` before it.
    start_s: Option<f64>,
    /// The count of its zero that was written down.
    kept: Option<i64>,
}

impl PublishedRun<'_> {
    fn packet(&mut self, packet: &Chapter10Packet<'_>, host_us: i64) {
        let PublishedRun { rows, out, start_s, .. } = self;
        if let Some(expected_s) = out.expected_s(host_us) {
            rows.expect(expected_s);
        }
        let before = out.samples;
        rows.packet(packet, start_s.unwrap_or_default(), &mut |row: &RecordingRow| out.row(row, host_us));
        if out.samples > before {
            out.arrived(out.newest_s, host_us);
        }
    }

    fn finish(&mut self, host_us: i64) {
        let PublishedRun { rows, out, .. } = self;
        rows.finish(&mut |row: &RecordingRow| out.row(row, host_us));
    }
}

fn is_pcm(packet: &Chapter10Packet<'_>) -> bool {
    packet.header.data_type == data_type::PCM_1
}

struct Chapter10Ingest<'s> {
    args: &'s IngestArgs,
    bus: &'s Bus,
    stop: &'s AtomicBool,
    description: FrameDescription,
    link: Link,
    receiver: UdpReceiver,
    /// The texts of the setup records that came.
    setup: Vec<u8>,
    /// Packets behind the setup, and their bodies, until the run begins with them.
    held: Vec<(Chapter10Packet<'static>, Vec<u8>)>,
    /// `None` before the format is known.
    run: Option<PublishedRun<'s>>,
    /// PCM packets before that.
    before_setup: u64,
    silence: SilenceMonitor,
    silent: bool,
    silences: u64,
}

impl Chapter10Ingest<'_> {
    fn work(&mut self) -> Result<(), Failure> {
        let mut buffer = vec![0; DATAGRAM_MAX];
        while !self.stop.load(Ordering::Relaxed) {
            match self.link.receive(&mut buffer) {
                Ok(LinkEvent::Bytes(count)) => self.datagram(buffer.get(..count).unwrap_or_default())?,
                Ok(LinkEvent::Silence) => self.notice_silence(),
                Ok(LinkEvent::Closed) => self.reopen("the other end has closed it"),
                Err(error) => self.reopen(&error.to_string()),
            }
        }
        Ok(())
    }

    fn datagram(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let host_us = host_us();
        self.begin_time()?;
        if std::mem::take(&mut self.silent) {
            message(format_args!("sideslip: {}: packets come again", self.link.url()));
        }
        self.silence.reset();
        let Chapter10Ingest { receiver, run, setup, held, before_setup, .. } = self;
        let before = *before_setup;
        // A datagram without a transfer header is counted by the receiver.
        let _ = receiver.datagram(bytes, |packet| match run {
            Some(run) => run.packet(packet, host_us),
            None => match SetupRecord::parse(packet) {
                Ok(text) if setup.len() + text.text.len() <= SETUP_MAX => setup.extend_from_slice(text.text),
                _ if setup.is_empty() => *before_setup += u64::from(is_pcm(packet)),
                // Of one datagram at most: the run begins at its end.
                _ if is_pcm(packet) || held.len() < HELD => held.push((packet.with_body(&[]), packet.body.to_vec())),
                _ => {}
            },
        });
        // A setup may need several packets: it is whole where data follow.
        if self.run.is_none() && self.held.iter().any(|(packet, _)| is_pcm(packet)) {
            self.begin_run()?;
            self.begin_time()?;
            let held = std::mem::take(&mut self.held);
            if let Some(run) = &mut self.run {
                held.iter().for_each(|(packet, body)| run.packet(&packet.with_body(body), host_us));
            }
        }
        self.keep_time()?;
        match &mut self.run {
            Some(run) => run.out.published(),
            None if before == 0 && self.before_setup > 0 => {
                message(format_args!("sideslip: {}: PCM packets come, the setup (TMATS) is waited for", self.link.url()));
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// The first packet has the time 0, or that since the first of the `ingest` whose place this one takes.
    fn begin_time(&mut self) -> Result<(), Failure> {
        let Some(run) = self.run.as_mut().filter(|run| run.start_s.is_none()) else { return Ok(()) };
        let now_ns = monotonic_ns();
        let since_ns = if self.args.resume { playing_since(self.bus.root(), now_ns)? } else { now_ns };
        let start_s = Duration::from_nanos(now_ns.saturating_sub(since_ns)).as_secs_f64();
        run.start_s = Some(start_s);
        if self.args.resume
            && let Some(zero) = read_counter(self.bus.root())?
        {
            run.rows.resume(zero);
            run.rows.expect(start_s);
        }
        Ok(())
    }

    /// Writes the count of the zero down: the first, and that of a recorder that started again.
    fn keep_time(&mut self) -> Result<(), Failure> {
        let Some(run) = &mut self.run else { return Ok(()) };
        let zero = run.rows.decoder().zero();
        if let Some(zero) = zero.filter(|_| zero != run.kept) {
            write_counter(self.bus.root(), zero)?;
            run.kept = Some(zero);
        }
        Ok(())
    }

    fn begin_run(&mut self) -> Result<(), Failure> {
        let wrong = |what: String| Failure::Input(format!("{}: {what}", self.link.url()));
        let chosen = self.description.choose(&self.setup).map_err(wrong)?;
        let rows = ChannelRows::new(&chosen).map_err(|what| wrong(format!("format of the frames: {what}")))?;
        note_setup(self.link.url(), &chosen.left_out, &chosen.assumed);
        let mut info = chosen.info;
        info.set_controls(rows.controls());
        override_keys(&mut info, &self.args.set)?;
        let mut publisher = SamplePublisher::new(self.bus, false)?;
        publisher.begin_run(&mut info, RecordingColumn::others(rows.columns()).count())?;
        write_head(self.bus.root(), self.bus.incarnation(), &fitted(head_with(&info, rows.columns())))?;
        write_setup(self.bus.root(), &self.setup)?;
        if let Some(channel) = chosen.channel {
            message(format_args!("sideslip: {}: PCM channel {channel} is read", self.link.url()));
        }
        self.run = Some(PublishedRun {
            rows: rows.unquestioned(),
            out: RowPublisher::new(publisher, self.stop),
            start_s: None,
            kept: None,
        });
        Ok(())
    }

    fn notice_silence(&mut self) {
        if self.silence.elapsed() < SILENCE || std::mem::replace(&mut self.silent, true) {
            return;
        }
        let known = self.receiver.tally().datagrams > 0;
        self.silences += u64::from(known);
        message(format_args!("sideslip: {}: no packet for {} s", self.link.url(), SILENCE.as_secs()));
    }

    fn reopen(&mut self, why: &str) {
        let url = self.link.url().clone();
        message(format_args!("sideslip: {url}: {why}; it is opened again"));
        if let Some(link) = until_open(Instant::now() + REOPEN, self.stop, || Link::open(url.clone(), PATIENCE)) {
            self.link = link;
            message(format_args!("sideslip: {url} is open again"));
        }
    }

    /// Publishes what waits, and says that the run has ended.
    fn end(&mut self) -> Result<(), Failure> {
        let host_us = host_us();
        let Chapter10Ingest { receiver, run, .. } = self;
        let Some(run) = run else { return Ok(()) };
        receiver.finish(|packet| run.packet(packet, host_us));
        run.finish(host_us);
        let published = run.out.published();
        run.out.end()?;
        published
    }

    /// What came and what did not.
    fn answer(&mut self) -> Outcome {
        let (samples, frames) =
            self.run.as_ref().map_or((0, 0), |run| (run.out.samples, run.rows.decoder().tally().minor_frames));
        message(format_args!("sideslip: {samples} samples, {frames} minor frames"));
        let mut losses = self.run.as_ref().map(|run| run.rows.shortfalls()).unwrap_or_default();
        losses.extend(self.run.as_mut().map(|run| run.out.take_losses()).unwrap_or_default());
        let (tally, segments) = (self.receiver.tally(), self.receiver.segments());
        let skipped: u64 = self.receiver.packets().map(|(_, packets)| packets.skipped_bytes).sum();
        let counted = [
            (tally.lost, "datagrams lost"),
            (tally.refused, "datagrams without a transfer header of format 1 or 3"),
            (tally.late, "datagrams late"),
            (tally.repeated, "datagrams that came twice"),
            (tally.restarts, "restarts of the sender's numbers"),
            (tally.other_sources, "datagrams of further sources"),
            (segments.incomplete, "packets of which a segment is missing"),
            (skipped, "bytes that belong to no packet"),
            (self.silences, "silences"),
            (self.before_setup, "PCM packets before the setup (TMATS)"),
        ];
        losses.extend(counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")));
        if samples == 0 && tally.datagrams > 0 {
            losses.push("packets came, but no sample that can be used was found in them".to_owned());
        }
        losses.iter().for_each(|loss| message(format_args!("sideslip: {loss}")));
        if losses.is_empty() { Outcome::Done } else { Outcome::DataLost }
    }
}
