//! A run with the model and everything that reaches it: motion, outputs, and what columns do to forces.
//!
//! Consumes the state, the blades' motion and the model; produces the state's rate of change and its Jacobian, each output with
//! its slopes by the state, by forces and by the place of its sensor, and the force or moment of every column. Equations of
//! motion are those of `simulation::motion`; gusts take from the velocity through the air, and their rates are
//!     g' = -g/tau                                                                                     (1)
//! with tau the scale length over the airspeed along the flight, and two thirds of it across.
//! Along an axis that the model says nothing of, the force is what the accelerometer felt there; where none stands, and about
//! such an axis, it is noise, and the motion follows its instruments.

use super::aircraft::{Changed, Partials};
use super::column::Column;
use super::driven::{Driven, MOVED, Moved, ROTOR_RATE, turning};
use super::filter::{GUST, STATES, Square, State};
use super::run_record::{FELT, OUTPUTS, ROTOR, Record};
use crate::estimation::compatibility::readings::Readings;
use crate::estimation::kinematics::{Attitude, velocity_rate, velocity_rate_by_rates, velocity_rate_by_velocity};
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::model::Trim;

/// Forward speed below which vanes tell nothing, m/s.
const SPEED_MIN: f64 = 2.0;

/// A run with the model and everything that reaches it.
pub struct Posed<'a> {
    /// The run.
    pub record: &'a Record,
    /// The model.
    pub model: &'a Changed<'a>,
    /// Its trim.
    pub trim: &'a Trim,
    /// What reaches the blades.
    pub driven: &'a Driven,
    /// Changes of that, by place.
    pub moved: &'a [&'a Driven],
    /// The outputs' readings, skews undone.
    pub readings: &'a Readings,
    /// Offset of the forces and moments of this run.
    pub constant: [f64; AXES],
    /// Biases and factors of the outputs.
    pub bias: [f64; OUTPUTS],
    /// See `bias`.
    pub factor: [f64; OUTPUTS],
    /// Where accelerometers stand, m.
    pub accelerometer_m: [f64; 3],
    /// Where vanes stand, m.
    pub vane_m: [f64; 3],
    /// The output with a lag of its own, and its time constant, s.
    pub lag: Option<(usize, f64)>,
}

/// Forces and their slopes at a node.
#[derive(Clone, Copy)]
pub struct Here {
    pub(super) force: [f64; AXES],
    pub(super) by: Partials,
    pub(super) by_rotor: [f64; AXES],
    pub(super) by_rate: [f64; AXES],
    pub(super) deviations: [f64; VARIABLES],
    pub(super) moved: Moved,
}

