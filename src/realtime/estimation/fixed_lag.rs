//! Fixed-lag smoother: states `lag` seconds ago, estimated from all measurements since.
//!
//! Consumes what the filter does, step by step; produces, every `spacing` seconds, the moving states \[16\] of `lag` seconds
//! ago with their variances. At such an instant j the filter's state is stored, and from then on updated by every measurement:
//!     C_j = E[e_j e'],  at the instant the first 16 rows of P                                     (1)
//!     C_j <- C_j F'                                                     (time update)             (2)
//!     k = C_j H'/s,  x_j <- x_j + k nu,  var_j <- var_j - k^2 s,  C_j <- C_j - k s K'             (3)
//! with the filter's own nu, s and gain K: the fixed-point smoother, run for several points side by side. It equals the
//! fixed-interval smoother over a record that ends `lag` after j, without any matrix inverse.
//!
//! The updates between two instants are the same for every point, so they are accumulated once, from Phi = I, l = 0, L = 0,
//!     Phi <- F Phi;    g = Phi' H',  l <- l + g nu/s,  L <- L + g g'/s,  Phi <- Phi - K g'         (4)
//! and applied to all points at the next instant,
//!     x_j <- x_j + C_j l,  var_j <- var_j - (C_j L C_j')_ii,  C_j <- C_j Phi'                       (5)
//! The measurements of one sample go into Phi and L together: g of a later one is its H through Phi as it was before
//! them, less (H K) g of each that came before.
//! Source: B. D. O. Anderson and J. B. Moore, Optimal Filtering, 1979, section 7.2; D. Simon, Optimal State Estimation, 2006,
//! 9.2 and 9.3.
//! Numerics: C_j is a cross covariance, which has no sign to lose; a variance that (5) makes negative is reported as 0.
//! (5), once every `spacing` for all points, is the largest single cost.
//! Returns `None` before `lag` has passed since the filter began.

use super::ekf::{Ekf, FilterObserver, Fusion, Transition};
use super::process::{ANGULAR_ACCELERATION, MOVING, NAVIGATION, RATES, STATES, State};
use crate::num::product::dot;
use crate::num::rows::{add_rows, quadratic_form};

/// Largest number of stored instants.
pub const POINTS: usize = 8;

/// The moving states of one instant.
pub type Moving = [f64; MOVING];

/// Measurements that are accumulated into Phi and L together.
const WAITING: usize = 13;

type Matrix = [State; STATES];

/// A stored instant, updated to the newest stored one.
#[derive(Clone, Copy, Debug)]
struct LaggedInstant {
    time_s: f64,
    /// The filter's state at the instant.
    filtered: Moving,
    x: Moving,
    var: Moving,
    /// C_j, a row for each of its states.
    cross: [State; MOVING],
}

/// Accumulated updates since the newest stored instant, (4).
#[derive(Clone, Debug)]
struct Since {
    phi: Matrix,
    /// l.
    vector: State,
    /// L, on and below the diagonal.
    matrix: Matrix,
    /// g, K and s of measurements that have gone into l alone.
    g: [State; WAITING],
    gain: [State; WAITING],
    innovation_var: [f64; WAITING],
    waiting: usize,
}

/// A smoothed instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothedPoint {
    /// The instant, s.
    pub time_s: f64,
    /// The moving states, estimated from everything until now.
    pub x: Moving,
    /// Their variances.
    pub var: Moving,
    /// Smoothed less filtered states.
    pub correction: Moving,
}

/// State of the smoother.
#[derive(Clone, Debug)]
pub struct FixedLag {
    lag_s: f64,
    spacing_s: f64,
    points: [LaggedInstant; POINTS],
    first: usize,
    len: usize,
    since: Since,
}

impl Since {
    const NOTHING: Since = Since {
        phi: [[0.0; STATES]; STATES],
        vector: [0.0; STATES],
        matrix: [[0.0; STATES]; STATES],
        g: [[0.0; STATES]; WAITING],
        gain: [[0.0; STATES]; WAITING],
        innovation_var: [1.0; WAITING],
        waiting: 0,
    };

