//! Fuzzing: every parser of outside bytes on the corpus, on its seeds, and on small changes of both.
//!
//! `targets` has what each parser promises; `corpus/TARGET` the seeds (made by [`seeds`]) and every input that found a
//! defect, by a name that says which. Here they are replayed; `libfuzzer.rs` runs the same targets for long, guided by
//! coverage (`src/guide/contributing.md` has the command).
//! `SIDESLIP_FUZZ_MUTATIONS=100000` makes the last test as long as that for each target; 300 otherwise.

mod mutation;
mod seeds;
mod targets;

use mutation::Mutator;
use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use targets::{TARGETS, Target};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus")
}

/// Names and contents of the files of a target.
fn inputs(target: &Target) -> Vec<(String, Vec<u8>)> {
    let folder = corpus().join(target.name);
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap())).collect()
}

#[test]
fn the_corpus_is_read_without_a_broken_promise() {
    let mut total = 0;
    for target in &TARGETS {
        for (name, bytes) in inputs(target) {
            total += bytes.len();
            let outcome = catch_unwind(AssertUnwindSafe(|| target.run(&bytes)));
            let Ok(reading) = outcome else { panic!("corpus/{}/{name} breaks a promise", target.name) };
            assert!(reading.things > 0 || !name.starts_with("seed-"), "nothing is read in corpus/{}/{name}", target.name);
        }
    }
    assert!(total < 300_000, "the corpus has {total} bytes");
}

#[test]
fn the_seeds_in_the_corpus_are_those_that_the_encoders_make() {
    let mut covered = BTreeSet::new();
    for (target, name, bytes) in seeds::seeds() {
        covered.insert(target);
        let path = corpus().join(target).join(format!("seed-{name}"));
        if std::env::var_os("SIDESLIP_FUZZ_RENEW").is_some() {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, &bytes).unwrap();
        }
        let found = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(found == bytes, "{} is not what the encoders make; SIDESLIP_FUZZ_RENEW=1 writes it anew", path.display());
    }
    assert!(TARGETS.iter().all(|target| covered.contains(target.name)), "a target without a seed");
    let named = |target: &Target| fs::read_dir(corpus().join(target.name)).unwrap().count();
    assert_eq!(fs::read_dir(corpus()).unwrap().count(), TARGETS.len(), "a folder without a target");
    assert!(TARGETS.iter().all(|target| named(target) > 0));
}

#[test]
fn changed_seeds_are_read_without_a_broken_promise() {
    let times = std::env::var("SIDESLIP_FUZZ_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(300);
    for target in &TARGETS {
        let inputs: Vec<Vec<u8>> = inputs(target).into_iter().map(|(_, bytes)| bytes).collect();
        let (mut mutator, mut most) = (Mutator::new(17), 0);
        for turn in 0..times {
            let bytes = mutator.change(&inputs);
            let outcome = catch_unwind(AssertUnwindSafe(|| target.run(&bytes)));
            let reading = outcome.unwrap_or_else(|_| {
                let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{}-{turn}", target.name));
                fs::write(&path, &bytes).unwrap();
                panic!("{}: change {turn} breaks a promise; the input is {}", target.name, path.display())
            });
            most = most.max(reading.held);
        }
        eprintln!("{}: {times} changes of {} inputs, at most {most} bytes held", target.name, inputs.len());
    }
}
