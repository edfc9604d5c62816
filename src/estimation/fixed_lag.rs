//! Fixed-lag smoother: states of a while ago, estimated from everything that came since.
//!
//! Consumes what the filter does, step by step; produces, every `spacing` seconds, the moving states \[16\] of `lag` seconds
//! ago with their variances. At such an instant j the filter's state is set aside, and from then on moves by what is measured:
//!     C_j = E[e_j e'],  at the instant the first 16 rows of P                                     (1)
//!     C_j <- C_j F'                                                     (time update)             (2)
//!     k = C_j H'/s,  x_j <- x_j + k nu,  var_j <- var_j - k^2 s,  C_j <- C_j - k s K'             (3)
//! with the filter's own nu, s and gain K: the fixed-point smoother, run for several points side by side. It equals the
//! fixed-interval smoother over a record that ends `lag` after j, without any matrix inverse.
//! Source: B. D. O. Anderson and J. B. Moore, Optimal Filtering, 1979, section 7.2; D. Simon, Optimal State Estimation, 2006,
//! 9.2 and 9.3.
//! Numerics: C_j is no covariance of its own and cannot lose its sign; a variance that (3) would make negative is told as 0.
//! Cannot answer before `lag` has passed since the filter began.

use super::ekf::{Ekf, Follow, Fusion, Transition};
use super::process::{ANGULAR_ACCELERATION, MOVING, NAVIGATION, RATES, STATES, State};

/// Instants on their way at a time.
pub const POINTS: usize = 8;

/// The moving states of one instant.
pub type Moving = [f64; MOVING];

/// One instant on its way.
#[derive(Clone, Copy, Debug)]
struct Point {
    time_s: f64,
    /// The filter's state at the instant.
    filtered: Moving,
    x: Moving,
    var: Moving,
    /// C_j, a row for each of its states.
    cross: [State; MOVING],
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
    /// What the smoother has changed in the filter's estimate of that instant.
    pub correction: Moving,
}

/// Several instants on their way.
#[derive(Clone, Debug)]
pub struct FixedLag {
    lag_s: f64,
    spacing_s: f64,
    points: [Point; POINTS],
    first: usize,
    len: usize,
}

impl FixedLag {
    /// Instants at least `spacing_s` apart, each told `lag_s` later; wider apart where so many would not fit.
    pub const fn new(lag_s: f64, spacing_s: f64) -> Self {
        let least_s = lag_s / (POINTS - 1) as f64;
        let spacing_s = if spacing_s > least_s { spacing_s } else { least_s };
        let none =
            Point { time_s: 0.0, filtered: [0.0; MOVING], x: [0.0; MOVING], var: [0.0; MOVING], cross: [[0.0; STATES]; MOVING] };
        FixedLag { lag_s, spacing_s, points: [none; POINTS], first: 0, len: 0 }
    }

    /// Forgets every instant: the filter has begun again.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    fn place(&self, age: usize) -> usize {
        (self.first + age) % POINTS
    }

    /// Sets the filter's state aside where the next instant is due, (1), and returns the one that is `lag_s` old.
    pub fn tick(&mut self, time_s: f64, ekf: &Ekf) -> Option<SmoothedPoint> {
        let mut ripe = None;
        if self.len > 0 && time_s - self.points[self.first].time_s >= self.lag_s {
            ripe = self.smoothed(0);
            self.first = self.place(1);
            self.len -= 1;
        }
        let due = match self.len.checked_sub(1) {
            Some(newest) => time_s - self.points[self.place(newest)].time_s >= self.spacing_s * (1.0 - 1e-6),
            None => true,
        };
        if due && self.len < POINTS {
            let place = self.place(self.len);
            let (x, p) = (ekf.state(), ekf.covariance());
            let point = &mut self.points[place];
            point.time_s = time_s;
            point.filtered.copy_from_slice(&x[..MOVING]);
            point.x = point.filtered;
            for (i, row) in point.cross.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry = p.covariance(i, j);
                }
                point.var[i] = row[i];
            }
            self.len += 1;
        }
        ripe
    }

    fn smoothed(&self, age: usize) -> Option<SmoothedPoint> {
        let point = (age < self.len).then(|| &self.points[self.place(age)])?;
        let correction = core::array::from_fn(|i| point.x[i] - point.filtered[i]);
        Some(SmoothedPoint { time_s: point.time_s, x: point.x, var: point.var, correction })
    }

    /// What the smoother has changed so far in the filter's estimate at `time_s`: a straight line between the instants on
    /// either side, which are at most `hold_s` apart; `None` where there are none.
    pub fn correction(&self, time_s: f64, hold_s: f64) -> Option<Moving> {
        let after = (0..self.len).position(|age| self.points[self.place(age)].time_s >= time_s)?;
        let later = self.smoothed(after)?;
        let Some(earlier) = after.checked_sub(1).and_then(|before| self.smoothed(before)) else {
            return (later.time_s <= time_s).then_some(later.correction);
        };
        let interval = later.time_s - earlier.time_s;
        if !(interval > 0.0 && interval <= hold_s) {
            return None;
        }
        let part = (time_s - earlier.time_s) / interval;
        Some(core::array::from_fn(|i| earlier.correction[i] + part * (later.correction[i] - earlier.correction[i])))
    }
}

impl Follow for FixedLag {
    /// (2).
    fn propagate(&mut self, transition: &Transition) {
        for age in 0..self.len {
            for c in &mut self.points[self.place(age)].cross {
                let old = *c;
                for (new, row) in c.iter_mut().zip(&transition[..NAVIGATION]) {
                    *new = row.iter().zip(&old).map(|(f, c)| f * c).sum();
                }
                for i in 0..3 {
                    c[RATES + i] += transition[RATES + i][ANGULAR_ACCELERATION + i] * old[ANGULAR_ACCELERATION + i];
                }
            }
        }
    }

    /// (3).
    fn fuse(&mut self, row: &State, fusion: &Fusion) {
        let Fusion { innovation, innovation_var, gain: Some(gain), .. } = fusion else { return };
        let begin = row.iter().position(|&h| h != 0.0).unwrap_or(STATES);
        let end = row.iter().rposition(|&h| h != 0.0).map_or(begin, |last| last + 1);
        for age in 0..self.len {
            let place = self.place(age);
            let Point { x, var, cross, .. } = &mut self.points[place];
            for ((x, var), c) in x.iter_mut().zip(var).zip(cross) {
                let ch: f64 = row[begin..end].iter().zip(&c[begin..end]).map(|(h, c)| h * c).sum();
                let k = ch / innovation_var;
                *x += k * innovation;
                *var = (*var - k * ch).max(0.0);
                for (c, gain) in c.iter_mut().zip(gain) {
                    *c -= ch * gain;
                }
            }
        }
    }
}
