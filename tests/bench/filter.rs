//! One filter step: prediction and thirteen measurements with 25 states, ours on UD factors beside three textbook forms and
//! the crate `adskalman`.

use crate::FAST_HZ;
use crate::flight::Flight;
use crate::ledger::{Ledger, group};
use crate::peer::Peer;
use crate::textbook::{M, N, Readings, Square, Textbook};
use criterion::Criterion;
use nalgebra::{SMatrix, SVector};
use sideslip::flight::run::RunGeometry;
use sideslip::num::ud::UdFactor;
use sideslip::realtime::estimation::aid;
use sideslip::realtime::estimation::aid::inertial;
use sideslip::realtime::estimation::config::{EstimationConfig, Noise};
use sideslip::realtime::estimation::ekf::{Ekf, FilterObserver, ProcessNoise};
use sideslip::realtime::estimation::process::{STATES, State};
use sideslip::realtime::estimation::record::Aid;
use std::hint::black_box;

/// Interval of the samples, s.
pub(crate) const DT: f64 = 1.0 / FAST_HZ;
/// The answers are compared over so many samples; the joint forms, which linearise everything at one state, stray slowly.
const COMPARED: usize = 2048;
/// Innovations of gyros and accelerometers are not judged.
const NO_GATE: f64 = 1e9;

/// Ours, with what it needs.
#[derive(Clone)]
pub(crate) struct Ours {
    pub(crate) ekf: Ekf,
    pub(crate) noise: ProcessNoise,
    pub(crate) geometry: RunGeometry,
    pub(crate) config: EstimationConfig,
}

impl Ours {
    /// Over one interval to a sample.
    pub(crate) fn step(&mut self, z: &Readings, observer: &mut impl FilterObserver) -> usize {
        self.ekf.propagate(DT, &self.noise).unwrap();
        observer.propagate(self.ekf.transition());
        self.measure(z, observer)
    }

    /// The measurements of a sample; how many were fused.
    pub(crate) fn measure(&mut self, z: &Readings, observer: &mut impl FilterObserver) -> usize {
        let mut fused = 0;
        for place in 0..M {
            let (prediction, gate) = match place.checked_sub(inertial::INERTIAL.len()) {
                None => (inertial::predict(place, self.ekf.state(), &self.config.noise), NO_GATE),
                Some(aid) => {
                    let aid = Aid::ALL[aid];
                    (aid::predict(aid, self.ekf.state(), &self.geometry, &self.config.noise).unwrap(), self.config.gate_sigmas)
                }
            };
            let fusion = self.ekf.fuse(z[place], &prediction, gate).unwrap();
            observer.fuse(&prediction.row, &fusion);
            fused += usize::from(fusion.gain.is_some());
        }
        fused
    }
}

fn variances(n: &Noise) -> Readings {
    let [p, q, r] = n.gyro_std;
    let [x, y, z] = n.accelerometer_std;
    let aids = [n.airspeed_std, n.incidence_std, n.sideslip_std, n.bank_std, n.pitch_std, n.heading_std, n.altitude_std];
    let [tas, alpha, beta, phi, theta, psi, h] = aids;
    SVector::from([p, q, r, x, y, z, tas, alpha, beta, phi, theta, psi, h].map(|std| std * std))
}

/// The readings of a flight.
pub(crate) fn ticks(flight: &Flight) -> Vec<Readings> {
    let channels = inertial::INERTIAL.into_iter().chain(Aid::ALL.map(Aid::channel));
    let channels: Vec<_> = channels.collect();
    flight.samples.iter().map(|sample| SVector::from_fn(|i, _| sample.get(channels[i]).unwrap())).collect()
}

/// Both filters at the first sample; the biases walk `walk` times as fast as configured.
pub(crate) fn start(ticks: &[Readings], walk: f64) -> (Ours, Textbook) {
    let config = EstimationConfig::default();
    let [p, q, r, ax, ay, az, tas, alpha, beta, phi, theta, psi, h] = ticks[0].into();
    let mut x: State = [0.0; STATES];
    x[..3].copy_from_slice(&[tas * alpha.cos() * beta.cos(), tas * beta.sin(), tas * alpha.sin() * beta.cos()]);
    x[3..10].copy_from_slice(&[phi, theta, psi, h, p, q, r]);
    x[13..16].copy_from_slice(&[ax, ay, az]);
    let std: [f64; STATES] = [
        0.5, 0.2, 0.2, 0.003, 0.003, 0.005, 2.0, 0.01, 0.01, 0.01, 0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.003, 0.003,
        0.003, 0.01, 0.02, 0.02,
    ];
    let variance = std.map(|std| std * std);
    let square = |std: f64| std * std;
    let noise = ProcessNoise {
        angular_acceleration: config.angular_acceleration_walk.map(square),
        specific_force: config.specific_force_walk.map(square),
        measured: [true; 3],
        accelerometer_walk_var: walk * square(config.accelerometer_bias_walk),
        gyro_walk_var: walk * square(config.gyro_bias_walk),
    };
    let intensity = SVector::from_iterator(noise.angular_acceleration.into_iter().chain(noise.specific_force));
    let mut walk_var = SVector::<f64, N>::zeros();
    for i in 0..3 {
        walk_var[16 + i] = noise.accelerometer_walk_var;
        walk_var[19 + i] = noise.gyro_walk_var;
    }
    let textbook =
        Textbook { x: x.into(), p: SMatrix::from_diagonal(&variance.into()), intensity, walk_var, r: variances(&config.noise) };
    (Ours { ekf: Ekf::new(x, variance), noise, geometry: RunGeometry::default(), config }, textbook)
}

