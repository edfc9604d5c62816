//! What is hidden, and how large: plainly visible to an engineer at full size, down to a quarter of that.
//!
//! Of a term: a force of 0.3 to 0.6 of what the axis does at the motion flown; of a derivative that the axis lives by, 0.3 to 1.0
//! of itself. Of a control's path and of an instrument: the numbers beside each.

use super::case::{FAMILIES, Sort, baseline};
use super::motion::Motion;
use super::outside::{self, Law};
use crate::support::uniform::Uniform;
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::effect::{Effect, Family, PositionedSensor};
use sideslip::flight::file::model_file::DEFAULT_TOLERANCE;
use sideslip::flight::model::LinearModel;
use sideslip::flight::term::{MOTION, Term};

/// A derivative whose force is this part of its axis's is one that the axis lives by.
const PRIMARY: f64 = 0.25;

/// What a case hides.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hidden {
    pub(crate) effects: Vec<Effect>,
    pub(crate) law: Option<Law>,
    /// Size of each, of large.
    pub(crate) share: Vec<f64>,
}

impl Hidden {
    /// Each by itself.
    pub(crate) fn each(&self) -> Vec<Hidden> {
        let effects = self.effects.iter().map(|&effect| Hidden { effects: vec![effect], ..Hidden::default() });
        let laws = self.law.iter().map(|law| Hidden { law: Some(law.clone()), ..Hidden::default() });
        effects.chain(laws).collect()
    }
}

/// The aircraft that is flown, before anything is hidden in it.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    pub(crate) model: LinearModel,
    pub(crate) off: bool,
}

impl Truth {
    /// The model of the file, or one whose every derivative is off by up to the file's tolerance.
    pub(crate) fn draw(seed: u64, off: bool) -> Self {
        let mut model = baseline();
        let mut uniform = Uniform(stream(seed, 2));
        if off {
            model.derivatives.iter_mut().flatten().for_each(|value| *value *= 1.0 + uniform.within(DEFAULT_TOLERANCE));
        }
        Truth { model, off }
    }
}

/// A seed of its own for each use of a case's seed.
pub(crate) fn stream(seed: u64, use_of: u64) -> u64 {
    let mut mixed = Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(use_of.wrapping_mul(0xd1b5_4a32_d192_ed03)));
    mixed.bits();
    mixed.bits() ^ (mixed.bits() << 21)
}

/// One draw; `None` where it has nothing to draw from.
pub(crate) fn draw(sort: Sort, seed: u64, attempt: u64, motion: &Motion) -> Option<Hidden> {
    let mut uniform = Uniform(stream(seed, 1000 + attempt));
    let turn = seed / 12;
    let mut hidden = Hidden { share: vec![share(seed, 0)], ..Hidden::default() };
    let first = hidden.share[0];
    match sort {
        Sort::Healthy => return Some(Hidden::default()),
        Sort::Single(family) => hidden.effects.push(effect(family, turn, &mut uniform, first, motion)?),
        Sort::Double => {
            let (one, other) = pair(seed);
            hidden.share.push(share(seed, 1));
            for (family, share) in [one, other].into_iter().zip(hidden.share.clone()) {
                hidden.effects.push(effect(family, uniform.bits() % 30, &mut uniform, share, motion)?);
            }
        }
        Sort::Outside => hidden.law = Some(outside::draw(seed, attempt, &mut uniform, first, motion)?),
    }
    Some(hidden)
}

/// Two different families: the fifteen pairs take turns.
fn pair(seed: u64) -> (Family, Family) {
    let pairs = FAMILIES.iter().enumerate().flat_map(|(i, &one)| FAMILIES.iter().skip(i + 1).map(move |&other| (one, other)));
    pairs.cycle().nth((seed % 15) as usize).unwrap()
}

/// The size of one hidden thing, of large: the seed's own, however often the rest is drawn again.
fn share(seed: u64, which: u64) -> f64 {
    0.25_f64.powf(Uniform(stream(seed, 3 + which)).between(0.0, 1.0))
}

pub(crate) fn one_of<T: Copy>(uniform: &mut Uniform, all: &[T]) -> T {
    all[(uniform.between(0.0, all.len() as f64) as usize).min(all.len() - 1)]
}

fn sign(uniform: &mut Uniform) -> f64 {
    if uniform.within(1.0) < 0.0 { -1.0 } else { 1.0 }
}

/// A coefficient with which something of that rms makes its part of what the axis does.
pub(crate) fn coefficient(uniform: &mut Uniform, share: f64, axis: Axis, rms: f64, motion: &Motion) -> Option<f64> {
    let size = uniform.between(0.3, 0.6) * share * motion.axis_rms(axis) * sign(uniform);
    (rms > 1e-6).then(|| size / rms)
}

/// Controls that the manoeuvres move.
const MOVED: [Control; 3] = [Control::LonCyclic, Control::LatCyclic, Control::Pedal];

