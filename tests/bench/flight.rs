//! The benchmark's flight: a stable linear aircraft at 51 m/s under multisine controls, every channel, fixed noise.
//!
//! Forces and moments are linear in deviations from trim, the motion is the nonlinear kinematics (1) to (6) of the paper,
//! integrated by the midpoint rule in four steps a sample. Nothing here comes from the library but channel names.

use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;

const G0: f64 = 9.80665;
const U0: f64 = 51.3;
const THETA0: f64 = 0.031;
const SUBSTEPS: usize = 4;

/// u v w p q r phi theta psi h.
type Motion = [f64; 10];

/// Samples as telemetry would bring them.
pub(crate) struct Flight {
    /// One a tick.
    pub(crate) samples: Vec<Sample>,
}

/// Standard deviations of the noise, in the order of `CHANNELS`.
const NOISE: [(Channel, f64); 13] = [
    (Channel::Ax, 0.05),
    (Channel::Ay, 0.05),
    (Channel::Az, 0.05),
    (Channel::P, 0.002),
    (Channel::Q, 0.002),
    (Channel::R, 0.002),
    (Channel::Phi, 0.003),
    (Channel::Theta, 0.003),
    (Channel::Psi, 0.005),
    (Channel::Tas, 0.5),
    (Channel::Alpha, 0.003),
    (Channel::Beta, 0.003),
    (Channel::Altitude, 2.0),
];

/// lon_cyclic lat_cyclic collective pedal as deviations from trim, rad: sums of three sines each, all different.
fn controls(t: f64) -> [f64; 4] {
    let sines = |scale: f64, omegas: [f64; 3]| {
        scale * omegas.iter().enumerate().map(|(i, omega)| (omega * t + i as f64).sin()).sum::<f64>()
    };
    [sines(0.004, [0.9, 2.3, 4.1]), sines(0.006, [1.1, 2.9, 5.3]), sines(0.004, [0.5, 1.7, 3.1]), sines(0.008, [0.7, 1.9, 4.7])]
}

/// Specific force at the centre of mass and angular acceleration.
fn forces(x: &Motion, control: [f64; 4]) -> ([f64; 3], [f64; 3]) {
    let (u, v, w) = (x[0] - U0, x[1], x[2] - U0 * THETA0.tan());
    let [p, q, r] = [x[3], x[4], x[5]];
    let [lon, lat, collective, pedal] = control;
    let force = [
        G0 * THETA0.sin() - 0.03 * u + 0.02 * w + 2.0 * lon + 3.0 * collective,
        -0.12 * v + 2.0 * lat + 4.0 * pedal,
        -G0 * THETA0.cos() - 0.05 * u - 0.8 * w - 20.0 * lon - 80.0 * collective,
    ];
    let moment = [
        -0.05 * v - 1.8 * p + 0.14 * r + 20.0 * lat - 2.0 * pedal,
        0.002 * u - 0.02 * w - 1.2 * q + 6.0 * lon + 0.5 * collective,
        0.02 * v - 0.1 * p - 0.5 * r + 0.5 * lat - 6.0 * pedal,
    ];
    (force, moment)
}

fn slope(x: &Motion, control: [f64; 4]) -> Motion {
    let ([ax, ay, az], [dp, dq, dr]) = forces(x, control);
    let [u, v, w, p, q, r, phi, theta, _, _] = *x;
    let (sp, cp) = phi.sin_cos();
    let (st, ct) = theta.sin_cos();
    [
        -w * q + v * r + ax - G0 * st,
        -u * r + w * p + ay + G0 * ct * sp,
        -v * p + u * q + az + G0 * ct * cp,
        dp,
        dq,
        dr,
        p + (q * sp + r * cp) * st / ct,
        q * cp - r * sp,
        (q * sp + r * cp) / ct,
        u * st - (v * sp + w * cp) * ct,
    ]
}

/// Uniform numbers in -0.5 .. 0.5 from a linear congruence.
struct Noise(u64);

impl Noise {
    /// Nearly normal, unit variance: twelve uniform numbers.
    fn next(&mut self) -> f64 {
        let mut sum = 0.0;
        for _ in 0..12 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        }
        sum
    }
}

impl Flight {
    /// Flies so many samples at that rate.
    pub(crate) fn fly(rate_hz: f64, samples: usize) -> Self {
        let mut noise = Noise(2026);
        let mut x: Motion = [U0, 0.0, U0 * THETA0.tan(), 0.0, 0.0, 0.0, 0.0, THETA0, 0.3, 1000.0];
        let dt = 1.0 / rate_hz / SUBSTEPS as f64;
        let samples = (0..samples)
            .map(|k| {
                let t = k as f64 / rate_hz;
                // The first second and a bit is trim.
                let control = |t: f64| if t < 1.2 { [0.0; 4] } else { controls(t - 1.2) };
                let sample = measured(t, &x, control(t), &mut noise);
                for i in 0..SUBSTEPS {
                    let t = t + i as f64 * dt;
                    let first = slope(&x, control(t));
                    let middle: Motion = std::array::from_fn(|j| x[j] + 0.5 * dt * first[j]);
                    let second = slope(&middle, control(t + 0.5 * dt));
                    for (x, slope) in x.iter_mut().zip(second) {
                        *x += dt * slope;
                    }
                }
                sample
            })
            .collect();
        Flight { samples }
    }
}

fn measured(time_s: f64, x: &Motion, control: [f64; 4], noise: &mut Noise) -> Sample {
    let ([ax, ay, az], _) = forces(x, control);
    let [u, v, w, p, q, r, phi, theta, psi, h] = *x;
    let speed = (u * u + v * v + w * w).sqrt();
    let values = [ax, ay, az, p, q, r, phi, theta, psi, speed, w.atan2(u), (v / speed).asin(), h];
    let mut sample = Sample::new(time_s);
    for ((channel, std), value) in NOISE.into_iter().zip(values) {
        sample.set(channel, value + std * noise.next());
    }
    for (channel, value) in Channel::CONTROLS.into_iter().zip(control) {
        sample.set(channel, value);
    }
    sample
}
