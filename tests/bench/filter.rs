//! One filter step: prediction and seven aids with 13 states, ours on UD factors beside three textbook forms.

use crate::flight::{Flight, RATE_HZ};
use crate::ledger::{Ledger, group};
use crate::textbook::Textbook;
use criterion::Criterion;
use nalgebra::{SMatrix, SVector};
use sideslip::estimation::aid;
use sideslip::estimation::config::{Config, Noise};
use sideslip::estimation::ekf::{Ekf, ProcessNoise};
use sideslip::estimation::process::{INPUTS, Input, STATES, State};
use sideslip::estimation::record::{AIDS, Aid};
use sideslip::flight::channel::Channel;
use sideslip::flight::run::RunGeometry;
use std::hint::black_box;

/// The filter flies the first so many ticks again and again.
const TICKS: usize = 4096;
const DT: f64 = 1.0 / RATE_HZ;
const INPUT_CHANNELS: [Channel; INPUTS] = [Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R];

/// Inputs and measurements of a tick.
struct Tick {
    input: Input,
    aids: [f64; AIDS],
}

struct Ours {
    ekf: Ekf,
    noise: ProcessNoise,
    geometry: RunGeometry,
    config: Config,
}

impl Ours {
    fn step(&mut self, from: &Tick, to: &Tick) -> usize {
        self.ekf.propagate(&from.input, &to.input, DT, &self.noise).unwrap();
        let mut fused = 0;
        for aid in Aid::ALL {
            let prediction = aid::predict(aid, self.ekf.state(), &to.input, &self.geometry, &self.config.noise).unwrap();
            let observation = to.aids[aid.index()];
            let innovation = self.ekf.fuse(0.0, aid, observation, &prediction, self.config.gate_sigmas).unwrap();
            fused += usize::from(innovation.fused);
        }
        fused
    }
}

fn variances(n: &Noise) -> [f64; AIDS] {
    let std = [n.airspeed_std, n.incidence_std, n.sideslip_std, n.bank_std, n.pitch_std, n.heading_std, n.altitude_std];
    std.map(|std| std * std)
}

/// Both filters at the first tick; the biases walk `walk` times as fast as configured.
fn start(ticks: &[Tick], walk: f64) -> (Ours, Textbook) {
    let config = Config::default();
    let n = config.noise;
    let [tas, alpha, beta, phi, theta, psi, h] = ticks[0].aids;
    let mut x: State = [0.0; STATES];
    x[..3].copy_from_slice(&[tas * alpha.cos() * beta.cos(), tas * beta.sin(), tas * alpha.sin() * beta.cos()]);
    x[3..7].copy_from_slice(&[phi, theta, psi, h]);
    let std = [0.5, 0.2, 0.2, 0.003, 0.003, 0.005, 2.0, 0.1, 0.1, 0.1, 0.003, 0.003, 0.003];
    let variance = std.map(|std: f64| std * std);
    let (force, rate) = (n.accelerometer_std * n.accelerometer_std, n.gyro_std * n.gyro_std);
    let input_var = [force, force, force, rate, rate, rate];
    let (force_walk, rate_walk) = (walk * config.accelerometer_bias_walk.powi(2), walk * config.gyro_bias_walk.powi(2));
    let mut walk_var = [0.0; STATES];
    walk_var[7..10].fill(force_walk);
    walk_var[10..].fill(rate_walk);
    let ours = Ours {
        ekf: Ekf::new(x, variance),
        noise: ProcessNoise { input_var, accelerometer_walk_var: force_walk, gyro_walk_var: rate_walk },
        geometry: RunGeometry::default(),
        config,
    };
    let textbook = Textbook {
        x: x.into(),
        p: SMatrix::from_diagonal(&variance.into()),
        input_var: input_var.into(),
        walk_var: walk_var.into(),
        r: variances(&n).into(),
    };
    (ours, textbook)
}

