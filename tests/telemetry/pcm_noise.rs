//! Encoder to decoder through a noisy channel: lock, wrong words that pass undetected, bit slips.

use super::line::{Random, add_errors, format, sent, with_slips};
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::decommutator::SampleFlags;
use sideslip::io::telemetry::pcm::frame_sync::FrameSynchronizer;
use sideslip::io::telemetry::pcm::layout::PcmFormat;

struct Outcome {
    rate: f64,
    frames_sent: u64,
    decoder: PcmDecoder,
    words: u64,
    wrong: u64,
    /// Wrong and without any flag.
    undetected: u64,
    /// Subcommutated words under another parameter's name.
    misplaced: u64,
}

/// Sends that many minor frames through a channel with that bit-error rate.
fn through(format: &PcmFormat, rate: f64, frames: usize, seed: u64) -> Outcome {
    let mut random = Random(seed);
    let sent = sent(format, frames, seed % 2 == 1, &mut random);
    let mut line = sent.line.clone();
    add_errors(&mut line, rate, &mut random);
    let mut decoder = PcmDecoder::new(format, 0.0);
    let (mut words, mut wrong, mut undetected, mut misplaced) = (0, 0, 0, 0);
    let bit_rate = format.spec().bit_rate;
    let minor_frame_bits = format.minor_frame_bits() as u64;
    let mut check = |sample: sideslip::io::telemetry::pcm::decommutator::PcmSample| {
        // The word by its time alone.
        let bit = (sample.time_s * bit_rate).round() as u64;
        let (frame, word) = (bit / minor_frame_bits, (bit % minor_frame_bits - 48) / 16);
        let (parameter, raw) = sent.words[frame as usize * sent.words_per_frame + word as usize];
        words += 1;
        misplaced += u64::from(parameter != sample.parameter);
        let differs = raw != sample.raw || parameter != sample.parameter;
        wrong += u64::from(differs);
        undetected += u64::from(differs && sample.flags == SampleFlags::NONE);
    };
    for piece in line.chunks(1000) {
        decoder.feed(piece, &mut check);
    }
    decoder.finish(&mut check);
    Outcome { rate, frames_sent: frames as u64, decoder, words, wrong, undetected, misplaced }
}

fn report(name: &str, outcome: &Outcome) {
    let (sync, read) = (outcome.decoder.synchronizer.counters(), outcome.decoder.decommutator.counters());
    eprintln!(
        "{name} {:.0e}: frames {}/{} locks {} losses {} missed {} slips {} | words {} wrong {} undetected {} misplaced {} | parity {} withheld {} jumps {}",
        outcome.rate,
        sync.minor_frames,
        outcome.frames_sent,
        sync.locks,
        sync.losses,
        sync.missed_syncs,
        sync.slips,
        outcome.words,
        outcome.wrong,
        outcome.undetected,
        outcome.misplaced,
        read.parity_errors,
        read.withheld_frames,
        read.subframe_id.jumps,
    );
}

/// Probability that some of so many bits are wrong.
fn any_wrong(rate: f64, bits: i32) -> f64 {
    1.0 - (1.0 - rate).powi(bits)
}

fn near(found: u64, expected: f64) -> bool {
    (found as f64 - expected).abs() <= 5.0 * expected.sqrt() + 1.0
}

#[test]
fn lock_is_kept_to_one_wrong_bit_in_a_thousand_and_wrong_words_are_as_many_as_they_must_be() {
    let format = format("nrz_l", "none");
    for (rate, seed) in [(1e-6, 1), (1e-5, 2), (1e-4, 3), (1e-3, 4), (1e-2, 5)] {
        let outcome = through(&format, rate, 20_000, seed);
        report("NRZ-L", &outcome);
        let sync = outcome.decoder.synchronizer.counters();
        if rate <= 1e-3 {
            assert_eq!((sync.losses, sync.locks), (0, 1), "{rate:e}");
            assert!(sync.minor_frames >= outcome.frames_sent - 2, "{rate:e}: {}", sync.minor_frames);
        }
        assert!(sync.minor_frames as f64 > 0.999 * outcome.frames_sent as f64, "{rate:e}: {}", sync.minor_frames);
        assert!(near(outcome.wrong, outcome.words as f64 * any_wrong(rate, 16)), "{rate:e}: {} wrong", outcome.wrong);
        assert!(outcome.misplaced <= if rate <= 1e-3 { 0 } else { 3 }, "{rate:e}: {}", outcome.misplaced);
    }
}