impl Posed<'_> {
    pub(super) fn deviations(&self, x: &State, moved: &Moved) -> [f64; VARIABLES] {
        deviations(self.trim, x, moved)
    }

    pub(super) fn force(&self, x: &State, moved: &Moved) -> [f64; AXES] {
        let mut force = self.model.forces(&self.deviations(x, moved), turning(moved));
        let turning = [force[3], force[4], force[5]];
        for (axis, force) in force.iter_mut().enumerate() {
            *force = self.felt(axis, x, moved, turning).unwrap_or(*force) + self.constant[axis];
        }
        force
    }

    /// What an accelerometer felt along an axis that the model says nothing of, brought to the centre of mass:
    ///     f = f_measured - w' x r - w x (w x r)                                                       (2)
    fn felt(&self, axis: usize, x: &State, moved: &Moved, [dp, dq, dr]: [f64; 3]) -> Option<f64> {
        self.record.inputs.get(FELT + axis)?.as_ref()?;
        let ([rx, ry, rz], [p, q, r]) = (self.accelerometer_m, [x[3], x[4], x[5]]);
        let arm = match axis {
            0 => dq * rz - dr * ry + p * (q * ry + r * rz) - (q * q + r * r) * rx,
            1 => dr * rx - dp * rz + q * (p * rx + r * rz) - (p * p + r * r) * ry,
            _ => dp * ry - dq * rx + r * (p * rx + q * ry) - (p * p + q * q) * rz,
        };
        Some(moved.get(FELT + axis)? - arm)
    }

    /// Rate of change of the state.
    pub(super) fn rate(&self, x: &State, force: &[f64; AXES], gust_s: f64) -> Option<State> {
        let attitude = Attitude::regular(x[6], x[7])?;
        let (velocity, rates) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        let [du, dv, dw] = velocity_rate(velocity, rates, [force[0], force[1], force[2]]);
        let [gx, gy, gz] = attitude.gravity();
        let [dphi, dtheta, dpsi] = attitude.euler_rates(rates);
        let mut rate = [0.0; STATES];
        rate[..10].copy_from_slice(&[
            du + gx,
            dv + gy,
            dw + gz,
            force[3],
            force[4],
            force[5],
            dphi,
            dtheta,
            dpsi,
            attitude.climb(velocity),
        ]);
        for axis in 0..3 {
            rate[GUST + axis] = -x[GUST + axis] / gust_time(axis, gust_s);
        }
        Some(rate)
    }

    /// Jacobian of the rate of change by the state.
    pub(super) fn jacobian(&self, x: &State, by: &Partials, gust_s: f64) -> Option<Square> {
        let attitude = Attitude::regular(x[6], x[7])?;
        let (velocity, rates) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        let (by_velocity, by_rates) = (velocity_rate_by_velocity(rates), velocity_rate_by_rates(velocity));
        let (gravity, euler) = (attitude.gravity_partials(), attitude.euler_partials(rates));
        let mut a = [[0.0; STATES]; STATES];
        for i in 0..3 {
            for j in 0..3 {
                a[i][j] = by_velocity[i][j];
                a[i][3 + j] = by_rates[i][j];
                a[6 + i][3 + j] = euler.by_rates[i][j];
            }
            a[i][6..8].copy_from_slice(&gravity[i]);
            a[6 + i][6..8].copy_from_slice(&euler.by_attitude[i]);
            a[GUST + i][GUST + i] = -1.0 / gust_time(i, gust_s);
        }
        a[9][..3].copy_from_slice(&attitude.climb_by_vector());
        a[9][6..8].copy_from_slice(&attitude.climb_by_attitude(velocity));
        for (row, by) in a.iter_mut().zip(by) {
            for j in 0..6 {
                row[j] += by[j];
            }
            for j in 0..3 {
                row[GUST + j] -= by[j];
            }
        }
        Some(a)
    }

    /// An output's true value, its slope by the state, and by forces and moments.
    pub(super) fn seen(&self, output: usize, x: &State, here: &Here) -> Option<(f64, State, [f64; AXES])> {
        let mut h = [0.0; STATES];
        let mut by_force = [0.0; AXES];
        let [p, q, r] = [x[3], x[4], x[5]];
        let value = match output {
            0..=2 => {
                let [rx, ry, rz] = self.accelerometer_m;
                let [dp, dq, dr] = [here.force[3], here.force[4], here.force[5]];
                let (tangential, centripetal, by_moment, by_rate) = match output {
                    0 => (
                        dq * rz - dr * ry,
                        p * (q * ry + r * rz) - (q * q + r * r) * rx,
                        [0.0, rz, -ry],
                        [q * ry + r * rz, p * ry - 2.0 * q * rx, p * rz - 2.0 * r * rx],
                    ),
                    1 => (
                        dr * rx - dp * rz,
                        q * (p * rx + r * rz) - (p * p + r * r) * ry,
                        [-rz, 0.0, rx],
                        [q * rx - 2.0 * p * ry, p * rx + r * rz, q * rz - 2.0 * r * ry],
                    ),
                    _ => (
                        dp * ry - dq * rx,
                        r * (p * rx + q * ry) - (p * p + q * q) * rz,
                        [ry, -rx, 0.0],
                        [r * rx - 2.0 * p * rz, r * ry - 2.0 * q * rz, p * rx + q * ry],
                    ),
                };
                by_force[output] = 1.0;
                by_force[3..].copy_from_slice(&by_moment);
                for (j, slope) in by_rate.into_iter().enumerate() {
                    h[3 + j] += slope;
                }
                for (axis, weight) in by_force.into_iter().enumerate() {
                    if weight != 0.0 {
                        let by = &here.by[axis];
                        h.iter_mut().zip(by).take(6).for_each(|(h, by)| *h += weight * by);
                        h.iter_mut().skip(GUST).zip(by).take(3).for_each(|(h, by)| *h -= weight * by);
                    }
                }
                here.force[output] + tangential + centripetal
            }
            3..=8 => {
                h[output] = 1.0;
                x[output]
            }
            9..=11 => {
                let [rx, ry, rz] = if output == 9 { [0.0; 3] } else { self.vane_m };
                let u = x[0] - x[GUST] + q * rz - r * ry;
                let v = x[1] - x[GUST + 1] + r * rx - p * rz;
                let w = x[2] - x[GUST + 2] + p * ry - q * rx;
                if !(u > SPEED_MIN) {
                    return None;
                }
                let s2 = u * u + w * w;
                let speed2 = s2 + v * v;
                let (s, speed) = (libm::sqrt(s2), libm::sqrt(speed2));
                let (value, [a, b, c]) = match output {
                    9 => (speed, [u / speed, v / speed, w / speed]),
                    10 => (libm::atan2(w, u), [-w / s2, 0.0, u / s2]),
                    _ => (libm::atan2(v, s), [-v * u / (s * speed2), s / speed2, -v * w / (s * speed2)]),
                };
                for (j, slope) in [a, b, c].into_iter().enumerate() {
                    h[j] = slope;
                    h[GUST + j] = -slope;
                }
                h[3] = c * ry - b * rz;
                h[4] = a * rz - c * rx;
                h[5] = b * rx - a * ry;
                value
            }
            _ => {
                h[9] = 1.0;
                x[9]
            }
        };
        Some((value, h, by_force))
    }

    /// Slope of an output by the place of its sensor.
    pub(super) fn by_place(&self, output: usize, axis: usize, x: &State, here: &Here) -> f64 {
        let [p, q, r] = [x[3], x[4], x[5]];
        let [dp, dq, dr] = [here.force[3], here.force[4], here.force[5]];
        match output {
            0..=2 => {
                let rows = [
                    [-(q * q + r * r), p * q - dr, p * r + dq],
                    [p * q + dr, -(p * p + r * r), q * r - dp],
                    [p * r - dq, q * r + dp, -(p * p + q * q)],
                ];
                rows[output][axis]
            }
            10 | 11 => {
                let Some((_, h, _)) = self.seen(output, x, here) else { return 0.0 };
                let [a, b, c] = [h[0], h[1], h[2]];
                [b * r - c * q, c * p - a * r, a * q - b * p][axis]
            }
            _ => 0.0,
        }
    }

    /// Axis of a column's force or moment and its value per unit of the parameter, of one that acts on one axis.
    fn column_force(&self, column: Column, here: &Here) -> Option<(usize, f64)> {
        // What is added to N turns the rotor with it.
        let share = |axis: Axis| if axis == Axis::N { self.model.share_of_yaw() } else { 1.0 };
        match column {
            Column::Derivative(axis, variable) => Some((axis.index(), share(axis) * here.deviations[variable.index()])),
            Column::Term(axis, term) => Some((axis.index(), share(axis) * term.value(&here.deviations))),
            Column::RotorSpeed(axis) => Some((axis.index(), share(axis) * here.moved[ROTOR])),
            Column::Reaction(sign) => {
                let yaw = Axis::N.index();
                let turned = here.force[yaw] - self.constant[yaw];
                Some((yaw, share(Axis::N) * (here.moved[ROTOR_RATE] - sign * turned)))
            }
            Column::Constant(axis) => Some((axis.index(), 1.0)),
            _ => None,
        }
    }

    /// The same of one that moves all axes.
    fn column_forces(&self, column: Column, here: &Here, moved: impl Fn(usize) -> Moved) -> Option<[f64; AXES]> {
        match column {
            Column::Effectiveness(control) => {
                let variable = Variable::CONTROLS.get(control)?.index();
                let moved = here.deviations[variable] / self.model.share(control);
                Some(core::array::from_fn(|axis| here.by[axis][variable] * moved))
            }
            Column::Moved(place) => {
                let moved = moved(place);
                Some(core::array::from_fn(|axis| {
                    let blades = Variable::CONTROLS
                        .into_iter()
                        .zip(&moved)
                        .map(|(variable, moved)| here.by[axis][variable.index()] * moved);
                    blades.sum::<f64>() + here.by_rotor[axis] * moved[ROTOR] + here.by_rate[axis] * moved[ROTOR_RATE]
                }))
            }
            _ => None,
        }
    }

    /// Forces of all columns at a node, [axes x columns].
    pub(super) fn all_forces(&self, columns: &[Column], here: &Here, node: usize, out: &mut [f32]) {
        out.fill(0.0);
        let width = columns.len();
        let moved =
            |place: usize| self.moved.get(place).and_then(|driven| driven.nodes.get(node)).copied().unwrap_or([0.0; MOVED]);
        for (k, &column) in columns.iter().enumerate() {
            if let Some((axis, value)) = self.column_force(column, here) {
                out[axis * width + k] = value as f32;
            } else if let Some(values) = self.column_forces(column, here, moved) {
                values.into_iter().enumerate().for_each(|(axis, value)| out[axis * width + k] = value as f32);
            }
        }
    }
}

