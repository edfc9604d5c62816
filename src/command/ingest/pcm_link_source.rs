//! A link that brings a stream of PCM onto the bus, until it is stopped; one that breaks is opened again.
//!
//! Time is that of the words, from the first bit that came. Where the link was silent and the bits of that time are lost, the
//! stream goes on later by what this machine's clock says, so that a gap is one in the samples too; it is counted and said. A
//! single datagram that is lost is not noticed so: the synchroniser finds the next pattern, counts the loss, and the samples
//! behind it are early by the bits that are missing.

use super::args::IngestArgs;
use super::link_source::{open, until_open};
use super::recording_source::fitted;
use super::sample_publisher::SamplePublisher;
use crate::command::recordings::run_head::{head_with, override_keys};
use crate::command::{message, patience, root_path};
use sideslip::error::{Failure, Outcome};
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::{playing_since, write_head};
use sideslip::io::bus::service::Bus;
use sideslip::io::telemetry::mavlink::host_time::HostOffset;
use sideslip::io::telemetry::mavlink::link::{DATAGRAM_MAX, Link, LinkEvent, Url};
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::format_file::PcmFormatFile;
use sideslip::io::telemetry::pcm::recording::losses_in_words;
use sideslip::io::telemetry::pcm::rows::PcmRows;
use sideslip::io::telemetry::record::RecordingRow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Between attempts to open a link again.
const REOPEN: Duration = Duration::from_secs(1);
/// Reads in a row without bytes after which bits may be lost: each waits as long as a link does.
const SILENT_READS: u32 = 4;
/// A stream so far behind the clock after a silence has lost bits, s.
const BEHIND_S: f64 = 0.1;

/// Listens until it is stopped.
pub(super) fn listen(args: &IngestArgs, url: &Url, format: &Path, stop: &AtomicBool) -> Result<Outcome, Failure> {
    let format = PcmFormatFile::read(format)?;
    let rows = PcmRows::new(&format.format).map_err(|what| Failure::Input(format!("format of the frames: {what}")))?;
    let mut info = format.info.clone();
    info.set_controls(rows.controls());
    override_keys(&mut info, &args.set)?;
    let mut bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take_within(BusRole::Telemetry, patience(args.supervised))?;
    let Some(link) = open(args, url, stop)? else {
        message(format_args!("sideslip: {url}: stopped before it was open"));
        return Ok(Outcome::Done);
    };
    write_head(bus.root(), bus.incarnation(), &fitted(head_with(&info, rows.columns())))?;
    let now_ns = monotonic_ns();
    let since_ns = if args.resume { playing_since(bus.root(), now_ns)? } else { now_ns };
    let mut ingest = PcmIngest {
        start_s: Duration::from_nanos(now_ns.saturating_sub(since_ns)).as_secs_f64(),
        decoder: None,
        format,
        rows,
        link,
        offset: HostOffset::default(),
        newest_s: 0.0,
        samples: 0,
        gaps: (0, 0.0),
        earlier: Vec::new(),
    };
    let mut publisher = SamplePublisher::new(&bus, false)?;
    message(format_args!("sideslip: listening at {url} for PCM"));
    let worked = ingest.work(&mut publisher, stop);
    publisher.end(ingest.newest_s, stop)?;
    worked?;
    Ok(ingest.answer())
}

struct PcmIngest {
    format: PcmFormatFile,
    rows: PcmRows,
    link: Link,
    /// Time of the first bit of the stream, and of each that begins behind a gap, s.
    start_s: f64,
    /// `None` before the first bit, and behind a gap.
    decoder: Option<PcmDecoder>,
    offset: HostOffset,
    newest_s: f64,
    samples: u64,
    /// How many, and how long together, s.
    gaps: (u32, f64),
    /// Losses of the streams before the last gap.
    earlier: Vec<String>,
}

impl PcmIngest {
    fn work(&mut self, publisher: &mut SamplePublisher, stop: &AtomicBool) -> Result<(), Failure> {
        let mut buffer = vec![0; DATAGRAM_MAX];
        let mut silent = 0;
        while !stop.load(Ordering::Relaxed) {
            match self.link.receive(&mut buffer) {
                Ok(LinkEvent::Bytes(count)) => {
                    let after_silence = std::mem::take(&mut silent) >= SILENT_READS;
                    self.bytes(buffer.get(..count).unwrap_or_default(), after_silence, publisher, stop)?;
                }
                Ok(LinkEvent::Silence) => silent += 1,
                Ok(LinkEvent::Closed) => self.reopen("the other end has closed it", stop),
                Err(error) => self.reopen(&error.to_string(), stop),
            }
        }
        Ok(())
    }