#[test]
fn a_randomised_line_has_three_times_the_errors_and_keeps_lock_too() {
    let format = format("rnrz_l", "none");
    for (rate, seed) in [(1e-6, 11), (1e-5, 12), (1e-4, 13), (1e-3, 14), (1e-2, 15)] {
        let outcome = through(&format, rate, 20_000, seed);
        report("RNRZ-L", &outcome);
        let sync = outcome.decoder.synchronizer.counters();
        if rate <= 1e-3 {
            assert_eq!((sync.losses, sync.locks), (0, 1), "{rate:e}");
            // A word is wrong where one of its bits, or of the bits 14 and 15 before, is: 31 bits of the line, from which
            // those pairs that make each other good are very few.
            assert!(near(outcome.wrong, outcome.words as f64 * any_wrong(rate, 31)), "{rate:e}: {} wrong", outcome.wrong);
        }
        assert!(sync.minor_frames as f64 > 0.98 * outcome.frames_sent as f64, "{rate:e}: {}", sync.minor_frames);
        assert!(outcome.misplaced <= if rate <= 1e-3 { 0 } else { 3 }, "{rate:e}: {}", outcome.misplaced);
    }
}

#[test]
fn wrong_words_that_pass_undetected_at_1e_4_are_those_with_an_even_number_of_wrong_bits() {
    let frames = 40_000;
    let without = through(&format("nrz_l", "none"), 1e-4, frames, 21);
    report("no parity", &without);
    assert!(near(without.undetected, without.words as f64 * any_wrong(1e-4, 16)));
    for (rate, seed) in [(1e-4, 22), (1e-3, 23)] {
        let with = through(&format("nrz_l", "odd"), rate, frames, seed);
        report("parity", &with);
        // Two of sixteen bits, not both in the parity bit alone; higher even numbers are far rarer.
        let expected = with.words as f64 * 120.0 * rate * rate * (1.0 - rate).powi(14);
        assert!(near(with.undetected, expected), "{rate:e}: {} undetected, expected {expected:.1}", with.undetected);
        assert!(with.undetected < with.wrong / 50);
    }
}

#[test]
fn after_a_slip_minor_frames_are_found_again_within_three() {
    let format = format("nrz_l", "none");
    let length = format.minor_frame_bits();
    let frames = 6000;
    for (most, rate, seed) in [(2, 0.0, 31), (2, 1e-4, 32), (2, 1e-3, 33), (20, 0.0, 34), (20, 1e-4, 35)] {
        let mut random = Random(seed);
        let sent = sent(&format, frames, false, &mut random);
        let slips: Vec<(usize, i32)> = (1..frames / 30)
            .map(|k| {
                let by = 1 + random.below(most) as i32;
                (k * 30 * length + random.below(length), if random.below(2) == 0 { by } else { -by })
            })
            .collect();
        let mut line = with_slips(&sent.line, &slips);
        if rate > 0.0 {
            add_errors(&mut line, rate, &mut random);
        }
        let mut synchronizer = FrameSynchronizer::of_format(&format);
        let mut starts = Vec::new();
        let mut rest = line.as_slice();
        while !rest.is_empty() {
            rest = &rest[synchronizer.take(rest)..];
            while let Some(frame) = synchronizer.next_frame() {
                starts.push(frame.first_bit);
            }
        }
        while let Some(frame) = synchronizer.last_frame() {
            starts.push(frame.first_bit);
        }
        let mut worst = 0;
        let mut moved = 0_i64;
        for (place, by) in &slips {
            moved += i64::from(*by);
            let behind = place / length + 1;
            let found =
                (behind..behind + 10).find(|k| starts.binary_search(&((k * length) as i64 + moved).cast_unsigned()).is_ok());
            let frames = found.map_or(99, |k| k - behind + 1);
            worst = worst.max(frames);
        }
        let counters = synchronizer.counters();
        eprintln!(
            "slips to {most} bits at {rate:.0e}: {} made, {} seen, {} losses, found again at minor frame {worst} behind at worst; {} of {frames} handed out",
            slips.len(),
            counters.slips,
            counters.losses,
            counters.minor_frames,
        );
        assert!(worst <= 3, "{most} bits at {rate:e}: {worst}");
        if most <= 2 {
            assert!(counters.losses == 0 && counters.slips as usize >= slips.len() * 99 / 100);
        }
    }
}
