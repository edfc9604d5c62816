//! The benchmark's own book: durations as criterion measured them, and the ratios between partners.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, SamplingMode, Throughput};
use std::cell::RefCell;
use std::time::{Duration, Instant};

/// A piece and what was measured of it.
struct Entry {
    name: String,
    /// Iterations and the time that they took, each call of criterion.
    calls: Vec<(u64, Duration)>,
}

/// Which piece is compared with which, and what is to be said of it.
struct Comparison {
    ours: String,
    theirs: String,
    /// How many of ours one of theirs is.
    parts: f64,
    remark: &'static str,
}

/// A piece without a partner: how many of what it is one of, and what is asked of it.
struct Alone {
    ours: String,
    parts: f64,
    remark: &'static str,
}

/// Durations, comparisons, and pieces that stand alone.
#[derive(Default)]
pub(crate) struct Ledger {
    entries: RefCell<Vec<Entry>>,
    comparisons: RefCell<Vec<Comparison>>,
    alone: RefCell<Vec<Alone>>,
    notes: RefCell<Vec<String>>,
}

/// A group of pieces in flat sampling: every sample is the same number of iterations.
pub(crate) fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.sampling_mode(SamplingMode::Flat).throughput(Throughput::Elements(1));
    group
}

impl Ledger {
    /// Times `step` alone.
    pub(crate) fn bench(&self, group: &mut BenchmarkGroup<WallTime>, name: &str, mut step: impl FnMut()) {
        self.bench_prepared(group, name, |iterations| {
            let begin = Instant::now();
            for _ in 0..iterations {
                step();
            }
            begin.elapsed()
        });
    }

    /// Keeps what `timed` says that so many iterations took.
    pub(crate) fn bench_prepared(
        &self,
        group: &mut BenchmarkGroup<WallTime>,
        name: &str,
        mut timed: impl FnMut(u64) -> Duration,
    ) {
        let mut calls = Vec::new();
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|iterations| {
                let took = timed(iterations);
                calls.push((iterations, took));
                took
            });
        });
        self.entries.borrow_mut().push(Entry { name: name.to_owned(), calls });
    }

    /// Notes that `ours` is to be compared with `theirs`.
    pub(crate) fn compare(&self, ours: &str, theirs: &str, remark: &'static str) {
        self.compare_part(ours, theirs, 1.0, remark);
    }

    /// Notes that `ours` is to be compared with the time of `theirs` over `parts`.
    pub(crate) fn compare_part(&self, ours: &str, theirs: &str, parts: f64, remark: &'static str) {
        let comparison = Comparison { ours: ours.to_owned(), theirs: theirs.to_owned(), parts, remark };
        self.comparisons.borrow_mut().push(comparison);
    }

    /// Something to be said at the end.
    pub(crate) fn note(&self, note: String) {
        self.notes.borrow_mut().push(note);
    }

    /// Notes that the time of `ours` over `parts` is to be told.
    pub(crate) fn tell(&self, ours: &str, parts: f64, remark: &'static str) {
        self.alone.borrow_mut().push(Alone { ours: ours.to_owned(), parts, remark });
    }

    /// Quartiles of the time an iteration, ns; `None` where the piece was not run.
    fn quartiles(&self, name: &str) -> Option<[f64; 3]> {
        let entries = self.entries.borrow();
        let calls = &entries.iter().find(|entry| entry.name == name)?.calls;
        // The measured samples are the last calls, all with the same number of iterations; the rest was warming up.
        let (iterations, _) = *calls.last()?;
        let mut times: Vec<f64> =
            calls.iter().filter(|(n, _)| *n == iterations).map(|(n, took)| took.as_secs_f64() * 1e9 / *n as f64).collect();
        times.sort_by(f64::total_cmp);
        let at = |part: usize| times[(times.len() - 1) * part / 4];
        Some([at(1), at(2), at(3)])
    }

    /// The tables of ratios and of pieces alone.
    pub(crate) fn print(&self) {
        println!("\nours/theirs, medians of this run (quartiles in brackets, ns):");
        for Comparison { ours, theirs, parts, remark } in self.comparisons.borrow().iter() {
            let (Some(a), Some(b)) = (self.quartiles(ours), self.quartiles(theirs)) else { continue };
            let b = b.map(|time| time / parts);
            println!("  {:6.3}  {ours} {} / {theirs} {}{remark}", a[1] / b[1], written(a), written(b));
        }
        println!("\nalone, medians of this run (quartiles in brackets, ns):");
        for Alone { ours, parts, remark } in self.alone.borrow().iter() {
            let Some(times) = self.quartiles(ours) else { continue };
            println!("  {ours} {}{remark}", written(times.map(|time| time / parts)));
        }
        for note in self.notes.borrow().iter() {
            println!("  {note}");
        }
    }
}

fn written([low, median, high]: [f64; 3]) -> String {
    format!("{median:.0} [{low:.0} {high:.0}]")
}
