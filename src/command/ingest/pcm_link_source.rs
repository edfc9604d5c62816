//! A link that brings a stream of PCM onto the bus, until it is stopped; one that breaks is opened again.
//!
//! Time is that of the words, from the first bit that came. Where the link was silent and the bits of that time are lost, the
//! stream goes on later by what this machine's clock says, so that a gap is one in the samples too. Datagrams that are lost one
//! by one are told by the times at which the others arrive ([`ArrivalWindow`]), half a second later; from there on the time is
//! right again, and the samples between are early by the bits that are missing. Both are counted and said. Said, and not mended,
//! are bits at another rate than the format's, and a stream that holds more bits than its time has ([`ArrivalRate`]).

use super::args::IngestArgs;
use super::link_source::{open, until_open};
use super::recording_source::fitted;
use super::row_publisher::{RowPublisher, host_us};
use super::sample_publisher::SamplePublisher;
use crate::command::recordings::run_head::{head_with, override_keys};
use crate::command::{message, patience, root_path};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::file::run_file::RecordingColumn;
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::{playing_since, write_head};
use sideslip::io::bus::service::Bus;
use sideslip::io::telemetry::mavlink::link::{DATAGRAM_MAX, Link, LinkEvent, Url};
use sideslip::io::telemetry::pcm::arrival::ArrivalWindow;
use sideslip::io::telemetry::pcm::arrival_rate::ArrivalRate;
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
    let mut publisher = SamplePublisher::new(&bus, false)?;
    publisher.begin_run(&mut info, RecordingColumn::others(rows.columns()).count())?;
    write_head(bus.root(), bus.incarnation(), &fitted(head_with(&info, rows.columns())))?;
    let now_ns = monotonic_ns();
    let since_ns = if args.resume { playing_since(bus.root(), now_ns)? } else { now_ns };
    let mut ingest = PcmIngest {
        start_s: Duration::from_nanos(now_ns.saturating_sub(since_ns)).as_secs_f64(),
        is_whole: matches!(url, Url::Tcp(_) | Url::Serial { .. }),
        decoder: None,
        format,
        rows,
        link,
        out: RowPublisher::new(publisher, stop),
        arrivals: ArrivalWindow::default(),
        rate: ArrivalRate::default(),
        other_rate: None,
        lead_s: 0.0,
        gaps: (0, 0.0),
        lost: (0, 0.0),
        earlier: Vec::new(),
        frames: 0,
        bits: 0,
    };
    message(format_args!("sideslip: listening at {url} for PCM"));
    let worked = ingest.work(stop);
    let ended = ingest.end_stream(host_us());
    ingest.out.end()?;
    worked.and(ended)?;
    Ok(ingest.answer())
}

struct PcmIngest<'s> {
    format: PcmFormatFile,
    rows: PcmRows,
    link: Link,
    /// Time of the first bit of the stream, and of each that begins behind a gap, s.
    start_s: f64,
    /// Whether the link loses nothing while it is open.
    is_whole: bool,
    /// `None` before the first bit, and behind a gap.
    decoder: Option<PcmDecoder>,
    out: RowPublisher<'s>,
    arrivals: ArrivalWindow,
    rate: ArrivalRate,
    /// The rate that was said, in those of the format.
    other_rate: Option<f64>,
    /// By how much the stream led its arrival at most, s.
    lead_s: f64,
    /// Silences, how many, and how long together, s.
    gaps: (u32, f64),
    /// Losses without a silence, the same.
    lost: (u32, f64),
    /// Losses of the streams before the last gap.
    earlier: Vec<String>,
    /// Minor frames and bits of the streams that ended.
    frames: u64,
    bits: u64,
}