    /// From here on.
    fn begin(&mut self) {
        for (i, (phi, matrix)) in self.phi.iter_mut().zip(&mut self.matrix).enumerate() {
            *phi = [0.0; STATES];
            phi[i] = 1.0;
            *matrix = [0.0; STATES];
        }
        self.vector = [0.0; STATES];
        self.waiting = 0;
    }

    /// Phi <- F Phi.
    fn propagate(&mut self, transition: &Transition) {
        self.settle();
        let mut new = [[0.0; STATES]; NAVIGATION];
        for (new, row) in new.iter_mut().zip(transition) {
            add_rows(new, &self.phi[..MOVING], row, STATES);
        }
        self.phi[..NAVIGATION].copy_from_slice(&new);
        for i in 0..3 {
            let acceleration = self.phi[ANGULAR_ACCELERATION + i];
            let by = transition[RATES + i][ANGULAR_ACCELERATION + i];
            add_rows(&mut self.phi[RATES + i], &[acceleration], &[by], STATES);
        }
    }

    /// g of a measurement; it goes into l, and waits.
    fn fuse(&mut self, row: &State, innovation: f64, innovation_var: f64, gain: &State) {
        if self.waiting == WAITING {
            self.settle();
        }
        let mut g = [0.0; STATES];
        add_rows(&mut g, &self.phi, row, STATES);
        let mut weights = [0.0; WAITING];
        for (weight, gain) in weights.iter_mut().zip(&self.gain[..self.waiting]) {
            for (h, k) in row.iter().zip(gain) {
                if *h != 0.0 {
                    *weight -= h * k;
                }
            }
        }
        add_rows(&mut g, &self.g[..self.waiting], &weights, STATES);
        add_rows(&mut self.vector, &[g], &[innovation / innovation_var], STATES);
        self.g[self.waiting] = g;
        self.gain[self.waiting] = *gain;
        self.innovation_var[self.waiting] = innovation_var;
        self.waiting += 1;
    }

    /// What waits goes into Phi and L.
    fn settle(&mut self) {
        let g = &self.g[..self.waiting];
        for (i, (phi, matrix)) in self.phi.iter_mut().zip(&mut self.matrix).enumerate() {
            let (mut by_gain, mut by_g) = ([0.0; WAITING], [0.0; WAITING]);
            for (k, g) in g.iter().enumerate() {
                by_gain[k] = -self.gain[k][i];
                by_g[k] = g[i] / self.innovation_var[k];
            }
            add_rows(phi, g, &by_gain, STATES);
            add_rows(matrix, g, &by_g, i + 1);
        }
        self.waiting = 0;
    }

    /// Phi' in place of Phi.
    fn transpose(&mut self) {
        for i in 0..STATES {
            for j in 0..i {
                let entry = self.phi[i][j];
                self.phi[i][j] = self.phi[j][i];
                self.phi[j][i] = entry;
            }
        }
    }
}

impl LaggedInstant {
    /// x_j of (5).
    fn estimate(&self, since: &Since) -> Moving {
        core::array::from_fn(|i| self.x[i] + dot(&self.cross[i], &since.vector))
    }

    /// var_j of (5).
    fn variance(&self, since: &Since) -> Moving {
        core::array::from_fn(|i| (self.var[i] - quadratic_form(&since.matrix, &self.cross[i])).max(0.0))
    }
}

impl FixedLag {
    /// Instants at least `spacing_s` apart, each reported `lag_s` later; further apart where [`POINTS`] would not hold them.
    pub const fn new(lag_s: f64, spacing_s: f64) -> Self {
        let least_s = lag_s / (POINTS - 1) as f64;
        let spacing_s = if spacing_s > least_s { spacing_s } else { least_s };
        let none = LaggedInstant {
            time_s: 0.0,
            filtered: [0.0; MOVING],
            x: [0.0; MOVING],
            var: [0.0; MOVING],
            cross: [[0.0; STATES]; MOVING],
        };
        FixedLag { lag_s, spacing_s, points: [none; POINTS], first: 0, len: 0, since: Since::NOTHING }
    }

