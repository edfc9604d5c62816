//! Golden: recorded runs of the program's commands, every record and number compared bit for bit, the words separately.
//!
//! Each case runs the program as a user runs it, on the bundled recording, bundled models and flights that it simulates itself
//! with fixed seeds. What the program answers is written as two texts and compared with `expected/NAME.numbers.txt` and
//! `expected/NAME.words.txt`:
//! - numbers: exit status, numbers, truth values and names (strings without white space), records of logs, rows of tables,
//!   geometry of drawings. Of long series, and of documents that would be too long, a SHA-256 over all of it and every Nth entry.
//! - words: standard output and standard error verbatim, and every string with white space.
//!
//! There is no tolerance. Only the program is driven, nothing of the library is imported, so that the expectations outlive a
//! rearrangement of the code.
//!
//! Environment: `SIDESLIP_GOLDEN=numbers` (or `words`) compares that kind only. `SIDESLIP_PROGRAM=PATH` runs another build, such
//! as a release build or that of an earlier revision. `SIDESLIP_RENEW=numbers`, `words` or `numbers,words` writes the expected
//! files anew, by hand only. To renew numbers is legitimate where a change of the method is intended and the difference has been
//! explained; in a change that only moves, renames or merges code it never is. To renew words is legitimate where the wording is
//! what was to change, after the difference has been read.

mod case;
mod compare;
mod digest;
mod document;
mod drawing;
mod expected;
mod flights;
mod log;
mod table;

mod comparisons;
mod diagnoses;
mod identifications;
mod instruments;
mod lives;
mod recordings;
mod replays;
mod simulations;
mod vehicle;

/// One test for each case, and the list of their names.
macro_rules! cases {
    ($($name:ident: $run:path,)+) => {
        const CASES: &[&str] = &[$(stringify!($name)),+];
        $(#[test]
        fn $name() {
            case::verify(stringify!($name), $run);
        })+
    };
}

cases! {
    replay: replays::bundled,
    replay_streaming: replays::streaming,
    replay_with_model: replays::with_model,
    replay_bus: replays::through_shared_memory,
    replay_mavlink: replays::mavlink,
    simulate_linear: simulations::linear,
    simulate_level1: simulations::level1,
    linearise: simulations::linearise,
    design: simulations::design,
    inspect: simulations::inspect,
    check: instruments::check,
    identify: identifications::helicopter,
    identify_lateral: identifications::lateral,
    identify_stepwise: identifications::stepwise,
    identify_frequency: identifications::frequency,
    identify_points: identifications::test_points,
    identify_sideslips: identifications::steady_sideslips,
    compare: comparisons::compare,
    diagnose: diagnoses::linear,
    diagnose_level1: diagnoses::level1,
    live_link: lives::link,
    live_file: lives::file,
    recordings_checked: recordings::checked,
    recordings_estimated: recordings::estimated,
}

#[test]
fn every_expected_file_belongs_to_a_case() {
    expected::complete(CASES);
}
