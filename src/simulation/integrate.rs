//! Integration of the motion: the classical Runge-Kutta method of fourth order over a mesh with every breakpoint of the inputs.
//!
//! Consumes the model (a linear one, or a Level-1 aircraft to whose accelerations the linear one's deviations add), the
//! blade's deviations at mesh points and half way between, gusts and rotor speed; produces the true state at every mesh
//! point. Between neighbouring mesh points every input is linear, so corners do not lower the order of the method.
//! Numerics: steps of at most [`MAX_STEP_S`], shorter where the model's fastest mode asks for it ([`STEP_ANGLE`]);
//! `tests/jacobians` compares half the step and the matrix exponential.
//! Where the motion leaves the range of the kinematics ([`MAX_PITCH`], [`MAX_MAGNITUDE`]) it ends, at a reported time.

use super::level1::aircraft::{Equations, Situation};
use super::level1::flapping::Flap;
use super::level1::inflow::InflowGuess;
use super::level1::internal_states::{INNER, InternalStates};
use super::level1::trim::Trimmed;
use super::motion::{MOTION_STATES, Motion};
use super::unmodelled::Unmodelled;
use crate::dynamics::linear::{Turning, forces, state_matrix, trim_specific_force};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::model::LinearModel;
use crate::flight::signal::piecewise_linear::History;
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

/// Place of the yawing moment.
const YAW: usize = Axis::N.index();

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

/// A Level-1 aircraft, and what effects make of it.
#[derive(Clone, Copy)]
pub(crate) struct Level1Motion<'d> {
    pub(crate) trimmed: &'d Trimmed,
    pub(crate) equations: Equations<'d>,
    /// Share of each control's deviation that acts.
    pub(crate) effectiveness: [f64; CONTROLS],
    /// Whether any inner state moves.
    pub(crate) inner: bool,
    /// Whether the linear model has anything to add.
    pub(crate) added: bool,
}

/// The motion and the states beside it, or their rates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct IntegrationState {
    pub(crate) motion: [f64; MOTION_STATES],
    pub(crate) inner: [f64; INNER],
    /// Of what no effect describes.
    pub(crate) memory: f64,
}

struct Moment {
    accelerations: [f64; AXES],
    air_velocity: [f64; 3],
    blade: [f64; CONTROLS],
    rotor_speed: Option<f64>,
    rotor: Option<TrueRotor>,
    inner_rates: InternalStates,
    memory_rate: f64,
    /// Start of the next instant's inflow iterations.
    guess: InflowGuess,
}

pub(crate) struct MotionDrive<'d> {
    pub(crate) model: &'d LinearModel,
    pub(crate) level1: Option<Level1Motion<'d>>,
    /// Mesh points and the points half way between, in turn: t0, half, t1, half, t2.
    pub(crate) nodes_s: &'d [f64],
    /// Blade deviations at every node.
    pub(crate) blade: &'d [[f64; CONTROLS]],
    pub(crate) controls: &'d [History; CONTROLS],
    pub(crate) gusts: Option<&'d [History; 3]>,
    pub(crate) rotor_speed: Option<&'d History>,
    pub(crate) unmodelled: Option<&'d Unmodelled>,
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

