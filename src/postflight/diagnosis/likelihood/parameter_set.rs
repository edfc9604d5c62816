//! A point: hypotheses with their numbers, small errors of every derivative, each run's own offsets, noise.

use super::aircraft::Partials;
use super::parameter::{RUN_OFFSETS, components, with_number_changed, within_limits};
use crate::flight::derivative::AXES;
use crate::flight::effect::Effect;

/// An effect under test, with the prior of its parameter.
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
    pub(crate) fn beforehand(&self, component: usize) -> f64 {
        self.known.map_or(self.effect.kind().neutral(), |known| number(&known, component))
    }
}

/// Where everything stands.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSet {
    /// What is in the model besides.
    pub hypotheses: Vec<Hypothesis>,
    /// Small errors of derivatives.
    pub derivative_errors: Partials,
    /// Each run's own offsets.
    pub run_offsets: Vec<[f64; RUN_OFFSETS]>,
    /// Noise, the same for all runs but the outputs'.
    pub force_density: [f64; AXES],
    /// Gusts: standard deviation, m/s, and time constant, s.
    pub gust: (f64, f64),
}

/// A component of an effect's number.
fn number(effect: &Effect, component: usize) -> f64 {
    match effect {
        Effect::SensorPosition { offset_m, .. } => offset_m.get(component).copied().unwrap_or(0.0),
        effect => effect.main_number().unwrap_or(0.0),
    }
}

impl ParameterSet {
    /// Effects in it.
    pub fn effects(&self) -> impl Iterator<Item = Effect> + '_ {
        self.hypotheses.iter().map(|hypothesis| hypothesis.effect)
    }

    /// Places of the hypotheses' parameters: hypothesis and component.
    pub(crate) fn places(&self) -> Vec<(usize, usize)> {
        let mut places = Vec::new();
        for (number, hypothesis) in self.hypotheses.iter().enumerate() {
            let components = components(&hypothesis.effect);
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

    pub(crate) fn number(&self, (hypothesis, component): (usize, usize)) -> f64 {
        self.hypotheses.get(hypothesis).map_or(0.0, |hypothesis| number(&hypothesis.effect, component))
    }

    pub(crate) fn change(&mut self, (hypothesis, component): (usize, usize), by: f64, run_s: f64) {
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
        let target = within_limits(effect, now, by, run_s);
        *effect = with_number_changed(effect, target - now);
    }
}
