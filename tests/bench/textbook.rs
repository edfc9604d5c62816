//! The textbook filter: the same extended Kalman filter on nalgebra's fixed-size matrices, as a book writes it, and the
//! Rauch-Tung-Striebel smoother over its steps.
//!
//!     x <- x + dt f(x + dt/2 f(x))               P <- F P F' + G diag(q/dt) G' + W dt                 (1)
//!     S = H P H' + R,  K = P H' S^-1,  x <- x + K (z - h(x))                                         (2)
//!     P <- (I - K H) P, made symmetric        or        P <- (I - K H) P (I - K H)' + K R K' (Joseph)  (3)
//!     A = P F' P'^-1,  x_s = x + A (x_s' - x'),  P_s = P + A (P_s' - P') A'                           (4)
//! with all thirteen measurements at once, or one after the other, each a scalar. Equations and noise are those of the
//! library (25 states, instruments at the centre of mass); nothing is shared with it. There is no gate in the joint forms.

use nalgebra::{Cholesky, SMatrix, SVector};

/// States.
pub(crate) const N: usize = 25;
/// Measurements: p q r, ax ay az, tas alpha beta, phi theta psi, h.
pub(crate) const M: usize = 13;
/// Measurements from here on pass a gate.
const GATED: usize = 6;
const G0: f64 = 9.80665;

pub(crate) type State = SVector<f64, N>;
pub(crate) type Square = SMatrix<f64, N, N>;
pub(crate) type Readings = SVector<f64, M>;
pub(crate) type Rows = SMatrix<f64, M, N>;

/// The textbook filter.
#[derive(Clone)]
pub(crate) struct Textbook {
    /// State.
    pub(crate) x: State,
    /// Covariance.
    pub(crate) p: Square,
    /// Intensities of the random walks of angular accelerations and specific forces.
    pub(crate) intensity: SVector<f64, 6>,
    /// Random walk of the states, variance a second.
    pub(crate) walk_var: State,
    /// Variances of the measurements.
    pub(crate) r: Readings,
}

/// One step of the filter, as the smoother needs it.
#[derive(Clone)]
pub(crate) struct Step {
    /// F into this step.
    pub(crate) transition: Square,
    /// State and covariance before the measurements.
    pub(crate) predicted: (State, Square),
    /// And after them.
    pub(crate) filtered: (State, Square),
}

fn f(x: &State) -> State {
    let (sp, cp) = x[3].sin_cos();
    let (st, ct) = x[4].sin_cos();
    let (u, v, w) = (x[0], x[1], x[2]);
    let (p, q, r) = (x[7], x[8], x[9]);
    let mut out = State::zeros();
    out[0] = -w * q + v * r + x[13] - G0 * st;
    out[1] = -u * r + w * p + x[14] + G0 * ct * sp;
    out[2] = -v * p + u * q + x[15] + G0 * ct * cp;
    out[3] = p + (q * sp + r * cp) * st / ct;
    out[4] = q * cp - r * sp;
    out[5] = (q * sp + r * cp) / ct;
    out[6] = u * st - (v * sp + w * cp) * ct;
    for i in 0..3 {
        out[7 + i] = x[10 + i];
    }
    out
}

/// Transition over dt.
pub(crate) fn transition(x: &State, dt: f64) -> Square {
    let (sp, cp) = x[3].sin_cos();
    let (st, ct) = x[4].sin_cos();
    let tt = st / ct;
    let (u, v, w) = (x[0], x[1], x[2]);
    let (p, q, r) = (x[7], x[8], x[9]);
    let turn = q * sp + r * cp;
    let lean = q * cp - r * sp;
    let mut a = Square::zeros();
    a[(0, 1)] = r;
    a[(0, 2)] = -q;
    a[(0, 4)] = -G0 * ct;
    a[(0, 8)] = -w;
    a[(0, 9)] = v;
    a[(1, 0)] = -r;
    a[(1, 2)] = p;
    a[(1, 3)] = G0 * ct * cp;
    a[(1, 4)] = -G0 * st * sp;
    a[(1, 7)] = w;
    a[(1, 9)] = -u;
    a[(2, 0)] = q;
    a[(2, 1)] = -p;
    a[(2, 3)] = -G0 * ct * sp;
    a[(2, 4)] = -G0 * st * cp;
    a[(2, 7)] = -v;
    a[(2, 8)] = u;
    a[(3, 3)] = lean * tt;
    a[(3, 4)] = turn * (1.0 + tt * tt);
    a[(3, 7)] = 1.0;
    a[(3, 8)] = sp * tt;
    a[(3, 9)] = cp * tt;
    a[(4, 3)] = -turn;
    a[(4, 8)] = cp;
    a[(4, 9)] = -sp;
    a[(5, 3)] = lean / ct;
    a[(5, 4)] = turn * tt / ct;
    a[(5, 8)] = sp / ct;
    a[(5, 9)] = cp / ct;
    a[(6, 0)] = st;
    a[(6, 1)] = -sp * ct;
    a[(6, 2)] = -cp * ct;
    a[(6, 3)] = (w * sp - v * cp) * ct;
    a[(6, 4)] = u * ct + (v * sp + w * cp) * st;
    let mut out = Square::identity() + a * dt;
    for i in 0..7 {
        for j in 0..3 {
            out[(i, 10 + j)] = 0.5 * dt * dt * a[(i, 7 + j)];
        }
    }
    for i in 0..3 {
        out[(i, 13 + i)] = dt;
        out[(7 + i, 10 + i)] = dt;
    }
    out
}