impl Posed<'_> {
    pub(super) fn here(&self, x: &State, moved: &Moved) -> Here {
        let deviations = self.deviations(x, moved);
        Here {
            force: self.force(x, moved),
            by: self.model.partials(&deviations, moved[ROTOR]),
            by_rotor: self.model.by_rotor(&deviations, moved[ROTOR]),
            by_rate: core::array::from_fn(|axis| {
                if axis == Axis::N.index() { self.model.reaction() * self.model.share_of_yaw() } else { 0.0 }
            }),
            deviations,
            moved: *moved,
        }
    }

    /// The same after the state has been corrected.
    pub(super) fn at(&self, mut here: Here, x: &State, before: &State) -> Here {
        for (axis, force) in here.force.iter_mut().enumerate() {
            for j in 0..6 {
                *force += here.by[axis][j] * (x[j] - before[j]);
            }
            for j in 0..3 {
                *force -= here.by[axis][j] * (x[GUST + j] - before[GUST + j]);
            }
        }
        here
    }
}

/// Deviations from trim of a state, through the air, and of what moves the blades.
pub(super) fn deviations(trim: &Trim, x: &State, moved: &Moved) -> [f64; VARIABLES] {
    let mut deviations = [0.0; VARIABLES];
    deviations[0] = x[0] - x[GUST] - trim.u;
    deviations[1] = x[1] - x[GUST + 1] - trim.v;
    deviations[2] = x[2] - x[GUST + 2] - trim.w;
    deviations[3..6].copy_from_slice(&x[3..6]);
    for (place, variable) in Variable::CONTROLS.into_iter().enumerate() {
        deviations[variable.index()] = moved[place];
    }
    deviations
}