impl MotionDrive<'_> {
    /// Flies on from the state at the first mesh point, which becomes that at the last; adds the true states at the mesh
    /// points after those that are there. The time at which the motion diverged, where it did.
    pub(crate) fn fly(&self, now: &mut IntegrationState, states: &mut Vec<TrueState>) -> Option<f64> {
        let known_s = states.last().map_or(f64::NEG_INFINITY, |state| state.time_s);
        states.reserve(self.nodes_s.len() / 2 + 1);
        let (mut node, mut guess, mut places) = (0, InflowGuess::NONE, [0; CONTROLS]);
        let mut slopes = [IntegrationState::default(); 4];
        while let (Some(&time_s), Some(moment)) = (self.nodes_s.get(node), self.moment((node, node), now, guess)) {
            let motion = Motion::from_vector(now.motion);
            if !carries(&motion) {
                return Some(time_s);
            }
            if time_s > known_s {
                let mut controls = [0.0; CONTROLS];
                for ((value, history), place) in controls.iter_mut().zip(self.controls).zip(&mut places) {
                    *value = history.at_next(time_s, place);
                }
                let [ax, ay, az, dp, dq, dr] = moment.accelerations;
                states.push(TrueState {
                    time_s,
                    air_velocity: moment.air_velocity,
                    motion,
                    specific_force: [ax, ay, az],
                    angular_acceleration: [dp, dq, dr],
                    controls,
                    blade: moment.blade,
                    rotor_speed: moment.rotor_speed,
                    rotor: moment.rotor,
                });
            }
            guess = moment.guess;
            self.slope_into(&mut slopes[0], &moment, &now.motion);
            if self.step(node, now, &mut slopes, &mut guess).is_none() {
                break;
            }
            node += 2;
        }
        None
    }

    /// One Runge-Kutta step from a mesh point, where the first slope is known, to the next; `None` past the last.
    fn step(&self, node: usize, x: &mut IntegrationState, k: &mut [IntegrationState; 4], guess: &mut InflowGuess) -> Option<()> {
        let h = self.nodes_s.get(node + 2)? - self.nodes_s.get(node)?;
        let mut there = *x;
        let mut slope = |there_node: usize, h: f64, known: &IntegrationState, found: &mut IntegrationState| -> Option<()> {
            along(&mut there.motion, &x.motion, h, &known.motion);
            if self.inner() {
                along(&mut there.inner, &x.inner, h, &known.inner);
            }
            there.memory = x.memory + h * known.memory;
            let moment = self.moment((there_node, node), &there, *guess)?;
            *guess = moment.guess;
            self.slope_into(found, &moment, &there.motion);
            Some(())
        };
        let [k1, k2, k3, k4] = k;
        slope(node + 1, 0.5 * h, k1, k2)?;
        slope(node + 1, 0.5 * h, k2, k3)?;
        slope(node + 2, h, k3, k4)?;
        weighted(&mut x.motion, h, [&k1.motion, &k2.motion, &k3.motion, &k4.motion]);
        if self.inner() {
            weighted(&mut x.inner, h, [&k1.inner, &k2.inner, &k3.inner, &k4.inner]);
        }
        x.memory += h / 6.0 * (k1.memory + 2.0 * (k2.memory + k3.memory) + k4.memory);
        Some(())
    }

    /// Whether anything but the motion moves.
    fn inner(&self) -> bool {
        self.level1.as_ref().is_some_and(|level1| level1.inner)
    }

    /// Rates of the state that holds at that moment.
    fn slope_into(&self, slope: &mut IntegrationState, moment: &Moment, motion: &[f64; MOTION_STATES]) {
        let [ax, ay, az, dp, dq, dr] = moment.accelerations;
        slope.motion = Motion::from_vector(*motion).rate_of_change([ax, ay, az], [dp, dq, dr]).to_vector();
        if self.inner() {
            slope.inner = moment.inner_rates.to_vector();
        }
        slope.memory = moment.memory_rate;
    }

    /// The rotor's acceleration over the step from a mesh point; over the last one before the end. Nothing where none matters.
    fn rotor_rate(&self, from: usize) -> f64 {
        let Some(history) = self.rotor_speed.filter(|_| self.model.reaction != 0.0) else { return 0.0 };
        let step = |from: usize| Some((*self.nodes_s.get(from)?, *self.nodes_s.get(from + 2)?));
        let last = || step(from.checked_sub(2)?);
        step(from).or_else(last).map_or(0.0, |(t0, t1)| (history.at(t1) - history.at(t0)) / (t1 - t0))
    }

    /// Everything that holds at a node, within the step from a mesh point, for this state; inflow iterations start from
    /// `guess` on.
    fn moment(&self, (node, from): (usize, usize), state: &IntegrationState, guess: InflowGuess) -> Option<Moment> {
        let [u, v, w, p, q, r, ..] = state.motion;
        let time_s = *self.nodes_s.get(node)?;
        let moved = *self.blade.get(node)?;
        let trim = &self.model.trim;
        let [gust_u, gust_v, gust_w] = self.gusts.map_or([0.0; 3], |[x, y, z]| [x.at(time_s), y.at(time_s), z.at(time_s)]);
        let air_velocity = [u - gust_u, v - gust_v, w - gust_w];
        let deviations = || {
            let mut deviations = [0.0; VARIABLES];
            let body = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R];
            for (variable, value) in body.into_iter().zip(air_velocity.into_iter().chain([p, q, r])) {
                deviations[variable.index()] = value - trim.of(variable);
            }
            deviations
        };
        let mut blade = trim.controls;
        blade.iter_mut().zip(moved).for_each(|(position, deviation)| *position += deviation);
        let rotor_speed = self.rotor_speed.map(|history| history.at(time_s)).or(trim.rotor_speed);
        let rate = self.rotor_rate(from);
        let turning = |speed: Option<f64>| {
            let deviation = speed.zip(trim.rotor_speed).map_or(0.0, |(speed, at_trim)| speed - at_trim);
            Turning { deviation, rate }
        };
        let Some(Level1Motion { trimmed, equations, effectiveness, added, .. }) = &self.level1 else {
            let mut deviations = deviations();
            controls_into(&mut deviations, moved);
            let mut accelerations = forces(self.model, &deviations, turning(rotor_speed));
            let memory_rate = self.unmodelled(&mut accelerations, &deviations, state.memory);
            let inner_rates = InternalStates::default();
            return Some(Moment {
                accelerations,
                air_velocity,
                blade,
                rotor_speed,
                rotor: None,
                inner_rates,
                memory_rate,
                guess,
            });
        };
        let asked = Situation {
            velocity: air_velocity,
            rates: [p, q, r],
            blade,
            rotor_speed: rotor_speed.unwrap_or(trimmed.aircraft.main_rotor.speed),
            density: trimmed.condition.density,
        };
        let inner = InternalStates::from_vector(state.inner);
        let instant = trimmed.instant(equations, (&asked, &inner, guess), effectiveness, |blade, speed| {
            added.then(|| self.additions(deviations(), blade, turning(Some(speed))))
        });
        let torque = if trimmed.aircraft.options.governed {
            trimmed.aircraft.engine.delivered(inner.torque)
        } else {
            instant.response.torque
        };
        let mut accelerations = instant.response.accelerations;
        accelerations[YAW] *= self.model.share_of_yaw();
        let mut memory_rate = 0.0;
        if self.unmodelled.is_some() {
            let mut deviations = deviations();
            controls_into(&mut deviations, core::array::from_fn(|place| instant.blade[place] - trim.controls[place]));
            memory_rate = self.unmodelled(&mut accelerations, &deviations, state.memory);
        }
        Some(Moment {
            accelerations,
            air_velocity,
            blade: instant.blade,
            rotor_speed: Some(instant.rotor_speed),
            rotor: Some(TrueRotor { torque, flap: instant.response.flap }),
            inner_rates: instant.rates,
            memory_rate,
            guess: instant.response.inflows,
        })
    }

    /// Adds what no effect describes to the accelerations; the rate of its memory.
    fn unmodelled(&self, accelerations: &mut [f64; AXES], deviations: &[f64; VARIABLES], memory: f64) -> f64 {
        let Some(law) = self.unmodelled else { return 0.0 };
        let (added, rate) = law.at(deviations, memory);
        accelerations.iter_mut().zip(added).for_each(|(acceleration, added)| *acceleration += added);
        rate
    }

    /// What the linear model's deviations add to a Level-1 aircraft, before its rotor reacts.
    fn additions(&self, mut deviations: [f64; VARIABLES], blade: [f64; CONTROLS], rotor: Turning) -> [f64; AXES] {
        let trim = &self.model.trim;
        let mut moved = blade;
        moved.iter_mut().zip(trim.controls).for_each(|(position, at_trim)| *position -= at_trim);
        controls_into(&mut deviations, moved);
        let mut added = forces(self.model, &deviations, rotor);
        added.iter_mut().zip(trim_specific_force(trim)).for_each(|(force, at_trim)| *force -= at_trim);
        added[YAW] /= self.model.share_of_yaw();
        added
    }
}

