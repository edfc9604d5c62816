//! How often random bits lead to lock: counted, and beside it the rate of the formula.

use super::line::Random;
use sideslip::io::telemetry::pcm::bits::LineCode;
use sideslip::io::telemetry::pcm::frame_sync::{FrameSynchronizer, SyncCounters};
use sideslip::io::telemetry::pcm::sync_pattern::{PolarityRule, SyncPattern, SyncRules};

const LENGTH: usize = 544;
/// So tolerant that it happens.
const TOLERANT: SyncRules =
    SyncRules { search_errors: 2, check_errors: 2, lock_errors: 0, check_frames: 1, flywheel_frames: 0, slip_bits: 0 };

fn counted(sync: SyncPattern, rules: SyncRules, bits: usize, seed: u64) -> SyncCounters {
    let mut synchronizer = FrameSynchronizer::new(sync, rules, PolarityRule::Automatic, LineCode::NrzL, LENGTH);
    let mut random = Random(seed);
    for _ in 0..bits / 64 {
        let bytes = random.next().to_be_bytes();
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            rest = &rest[synchronizer.take(rest)..];
            while synchronizer.next_frame().is_some() {}
        }
    }
    synchronizer.counters()
}

fn near(found: u64, expected: f64) -> bool {
    (found as f64 - expected).abs() <= 4.0 * expected.sqrt() + 1.0
}

fn compared(bits: usize) {
    let long = SyncPattern::whole(0xFE6B_2840, 32);
    let rules = SyncRules::for_length(32);
    let counters = counted(long, rules, bits, 41);
    let rate = long.false_lock_rate(&rules, PolarityRule::Automatic);
    let candidates = 2.0 * long.random_match(rules.search_errors) * bits as f64;
    eprintln!(
        "32 bits, default rules, {bits} random bits: {} candidates (formula {candidates:.2}), {} locks (formula {rate:.1e} a bit)",
        counters.candidates, counters.locks
    );
    assert!(counters.locks == 0 && near(counters.candidates, candidates) && rate <= 1e-9);
    for (pattern, length, seed) in [(0xEB90, 16, 42), (0x2_F684, 18, 43)] {
        let short = SyncPattern::whole(pattern, length);
        let default = SyncRules::for_length(length);
        let counters = counted(short, default, bits, seed);
        let rate = short.false_lock_rate(&default, PolarityRule::Automatic);
        eprintln!("{length} bits, default rules: {} locks (formula {rate:.1e} a bit)", counters.locks);
        assert!(counters.locks == 0 && rate <= 1e-9);
        let counters = counted(short, TOLERANT, bits, seed);
        let expected = short.false_lock_rate(&TOLERANT, PolarityRule::Automatic) * bits as f64;
        eprintln!("{length} bits, tolerant rules: {} locks (formula {expected:.1})", counters.locks);
        assert!(near(counters.locks, expected), "{} locks, expected {expected:.1}", counters.locks);
    }
}

#[test]
fn random_bits_lock_as_often_as_the_formula_says() {
    compared(10_000_000);
}

#[test]
#[ignore = "a study"]
fn the_same_of_1e8_bits() {
    compared(100_000_000);
}

#[test]
fn a_pseudorandom_sequence_never_locks() {
    // x^15 + x^14 + 1 from every start: ten periods.
    let mut register = 1_u32;
    let mut byte = || {
        (0..8).fold(0_u8, |byte, _| {
            let bit = (register >> 13 ^ register >> 14) & 1;
            register = register << 1 | bit;
            byte << 1 | bit as u8
        })
    };
    let bytes: Vec<u8> = (0..41_000).map(|_| byte()).collect();
    for (pattern, bits, length) in [(0xFE6B_2840, 32, 512), (0xFE6B_2840, 32, 4096), (0xEB90, 16, 88)] {
        let sync = SyncPattern::whole(pattern, bits);
        let rules = SyncRules::for_length(bits);
        let mut synchronizer = FrameSynchronizer::new(sync, rules, PolarityRule::Automatic, LineCode::NrzL, length);
        let mut rest = bytes.as_slice();
        while !rest.is_empty() {
            rest = &rest[synchronizer.take(rest)..];
            assert!(synchronizer.next_frame().is_none());
        }
        assert_eq!(synchronizer.counters().locks, 0);
    }
}
