//! The format of a recording, recognised by its first bytes and not by its name.
//!
//! Consumes the head of a file; produces a [`RecordingFormat`]. Text is taken for a run file; the run file's own reader says what
//! is wrong with it. Signatures are those that each format's own specification gives.

/// How many bytes of a file decide; two MAVLink records of any size fit in.
pub const HEAD_BYTES: usize = 4096;

/// The kind of a file, by content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordingFormat {
    /// A run file in text.
    Csv,
    /// An MCAP log.
    Mcap,
    /// MAVLink frames, each behind a time stamp: a tlog.
    Tlog,
    /// MAVLink frames one after the other.
    Mavlink,
    /// A log of ArduPilot.
    Dataflash,
    /// A log of PX4.
    Ulog,
    /// Packets after IRIG 106 Chapter 10.
    Chapter10,
    /// Something else that has a name.
    Named(&'static str),
    /// Nothing at all.
    Empty,
    /// Bytes of no known kind; the first of them.
    Unknown(Vec<u8>),
}

/// Formats with a fixed signature at the start.
const SIGNATURES: [(&[u8], &str); 9] = [
    (b"PAR1", "a Parquet file"),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 or MATLAB 7.3 file"),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file"),
    (b"#ROSBAG", "a ROS bag"),
    (b"SQLite format 3\0", "an SQLite database"),
    (b"PK\x03\x04", "a zip archive (a spreadsheet?)"),
    (&[0x1F, 0x8B], "a gzip archive"),
    (&[0x28, 0xB5, 0x2F, 0xFD], "a zstd archive"),
    (&[0xFF, 0xFE], "UTF-16 text (UTF-8 is expected)"),
];

const MCAP_MAGIC: &[u8] = b"\x89MCAP0\r\n";
const CHAPTER10_MAGIC: &[u8] = &[0x25, 0xEB];
const ULOG_MAGIC: &[u8] = &[0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35];
const DATAFLASH_MAGIC: &[u8] = &[0xA3, 0x95];

impl RecordingFormat {
    /// In words.
    pub fn words(&self) -> &'static str {
        match self {
            RecordingFormat::Csv => "text",
            RecordingFormat::Mcap => "an MCAP log",
            RecordingFormat::Tlog | RecordingFormat::Mavlink => "messages of MAVLink",
            RecordingFormat::Dataflash => "a log of ArduPilot",
            RecordingFormat::Ulog => "a log of PX4",
            RecordingFormat::Chapter10 => "packets after IRIG 106 Chapter 10",
            RecordingFormat::Named(name) => name,
            RecordingFormat::Empty => "an empty file",
            RecordingFormat::Unknown(_) => "no known format",
        }
    }

    /// Tells the format by the first bytes, at best [`HEAD_BYTES`] of them.
    pub fn of(head: &[u8]) -> RecordingFormat {
        if head.is_empty() {
            return RecordingFormat::Empty;
        }
        if head.starts_with(MCAP_MAGIC) {
            return RecordingFormat::Mcap;
        }
        for (signature, format) in [
            (CHAPTER10_MAGIC, RecordingFormat::Chapter10),
            (ULOG_MAGIC, RecordingFormat::Ulog),
            (DATAFLASH_MAGIC, RecordingFormat::Dataflash),
        ] {
            if head.starts_with(signature) {
                return format;
            }
        }
        if let Some((_, name)) = SIGNATURES.iter().find(|(signature, _)| head.starts_with(signature)) {
            return RecordingFormat::Named(name);
        }
        if is_tlog(head) {
            return RecordingFormat::Tlog;
        }
        if mavlink_frame(head).is_some() {
            return RecordingFormat::Mavlink;
        }
        let magic_cut_short = MCAP_MAGIC.starts_with(head);
        if !magic_cut_short && head.iter().all(|&byte| byte >= b' ' || matches!(byte, b'\t' | b'\r' | b'\n' | 0x0C)) {
            return RecordingFormat::Csv;
        }
        RecordingFormat::Unknown(head.iter().take(8).copied().collect())
    }
}

/// Length of the MAVLink frame at the start, where a whole one stands there and another follows, or it ends the bytes.
fn mavlink_frame(bytes: &[u8]) -> Option<usize> {
    let payload = usize::from(*bytes.get(1)?);
    let length = match *bytes.first()? {
        0xFE => payload + 8,
        0xFD if bytes.get(2)? & 1 != 0 => payload + 25,
        0xFD => payload + 12,
        _ => return None,
    };
    match bytes.get(length..)? {
        [] | [0xFD | 0xFE, ..] => Some(length),
        _ => None,
    }
}

/// Two records of eight bytes of microseconds (before the year 2100, so the first is zero) and a frame, or one and the end.
fn is_tlog(head: &[u8]) -> bool {
    let record = |bytes: &[u8]| -> Option<usize> {
        let (stamp, frame) = bytes.split_first_chunk::<8>()?;
        if u64::from_be_bytes(*stamp) >> 52 != 0 {
            return None;
        }
        let payload = usize::from(*frame.get(1)?);
        match *frame.first()? {
            0xFE => Some(payload + 16),
            0xFD if frame.get(2)? & 1 != 0 => Some(payload + 33),
            0xFD => Some(payload + 20),
            _ => None,
        }
    };
    let Some(second) = record(head).and_then(|length| head.get(length..)) else { return false };
    second.is_empty() || record(second).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_format_is_told_by_its_first_bytes() {
        assert_eq!(RecordingFormat::of(b""), RecordingFormat::Empty);
        assert_eq!(RecordingFormat::of(b"\x89MCAP0\r\n\x01"), RecordingFormat::Mcap);
        assert_eq!(RecordingFormat::of(b"\xEF\xBB\xBFtime,p\r\n0,1"), RecordingFormat::Csv);
        assert_eq!(RecordingFormat::of("# aircraft = \"Übung\"\ntime".as_bytes()), RecordingFormat::Csv);
        assert_eq!(RecordingFormat::of(&[0x25, 0xEB, 0, 0]), RecordingFormat::Chapter10);
        assert_eq!(RecordingFormat::of(&[0xA3, 0x95, 0x80]), RecordingFormat::Dataflash);
        assert_eq!(RecordingFormat::of(b"\x7fELF\x02\x01"), RecordingFormat::Unknown(b"\x7fELF\x02\x01".to_vec()));
        assert_eq!(RecordingFormat::of(b"\x89MCA"), RecordingFormat::Unknown(b"\x89MCA".to_vec()));
        // MAVLink 1 heartbeat: 9 bytes of payload, 17 in all, behind a stamp of the year 2015.
        let mut frame = vec![0xFE, 9, 0, 1, 1, 0];
        frame.extend([0; 11]);
        assert_eq!(RecordingFormat::of(&frame.repeat(2)), RecordingFormat::Mavlink);
        let mut record = 1_420_070_400_000_000_u64.to_be_bytes().to_vec();
        record.extend(&frame);
        assert_eq!(RecordingFormat::of(&record.repeat(2)), RecordingFormat::Tlog);
        assert_eq!(RecordingFormat::of(&record), RecordingFormat::Tlog);
    }
}
