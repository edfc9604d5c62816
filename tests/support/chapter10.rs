//! Writes IRIG 106 Chapter 10 packets, setups and datagrams, straight from the layouts in the standard: nothing of the reader
//! is used, save the format of the frames, which the setup is to say in its own words.

use sideslip::io::telemetry::pcm::calibration::Calibration;
use sideslip::io::telemetry::pcm::encoding::RawEncoding;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use std::fmt::Write;

/// How a recorder stores PCM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    Packed,
    PackedBy32,
    Unpacked,
    /// 32-bit alignment, words of up to 16 bits in cells of 32.
    UnpackedBy32,
    Throughput,
}

impl Storage {
    pub(crate) const ALL: [Storage; 5] =
        [Storage::Packed, Storage::PackedBy32, Storage::Unpacked, Storage::UnpackedBy32, Storage::Throughput];

    fn alignment(self) -> usize {
        if matches!(self, Storage::PackedBy32 | Storage::UnpackedBy32) { 4 } else { 2 }
    }

    fn channel_word(self) -> u32 {
        let mode = match self {
            Storage::Unpacked | Storage::UnpackedBy32 => 1 << 18,
            Storage::Packed | Storage::PackedBy32 => 1 << 19,
            Storage::Throughput => return 1 << 20,
        };
        // Intra-packet headers, both locks, the first word begins a minor frame.
        1 << 30 | 0xF << 24 | 1 << 28 | mode | if self.alignment() == 4 { 1 << 21 } else { 0 }
    }

    /// What `R-x\PDP-n` calls it.
    fn in_setup(self) -> &'static str {
        match self {
            Storage::Unpacked | Storage::UnpackedBy32 => "UN",
            Storage::Packed | Storage::PackedBy32 => "PFS",
            Storage::Throughput => "TM",
        }
    }
}

/// A packet with a 16-bit data checksum.
pub(crate) fn packet(channel: u16, data_type: u8, sequence: u8, rtc: u64, body: &[u8]) -> Vec<u8> {
    let mut behind = body.to_vec();
    while behind.len() % 4 != 2 {
        behind.push(0);
    }
    let sum = behind.chunks(2).fold(0_u16, |sum, word| sum.wrapping_add(u16::from_le_bytes([word[0], word[1]])));
    behind.extend(sum.to_le_bytes());
    let mut bytes = vec![0x25, 0xEB];
    bytes.extend(channel.to_le_bytes());
    bytes.extend((24 + behind.len() as u32).to_le_bytes());
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend([3, sequence, 2, data_type]);
    bytes.extend(&rtc.to_le_bytes()[..6]);
    let sum = bytes.chunks(2).fold(0_u16, |sum, word| sum.wrapping_add(u16::from_le_bytes([word[0], word[1]])));
    bytes.extend(sum.to_le_bytes());
    bytes.extend(behind);
    bytes
}

/// A setup record.
pub(crate) fn setup_packet(text: &str) -> Vec<u8> {
    packet(0, 0x01, 0, 0, &[&[8, 0, 0, 0][..], text.as_bytes()].concat())
}

/// A time packet: day 131, so many seconds after 20:05:00.
pub(crate) fn time_packet(sequence: u8, rtc: u64, second: u8) -> Vec<u8> {
    let bcd = |value: u8| ((value / 10) << 4) | (value % 10);
    packet(1, 0x11, sequence, rtc, &[1, 0, 0, 0, 0, bcd(second), 0x05, 0x20, 0x31, 0x01])
}

