//! One bad run among good ones: its error is told of it and of no other.
//!
//! A whole study: `SIDESLIP_SEEDS=5 cargo nextest run --release --test slow --run-ignored all --no-capture -E 'test(check::odd)'`

use super::flown::{SORTIE, candidate, own_biases, sortie};
use super::score::score;
use crate::support::asked::{is_study, seeds};
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::channel::Channel::{Beta, Phi, R, Theta};
use sideslip::flight::effect::Effect;
use sideslip::io::outputs::words::instrument_words::verdict_reason;
use sideslip::postflight::reconstruction::verdict::check;
use sideslip::postflight::recorded_run::RecordedRun;

#[test]
#[ignore = "a study"]
fn one_bad_run_is_told_from_the_others() {
    let cases = [
        (0, Effect::SensorScale { channel: R, factor: 1.15 }),
        (0, Effect::SensorScale { channel: Beta, factor: 1.15 }),
        (1, Effect::SensorDelay { channel: Phi, delay: 0.12 }),
        (2, Effect::SensorDelay { channel: Theta, delay: 0.12 }),
    ];
    // Two of them where not the whole study is asked for.
    let whole = is_study();
    let cases = if whole { &cases[..] } else { &cases[1..3] };
    let runs = sortie();
    let each = seeds(1);
    let said = over_seeds(each * cases.len() as u64, |number| {
        let (bad, error) = cases[(number / each) as usize];
        let flown: Vec<RecordedRun> = runs
            .iter()
            .zip(SORTIE)
            .enumerate()
            .map(|(place, (run, input))| {
                let (mut run, seed) = (run.clone(), 10 * (60_000 + number) + place as u64);
                own_biases(&mut run, seed);
                let errors: &[Effect] = if place == bad { &[error] } else { &[] };
                candidate(input, &run, errors, seed)
            })
            .collect();
        let verdicts = check(&flown);
        let others =
            verdicts.iter().enumerate().filter(|(place, verdict)| *place != bad && !verdict.corrections.is_empty()).count();
        let one = score(&verdicts[bad], &[error]);
        eprintln!("{error:?}: {}; {others} other runs blamed; {}", one.line(), verdict_reason(&verdicts[bad].reason));
        (one.named + one.among_rivals, one.sized, others)
    });
    let sum = said.iter().fold((0, 0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1, sum.2 + one.2));
    let count = said.len();
    eprintln!("{count} sorties: {} named, {} sized, {} healthy runs blamed", sum.0, sum.1, sum.2);
    assert!(sum.0 * 20 >= 19 * said.len() && sum.1 * 20 >= 19 * said.len() && sum.2 == 0);
}
