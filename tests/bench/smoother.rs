//! One sample of filter and fixed-lag smoother: ours beside Rauch-Tung-Striebel over the last half second, in plain nalgebra
//! and by the crate `adskalman`.
//!
//! Ours tells a state of half a second ago with its variances every 0.08 s. Theirs can do that by smoothing the window of the
//! lag anew each time; the other reading, the most favourable to them, is one sample's part of a whole record smoothed once.

use crate::FAST_HZ;
use crate::filter::{DT, Ours, round, start};
use crate::ledger::{Ledger, group};
use crate::peer::{Estimate, Peer};
use crate::textbook::{Readings, Step, Textbook, smooth};
use criterion::Criterion;

use sideslip::realtime::estimation::fixed_lag::{FixedLag, SmoothedPoint};
use sideslip::realtime::estimation::process::MOVING;
use std::collections::VecDeque;
use std::hint::black_box;

const LAG_S: f64 = 0.5;
const SPACING_S: f64 = 0.08;
/// Samples from a smoothed instant to the newest, and from one instant to the next.
const WINDOW: usize = (LAG_S * FAST_HZ) as usize;
const EVERY: usize = 21;
/// A whole record for the favourable reading: 4 s.
const RECORD: usize = 1024;

/// Ours.
#[derive(Clone)]
struct Lagged {
    filter: Ours,
    smoother: FixedLag,
    sample: usize,
}

impl Lagged {
    fn step(&mut self, z: &Readings) -> Option<SmoothedPoint> {
        self.sample += 1;
        self.filter.step(z, &mut self.smoother);
        self.smoother.tick(self.sample as f64 * DT, &self.filter.ekf)
    }
}

/// The textbook's filter with its last half second.
#[derive(Clone)]
struct Window {
    filter: Textbook,
    steps: VecDeque<Step>,
    sample: usize,
}

impl Window {
    fn step(&mut self, z: &Readings) {
        if self.steps.len() > WINDOW {
            self.steps.pop_front();
        }
        self.steps.push_back(self.filter.step(z, DT));
        self.sample += 1;
        if self.sample.is_multiple_of(EVERY) {
            assert!(smooth(self.steps.iter(), |smoothed| {
                black_box(smoothed);
            }));
        }
    }
}

/// The crate's filter with its last half second.
#[derive(Clone)]
struct PeerWindow {
    estimates: VecDeque<Estimate>,
    sample: usize,
}

impl PeerWindow {
    fn step(&mut self, peer: &Peer, z: &Readings) {
        let last = self.estimates.back().unwrap_or(&peer.start);
        let estimate = peer.filter().step(last, &(z - peer.reading)).unwrap();
        if self.estimates.len() > WINDOW {
            self.estimates.pop_front();
        }
        self.estimates.push_back(estimate);
        self.sample += 1;
        if self.sample.is_multiple_of(EVERY) {
            let window = self.estimates.iter().cloned().collect();
            black_box(peer.filter().smooth_from_filtered(window).unwrap());
        }
    }
}

