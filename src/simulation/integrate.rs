//! The motion over time: Runge and Kutta's fourth order over a mesh that holds every bend of what drives it.
//!
//! Consumes the model (a linear one, or a Level-1 aircraft to whose accelerations the linear one's deviations add), the
//! blade's deviations at mesh points and half way between, gusts and rotor speed; produces the true state at every mesh
//! point. Between neighbouring mesh points everything that drives the motion is a straight line, so the order of the method
//! is not spoilt by corners.
//! Numerics: steps of at most [`MAX_STEP_S`], shorter where the model's fastest mode asks for it ([`STEP_ANGLE`]);
//! `tests/jacobians` compares half the step and the matrix exponential.
//! Where the motion leaves what the kinematics can carry ([`MAX_PITCH`], [`MAX_MAGNITUDE`]) it ends, and it is said when.

use super::history::History;
use super::level1::aircraft::Situation;
use super::level1::flapping::Flap;
use super::level1::inner::{INNER, Inner};
use super::level1::trim::Trimmed;
use super::linear::{forces, state_matrix, trim_specific_force};
use super::motion::{MOTION_STATES, Motion};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::{AXES, VARIABLES, Variable};
use crate::flight::model::LinearModel;
use crate::num::eigen::eigenvalues_8;

/// Longest step, s.
pub const MAX_STEP_S: f64 = 0.005;

/// Longest step of a Level-1 aircraft, s.
pub const MAX_LEVEL1_STEP_S: f64 = 1.0 / 256.0;

/// Largest product of step and fastest mode, rad: the step's error is about its fifth power over 120.
pub const STEP_ANGLE: f64 = 0.05;

/// Pitch attitude at which a flight ends, rad (89 degrees).
pub const MAX_PITCH: f64 = 1.553_343;

/// Magnitude of a velocity, rate or bank angle at which a flight ends: beyond any aircraft.
pub const MAX_MAGNITUDE: f64 = 1e4;

/// The true state at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueState {
    /// Time, s.
    pub time_s: f64,
    /// Velocity u, v, w through the air, gusts included, body axes, m/s.
    pub air_velocity: [f64; 3],
    /// Motion of the body; without gusts its velocity is that through the air.
    pub motion: Motion,
    /// Specific force at the centre of mass, body axes, m/s^2.
    pub specific_force: [f64; 3],
    /// Angular acceleration, body axes, rad/s^2.
    pub angular_acceleration: [f64; 3],
    /// The pilot's controls by [`Control`] place, rad.
    pub controls: [f64; CONTROLS],
    /// The blade's positions behind the control path, by [`Control`] place, rad.
    pub blade: [f64; CONTROLS],
    /// Rotor speed, rad/s, where the model has one.
    pub rotor_speed: Option<f64>,
    /// What else there is to say of the rotor, of a Level-1 aircraft.
    pub rotor: Option<TrueRotor>,
}

/// The rotor of a Level-1 aircraft at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueRotor {
    /// Engine torque at the main rotor, N m; that which the rotors take where no governor makes it.
    pub torque: f64,
    /// Flap in the rotor's own axes, azimuth from aft in the direction of rotation, rad.
    pub flap: Flap,
}

impl TrueState {
    /// Rate of change of the motion, as its vector.
    fn rate_of_change(&self) -> [f64; MOTION_STATES] {
        self.motion.rate_of_change(self.specific_force, self.angular_acceleration).to_vector()
    }
}

/// A Level-1 aircraft, and what effects make of it.
#[derive(Clone, Copy)]
pub(crate) struct Nonlinear<'d> {
    pub(crate) trimmed: &'d Trimmed,
    /// Share of each control's deviation that acts.
    pub(crate) effectiveness: [f64; CONTROLS],
    /// Whether the linear model has anything to add.
    pub(crate) added: bool,
}

/// The motion and the states beside it.
pub(crate) type State = ([f64; MOTION_STATES], [f64; INNER]);

/// What drives the motion.
pub(crate) struct Drive<'d> {
    pub(crate) model: &'d LinearModel,
    pub(crate) level1: Option<Nonlinear<'d>>,
    /// Mesh points and the points half way between, in turn: t0, half, t1, half, t2.
    pub(crate) nodes_s: &'d [f64],
    /// Blade deviations at every node.
    pub(crate) blade: &'d [[f64; CONTROLS]],
    pub(crate) controls: &'d [History; CONTROLS],
    pub(crate) gusts: Option<&'d [History; 3]>,
    pub(crate) rotor_speed: Option<&'d History>,
}