impl PcmIngest<'_> {
    fn work(&mut self, stop: &AtomicBool) -> Result<(), Failure> {
        let mut buffer = vec![0; DATAGRAM_MAX];
        let mut silent = 0;
        while !stop.load(Ordering::Relaxed) {
            match self.link.receive(&mut buffer) {
                Ok(LinkEvent::Bytes(count)) => {
                    let after_silence = std::mem::take(&mut silent) >= SILENT_READS;
                    self.bytes(buffer.get(..count).unwrap_or_default(), after_silence)?;
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
        self.decoder.as_ref().map_or(self.start_s, PcmDecoder::next_bit_s)
    }

    fn bytes(&mut self, bytes: &[u8], after_silence: bool) -> Result<(), Failure> {
        if bytes.is_empty() {
            return Ok(());
        }
        let host_us = host_us();
        let received_s = 8.0 * bytes.len() as f64 / self.format.format.spec().bit_rate;
        if after_silence && let Some(expected_s) = self.out.expected_s(host_us) {
            let behind_s = expected_s - received_s - self.stream_s();
            if behind_s > BEHIND_S {
                self.begin_behind_gap(behind_s, host_us)?;
            }
        }
        if self.decoder.is_none() {
            self.decoder = Some(PcmDecoder::new(&self.format.format, self.start_s));
        }
        self.go_on_behind_losses(received_s, host_us);
        self.out.arrived(self.stream_s() + received_s, host_us);
        let PcmIngest { decoder, rows, out, .. } = self;
        if let Some(decoder) = decoder {
            decoder.feed(bytes, |sample| rows.put(&sample, &mut |row| out.row(row, host_us)));
        }
        out.published()
    }

    /// Datagrams that the others show to be lost took time.
    fn go_on_behind_losses(&mut self, received_s: f64, host_us: i64) {
        let us =
            |time_s: f64| Duration::try_from_secs_f64(time_s).map_or(0, |time| time.as_micros().try_into().unwrap_or(i64::MAX));
        let (stream_us, length_us) = (us(self.stream_s() + received_s), us(received_s));
        self.rate.arrived(host_us, stream_us, length_us);
        self.say_other_rate();
        if self.is_whole {
            return;
        }
        let Some(lost_us) = self.arrivals.arrived(host_us, stream_us, length_us) else { return };
        let lost_s = lost_us as f64 * 1e-6;
        if let Some(decoder) = &mut self.decoder {
            decoder.go_on_later(lost_s);
        }
        self.lost = (self.lost.0 + 1, self.lost.1 + lost_s);
        // Where the rate is another, it is not datagrams one by one.
        if self.other_rate.is_none() {
            message(format_args!("sideslip: {}: datagrams of {lost_s:.4} s are lost", self.link.url()));
        }
    }

    /// Bits at another rate than the format's, said once; a stream ahead of its arrival is kept for the end.
    fn say_other_rate(&mut self) {
        let other = self.rate.other_rate();
        if let (Some(ratio), None) = (other, self.other_rate) {
            let url = self.link.url();
            message(format_args!(
                "sideslip: {url}: bits come at {ratio:.2} times the bit rate of the format: the rate is wrong, the sender does \
                 not keep to the time, or bits are lost all the time; do not rely on the times of samples"
            ));
            self.other_rate = Some(ratio);
        }
        if other.is_none() && !self.is_whole {
            self.lead_s = self.lead_s.max(self.rate.lead_s().unwrap_or(0.0));
        }
    }

    /// The bits of a silence are lost: what was received before it is ended, and the stream begins anew that much later.
    fn begin_behind_gap(&mut self, behind_s: f64, host_us: i64) -> Result<(), Failure> {
        self.start_s = self.stream_s() + behind_s;
        self.arrivals.clear();
        self.rate.clear();
        self.gaps = (self.gaps.0 + 1, self.gaps.1 + behind_s);
        message(format_args!("sideslip: {}: {behind_s:.2} s of the stream are lost", self.link.url()));
        self.end_stream(host_us)
    }

    /// Publishes what waits for further bits.
    fn end_stream(&mut self, host_us: i64) -> Result<(), Failure> {
        let PcmIngest { decoder, rows, out, earlier, .. } = self;
        if let Some(mut decoder) = decoder.take() {
            let mut each = |row: &RecordingRow| out.row(row, host_us);
            decoder.finish(|sample| rows.put(&sample, &mut each));
            rows.finish(&mut each);
            earlier.extend(losses_in_words(&decoder.synchronizer.counters(), &decoder.decommutator.counters()));
            self.frames += decoder.synchronizer.counters().minor_frames;
            self.bits += decoder.synchronizer.counters().bits;
        }
        self.out.published()
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
    fn answer(&mut self) -> Outcome {
        message(format_args!("sideslip: {} samples, {} minor frames", self.out.samples, self.frames));
        let mut losses = self.earlier.clone();
        losses.extend(self.out.take_losses());
        losses.extend(self.rows.shortfall());
        if self.gaps.0 > 0 {
            losses.push(format!("{} gaps of the stream, {:.2} s in all", self.gaps.0, self.gaps.1));
        }
        if self.lost.0 > 0 {
            losses.push(format!("datagrams lost at {} places, {:.4} s in all", self.lost.0, self.lost.1));
        }
        if let Some(ratio) = self.other_rate.filter(|ratio| *ratio < 1.0) {
            losses.push(format!("bits came at {ratio:.2} times the bit rate of the format"));
        }
        if self.lead_s > 0.0 {
            losses.push(format!(
                "the stream ran up to {:.4} s ahead of its arrival (datagrams that came twice, out of order, or from another \
                 sender): samples are dated later by that",
                self.lead_s
            ));
        }
        if self.out.samples == 0 && self.bits > 0 {
            losses.push("bits came, but no minor frame of this format was found in them".to_owned());
        }
        losses.iter().for_each(|loss| message(format_args!("sideslip: {loss}")));
        if losses.is_empty() { Outcome::Done } else { Outcome::DataLost }
    }
}