/// Ours against the textbook's smoother over the same window, at every instant that comes of age; the crate's against the
/// textbook's over a record of its own.
fn agree(ticks: &[Readings]) {
    let (filter, textbook) = start(ticks, 0.0);
    let mut ours = Box::new(Lagged { filter, smoother: FixedLag::new(LAG_S, SPACING_S), sample: 0 });
    let mut theirs = textbook.clone();
    let mut steps: Vec<Step> = Vec::new();
    let mut compared = 0;
    for z in &ticks[1..RECORD] {
        let point = ours.step(z);
        steps.push(theirs.step(z, DT));
        let Some(point) = point else { continue };
        let at = (point.time_s / DT).round() as usize - 1;
        assert!((WINDOW..WINDOW + 2).contains(&(steps.len() - 1 - at)), "{at} of {}", steps.len());
        let mut last = None;
        assert!(smooth(steps[at..].iter(), |smoothed| last = Some(*smoothed)));
        let (x, p) = last.unwrap();
        for i in 0..MOVING {
            let std = p[(i, i)].sqrt();
            let (state, spread) = ((point.x[i] - x[i]).abs() / std, (point.var[i].sqrt() / std - 1.0).abs());
            assert!(state < 1e-5 && spread < 1e-5, "state {i}: {state} standard errors apart, spread {spread}");
        }
        compared += 1;
    }
    assert!(compared > 30, "{compared}");

    let peer = Peer::about(&textbook, DT);
    let (f, _, q) = peer.matrices();
    let mut filtered = vec![peer.start.clone()];
    for z in &ticks[1..WINDOW] {
        filtered.push(peer.filter().step(&filtered[filtered.len() - 1], &(z - peer.reading)).unwrap());
    }
    let mut steps: Vec<Step> = Vec::new();
    for pair in filtered.windows(2) {
        let predicted = (f * pair[0].state(), f * pair[0].covariance() * f.transpose() + q);
        steps.push(Step { transition: *f, predicted, filtered: (*pair[1].state(), *pair[1].covariance()) });
    }
    let found = peer.filter().smooth_from_filtered(filtered).unwrap();
    let mut back = found.iter().rev();
    assert!(smooth(steps.iter(), |(x, p)| {
        let found = back.next().unwrap();
        for i in 0..MOVING {
            let std = p[(i, i)].sqrt();
            assert!((found.state()[i] - x[i]).abs() < 1e-4 * std, "the crate's state {i}");
            assert!((found.covariance()[(i, i)].sqrt() / std - 1.0).abs() < 1e-4, "the crate's spread of state {i}");
        }
    }));
}

/// Runs the group.
pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger, ticks: &[Readings]) {
    agree(ticks);
    let (filter, textbook) = start(ticks, 1.0);
    let peer = Peer::about(&textbook, DT);
    let mut group = group(criterion, "fixed lag");
    let ours = Box::new(Lagged { filter: filter.clone(), smoother: FixedLag::new(LAG_S, SPACING_S), sample: 0 });
    ledger.bench(
        &mut group,
        "lag: ours with its filter",
        round(ticks, &ours, |lagged, z| {
            black_box(lagged.step(z));
        }),
    );
    ledger.bench(
        &mut group,
        "lag: nalgebra, window anew",
        round(ticks, &Window { filter: textbook.clone(), steps: VecDeque::new(), sample: 0 }, Window::step),
    );
    ledger.bench(
        &mut group,
        "lag: adskalman, window anew",
        round(ticks, &PeerWindow { estimates: VecDeque::new(), sample: 0 }, |window, z| window.step(&peer, z)),
    );
    ledger.bench(&mut group, "lag: nalgebra, a whole record once", || {
        let mut filter = textbook.clone();
        let steps: Vec<Step> = ticks[1..=RECORD].iter().map(|z| filter.step(z, DT)).collect();
        assert!(smooth(steps.iter(), |smoothed| {
            black_box(smoothed);
        }));
    });
    let deviations: Vec<Readings> = ticks[1..=RECORD].iter().map(|z| z - peer.reading).collect();
    ledger.bench(&mut group, "lag: adskalman, a whole record once", || {
        black_box(peer.filter().smooth(&peer.start, &deviations).unwrap());
    });
    group.finish();
    ledger.compare("lag: ours with its filter", "lag: nalgebra, window anew", " (sequential)");
    ledger.compare("lag: ours with its filter", "lag: adskalman, window anew", " (linear)");
    let favourable = " (a sample's part: the whole record smoothed once, no fixed lag)";
    ledger.compare_part("lag: ours with its filter", "lag: nalgebra, a whole record once", RECORD as f64, favourable);
    ledger.compare_part("lag: ours with its filter", "lag: adskalman, a whole record once", RECORD as f64, favourable);
}
