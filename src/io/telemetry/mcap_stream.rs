//! The messages of an MCAP file in the order of the file, however the file ends.
//!
//! Consumes bytes; produces (topic, payload). A file may come from anyone: every length is held against
//! [`LONGEST_RECORD`] and against what lz4 can do before memory is taken for it, chunks are checked against their CRC
//! before anything in them counts, and a damaged chunk costs its own messages only. The chunk reader of mcap 0.26 takes
//! it on trust that a record of an uncompressed chunk ends inside the chunk (it subtracts, and overflows); that is seen
//! to here, before it is asked. Of a file that was cut off every
//! whole message comes, from the chunk that the cut went through too.

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::{BTreeMap, VecDeque};
use std::io::{self, Read};
use std::ops::Range;

/// The longest record that is read, bytes, compressed or not.
pub(crate) const LONGEST_RECORD: usize = 32 << 20;

/// lz4 gives at most 255 bytes for one; a chunk that claims more is damaged.
const LZ4_GAIN: u64 = 255;

const OPCODE_AND_LENGTH: usize = 1 + 8;

/// How much is read at once, bytes: memory follows what the file holds, not what a length in it claims.
const BLOCK: usize = 256 << 10;

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shortfall {
    /// Why reading stopped before the end of the file, and that it was cut off.
    pub(crate) stopped: Option<String>,
    /// Chunks whose content did not match their checksum or their own lengths.
    pub(crate) damaged_chunks: u64,
    /// The first reason for that.
    pub(crate) chunk_reason: Option<String>,
    /// Messages of channels that the file does not introduce.
    pub(crate) orphans: u64,
}

/// A channel that the file introduced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ChannelInfo {
    pub(crate) topic: String,
    pub(crate) encoding: String,
}

/// Messages, one after another.
pub(crate) struct MessageStream<R> {
    source: R,
    reader: LinearReader,
    /// Bytes of the record that is being read, kept for the case that the file ends in it.
    record: Vec<u8>,
    channels: BTreeMap<u16, ChannelInfo>,
    metadata: Vec<(String, BTreeMap<String, String>)>,
    /// Messages decoded and not yet given: their channel, when they were logged, ns, and where their payload stands in `arena`.
    ready: VecDeque<(u16, u64, Range<usize>)>,
    arena: Vec<u8>,
    shortfall: Shortfall,
    started: bool,
    ended: bool,
    messages: u64,
}

impl<R: Read> MessageStream<R> {
    pub(crate) fn new(source: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_record_length_limit(LONGEST_RECORD);
        MessageStream {
            source,
            reader: LinearReader::new_with_options(options),
            record: Vec::new(),
            channels: BTreeMap::new(),
            metadata: Vec::new(),
            ready: VecDeque::new(),
            arena: Vec::new(),
            shortfall: Shortfall::default(),
            started: false,
            ended: false,
            messages: 0,
        }
    }

    pub(crate) fn channels(&self) -> &BTreeMap<u16, ChannelInfo> {
        &self.channels
    }

    pub(crate) fn shortfall(&self) -> &Shortfall {
        &self.shortfall
    }

    /// Messages given so far, of every topic.
    pub(crate) fn messages(&self) -> u64 {
        self.messages
    }

    /// Whether the file begins as an MCAP file does.
    pub(crate) fn is_mcap(&self) -> bool {
        self.started
    }

    /// Reads on until that metadata record has come.
    pub(crate) fn find_metadata(&mut self, name: &str) -> io::Result<Option<BTreeMap<String, String>>> {
        loop {
            if let Some(at) = self.metadata.iter().position(|(found, _)| found == name) {
                return Ok(Some(self.metadata.swap_remove(at).1));
            }
            self.metadata.clear();
            self.ready.clear();
            self.arena.clear();
            if self.ended {
                return Ok(None);
            }
            self.read_record()?;
        }
    }

    /// The next message; `None` at the end, whether or not the file was whole.
    pub(crate) fn next(&mut self) -> io::Result<Option<(&ChannelInfo, &[u8])>> {
        Ok(self.next_logged()?.map(|(channel, _, payload)| (channel, payload)))
    }

    /// The same with the time at which it was logged, ns.
    pub(crate) fn next_logged(&mut self) -> io::Result<Option<(&ChannelInfo, u64, &[u8])>> {
        let (id, logged_ns, place) = loop {
            match self.ready.pop_front() {
                Some((id, logged_ns, place)) if self.channels.contains_key(&id) => break (id, logged_ns, place),
                Some(_) => self.shortfall.orphans += 1,
                None if self.ended => return Ok(None),
                None => {
                    self.arena.clear();
                    self.metadata.clear();
                    self.read_record()?;
                }
            }
        };
        self.messages += 1;
        match (self.channels.get(&id), self.arena.get(place)) {
            (Some(channel), Some(payload)) => Ok(Some((channel, logged_ns, payload))),
            _ => Ok(None),
        }
    }

