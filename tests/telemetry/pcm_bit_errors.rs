//! One wrong bit in ten thousand on the PCM link of a simulated flight: what it does to the derivatives.
//!
//! Each flight is sent without errors and with them, in frames whose words have no guard, limits, limits with a largest step, or
//! a parity bit. Counted are the wrong words that pass undetected, and compared the derivatives with those of the same frames
//! without errors, in standard errors of these. CI takes 2 flights, the slow tests 12. The long form:
//! `SIDESLIP_SEEDS=100 cargo nextest run --release --test slow --no-capture -E 'test(pcm_bit_errors)'`

use super::derivatives::{Apart, apart, derivatives};
use super::line::{Random, add_errors};
use super::pcm_link::{Guard, flown, format, received, sent};
use crate::support::asked::seeds;
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;

const RATE: f64 = 1e-4;

struct Outcome {
    apart: Apart,
    words: u64,
    undetected: u64,
    left_out: u64,
}

/// Values of the rows, by their time, that differ from those sent: those that nothing told.
fn wrong(clean: &[Sample], noisy: &[Sample]) -> u64 {
    let mut clean = clean.iter().peekable();
    let mut wrong = 0;
    for sample in noisy {
        while clean.next_if(|right| right.time_s < sample.time_s - 1e-3).is_some() {}
        let Some(right) = clean.peek() else { break };
        let differs = |channel: &Channel| sample.get(*channel).is_some_and(|value| right.get(*channel) != Some(value));
        wrong += Channel::ALL.iter().filter(|channel| differs(channel)).count() as u64;
    }
    wrong
}

fn flight(guard: Guard, seed: u64) -> Outcome {
    let (format, samples) = (format(guard), flown(seed));
    let mut line = sent(&format, &samples);
    let clean = received(&format, &line);
    assert_eq!(clean.unused.words(), None);
    add_errors(&mut line, RATE, &mut Random(seed));
    let noisy = received(&format, &line);
    assert_eq!(noisy.decoder.synchronizer.counters().losses, 0);
    let unused = noisy.unused;
    Outcome {
        apart: apart(&derivatives(&clean.samples), &derivatives(&noisy.samples)),
        words: noisy.decoder.decommutator.counters().samples,
        undetected: wrong(&clean.samples, &noisy.samples),
        left_out: unused.parity + unused.doubtful_frame + unused.out_of_limits + unused.beyond_step + unused.no_value,
    }
}

/// The largest difference of all flights, and what was found in them.
fn flights(guard: Guard, seeds: u64) -> (f64, u64, u64, u64) {
    let outcomes = over_seeds(seeds, |seed| flight(guard, 100 + seed));
    let mut all = (0.0_f64, 0, 0, 0);
    for (seed, found) in outcomes.iter().enumerate() {
        eprintln!(
            "{guard:?}, seed {seed}: {:.2} standard errors ({}), errors times {:.3}, {} undetected, {} left out of {}; {:?}",
            found.apart.largest,
            found.apart.whose,
            found.apart.std_ratio,
            found.undetected,
            found.left_out,
            found.words,
            found.apart.different,
        );
        all = (all.0.max(found.apart.largest), all.1 + found.words, all.2 + found.undetected, all.3 + found.left_out);
    }
    eprintln!("{guard:?}: largest {:.2}; of {} words {} wrong and undetected, {} left out", all.0, all.1, all.2, all.3);
    all
}

/// Flights of each kind: more where studies run.
fn count() -> u64 {
    seeds(if module_path!().starts_with("slow") { 12 } else { 2 })
}

#[test]
fn with_parity_or_a_largest_step_derivatives_stand_one_wrong_bit_in_ten_thousand() {
    let (largest, words, undetected, left_out) = flights(Guard::Parity, count());
    // Two wrong bits of sixteen pass.
    let expected = words as f64 * 120.0 * RATE * RATE;
    assert!(largest < 0.5, "parity: {largest}");
    assert!(undetected as f64 <= expected + 5.0 * expected.sqrt() + 1.0 && left_out > words / 1000, "parity: {undetected}");
    let (largest, words, undetected, _) = flights(Guard::Steps, count());
    assert!(largest < 0.5, "largest steps: {largest}");
    // The others changed a value by less than its step.
    assert!(undetected < words / 800, "largest steps: {undetected}");
}

#[test]
fn without_a_guard_they_do_not_and_limits_are_not_enough() {
    for guard in [Guard::None, Guard::Limits] {
        let (largest, words, undetected, _) = flights(guard, count());
        assert!(largest > 0.5, "{guard:?}: {largest}");
        // Nearly each wrong word passes: sixteen bits.
        let expected = words as f64 * 16.0 * RATE;
        assert!(undetected as f64 > 0.7 * expected && (undetected as f64) < 1.3 * expected, "{guard:?}: {undetected}");
    }
}
