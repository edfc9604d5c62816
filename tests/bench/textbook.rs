//! The textbook filter: the same extended Kalman filter on nalgebra's fixed-size matrices, as a book writes it.
//!
//!     x <- x + dt f(x + dt/2 f(x, m), m)         P <- F P F' + G Q G' dt^2 + W dt                     (1)
//!     S = H P H' + R,  K = P H' S^-1,  x <- x + K (z - h(x))                                         (2)
//!     P <- (I - K H) P, made symmetric        or        P <- (I - K H) P (I - K H)' + K R K' (Joseph)  (3)
//! with all seven measurements at once, or one after the other, each a scalar. Equations and noise are those of the library
//! (13 states, instruments at the centre of mass); nothing is shared with it. There is no gate in the joint forms.

use nalgebra::{SMatrix, SVector};

const N: usize = 13;
const M: usize = 7;
const G0: f64 = 9.80665;

type State = SVector<f64, N>;
type Square = SMatrix<f64, N, N>;
type Rates = SVector<f64, 6>;
type NoiseInput = SMatrix<f64, N, 6>;

/// The textbook filter.
#[derive(Clone)]
pub(crate) struct Textbook {
    /// State.
    pub(crate) x: State,
    /// Covariance.
    pub(crate) p: Square,
    /// Variances of ax ay az p q r.
    pub(crate) input_var: Rates,
    /// Random walk of the states, variance a second.
    pub(crate) walk_var: State,
    /// Variances of tas alpha beta phi theta psi h.
    pub(crate) r: SVector<f64, M>,
}

fn f(x: &State, m: &Rates) -> State {
    let (sp, cp) = x[3].sin_cos();
    let (st, ct) = x[4].sin_cos();
    let (u, v, w) = (x[0], x[1], x[2]);
    let (ax, ay, az) = (m[0] - x[7], m[1] - x[8], m[2] - x[9]);
    let (p, q, r) = (m[3] - x[10], m[4] - x[11], m[5] - x[12]);
    let mut out = State::zeros();
    out[0] = -w * q + v * r + ax - G0 * st;
    out[1] = -u * r + w * p + ay + G0 * ct * sp;
    out[2] = -v * p + u * q + az + G0 * ct * cp;
    out[3] = p + (q * sp + r * cp) * st / ct;
    out[4] = q * cp - r * sp;
    out[5] = (q * sp + r * cp) / ct;
    out[6] = u * st - (v * sp + w * cp) * ct;
    out
}

/// Transition and noise input over dt.
fn linear(x: &State, m: &Rates, dt: f64) -> (Square, NoiseInput) {
    let (sp, cp) = x[3].sin_cos();
    let (st, ct) = x[4].sin_cos();
    let tt = st / ct;
    let (u, v, w) = (x[0], x[1], x[2]);
    let (p, q, r) = (m[3] - x[10], m[4] - x[11], m[5] - x[12]);
    let turn = q * sp + r * cp;
    let lean = q * cp - r * sp;
    let mut a = Square::zeros();
    a[(0, 1)] = r;
    a[(0, 2)] = -q;
    a[(0, 4)] = -G0 * ct;
    a[(1, 0)] = -r;
    a[(1, 2)] = p;
    a[(1, 3)] = G0 * ct * cp;
    a[(1, 4)] = -G0 * st * sp;
    a[(2, 0)] = q;
    a[(2, 1)] = -p;
    a[(2, 3)] = -G0 * ct * sp;
    a[(2, 4)] = -G0 * st * cp;
    a[(3, 3)] = lean * tt;
    a[(3, 4)] = turn * (1.0 + tt * tt);
    a[(4, 3)] = -turn;
    a[(5, 3)] = lean / ct;
    a[(5, 4)] = turn * tt / ct;
    a[(6, 0)] = st;
    a[(6, 1)] = -sp * ct;
    a[(6, 2)] = -cp * ct;
    a[(6, 3)] = (w * sp - v * cp) * ct;
    a[(6, 4)] = u * ct + (v * sp + w * cp) * st;
    let mut g = NoiseInput::zeros();
    g[(0, 0)] = 1.0;
    g[(1, 1)] = 1.0;
    g[(2, 2)] = 1.0;
    g[(0, 4)] = -w;
    g[(0, 5)] = v;
    g[(1, 3)] = w;
    g[(1, 5)] = -u;
    g[(2, 3)] = -v;
    g[(2, 4)] = u;
    g[(3, 3)] = 1.0;
    g[(3, 4)] = sp * tt;
    g[(3, 5)] = cp * tt;
    g[(4, 4)] = cp;
    g[(4, 5)] = -sp;
    g[(5, 4)] = sp / ct;
    g[(5, 5)] = cp / ct;
    for i in 0..M {
        for j in 0..6 {
            a[(i, 7 + j)] = -g[(i, j)];
        }
    }
    (Square::identity() + a * dt, g * dt)
}