/// Mesh points with the halves between: every wanted time, none further apart than the step.
pub(crate) fn nodes(mut wanted_s: Vec<f64>, max_step_s: f64) -> Vec<f64> {
    wanted_s.sort_by(f64::total_cmp);
    wanted_s.dedup();
    let mut nodes = Vec::with_capacity(2 * wanted_s.len());
    nodes.extend(wanted_s.first());
    for (&t0, &t1) in wanted_s.iter().zip(wanted_s.iter().skip(1)) {
        let parts = 2 * libm::ceil((t1 - t0) / max_step_s).max(1.0) as usize;
        nodes.extend((1..parts).map(|part| t0 + (t1 - t0) * (part as f64 / parts as f64)));
        nodes.push(t1);
    }
    nodes
}

/// The longest step that a model allows, s; `None` where its modes cannot be computed.
pub(crate) fn longest_step(model: &LinearModel) -> Option<f64> {
    let a = state_matrix(model);
    let modes = eigenvalues_8(&core::array::from_fn(|row| core::array::from_fn(|column| a[(row, column)])))?;
    let fastest = modes.iter().map(|mode| libm::hypot(mode.re, mode.im)).fold(0.0, f64::max);
    if fastest.is_finite() { Some(MAX_STEP_S.min(STEP_ANGLE / fastest.max(f64::MIN_POSITIVE))) } else { None }
}

/// The longest step that a Level-1 aircraft allows, s; `None` where its modes cannot be computed.
pub(crate) fn longest_level1_step(trimmed: &Trimmed) -> Option<f64> {
    let modes = trimmed.whole_eigenvalues()?;
    let fastest = modes.iter().map(|mode| libm::hypot(mode.re, mode.im)).fold(0.0, f64::max);
    if fastest.is_finite() { Some(MAX_LEVEL1_STEP_S.min(STEP_ANGLE / fastest.max(f64::MIN_POSITIVE))) } else { None }
}

impl Drive<'_> {
    /// Flies on from the state at the first mesh point, which becomes that at the last; adds the true states at the mesh
    /// points after those that are there. The time at which the motion diverged, where it did.
    pub(crate) fn fly(&self, now: &mut State, states: &mut Vec<TrueState>) -> Option<f64> {
        let known_s = states.last().map_or(f64::NEG_INFINITY, |state| state.time_s);
        let mut node = 0;
        while let Some((state, inner_rates)) = self.state_at(node, now) {
            if !carries(&state.motion) {
                return Some(state.time_s);
            }
            if state.time_s > known_s {
                states.push(state);
            }
            let Some(next) = self.step(node, now, (state.rate_of_change(), inner_rates)) else { break };
            *now = next;
            node += 2;
        }
        None
    }

    /// One Runge-Kutta step from a mesh point, where the slope is known, to the next; `None` past the last.
    fn step(&self, node: usize, x: &State, k1: State) -> Option<State> {
        let h = self.nodes_s.get(node + 2)? - self.nodes_s.get(node)?;
        let slope = |node: usize, x: &State| -> Option<State> {
            let (state, inner) = self.state_at(node, x)?;
            Some((state.rate_of_change(), inner))
        };
        let k2 = slope(node + 1, &along(x, 0.5 * h, &k1))?;
        let k3 = slope(node + 1, &along(x, 0.5 * h, &k2))?;
        let k4 = slope(node + 2, &along(x, h, &k3))?;
        let inner = if self.level1.is_some() { weighted(&x.1, h, [&k1.1, &k2.1, &k3.1, &k4.1]) } else { x.1 };
        Some((weighted(&x.0, h, [&k1.0, &k2.0, &k3.0, &k4.0]), inner))
    }

    /// Everything that holds at a node for this state, and the rates of the inner states.
    fn state_at(&self, node: usize, (motion, inner): &State) -> Option<(TrueState, [f64; INNER])> {
        let motion = Motion::from_vector(*motion);
        let time_s = *self.nodes_s.get(node)?;
        let moved = *self.blade.get(node)?;
        let trim = &self.model.trim;
        let [u, v, w] = motion.velocity;
        let [gust_u, gust_v, gust_w] = self.gusts.map_or([0.0; 3], |[x, y, z]| [x.at(time_s), y.at(time_s), z.at(time_s)]);
        let air_velocity = [u - gust_u, v - gust_v, w - gust_w];
        let mut deviations = [0.0; VARIABLES];
        let body = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R];
        for (variable, value) in body.into_iter().zip(air_velocity.into_iter().chain(motion.rates)) {
            deviations[variable.index()] = value - trim.of(variable);
        }
        let mut blade = trim.controls;
        blade.iter_mut().zip(moved).for_each(|(position, deviation)| *position += deviation);
        let mut rotor_speed = self.rotor_speed.map(|history| history.at(time_s)).or(trim.rotor_speed);
        let (mut inner_rates, mut rotor) = ([0.0; INNER], None);
        let deviation = |speed: Option<f64>| speed.zip(trim.rotor_speed).map_or(0.0, |(speed, at_trim)| speed - at_trim);
        let accelerations = match &self.level1 {
            None => {
                controls_into(&mut deviations, moved);
                forces(self.model, &deviations, deviation(rotor_speed))
            }
            Some(Nonlinear { trimmed, effectiveness, added }) => {
                let asked = Situation {
                    velocity: air_velocity,
                    rates: motion.rates,
                    blade,
                    rotor_speed: rotor_speed.unwrap_or(trimmed.aircraft.main_rotor.speed),
                    density: trimmed.condition.density,
                };
                let inner = Inner::from_vector(*inner);
                let instant = trimmed.instant(&asked, &inner, effectiveness, |blade, speed| {
                    added.then(|| self.additions(deviations, blade, deviation(Some(speed))))
                });
                (blade, rotor_speed) = (instant.blade, Some(instant.rotor_speed));
                inner_rates = instant.rates.to_vector();
                let torque = if trimmed.aircraft.options.governed { inner.torque } else { instant.response.torque };
                rotor = Some(TrueRotor { torque, flap: instant.response.flap });
                instant.response.accelerations
            }
        };
        let [ax, ay, az, dp, dq, dr] = accelerations;
        let state = TrueState {
            time_s,
            air_velocity,
            motion,
            specific_force: [ax, ay, az],
            angular_acceleration: [dp, dq, dr],
            controls: Control::ALL.map(|control| self.controls[control.index()].at(time_s)),
            blade,
            rotor_speed,
            rotor,
        };
        Some((state, inner_rates))
    }

    /// What the linear model's deviations add to a Level-1 aircraft.
    fn additions(&self, mut deviations: [f64; VARIABLES], blade: [f64; CONTROLS], rotor_speed: f64) -> [f64; AXES] {
        let trim = &self.model.trim;
        let mut moved = blade;
        moved.iter_mut().zip(trim.controls).for_each(|(position, at_trim)| *position -= at_trim);
        controls_into(&mut deviations, moved);
        let mut added = forces(self.model, &deviations, rotor_speed);
        added.iter_mut().zip(trim_specific_force(trim)).for_each(|(force, at_trim)| *force -= at_trim);
        added
    }
}