/// G diag(q/dt) G'.
pub(crate) fn process_noise(intensity: &SVector<f64, 6>, dt: f64) -> Square {
    let mut g = SMatrix::<f64, N, 6>::zeros();
    for i in 0..3 {
        g[(7 + i, i)] = 0.5 * dt * dt;
        g[(10 + i, i)] = dt;
        g[(i, 3 + i)] = 0.5 * dt * dt;
        g[(13 + i, 3 + i)] = dt;
    }
    g * SMatrix::<f64, 6, 6>::from_diagonal(&(intensity / dt)) * g.transpose()
}

/// Every reading with its row of H.
pub(crate) fn h(x: &State) -> (Readings, Rows) {
    let (mut z, mut rows) = (Readings::zeros(), Rows::zeros());
    for i in 0..M {
        let (reading, row) = h_one(i, x);
        z[i] = reading;
        rows.set_row(i, &row.transpose());
    }
    (z, rows)
}

/// Prediction and row of one measurement.
fn h_one(i: usize, x: &State) -> (f64, State) {
    let (u, v, w) = (x[0], x[1], x[2]);
    let mut row = State::zeros();
    let z = match i {
        0..3 => {
            row[7 + i] = 1.0;
            row[19 + i] = 1.0;
            return (x[7 + i] + x[19 + i], row);
        }
        3..6 => {
            row[10 + i] = 1.0;
            row[13 + i] = 1.0;
            return (x[10 + i] + x[13 + i], row);
        }
        6 => {
            let speed = (u * u + v * v + w * w).sqrt();
            row[0] = u / speed;
            row[1] = v / speed;
            row[2] = w / speed;
            speed
        }
        7 => {
            let s = u * u + w * w;
            row[0] = -w / s;
            row[2] = u / s;
            w.atan2(u)
        }
        8 => {
            let s = u * u + w * w;
            let root = s.sqrt();
            let speed2 = s + v * v;
            row[0] = -v * u / (speed2 * root);
            row[1] = root / speed2;
            row[2] = -v * w / (speed2 * root);
            v.atan2(root)
        }
        _ => {
            row[i - 6] = 1.0;
            return (x[i - 6], row);
        }
    };
    let scale = 1.0 + x[16 + i];
    row *= scale;
    row[16 + i] = z;
    (scale * z, row)
}

impl Textbook {
    /// (1); the transition.
    pub(crate) fn propagate(&mut self, dt: f64) -> Square {
        let middle = self.x + f(&self.x) * (0.5 * dt);
        let transition = transition(&middle, dt);
        self.x += f(&middle) * dt;
        self.p = transition * self.p * transition.transpose()
            + process_noise(&self.intensity, dt)
            + Square::from_diagonal(&(self.walk_var * dt));
        transition
    }

    /// (2) with the short form of (3); `false` where S has no inverse.
    pub(crate) fn update_short(&mut self, z: &Readings) -> bool {
        let (predicted, rows) = h(&self.x);
        let pht = self.p * rows.transpose();
        let s = rows * pht + SMatrix::<f64, M, M>::from_diagonal(&self.r);
        let Some(inverse) = s.try_inverse() else { return false };
        let k = pht * inverse;
        self.x += k * (z - predicted);
        let p = self.p - k * pht.transpose();
        self.p = (p + p.transpose()) * 0.5;
        true
    }

    /// (2) with Joseph's form of (3); `false` where S has no inverse.
    pub(crate) fn update_joseph(&mut self, z: &Readings) -> bool {
        let (predicted, rows) = h(&self.x);
        let pht = self.p * rows.transpose();
        let r = SMatrix::<f64, M, M>::from_diagonal(&self.r);
        let s = rows * pht + r;
        let Some(inverse) = s.try_inverse() else { return false };
        let k = pht * inverse;
        self.x += k * (z - predicted);
        let left = Square::identity() - k * rows;
        self.p = left * self.p * left.transpose() + k * r * k.transpose();
        true
    }

    /// One measurement after the other, the aids behind a gate of five standard deviations; how many were fused.
    pub(crate) fn update_sequential(&mut self, z: &Readings) -> usize {
        let mut fused = 0;
        for i in 0..M {
            let (predicted, row) = h_one(i, &self.x);
            let ph = self.p * row;
            let s = row.dot(&ph) + self.r[i];
            let innovation = z[i] - predicted;
            if i >= GATED && innovation * innovation > 25.0 * s {
                continue;
            }
            let k = ph / s;
            self.x += k * innovation;
            self.p -= k * ph.transpose();
            fused += 1;
        }
        self.p = (self.p + self.p.transpose()) * 0.5;
        fused
    }

    /// One step with sequential updates, kept for the smoother.
    pub(crate) fn step(&mut self, z: &Readings, dt: f64) -> Step {
        let transition = self.propagate(dt);
        let predicted = (self.x, self.p);
        self.update_sequential(z);
        Step { transition, predicted, filtered: (self.x, self.p) }
    }
}

/// (4), from the last of `steps` back to the first, each given to `each`; `false` where P' has no Cholesky factor.
pub(crate) fn smooth<'a>(steps: impl DoubleEndedIterator<Item = &'a Step>, mut each: impl FnMut(&(State, Square))) -> bool {
    let mut steps = steps.rev();
    let Some(mut later) = steps.next() else { return true };
    let mut smoothed = later.filtered;
    each(&smoothed);
    for step in steps {
        let Some(factor) = Cholesky::new(later.predicted.1) else { return false };
        let gain = factor.solve(&(later.transition * step.filtered.1)).transpose();
        smoothed = (
            step.filtered.0 + gain * (smoothed.0 - later.predicted.0),
            step.filtered.1 + gain * (smoothed.1 - later.predicted.1) * gain.transpose(),
        );
        each(&smoothed);
        later = step;
    }
    true
}
