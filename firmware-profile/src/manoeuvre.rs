//! A short flight that the profile carries in itself: doublets on pedal and lateral cyclic, computed sample by sample.
//!
//! A linear set of forces and moments about trim on the nonlinear kinematics, integrated by Runge-Kutta over each sample
//! interval with controls as straight lines; instruments with a little seeded noise, some of them slower than others.
//! No table, no heap, and the same bits on every target: products, sums, and sines of `libm`.

use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;

/// Interval of the samples, s.
pub const INTERVAL_S: f64 = 0.02;
/// Number of samples.
pub const SAMPLES: u32 = 2_000;

const G0: f64 = 9.80665;
/// u v w p q r phi theta psi h.
const STATES: usize = 10;

/// Lateral derivatives of the flight, by which the estimate can be judged: Y_v L_v L_p L_r N_v N_p N_r.
pub const LATERAL: [f64; 7] = [-0.138, -0.070, -1.79, 0.138, 0.0056, -0.21, -0.50];

/// u, w and theta of its trim, m/s and rad.
pub const TRIM: [f64; 3] = [51.44, 1.6, 0.031];

/// A control by doublets: (begin s, half length s, amplitude rad), straight between samples.
type Doublets = [(f64, f64, f64); 3];
const PEDAL: Doublets = [(3.0, 1.0, 0.02), (14.0, 1.5, -0.015), (27.0, 1.0, 0.02)];
const LAT_CYCLIC: Doublets = [(8.0, 0.6, 0.02), (20.0, 0.8, 0.02), (33.0, 0.6, -0.02)];
const LON_CYCLIC: Doublets = [(11.0, 0.8, 0.01), (24.0, 0.8, -0.01), (37.0, 0.5, 0.01)];

/// The flight so far; an iterator of samples.
#[derive(Clone, Debug)]
pub struct ManoeuvreSamples {
    state: [f64; STATES],
    number: u32,
    seed: u64,
}

impl Default for ManoeuvreSamples {
    fn default() -> Self {
        let mut state = [0.0; STATES];
        [state[0], state[2], state[7]] = TRIM;
        state[9] = 500.0;
        ManoeuvreSamples { state, number: 0, seed: 2 }
    }
}

/// Lateral cyclic, longitudinal cyclic and pedal at a time.
fn controls(time_s: f64) -> [f64; 3] {
    let hand = |doublets: &Doublets| {
        let mut value = 0.0;
        for &(begin_s, half_s, amplitude) in doublets {
            let since_s = time_s - begin_s;
            if since_s > 0.0 && since_s < 2.0 * half_s {
                value = if since_s < half_s { amplitude } else { -amplitude };
            }
        }
        value
    };
    [hand(&LAT_CYCLIC), hand(&LON_CYCLIC), hand(&PEDAL)]
}

/// Specific force and angular acceleration.
fn forces(x: &[f64; STATES], control: &[f64; 3]) -> [f64; 6] {
    let [u0, w0, theta0] = TRIM;
    let (u, v, w) = (x[0] - u0, x[1], x[2] - w0);
    let (p, q, r) = (x[3], x[4], x[5]);
    let [lat_cyclic, lon_cyclic, pedal] = *control;
    let [y_v, l_v, l_p, l_r, n_v, n_p, n_r] = LATERAL;
    [
        G0 * libm::sin(theta0) - 0.02 * u + 0.03 * w + 5.0 * lon_cyclic,
        y_v * v + 2.0 * pedal,
        -G0 * libm::cos(theta0) - 0.05 * u - 0.8 * w,
        l_v * v + l_p * p + l_r * r + 25.0 * lat_cyclic + 1.0 * pedal,
        0.001 * u - 0.02 * w - 1.2 * q + 6.0 * lon_cyclic,
        n_v * v + n_p * p + n_r * r - 5.0 * pedal,
    ]
}