fn controls_into(deviations: &mut [f64; VARIABLES], moved: [f64; CONTROLS]) {
    for (control, value) in Control::ALL.into_iter().zip(moved) {
        deviations[control.variable().index()] = value;
    }
}

/// Runge and Kutta's weights.
fn weighted<const N: usize>(x: &[f64; N], h: f64, [k1, k2, k3, k4]: [&[f64; N]; 4]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (((((sum, x), k1), k2), k3), k4) in sum.iter_mut().zip(x).zip(k1).zip(k2).zip(k3).zip(k4) {
        *sum = x + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
    }
    sum
}

fn along(x: &State, h: f64, slope: &State) -> State {
    let mut moved = *x;
    moved.0.iter_mut().zip(slope.0).for_each(|(x, slope)| *x += h * slope);
    moved.1.iter_mut().zip(slope.1).for_each(|(x, slope)| *x += h * slope);
    moved
}

/// Whether the kinematics carry this motion.
fn carries(motion: &Motion) -> bool {
    let [phi, theta, _] = motion.attitude;
    let mut watched = motion.velocity.into_iter().chain(motion.rates).chain([phi]);
    watched.all(|value| value.is_finite() && libm::fabs(value) < MAX_MAGNITUDE)
        && libm::fabs(theta) < MAX_PITCH
        && motion.to_vector().iter().all(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_holds_every_wanted_time_and_halves_between() {
        assert_eq!(nodes(vec![0.5, 0.0, 0.0, 1.5], 0.5), [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5]);
        assert_eq!(nodes(vec![2.0], 0.5), [2.0]);
        assert_eq!(nodes(vec![], 0.5), Vec::<f64>::new());
    }

    #[test]
    fn a_fast_mode_shortens_the_step() {
        let mut model = LinearModel::default();
        assert_eq!(longest_step(&model), Some(MAX_STEP_S));
        *model.derivative_mut(crate::flight::derivative::Axis::L, Variable::P) = -100.0;
        assert!((longest_step(&model).unwrap() - STEP_ANGLE / 100.0).abs() < 1e-12);
        *model.derivative_mut(crate::flight::derivative::Axis::L, Variable::P) = f64::INFINITY;
        assert_eq!(longest_step(&model), None);
    }
}