    /// Reads one record of the file and takes what is in it.
    fn read_record(&mut self) -> io::Result<()> {
        enum Step {
            Wants(usize),
            Record(u8),
            Stop(Option<McapError>),
        }
        loop {
            let mut body = None;
            let step = match self.reader.next_event() {
                None => Step::Stop(None),
                Some(Err(error)) => Step::Stop(Some(error)),
                Some(Ok(LinearReadEvent::ReadRequest(count))) => Step::Wants(count),
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    body = Some(data);
                    Step::Record(opcode)
                }
            };
            match step {
                Step::Wants(count) => {
                    let room = self.reader.insert(count.min(BLOCK));
                    let read = read_some(&mut self.source, room)?;
                    self.record.extend_from_slice(room.get(..read).unwrap_or_default());
                    self.reader.notify_read(read);
                }
                Step::Record(opcode) => {
                    self.started = true;
                    let taken = &mut Taken {
                        channels: &mut self.channels,
                        ready: &mut self.ready,
                        arena: &mut self.arena,
                        shortfall: &mut self.shortfall,
                    };
                    let body = body.unwrap_or_default();
                    if opcode == op::METADATA {
                        self.metadata.extend(Fields(body).metadata());
                    } else if opcode == op::CHUNK {
                        taken.chunk(&framed(op::CHUNK, body), true);
                    } else {
                        taken.record(opcode, body);
                    }
                    self.record.clear();
                    return Ok(());
                }
                Step::Stop(why) => {
                    self.stop(why);
                    return Ok(());
                }
            }
        }
    }

    fn stop(&mut self, why: Option<McapError>) {
        self.ended = true;
        let Some(error) = why else { return };
        if matches!(error, McapError::UnexpectedEof) {
            // The first record begins behind the eight bytes that every file starts with.
            let cut = if self.started { self.record.as_slice() } else { self.record.get(MAGIC..).unwrap_or_default() };
            self.started |= self.record.get(..MAGIC).is_some_and(|start| start == mcap::MAGIC);
            if cut.first() == Some(&op::CHUNK) {
                let cut = std::mem::take(&mut self.record);
                let taken = &mut Taken {
                    channels: &mut self.channels,
                    ready: &mut self.ready,
                    arena: &mut self.arena,
                    shortfall: &mut self.shortfall,
                };
                taken.chunk(&cut, false);
            }
            self.shortfall.stopped = Some("the file was cut off".to_owned());
        } else {
            self.shortfall.stopped = Some(format!("the rest is damaged ({error})"));
        }
        self.record = Vec::new();
    }
}

const MAGIC: usize = mcap::MAGIC.len();

/// Reads once, over again where a signal came between.
fn read_some(source: &mut impl Read, room: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(room) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            other => return other,
        }
    }
}

/// A record with its opcode and length in front.
fn framed(opcode: u8, body: &[u8]) -> Vec<u8> {
    let mut framed = Vec::with_capacity(OPCODE_AND_LENGTH + body.len());
    framed.push(opcode);
    framed.extend_from_slice(&(body.len() as u64).to_le_bytes());
    framed.extend_from_slice(body);
    framed
}

/// Where records put what they bring.
struct Taken<'a> {
    channels: &'a mut BTreeMap<u16, ChannelInfo>,
    ready: &'a mut VecDeque<(u16, u64, Range<usize>)>,
    arena: &'a mut Vec<u8>,
    shortfall: &'a mut Shortfall,
}