    /// Time of the next bit, s.
    fn stream_s(&self) -> f64 {
        let bits = self.decoder.as_ref().map_or(0, |decoder| decoder.synchronizer.counters().bits);
        self.start_s + bits as f64 / self.format.format.spec().bit_rate
    }

    fn bytes(
        &mut self,
        bytes: &[u8],
        after_silence: bool,
        publisher: &mut SamplePublisher,
        stop: &AtomicBool,
    ) -> Result<(), Failure> {
        if bytes.is_empty() {
            return Ok(());
        }
        let host_us = i64::try_from(monotonic_ns() / 1000).unwrap_or(i64::MAX);
        let received_s = 8.0 * bytes.len() as f64 / self.format.format.spec().bit_rate;
        if after_silence && let Some(least_us) = self.offset.least_us() {
            let expected_s = (host_us - least_us) as f64 * 1e-6 - received_s;
            let behind_s = expected_s - self.stream_s();
            if behind_s > BEHIND_S {
                self.begin_behind_gap(behind_s, publisher, stop)?;
            }
        }
        if self.decoder.is_none() {
            self.decoder = Some(PcmDecoder::new(&self.format.format, self.start_s));
        }
        self.offset.observe(microseconds(self.stream_s() + received_s), host_us);
        let PcmIngest { decoder, rows, offset, newest_s, samples, .. } = self;
        let mut published = Ok(true);
        let mut each = |row: &RecordingRow| {
            if matches!(published, Ok(true)) {
                let time_s = row.sample.time_s;
                let sampled_us = offset.host_of(microseconds(time_s), host_us);
                let sampled_ns = u64::try_from(sampled_us).unwrap_or_default().saturating_mul(1000);
                published = publisher.sample(&row.sample, &row.others, Some(sampled_ns), stop);
                *newest_s = time_s;
                *samples += 1;
            }
        };
        if let Some(decoder) = decoder {
            decoder.feed(bytes, |sample| rows.put(&sample, &mut each));
        }
        published.map(|_| ())
    }

    /// The bits of a silence are lost: what was received before it is ended, and the stream begins anew that much later.
    fn begin_behind_gap(&mut self, behind_s: f64, publisher: &mut SamplePublisher, stop: &AtomicBool) -> Result<(), Failure> {
        self.start_s = self.stream_s() + behind_s;
        let PcmIngest { decoder, rows, newest_s, samples, earlier, .. } = self;
        let mut published = Ok(true);
        if let Some(mut decoder) = decoder.take() {
            let mut each = |row: &RecordingRow| {
                if matches!(published, Ok(true)) {
                    published = publisher.sample(&row.sample, &row.others, None, stop);
                    *newest_s = row.sample.time_s;
                    *samples += 1;
                }
            };
            decoder.finish(|sample| rows.put(&sample, &mut each));
            rows.finish(&mut each);
            earlier.extend(losses_in_words(&decoder));
        }
        self.gaps = (self.gaps.0 + 1, self.gaps.1 + behind_s);
        message(format_args!("sideslip: {}: {behind_s:.2} s of the stream are lost", self.link.url()));
        published.map(|_| ())
    }

    fn reopen(&mut self, why: &str, stop: &AtomicBool) {
        let url = self.link.url().clone();
        message(format_args!("sideslip: {url}: {why}; it is opened again"));
        if let Some(link) = until_open(Instant::now() + REOPEN, stop, || Link::open(url.clone(), super::link_source::PATIENCE)) {
            self.link = link;
            message(format_args!("sideslip: {url} is open again"));
        }
    }

    /// What came and what did not.
    fn answer(&self) -> Outcome {
        let frames = self.decoder.as_ref().map_or(0, |decoder| decoder.synchronizer.counters().minor_frames);
        message(format_args!("sideslip: {} samples, {frames} minor frames since the last gap", self.samples));
        let mut losses = self.earlier.clone();
        losses.extend(self.decoder.as_ref().and_then(losses_in_words));
        losses.extend(self.rows.unused().words());
        if self.gaps.0 > 0 {
            losses.push(format!("{} gaps of the stream, {:.2} s in all", self.gaps.0, self.gaps.1));
        }
        if self.samples == 0 && self.decoder.is_some() {
            losses.push("bits came, but no minor frame of this format was found in them".to_owned());
        }
        losses.iter().for_each(|loss| message(format_args!("sideslip: {loss}")));
        if losses.is_empty() { Outcome::Done } else { Outcome::DataLost }
    }
}

fn microseconds(time_s: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "a cast of a float saturates, and a stream of 300,000 years is none")]
    let us = libm::round(time_s * 1e6) as i64;
    us
}