fn controls_into(deviations: &mut [f64; VARIABLES], moved: [f64; CONTROLS]) {
    for (control, value) in Control::ALL.into_iter().zip(moved) {
        deviations[control.variable().index()] = value;
    }
}

/// x + h k.
fn along<const N: usize>(there: &mut [f64; N], x: &[f64; N], h: f64, k: &[f64; N]) {
    for ((there, x), k) in there.iter_mut().zip(x).zip(k) {
        *there = x + h * k;
    }
}

/// Runge and Kutta's weights.
fn weighted<const N: usize>(x: &mut [f64; N], h: f64, [k1, k2, k3, k4]: [&[f64; N]; 4]) {
    let sixth = h / 6.0;
    for ((((x, k1), k2), k3), k4) in x.iter_mut().zip(k1).zip(k2).zip(k3).zip(k4) {
        *x += sixth * (k1 + 2.0 * (k2 + k3) + k4);
    }
}

/// Whether the kinematics carry this motion.
fn carries(motion: &Motion) -> bool {
    let [phi, theta, psi] = motion.attitude;
    let mut watched = motion.velocity.into_iter().chain(motion.rates).chain([phi]);
    watched.all(|value| libm::fabs(value) < MAX_MAGNITUDE) && libm::fabs(theta) < MAX_PITCH && (psi + motion.altitude).is_finite()
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