/// The setup of one PCM channel: every parameter a measurement of one word, in capitals, in the units given.
pub(crate) fn setup(channel: u16, format: &PcmFormat, storage: Storage, unit: impl Fn(&str) -> String) -> String {
    let spec = format.spec();
    let mut text = format!(
        "G\\PN:TEST;\r\nR-1\\TK1-1:1;R-1\\CDT-1:TIMEIN;R-1\\CDLN-1:TIME;\r\n\
         R-1\\TK1-2:{channel};R-1\\CDT-2:PCMIN;R-1\\CDLN-2:LINK;\
         R-1\\PDP-2:{};\r\nP-1\\DLN:LINK;P-1\\D1:NRZ-L;P-1\\D2:{};P-1\\D4:N;P-1\\D7:N;P-1\\F1:{};P-1\\F2:M;P-1\\F3:NO;\
         P-1\\MF\\N:{};P-1\\MF1:{};P-1\\MF2:{};P-1\\MF4:{};P-1\\MF5:{:b};\r\n",
        storage.in_setup(),
        spec.bit_rate,
        spec.word_bits,
        spec.minor_frames,
        spec.words,
        format.minor_frame_bits(),
        spec.sync.bits,
        spec.sync.pattern
    );
    if let Some(id) = &spec.subframe_id {
        let (word, bits, last) = (id.part.word, spec.word_bits, spec.minor_frames - 1);
        let _ = write!(
            text,
            "P-1\\ISF\\N:1;P-1\\ISF1-1:SFID;P-1\\ISF2-1:ID;P-1\\IDC1-1:{word};P-1\\IDC2-1:{bits};P-1\\IDC3-1:1;\
             P-1\\IDC4-1:{bits};\
             P-1\\IDC5-1:M;P-1\\IDC6-1:{};P-1\\IDC7-1:1;P-1\\IDC8-1:{last};P-1\\IDC9-1:{};P-1\\IDC10-1:INC;\r\n",
            id.first_value, spec.minor_frames
        );
    }
    let _ = write!(text, "D-1\\DLN:LINK;D-1\\ML\\N:1;D-1\\MN\\N-1:{};\r\n", spec.parameters.len());
    for (n, parameter) in (1..).zip(&spec.parameters) {
        let [place] = &parameter.places[..] else { panic!("one place for each parameter") };
        let [part] = &place.parts[..] else { panic!("one word for each parameter") };
        let (first, interval) = place.frames.map_or((1, 1), |frames| (frames.first, frames.interval.unwrap_or(0)));
        let name = parameter.name.to_ascii_uppercase();
        let Calibration::Polynomial { coefficients, .. } = &parameter.calibration else { panic!("a polynomial") };
        let coding = if parameter.encoding == RawEncoding::TwosComplement { "TWO" } else { "UNS" };
        let _ = write!(
            text,
            "D-1\\MN-1-{n}:{name};D-1\\LT-1-{n}:WDFR;D-1\\MML\\N-1-{n}:1;D-1\\MNF\\N-1-{n}-1:1;D-1\\WP-1-{n}-1-1:{};\
             D-1\\WI-1-{n}-1-1:0;D-1\\FP-1-{n}-1-1:{first};D-1\\FI-1-{n}-1-1:{interval};D-1\\WFM-1-{n}-1-1:FW;\
             D-1\\WFP-1-{n}-1-1:1;\
             C-{n}\\DCN:{name};C-{n}\\MN3:{};C-{n}\\BFM:{coding};C-{n}\\DCT:COE;C-{n}\\CO\\N:1;\
             C-{n}\\CO:{:e};C-{n}\\CO-1:{:e};\r\n",
            part.word,
            unit(&parameter.name).to_ascii_uppercase(),
            coefficients[0],
            coefficients[1]
        );
    }
    text
}

/// A measurement's unit as setups write it, for the SI unit of a channel.
pub(crate) fn in_setup_words(unit: &str) -> String {
    unit.replace("s^2", "s/s")
}

/// Packets of PCM data out of minor frames of whole bytes, with a sync pattern of 32 bits and words of 16.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorder {
    pub(crate) channel: u16,
    pub(crate) storage: Storage,
    /// Count of the first frame's first bit.
    pub(crate) first_rtc: u64,
    /// Counts that a minor frame lasts.
    pub(crate) frame_ticks: f64,
    /// Minor frames in a packet; in throughput mode the bits of so many, a third of a frame later.
    pub(crate) in_packet: usize,
}