/// Goes round through the samples, and starts again with `fresh` at each round.
pub(crate) fn round<F: Clone>(ticks: &[Readings], fresh: &F, mut step: impl FnMut(&mut F, &Readings)) -> impl FnMut() {
    let mut filter = fresh.clone();
    let mut k = 0;
    move || {
        k += 1;
        if k == ticks.len() {
            k = 1;
            filter = fresh.clone();
        }
        step(&mut filter, &ticks[k]);
    }
}

/// Both filters over the same samples: same state and covariance, everything fused.
fn agree(ticks: &[Readings]) {
    // The biases stand still here, for ours walk in steps of half a second and theirs every sample.
    let (mut ours, textbook) = start(ticks, 0.0);
    let (mut sequential, mut short, mut joseph) = (textbook.clone(), textbook.clone(), textbook);
    for z in &ticks[1..COMPARED] {
        let fused = ours.step(z, &mut ());
        for filter in [&mut sequential, &mut short, &mut joseph] {
            filter.propagate(DT);
        }
        assert_eq!((fused, sequential.update_sequential(z)), (M, M), "every aid passes its gate");
        assert!(short.update_short(z) && joseph.update_joseph(z), "the innovation covariance has an inverse");
    }
    for i in 0..STATES {
        let std = ours.ekf.std(i);
        for (filter, apart) in [(&sequential, 1e-7), (&short, 0.05), (&joseph, 0.05)] {
            let state = (ours.ekf.state()[i] - filter.x[i]).abs() / std;
            let spread = (std / filter.p[(i, i)].sqrt() - 1.0).abs();
            assert!(state < apart && spread < apart, "state {i}: {state} standard errors apart, spread {spread}");
        }
    }
}

/// The crate's linear filter and our factors with the same matrices: the same covariance.
fn agree_with_peer(peer: &Peer, textbook: &Textbook, ticks: &[Readings]) {
    let (f, rows, q) = peer.matrices();
    let mut estimate = peer.start.clone();
    let mut factor = UdFactor::<f64, N>::from_variances(std::array::from_fn(|i| textbook.p[(i, i)]));
    let top: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)]));
    // Q through its eigenvectors.
    let eigen = q.symmetric_eigen();
    let input: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| eigen.eigenvectors[(i, j)]));
    let var: [f64; N] = std::array::from_fn(|i| eigen.eigenvalues[i].max(0.0));
    for z in &ticks[1..COMPARED] {
        estimate = peer.filter().step(&estimate, &(z - peer.reading)).unwrap();
        factor.propagate(&top, &input, &var).unwrap();
        for i in 0..M {
            let row: [f64; N] = std::array::from_fn(|j| rows[(i, j)]);
            factor.fuse(&factor.project(&row, textbook.r[i]).unwrap()).unwrap();
        }
    }
    let found = Square::from_fn(|i, j| factor.covariance(i, j));
    for i in 0..N {
        let spread = (found[(i, i)] / estimate.covariance()[(i, i)]).sqrt() - 1.0;
        assert!(spread.abs() < 1e-6, "state {i}: {spread}");
    }
}

/// Runs the group.
pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger, ticks: &[Readings]) {
    agree(ticks);
    let (ours, textbook) = start(ticks, 1.0);
    let peer = Peer::about(&textbook, DT);
    agree_with_peer(&peer, &textbook, ticks);
    let mut group = group(criterion, "filter step");
    ledger.bench(
        &mut group,
        "filter: ours",
        round(ticks, &ours, |filter, z| {
            black_box(filter.step(z, &mut ()));
        }),
    );
    ledger.bench(
        &mut group,
        "filter: joint, short form",
        round(ticks, &textbook, |filter, z| {
            filter.propagate(DT);
            black_box(filter.update_short(z));
        }),
    );
    ledger.bench(
        &mut group,
        "filter: joint, Joseph form",
        round(ticks, &textbook, |filter, z| {
            filter.propagate(DT);
            black_box(filter.update_joseph(z));
        }),
    );
    ledger.bench(
        &mut group,
        "filter: sequential",
        round(ticks, &textbook, |filter, z| {
            filter.propagate(DT);
            black_box(filter.update_sequential(z));
        }),
    );
    ledger.bench(
        &mut group,
        "filter: adskalman",
        round(ticks, &peer.start, |estimate, z| {
            *estimate = peer.filter().step(estimate, &(z - peer.reading)).unwrap();
        }),
    );
    group.finish();
    ledger.compare("filter: ours", "filter: joint, short form", "");
    ledger.compare("filter: ours", "filter: joint, Joseph form", "");
    ledger.compare("filter: ours", "filter: sequential", " (no UD factors: covariance can lose its sign)");
    ledger.compare("filter: ours", "filter: adskalman", " (linear, its matrices ready; ours linearises)");
}