/// Time constant of the first-order gust along an axis: across the flight Dryden's is of second order, and has both the variance
/// and the roughness of a first-order one that is a third faster.
pub(super) fn gust_time(axis: usize, gust_s: f64) -> f64 {
    if axis == 0 { gust_s } else { gust_s * (2.0 / 3.0) }
}

/// A first guess of the state, by what is measured at the start.
pub(super) fn start(posed: &Posed<'_>) -> Option<State> {
    let record = posed.record;
    let time_s = record.mesh.time_s(0);
    let read = |output: usize| {
        let series = record.outputs.get(output).and_then(Option::as_ref)?;
        Some((series.mean(time_s, time_s + 0.2) - posed.bias[output]) / posed.factor[output])
    };
    let trim = posed.trim;
    let speed = read(9).unwrap_or(trim.airspeed()).max(3.0);
    let alpha = read(10).unwrap_or(libm::atan2(trim.w, trim.u));
    let beta = read(11).unwrap_or(libm::asin((trim.v / trim.airspeed().max(1.0)).clamp(-1.0, 1.0)));
    let (sin_beta, cos_beta) = libm::sincos(beta);
    let (sin_alpha, cos_alpha) = libm::sincos(alpha);
    let mut x = [0.0; STATES];
    x[..3].copy_from_slice(&[speed * cos_alpha * cos_beta, speed * sin_beta, speed * sin_alpha * cos_beta]);
    for (output, x) in x.iter_mut().enumerate().take(9).skip(3) {
        let at_trim = match output {
            6 => trim.phi,
            7 => trim.theta,
            _ => 0.0,
        };
        *x = read(output).unwrap_or(at_trim);
    }
    x[9] = read(12).unwrap_or(0.0);
    x.iter().all(|x| x.is_finite()).then_some(x)
}

/// Rate of change of an axis's force or moment by the controls and the rotor.
pub(super) fn pushed_by(here: &Here, axis: usize, turning: &Moved) -> f64 {
    let blades = Variable::CONTROLS.into_iter().zip(turning).map(|(variable, rate)| here.by[axis][variable.index()] * rate);
    blades.sum::<f64>() + here.by_rotor[axis] * turning[ROTOR] + here.by_rate[axis] * turning[ROTOR_RATE]
}