fn h(x: &State) -> (SVector<f64, M>, SMatrix<f64, M, N>) {
    let (u, v, w) = (x[0], x[1], x[2]);
    let s = u * u + w * w;
    let root = s.sqrt();
    let speed2 = s + v * v;
    let speed = speed2.sqrt();
    let z = SVector::<f64, M>::from([speed, w.atan2(u), v.atan2(root), x[3], x[4], x[5], x[6]]);
    let mut rows = SMatrix::<f64, M, N>::zeros();
    rows[(0, 0)] = u / speed;
    rows[(0, 1)] = v / speed;
    rows[(0, 2)] = w / speed;
    rows[(1, 0)] = -w / s;
    rows[(1, 2)] = u / s;
    rows[(2, 0)] = -v * u / (speed2 * root);
    rows[(2, 1)] = root / speed2;
    rows[(2, 2)] = -v * w / (speed2 * root);
    for i in 3..M {
        rows[(i, i)] = 1.0;
    }
    (z, rows)
}

/// Prediction and row of one measurement.
fn h_one(i: usize, x: &State) -> (f64, State) {
    let (u, v, w) = (x[0], x[1], x[2]);
    let mut row = State::zeros();
    let z = match i {
        0 => {
            let speed = (u * u + v * v + w * w).sqrt();
            row[0] = u / speed;
            row[1] = v / speed;
            row[2] = w / speed;
            speed
        }
        1 => {
            let s = u * u + w * w;
            row[0] = -w / s;
            row[2] = u / s;
            w.atan2(u)
        }
        2 => {
            let s = u * u + w * w;
            let root = s.sqrt();
            let speed2 = s + v * v;
            row[0] = -v * u / (speed2 * root);
            row[1] = root / speed2;
            row[2] = -v * w / (speed2 * root);
            v.atan2(root)
        }
        _ => {
            row[i] = 1.0;
            x[i]
        }
    };
    (z, row)
}

impl Textbook {
    /// (1).
    pub(crate) fn propagate(&mut self, m: &Rates, dt: f64) {
        let middle = self.x + f(&self.x, m) * (0.5 * dt);
        let (transition, g) = linear(&middle, m, dt);
        self.x += f(&middle, m) * dt;
        let gq = g * SMatrix::<f64, 6, 6>::from_diagonal(&self.input_var);
        self.p = transition * self.p * transition.transpose() + gq * g.transpose() + Square::from_diagonal(&(self.walk_var * dt));
    }

    /// (2) with the short form of (3); `false` where S has no inverse.
    pub(crate) fn update_short(&mut self, z: &SVector<f64, M>) -> bool {
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
    pub(crate) fn update_joseph(&mut self, z: &SVector<f64, M>) -> bool {
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

    /// One measurement after the other, each behind a gate of five standard deviations; how many were fused.
    pub(crate) fn update_sequential(&mut self, z: &SVector<f64, M>) -> usize {
        let mut fused = 0;
        for i in 0..M {
            let (predicted, row) = h_one(i, &self.x);
            let ph = self.p * row;
            let s = row.dot(&ph) + self.r[i];
            let innovation = z[i] - predicted;
            if innovation * innovation > 25.0 * s {
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
}