/// Goes round through the ticks, and starts again with `fresh` at each round.
fn round<F: Clone>(ticks: &[Tick], fresh: &F, mut step: impl FnMut(&mut F, &Tick, &Tick)) -> impl FnMut() {
    let mut filter = fresh.clone();
    let mut k = 0;
    move || {
        k += 1;
        if k == ticks.len() {
            k = 1;
            filter = fresh.clone();
        }
        step(&mut filter, &ticks[k - 1], &ticks[k]);
    }
}

fn middle(from: &Tick, to: &Tick) -> SVector<f64, INPUTS> {
    SVector::from_fn(|i, _| 0.5 * (from.input[i] + to.input[i]))
}

/// Both filters over the same ticks: same state and covariance, everything fused.
fn agree(ticks: &[Tick]) {
    // The biases stand still here, for ours walk in steps of half a second and theirs every tick.
    let (mut ours, textbook) = start(ticks, 0.0);
    let (mut sequential, mut short, mut joseph) = (textbook.clone(), textbook.clone(), textbook);
    for pair in ticks.windows(2) {
        let fused = ours.step(&pair[0], &pair[1]);
        let m = middle(&pair[0], &pair[1]);
        let z = SVector::from(pair[1].aids);
        for filter in [&mut sequential, &mut short, &mut joseph] {
            filter.propagate(&m, DT);
        }
        assert_eq!((fused, sequential.update_sequential(&z)), (AIDS, AIDS), "every aid passes its gate");
        assert!(short.update_short(&z) && joseph.update_joseph(&z), "the innovation covariance has an inverse");
    }
    for i in 0..STATES {
        let std = ours.ekf.std(i);
        // The joint forms linearise all measurements at one state.
        for (filter, apart) in [(&sequential, 1e-7), (&short, 0.05), (&joseph, 0.05)] {
            let state = (ours.ekf.state()[i] - filter.x[i]).abs() / std;
            let spread = (std / filter.p[(i, i)].sqrt() - 1.0).abs();
            assert!(state < apart && spread < apart, "state {i}: {state} standard errors apart, spread {spread}");
        }
    }
}

/// Runs the group.
pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger, flight: &Flight) {
    let ticks: Vec<Tick> = flight.samples[..TICKS]
        .iter()
        .map(|sample| Tick {
            input: INPUT_CHANNELS.map(|channel| sample.get(channel).unwrap()),
            aids: Aid::ALL.map(|aid| sample.get(aid.channel()).unwrap()),
        })
        .collect();
    agree(&ticks);
    let (ours, textbook) = start(&ticks, 1.0);
    let mut group = group(criterion, "filter step");
    ledger.bench(&mut group, "filter: ours", {
        let fresh = ours.ekf.clone();
        let mut filter = ours;
        let mut k = 0;
        let ticks = &ticks;
        move || {
            k += 1;
            if k == ticks.len() {
                k = 1;
                filter.ekf = fresh.clone();
            }
            black_box(filter.step(&ticks[k - 1], &ticks[k]));
        }
    });
    ledger.bench(
        &mut group,
        "filter: joint, short form",
        round(&ticks, &textbook, |filter, from, to| {
            filter.propagate(&middle(from, to), DT);
            black_box(filter.update_short(&to.aids.into()));
        }),
    );
    ledger.bench(
        &mut group,
        "filter: joint, Joseph form",
        round(&ticks, &textbook, |filter, from, to| {
            filter.propagate(&middle(from, to), DT);
            black_box(filter.update_joseph(&to.aids.into()));
        }),
    );
    ledger.bench(
        &mut group,
        "filter: sequential",
        round(&ticks, &textbook, |filter, from, to| {
            filter.propagate(&middle(from, to), DT);
            black_box(filter.update_sequential(&to.aids.into()));
        }),
    );
    group.finish();
    ledger.compare("filter: ours", "filter: joint, short form", "");
    ledger.compare("filter: ours", "filter: joint, Joseph form", "");
    ledger.compare("filter: ours", "filter: sequential", " (no UD factors: covariance can lose its sign)");
}
