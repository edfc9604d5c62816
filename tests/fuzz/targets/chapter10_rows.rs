//! IRIG 106 Chapter 10: rows of channels out of packets, by the recording's own setup and by a format of frames.
//!
//! Promises: the same rows in any pieces, times that are numbers, no row without a sample.

use super::{Steps, pieces};
use sideslip::io::telemetry::chapter10::channel_choice::{ChosenChannel, FrameDescription};
use sideslip::io::telemetry::chapter10::channel_rows::ChannelRows;
use sideslip::io::telemetry::chapter10::header::PacketLimits;
use sideslip::io::telemetry::chapter10::packet::Chapter10Reader;
use sideslip::io::telemetry::chapter10::tmats::SetupRecord;
use sideslip::io::telemetry::record::RecordingRow;

/// Short frames, so that small inputs hold many.
const FRAMES: &str = "bit_rate = 100_000\nwords = 3\nword_bits = 8\nminor_frames = 2\n[sync]\npattern = 0xEB90\nbits = 16\n\
    [subframe_id]\nword = 1\n[[parameter]]\nname = \"p\"\nword = 2\n[[parameter]]\nname = \"x\"\nword = 2\nbits = [1, 4]\nframe = 2\n";

/// Reads every packet with each format that can be had; how many rows there were.
pub(super) fn rows(bytes: &[u8], limits: PacketLimits) -> usize {
    let mut setup = Vec::new();
    let mut reader = Chapter10Reader::new(limits);
    reader.take(bytes);
    while let Some(packet) = reader.finish() {
        setup.extend(SetupRecord::parse(&packet).map(|record| record.text.to_vec()).unwrap_or_default());
    }
    let fixed = FrameDescription::from_toml(FRAMES).unwrap().choose(&[]);
    let mut count = 0;
    for chosen in [fixed, FrameDescription::default().choose(&setup)].into_iter().flatten() {
        let whole = read(bytes, limits, &chosen, std::iter::once(bytes));
        let cut = read(bytes, limits, &chosen, pieces(bytes));
        assert!(whole == cut, "pieces change the rows: {} {}", whole.0, cut.0);
        count += whole.0;
    }
    count
}

/// How many rows, a sum over their numbers, and what was lost.
fn read<'a>(
    bytes: &[u8],
    limits: PacketLimits,
    chosen: &ChosenChannel,
    pieces: impl Iterator<Item = &'a [u8]>,
) -> (usize, u64, Vec<String>) {
    let Ok(mut rows) = ChannelRows::new(chosen) else { return (0, 0, Vec::new()) };
    let (mut count, mut sum, mut reader) = (0, 0_u64, Chapter10Reader::new(limits));
    // A bit is in one row at most.
    let mut steps = Steps::of(bytes, 8);
    let mut each = |row: &RecordingRow| {
        steps.one();
        count += 1;
        assert!(row.sample.time_s.is_finite() && row.number == count as u64);
        assert!(row.sample.present != 0 || row.others.iter().any(Option::is_some), "a row without a sample");
        sum = sum.rotate_left(5) ^ row.sample.time_s.to_bits();
    };
    for mut piece in pieces {
        while !piece.is_empty() {
            piece = &piece[reader.take(piece)..];
            while let Some(packet) = reader.next_packet() {
                rows.packet(&packet, 0.0, &mut each);
            }
        }
    }
    while let Some(packet) = reader.finish() {
        rows.packet(&packet, 0.0, &mut each);
    }
    rows.finish(&mut each);
    let lost = rows.shortfalls();
    (count, sum, lost)
}