impl Taken<'_> {
    fn record(&mut self, opcode: u8, body: &[u8]) {
        if opcode == op::CHANNEL {
            match Fields(body).channel() {
                // What a file says first of a channel stays.
                Some((id, info)) => drop(self.channels.entry(id).or_insert(info)),
                None => self.damaged("a channel record is shorter than it says"),
            }
        } else if opcode == op::MESSAGE {
            match Fields(body).message() {
                Some((id, logged_ns, payload)) => {
                    let start = self.arena.len();
                    self.arena.extend_from_slice(payload);
                    self.ready.push_back((id, logged_ns, start..self.arena.len()));
                }
                None => self.damaged("a message record is shorter than it says"),
            }
        }
    }

    /// Takes the records of a chunk, given with its opcode and length; of one that was cut off, those before the cut.
    fn chunk(&mut self, framed: &[u8], whole: bool) {
        if let Err(reason) = plausible(framed.get(OPCODE_AND_LENGTH..).unwrap_or_default(), whole) {
            if whole {
                self.damaged(&reason);
            }
            return;
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(whole)
            .with_record_length_limit(LONGEST_RECORD);
        let mut reader = LinearReader::new_with_options(options);
        let mut rest = framed;
        loop {
            match reader.next_event() {
                None => return,
                Some(Ok(LinearReadEvent::Record { opcode, data })) => self.record(opcode, data),
                Some(Ok(LinearReadEvent::ReadRequest(count))) => {
                    let (now, later) = rest.split_at(count.min(rest.len()));
                    reader.insert(now.len()).copy_from_slice(now);
                    reader.notify_read(now.len());
                    rest = later;
                }
                Some(Err(error)) => {
                    if whole {
                        self.damaged(&error.to_string());
                    }
                    return;
                }
            }
        }
    }

    fn damaged(&mut self, reason: &str) {
        self.shortfall.damaged_chunks += 1;
        if self.shortfall.chunk_reason.is_none() {
            self.shortfall.chunk_reason = Some(reason.to_owned());
        }
    }
}

/// Whether a chunk's own lengths can be true, before anything is done with them. Of one that was cut off, the records may be
/// shorter than it says.
fn plausible(chunk: &[u8], whole: bool) -> Result<(), String> {
    let mut fields = Fields(chunk);
    let header = (|| {
        fields.bytes(16)?;
        let size = fields.u64()?;
        fields.bytes(4)?;
        Some((size, fields.text()?, fields.u64()?))
    })();
    let Some((size, compression, compressed)) = header else { return Err("a chunk is shorter than its header".to_owned()) };
    if whole && compressed > fields.0.len() as u64 {
        return Err(format!("a chunk claims {compressed} bytes of records, it has {}", fields.0.len()));
    }
    let most = match compression {
        "" => compressed,
        "lz4" => compressed.saturating_mul(LZ4_GAIN),
        other => {
            let name: String = other.chars().take(20).collect();
            return Err(format!("expected chunks compressed by lz4 or not at all, found `{name}`"));
        }
    };
    if size > most || size > LONGEST_RECORD as u64 {
        return Err(format!("a chunk claims to hold {size} bytes in {compressed}"));
    }
    if compression.is_empty() && !records_end_inside(fields.0, compressed) {
        return Err("a record is longer than the chunk that it stands in".to_owned());
    }
    Ok(())
}

/// Whether every record in the first `size` bytes ends inside them, as far as there are bytes to see.
fn records_end_inside(records: &[u8], size: u64) -> bool {
    let mut rest = Fields(records);
    let mut left = size;
    while left > 0 {
        let Some(length) = rest.bytes(1).and_then(|_| rest.u64()) else { return (records.len() as u64) < size };
        let Some(after) = left.checked_sub(OPCODE_AND_LENGTH as u64).and_then(|left| left.checked_sub(length)) else {
            return false;
        };
        left = after;
        if usize::try_from(length).ok().and_then(|length| rest.bytes(length)).is_none() {
            return (records.len() as u64) < size;
        }
    }
    true
}

/// The fields of a record; each is there only where the record is long enough for it.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (front, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(front)
    }

    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.bytes(2)?.try_into().ok()?))
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.bytes(4)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.bytes(8)?.try_into().ok()?))
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = usize::try_from(self.u32()?).ok()?;
        std::str::from_utf8(self.bytes(length)?).ok()
    }

    fn channel(mut self) -> Option<(u16, ChannelInfo)> {
        let id = self.u16()?;
        self.u16()?;
        let info = ChannelInfo { topic: self.text()?.to_owned(), encoding: self.text()?.to_owned() };
        Some((id, info))
    }

    fn message(mut self) -> Option<(u16, u64, &'a [u8])> {
        let id = self.u16()?;
        self.bytes(4)?;
        let logged_ns = self.u64()?;
        self.bytes(8)?;
        Some((id, logged_ns, self.0))
    }

    fn metadata(mut self) -> Option<(String, BTreeMap<String, String>)> {
        let name = self.text()?.to_owned();
        let length = usize::try_from(self.u32()?).ok()?;
        let mut pairs = Fields(self.bytes(length)?);
        let mut texts = BTreeMap::new();
        while !pairs.0.is_empty() {
            texts.insert(pairs.text()?.to_owned(), pairs.text()?.to_owned());
        }
        Some((name, texts))
    }
}