/// An effect of that family; its kinds take turns.
fn effect(family: Family, turn: u64, uniform: &mut Uniform, share: f64, motion: &Motion) -> Option<Effect> {
    let axis = one_of(uniform, &Axis::ALL);
    Some(match family {
        Family::Derivative => {
            let moved = [Variable::LonCyclic, Variable::LatCyclic, Variable::Pedal];
            let variable = if turn % 3 == 2 { one_of(uniform, &moved) } else { one_of(uniform, &MOTION) };
            let (own, rms) = (baseline().derivative(axis, variable), motion.term_rms(Term::Linear(variable)));
            let primary = (own * rms).abs() > PRIMARY * motion.axis_rms(axis);
            let delta = if primary {
                own * uniform.between(0.3, 1.0) * share * sign(uniform)
            } else {
                coefficient(uniform, share, axis, rms, motion)?
            };
            Effect::Derivative { axis, variable, delta }
        }
        Family::Nonlinear => {
            let term = one_of(uniform, &Term::library().collect::<Vec<_>>());
            let coefficient = coefficient(uniform, share, axis, motion.term_rms(term), motion)?;
            Effect::Nonlinear { axis, term, coefficient }
        }
        Family::Rotor => Effect::RotorSpeed { axis, coefficient: coefficient(uniform, share, axis, motion.rotor_rms(), motion)? },
        Family::Disturbance => {
            Effect::Turbulence { sigma: uniform.between(0.5, 1.5) * share, length: uniform.between(100.0, 300.0) }
        }
        Family::Control => control(turn, share, uniform, motion),
        Family::Instrument => instrument(turn, share, uniform),
        Family::None | Family::Unknown => return None,
    })
}

fn control(turn: u64, share: f64, uniform: &mut Uniform, motion: &Motion) -> Effect {
    let control = one_of(uniform, &MOVED);
    let amplitude = motion.amplitude[control.index()];
    match turn % 6 {
        0 => Effect::ActuatorLag { control, tau: uniform.between(0.15, 0.3) * share },
        1 => Effect::TransportDelay { control, delay: uniform.between(0.1, 0.25) * share },
        2 => Effect::ControlEffectiveness { control, factor: 1.0 + uniform.between(0.2, 0.4) * share * sign(uniform) },
        3 => {
            // From one side to the other within the usual clock; what is late grows as one over the limit.
            let used = 2.0 * amplitude / 0.7;
            Effect::RateLimit { control, rate: uniform.between(0.3, 0.6) * used / share }
        }
        4 => Effect::DeadZone { control, half_width: uniform.between(0.3, 0.6) * amplitude * share },
        _ => {
            let others: Vec<Control> = Control::ALL.into_iter().filter(|&other| other != control).collect();
            let (to, gain) = (one_of(uniform, &others), uniform.between(0.2, 0.5) * share * sign(uniform));
            Effect::CrossFeed { from: control, to, gain }
        }
    }
}

fn instrument(turn: u64, share: f64, uniform: &mut Uniform) -> Effect {
    use Channel::{Alpha, Ax, Ay, Az, Beta, P, Phi, Psi, Q, R, Tas, Theta};
    let dynamic = [Ay, Az, P, Q, R, Phi, Theta, Psi, Alpha, Beta];
    match turn % 5 {
        0 => {
            let channel = one_of(uniform, &[Ax, Ay, Az, P, Q, R, Phi, Theta, Tas, Alpha, Beta]);
            let large = match channel {
                Ax | Ay | Az => uniform.between(0.5, 1.0),
                Tas => uniform.between(2.0, 4.0),
                P | Q | R => uniform.between(0.02, 0.05),
                _ => uniform.between(0.025, 0.05),
            };
            Effect::SensorBias { channel, value: large * share * sign(uniform) }
        }
        1 => {
            let channel = one_of(uniform, &[Ay, Az, P, Q, R, Phi, Theta, Psi, Tas, Alpha, Beta]);
            let most = if sign(uniform) < 0.0 { -0.25 } else { 0.3 };
            Effect::SensorScale { channel, factor: 1.0 + most * uniform.between(0.6, 1.0) * share }
        }
        2 => Effect::SensorLag { channel: one_of(uniform, &dynamic), tau: uniform.between(0.1, 0.3) * share },
        3 => Effect::SensorDelay { channel: one_of(uniform, &dynamic), delay: uniform.between(0.1, 0.3) * share },
        _ => {
            let (sensor, component, large) = if uniform.within(1.0) < 0.0 {
                (PositionedSensor::Accelerometer, one_of(uniform, &[0, 1, 2]), uniform.between(1.0, 4.0))
            } else {
                (PositionedSensor::Vane, one_of(uniform, &[0, 0, 0, 2]), uniform.between(3.0, 15.0))
            };
            let mut offset_m = [0.0; 3];
            offset_m[component] = large * share * sign(uniform);
            Effect::SensorPosition { sensor, offset_m }
        }
    }
}
