//! A point: hypotheses with their numbers, small errors of every derivative, each run's own offsets, noise.

use super::aircraft::Partials;
use super::run_record::OUTPUT_CHANNELS;
use crate::flight::derivative::AXES;
use crate::flight::effect::Effect;

/// Offsets that each run has for itself: forces and moments, then accelerometers and gyros.
pub const OWN: usize = AXES + 6;

/// An effect that is looked at, with what is known of its number beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// The effect with its number.
    pub effect: Effect,
    /// Standard deviation of the number about what it is taken to be beforehand.
    pub prior_std: f64,
    /// That, where it is known to be something.
    pub known: Option<Effect>,
}

impl Hypothesis {
    /// Of an effect of which nothing is known but how large it may be.
    pub fn of(effect: Effect, prior_std: f64) -> Self {
        Hypothesis { effect, prior_std, known: None }
    }

    /// What a component of its number is taken to be beforehand: nothing being wrong, or what is known.
    pub(super) fn beforehand(&self, component: usize) -> f64 {
        self.known.map_or(nothing(&self.effect), |known| number(&known, component))
    }
}

/// Where everything stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What is in the model besides.
    pub hypotheses: Vec<Hypothesis>,
    /// Small errors of derivatives.
    pub small: Partials,
    /// Each run's own offsets.
    pub own: Vec<[f64; OWN]>,
    /// Noise, the same for all runs but the outputs'.
    pub force: [f64; AXES],
    /// Gusts: standard deviation, m/s, and time constant, s.
    pub gust: (f64, f64),
}

/// A step of a number for differences.
pub(super) fn nudged(effect: &Effect, by: f64) -> Effect {
    let mut effect = *effect;
    match &mut effect {
        Effect::ActuatorLag { tau: x, .. }
        | Effect::TransportDelay { delay: x, .. }
        | Effect::RateLimit { rate: x, .. }
        | Effect::DeadZone { half_width: x, .. }
        | Effect::CrossFeed { gain: x, .. }
        | Effect::SensorBias { value: x, .. }
        | Effect::SensorScale { factor: x, .. }
        | Effect::SensorLag { tau: x, .. }
        | Effect::SensorDelay { delay: x, .. }
        | Effect::Derivative { delta: x, .. }
        | Effect::Nonlinear { coefficient: x, .. }
        | Effect::ControlEffectiveness { factor: x, .. }
        | Effect::RotorSpeed { coefficient: x, .. }
        | Effect::RotorReaction { reaction: x }
        | Effect::FlightPath { slope: x, .. }
        | Effect::Turbulence { sigma: x, .. } => *x += by,
        Effect::SensorPosition { .. } | Effect::None | Effect::Unknown { .. } => {}
    }
    effect
}

/// The place of a channel among the outputs.
pub fn output_of(effect: &Effect) -> Option<usize> {
    let channel = effect.sensor_channel()?;
    OUTPUT_CHANNELS.iter().position(|&output| output == channel)
}

/// Whether an effect changes what reaches the blades.
pub fn moves_blades(effect: &Effect) -> bool {
    match effect {
        Effect::ActuatorLag { .. }
        | Effect::TransportDelay { .. }
        | Effect::RateLimit { .. }
        | Effect::DeadZone { .. }
        | Effect::CrossFeed { .. } => true,
        _ => effect.sensor_channel().is_some() && output_of(effect).is_none(),
    }
}

/// A component of an effect's number.
fn number(effect: &Effect, component: usize) -> f64 {
    match effect {
        Effect::SensorPosition { offset_m, .. } => offset_m.get(component).copied().unwrap_or(0.0),
        effect => effect.main_number().unwrap_or(0.0),
    }
}

/// What an effect is when nothing is wrong, as its number.
pub fn nothing(effect: &Effect) -> f64 {
    match effect {
        Effect::ControlEffectiveness { .. } | Effect::SensorScale { .. } => 1.0,
        _ => 0.0,
    }
}

impl Point {
    /// Effects in it.
    pub fn effects(&self) -> impl Iterator<Item = Effect> + '_ {
        self.hypotheses.iter().map(|hypothesis| hypothesis.effect)
    }

    /// Places of the hypotheses' parameters: hypothesis and component.
    pub(super) fn places(&self) -> Vec<(usize, usize)> {
        let mut places = Vec::new();
        for (number, hypothesis) in self.hypotheses.iter().enumerate() {
            let components = if matches!(hypothesis.effect, Effect::SensorPosition { .. }) { 3 } else { 1 };
            places.extend((0..components).map(|component| (number, component)));
        }
        places
    }

    /// First place of a hypothesis's parameters.
    pub fn place_of(&self, hypothesis: usize) -> usize {
        self.places().iter().position(|&(number, _)| number == hypothesis).unwrap_or(0)
    }

    /// The place of a hypothesis's main number.
    pub fn main_place_of(&self, hypothesis: usize) -> usize {
        let first = self.place_of(hypothesis);
        match self.hypotheses.get(hypothesis).map(|hypothesis| hypothesis.effect) {
            Some(Effect::SensorPosition { offset_m: [x, y, z], .. }) => {
                let [x, y, z] = [x, y, z].map(libm::fabs);
                first
                    + if x >= y && x >= z {
                        0
                    } else if y >= z {
                        1
                    } else {
                        2
                    }
            }
            _ => first,
        }
    }

    pub(super) fn number(&self, (hypothesis, component): (usize, usize)) -> f64 {
        self.hypotheses.get(hypothesis).map_or(0.0, |hypothesis| number(&hypothesis.effect, component))
    }

    pub(super) fn change(&mut self, (hypothesis, component): (usize, usize), by: f64, run_s: f64) {
        let Some(Hypothesis { effect, prior_std, .. }) = self.hypotheses.get_mut(hypothesis) else { return };
        // One step goes no further than this prior allows.
        let by = by.clamp(-1.5 * *prior_std, 1.5 * *prior_std);
        if let Effect::SensorPosition { offset_m, .. } = effect {
            if let Some(offset) = offset_m.get_mut(component) {
                *offset += by;
            }
            return;
        }
        let now = effect.main_number().unwrap_or(0.0);
        let target = match effect {
            Effect::ActuatorLag { .. } | Effect::SensorLag { .. } => (now + by).clamp((0.3 * now).max(1e-3), 0.1 * run_s),
            Effect::TransportDelay { .. } => (now + by).clamp(0.0, 0.1 * run_s),
            Effect::SensorDelay { .. } => (now + by).clamp(-0.1 * run_s, 0.1 * run_s),
            Effect::RateLimit { .. } => (now + by).clamp(0.4 * now, 2.5 * now),
            Effect::DeadZone { .. } => (now + by).clamp(0.4 * now, 2.5 * now).max(1e-6),
            Effect::SensorScale { .. } | Effect::ControlEffectiveness { .. } => (now + by).max(0.05),
            _ => now + by,
        };
        *effect = nudged(effect, target - now);
    }
}