impl Recorder {
    pub(crate) fn rtc(&self, frames: f64) -> u64 {
        self.first_rtc + (frames * self.frame_ticks).round() as u64
    }

    /// The packets, the first with that sequence number.
    pub(crate) fn packets(&self, frames: &[Vec<u8>]) -> Vec<Vec<u8>> {
        let word = self.storage.channel_word().to_le_bytes();
        let sequenced =
            |k: usize, rtc: u64, data: Vec<u8>| packet(self.channel, 0x09, k as u8, rtc, &[&word[..], &data].concat());
        if self.storage == Storage::Throughput {
            let (bits, frame) = (frames.concat(), frames[0].len());
            let first = frame / 3 / 2 * 2;
            let starts = std::iter::once(0).chain((first..bits.len()).step_by(self.in_packet * frame));
            let starts: Vec<usize> = starts.collect();
            let ends = starts[1..].iter().copied().chain([bits.len()]);
            let rtc = |byte: usize| self.rtc(byte as f64 / frame as f64);
            return starts
                .iter()
                .zip(ends)
                .enumerate()
                .map(|(k, (from, to))| sequenced(k, rtc(*from), stored(&bits[*from..to], 2)))
                .collect();
        }
        let packet_of = |(k, part): (usize, &[Vec<u8>])| {
            let mut data = Vec::new();
            for (index, frame) in part.iter().enumerate() {
                let rtc = self.rtc((k * self.in_packet + index) as f64);
                data.extend(&rtc.to_le_bytes()[..6]);
                data.extend([0, 0, 0, 0xF0]);
                data.resize(data.len() + self.storage.alignment() - 2, 0);
                data.extend(self.frame(frame));
            }
            sequenced(k, self.rtc((k * self.in_packet) as f64), data)
        };
        frames.chunks(self.in_packet).enumerate().map(packet_of).collect()
    }

    /// A frame as it is recorded.
    fn frame(&self, frame: &[u8]) -> Vec<u8> {
        match self.storage {
            Storage::UnpackedBy32 => {
                let cells = frame[4..].chunks(2).flat_map(|word| [word[0], word[1], 0, 0]);
                stored(&frame[..4].iter().copied().chain(cells).collect::<Vec<_>>(), 4)
            }
            // Cells of 16 bits hold words of 16 without filler.
            storage => stored(frame, storage.alignment()),
        }
    }
}

/// Bytes whose first bit came first, in little-endian words of 2 or 4 bytes.
fn stored(bytes: &[u8], alignment: usize) -> Vec<u8> {
    let mut padded = bytes.to_vec();
    padded.resize(bytes.len().next_multiple_of(alignment), 0);
    padded.chunks(alignment).flat_map(|word| word.iter().rev().copied().collect::<Vec<u8>>()).collect()
}

/// Datagrams of transfer header 1: each packet whole, or in segments where it is longer than so many bytes.
pub(crate) fn datagrams_1(packets: &[Vec<u8>], most: usize) -> Vec<Vec<u8>> {
    let mut datagrams = Vec::new();
    for packet in packets {
        let number = |kind: u32, sent: usize| ((sent as u32) << 8 | kind << 4 | 1).to_le_bytes();
        if packet.len() <= most {
            datagrams.push([&number(0, datagrams.len())[..], packet].concat());
            continue;
        }
        for (index, part) in packet.chunks(most).enumerate() {
            let offset = ((index * most) as u32).to_le_bytes();
            datagrams.push([&number(1, datagrams.len())[..], &packet[2..4], &[packet[13], 0], &offset, part].concat());
        }
    }
    datagrams
}

/// Datagrams of transfer header 3: the packets as a stream, in pieces of so many bytes.
pub(crate) fn datagrams_3(packets: &[Vec<u8>], piece: usize) -> Vec<Vec<u8>> {
    let stream = packets.concat();
    let datagram = |(number, part): (usize, &[u8])| [&[3, 0, 0, 0][..], &(number as u32).to_le_bytes(), part].concat();
    stream.chunks(piece).enumerate().map(datagram).collect()
}