fn rate(x: &[f64; STATES], control: &[f64; 3]) -> [f64; STATES] {
    let [u, v, w, p, q, r, phi, theta, ..] = *x;
    let [ax, ay, az, dp, dq, dr] = forces(x, control);
    let (sin_phi, cos_phi) = libm::sincos(phi);
    let (sin_theta, cos_theta) = libm::sincos(theta);
    let turn = q * sin_phi + r * cos_phi;
    [
        r * v - q * w + ax - G0 * sin_theta,
        p * w - r * u + ay + G0 * cos_theta * sin_phi,
        q * u - p * v + az + G0 * cos_theta * cos_phi,
        dp,
        dq,
        dr,
        p + turn * sin_theta / cos_theta,
        q * cos_phi - r * sin_phi,
        turn / cos_theta,
        u * sin_theta - (v * sin_phi + w * cos_phi) * cos_theta,
    ]
}

fn moved(x: &[f64; STATES], slope: &[f64; STATES], by: f64) -> [f64; STATES] {
    core::array::from_fn(|i| x[i] + by * slope[i])
}

impl ManoeuvreSamples {
    fn advance(&mut self) {
        let from = controls(f64::from(self.number) * INTERVAL_S);
        let to = controls(f64::from(self.number + 1) * INTERVAL_S);
        let middle = core::array::from_fn(|i| 0.5 * (from[i] + to[i]));
        let x = self.state;
        let k1 = rate(&x, &from);
        let k2 = rate(&moved(&x, &k1, 0.5 * INTERVAL_S), &middle);
        let k3 = rate(&moved(&x, &k2, 0.5 * INTERVAL_S), &middle);
        let k4 = rate(&moved(&x, &k3, INTERVAL_S), &to);
        self.state = core::array::from_fn(|i| x[i] + INTERVAL_S / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        self.number += 1;
    }

    /// Uniform noise of that standard deviation.
    fn noise(&mut self, std: f64) -> f64 {
        self.seed = self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let unit = (self.seed >> 11) as f64 / (1_u64 << 53) as f64;
        std * (unit - 0.5) * 3.464_101_615_137_754_6
    }
}

impl Iterator for ManoeuvreSamples {
    type Item = Sample;

    fn next(&mut self) -> Option<Sample> {
        use Channel::{
            Alpha, Altitude, Ax, Ay, Az, Beta, Collective, LatCyclic, LonCyclic, P, Pedal, Phi, Psi, Q, R, Tas, Theta,
        };
        if self.number >= SAMPLES {
            return None;
        }
        let [u, v, w, p, q, r, phi, theta, psi, altitude] = self.state;
        let control = controls(f64::from(self.number) * INTERVAL_S);
        let [ax, ay, az, ..] = forces(&self.state, &control);
        let [lat_cyclic, lon_cyclic, pedal] = control;
        let (in_symmetry, tas) = (libm::sqrt(u * u + w * w), libm::sqrt(u * u + v * v + w * w));
        // (channel, value, standard deviation of its noise, every how many samples).
        let readings = [
            (Ax, ax, 0.02, 1),
            (Ay, ay, 0.02, 1),
            (Az, az, 0.02, 1),
            (P, p, 0.001, 1),
            (Q, q, 0.001, 1),
            (R, r, 0.001, 1),
            (Phi, phi, 0.002, 1),
            (Theta, theta, 0.002, 1),
            (Psi, psi, 0.004, 4),
            (Tas, tas, 0.3, 2),
            (Alpha, libm::atan2(w, u), 0.002, 2),
            (Beta, libm::atan2(v, in_symmetry), 0.002, 2),
            (Altitude, altitude, 0.5, 4),
            (LonCyclic, lon_cyclic, 0.0002, 1),
            (LatCyclic, lat_cyclic, 0.0002, 1),
            (Collective, 0.25, 0.0, 1),
            (Pedal, pedal, 0.0002, 1),
        ];
        let mut sample = Sample::new(f64::from(self.number) * INTERVAL_S);
        for (channel, value, std, every) in readings {
            if self.number.is_multiple_of(every) {
                sample.set(channel, value + self.noise(std));
            }
        }
        self.advance();
        Some(sample)
    }
}