    /// Forgets every instant: the filter has begun again.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    fn place(&self, age: usize) -> usize {
        (self.first + age) % POINTS
    }

    /// Stores the filter's state where the next instant is due, (1), and returns the one that is `lag_s` old.
    pub fn tick(&mut self, time_s: f64, ekf: &Ekf) -> Option<SmoothedPoint> {
        let mut ripe = None;
        if self.len > 0 && time_s - self.points[self.first].time_s >= self.lag_s {
            self.since.settle();
            let LaggedInstant { time_s, filtered, .. } = self.points[self.first];
            let (x, var) = (self.points[self.first].estimate(&self.since), self.points[self.first].variance(&self.since));
            let correction = core::array::from_fn(|i| x[i] - filtered[i]);
            ripe = Some(SmoothedPoint { time_s, x, var, correction });
            self.first = self.place(1);
            self.len -= 1;
        }
        let due = match self.len.checked_sub(1) {
            Some(newest) => time_s - self.points[self.place(newest)].time_s >= self.spacing_s * (1.0 - 1e-6),
            None => true,
        };
        if due && self.len < POINTS {
            self.bring_up();
            let place = self.place(self.len);
            let (x, p) = (ekf.state(), ekf.covariance());
            let point = &mut self.points[place];
            point.time_s = time_s;
            point.filtered.copy_from_slice(&x[..MOVING]);
            point.x = point.filtered;
            p.rows(&mut point.cross);
            point.var = core::array::from_fn(|i| point.cross[i][i]);
            self.len += 1;
        }
        ripe
    }

    /// (5) for every point; from here on it is gathered anew.
    fn bring_up(&mut self) {
        self.since.settle();
        self.since.transpose();
        for age in 0..self.len {
            let place = self.place(age);
            let point = &mut self.points[place];
            point.x = point.estimate(&self.since);
            point.var = point.variance(&self.since);
            for c in &mut point.cross {
                let mut new = [0.0; STATES];
                add_rows(&mut new, &self.since.phi, c, STATES);
                *c = new;
            }
        }
        self.since.begin();
    }

    /// An instant and its correction so far.
    fn corrected(&self, age: usize) -> Option<(f64, Moving)> {
        let point = (age < self.len).then(|| &self.points[self.place(age)])?;
        let x = point.estimate(&self.since);
        Some((point.time_s, core::array::from_fn(|i| x[i] - point.filtered[i])))
    }

    /// Smoothed less filtered states at `time_s`, linear between the instants on either side, at most `hold_s` apart; `None`
    /// where there are none.
    pub fn correction(&self, time_s: f64, hold_s: f64) -> Option<Moving> {
        let after = (0..self.len).position(|age| self.points[self.place(age)].time_s >= time_s)?;
        let (later_s, later) = self.corrected(after)?;
        let Some((earlier_s, earlier)) = after.checked_sub(1).and_then(|before| self.corrected(before)) else {
            return (later_s <= time_s).then_some(later);
        };
        let interval = later_s - earlier_s;
        if !(interval > 0.0 && interval <= hold_s) {
            return None;
        }
        let part = (time_s - earlier_s) / interval;
        Some(core::array::from_fn(|i| earlier[i] + part * (later[i] - earlier[i])))
    }
}

impl FilterObserver for FixedLag {
    fn propagate(&mut self, transition: &Transition) {
        if self.len > 0 {
            self.since.propagate(transition);
        }
    }

    fn fuse(&mut self, row: &State, fusion: &Fusion) {
        let Fusion { innovation, innovation_var, gain: Some(gain), .. } = fusion else { return };
        if self.len > 0 {
            self.since.fuse(row, *innovation, *innovation_var, gain);
        }
    }
}
