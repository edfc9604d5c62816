//! The multistep that makes the expected standard errors least, within what hand and aircraft may do.
//!
//! Consumes a model, the derivatives wanted, a control, limits; produces the best of all patterns of 1 to
//! [`DesignLimits::longest`] clocks (each pulse a whole number of clocks, signs alternating, as `simulate --input` flies them)
//! and of all clocks offered. Each is scaled down until no limit is passed (one that would have to be smaller than
//! [`LEAST_AMPLITUDE`] does not fit); then it is judged by
//!     J = Sum_j w_j (std_j / theta_j)^2   (trace of the weighted dispersion)                (1)
//!     J = log det D                                                                         (2)
//! D is that of the derivatives wanted, those that are free besides estimated with them.
//! The search is complete, not a descent: 2^(n-1) patterns of n clocks. Records are of one length, so that no sequence wins by
//! lasting longer.

use super::dispersion::InformationError;
use super::information::{DesignManoeuvre, DesignParameter, InputInformation, MeasuredOutput};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::model::LinearModel;
use crate::flight::signal::piecewise_linear::History;
use crate::num::parallel_map::parallel_map;
use crate::simulation::input::InputSpec;

/// Sequences that are judged before the next look at whether to go on.
const AT_ONCE: usize = 64;

/// How often an amplitude is lowered at most.
const MOST_TRIES: u32 = 8;

/// The smallest amplitude that is an input, rad: a hand and its measurement know no less.
pub const LEAST_AMPLITUDE: f64 = 1e-5;

/// What is judged.
#[derive(Clone, Debug, PartialEq)]
pub enum Criterion {
    /// (1) with these weights, in the order of the derivatives.
    Trace(Vec<f64>),
    /// (2).
    LogDeterminant,
}

/// What hand and aircraft may do.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignLimits {
    /// Largest deviation of the control, rad.
    pub amplitude: f64,
    /// Largest deviation of each state from trim, u w q theta v p phi r; infinite where there is none.
    pub excursion: [f64; 8],
    /// Clocks that are tried, s.
    pub clocks_s: Vec<f64>,
    /// Clocks in a sequence at most.
    pub longest: u32,
    /// Steady flight before it, s.
    pub lead_s: f64,
    /// Length of the record, s.
    pub duration_s: f64,
    /// Samples a second.
    pub rate_hz: f64,
}

/// An input with what it brings.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluatedInput {
    /// The input; its amplitude keeps every limit, if it fits.
    pub spec: InputSpec,
    /// Whether an amplitude of [`LEAST_AMPLITUDE`] or more keeps every limit.
    pub fits: bool,
    /// J; smaller is better. Infinite where a derivative stays without information, or where it does not fit.
    pub cost: f64,
    /// What it brings about the derivatives wanted and those that are free besides.
    pub information: InputInformation,
}

/// The problem: everything but the sequence.
#[derive(Clone, Debug)]
pub struct DesignProblem<'a> {
    /// The aircraft.
    pub model: &'a LinearModel,
    /// What is to be known.
    pub parameters: &'a [DesignParameter],
    /// What is unknown besides, and has to be estimated with them.
    pub free: &'a [DesignParameter],
    /// What is measured.
    pub outputs: &'a [MeasuredOutput],
    /// The control that moves.
    pub control: Control,
    /// What is judged.
    pub criterion: &'a Criterion,
    /// Limits.
    pub limits: &'a DesignLimits,
    /// What other manoeuvres have brought already.
    pub known: Option<&'a InputInformation>,
}

impl DesignProblem<'_> {
    /// The input of that pattern and clock, as large as the limits allow.
    pub fn judge(&self, pattern: &[u32], clock_s: f64) -> EvaluatedInput {
        let spec = |amplitude: f64| InputSpec {
            channel: self.control.channel(),
            pattern: pattern.to_vec(),
            amplitude,
            clock_s,
            start_s: Some(self.limits.lead_s),
        };
        let mut chosen = spec(self.limits.amplitude);
        // The hand's edges get shorter with the amplitude, so that the response is not quite proportional to it. The states alone
        // say how large it may be; what it brings is worked out once.
        let mut room = self.room(&InputInformation::excursion(self.model, &self.manoeuvre(&chosen)));
        for _ in 0..MOST_TRIES {
            let amplitude = rounded_down(0.998 * room * chosen.amplitude);
            if room >= 1.0 || !(amplitude >= LEAST_AMPLITUDE) {
                break;
            }
            chosen = spec(amplitude);
            room = self.room(&InputInformation::excursion(self.model, &self.manoeuvre(&chosen)));
        }
        let fits = room >= 1.0;
        let information = self.information(&chosen);
        let all = match self.known {
            Some(known) => information.clone().plus(known),
            None => information.clone(),
        };
        let cost = if fits { self.cost(&all) } else { f64::INFINITY };
        EvaluatedInput { spec: chosen, fits, cost, information }
    }

    /// The limits as multiples of what was reached: the least of them.
    fn room(&self, excursion: &[f64; 8]) -> f64 {
        let room = excursion.iter().zip(self.limits.excursion).map(|(most, limit)| limit / most);
        room.fold(f64::INFINITY, |least, room| if room < least || room.is_nan() { room } else { least })
    }

    /// The state that goes furthest beyond its limit, by its place among u w q theta v p phi r.
    pub fn tightest(&self, information: &InputInformation) -> usize {
        let room = information.excursion.iter().zip(self.limits.excursion).map(|(most, limit)| limit / most).enumerate();
        room.min_by(|(_, one), (_, other)| one.total_cmp(other)).map_or(0, |(place, _)| place)
    }

    /// Of the derivatives wanted alone.
    ///
    /// # Errors
    /// [`InformationError`] where it does not identify one of them.
    pub fn wanted(&self, information: &InputInformation) -> Result<InputInformation, InformationError> {
        information.about(self.parameters)
    }

    /// J.
    pub fn cost(&self, information: &InputInformation) -> f64 {
        let Ok(information) = self.wanted(information) else { return f64::INFINITY };
        match self.criterion {
            Criterion::LogDeterminant => information.log_determinant().unwrap_or(f64::INFINITY),
            Criterion::Trace(weights) => {
                let Ok(errors) = information.standard_errors() else { return f64::INFINITY };
                let relative = |(parameter, std): (&DesignParameter, f64)| {
                    let value = self.model.derivative(parameter.axis, parameter.variable);
                    (std / value) * (std / value)
                };
                self.parameters.iter().zip(errors).map(relative).zip(weights).map(|(variance, weight)| variance * weight).sum()
            }
        }
    }

    fn manoeuvre(&self, spec: &InputSpec) -> DesignManoeuvre {
        let mut controls = [const { None }; CONTROLS].map(|_: Option<()>| History::constant(0.0));
        if let Some(history) = controls.get_mut(self.control.index()) {
            *history = spec.deviation(self.limits.lead_s);
        }
        let DesignLimits { duration_s, rate_hz, .. } = *self.limits;
        DesignManoeuvre { controls, duration_s, rate_hz }
    }

    fn information(&self, spec: &InputSpec) -> InputInformation {
        let parameters = [self.free, self.parameters].concat();
        InputInformation::of(self.model, &parameters, self.outputs, &self.manoeuvre(spec))
    }

    /// How many sequences [`DesignProblem::search`] judges.
    pub fn sequences(&self) -> usize {
        let of_length = |length: u32| (0..1_u32 << (length - 1)).filter(|&cuts| pulses(length, cuts).is_some()).count();
        let counts: Vec<usize> = (1..=self.limits.longest).map(of_length).collect();
        let of_clock = |&clock_s: &f64| -> usize {
            counts
                .iter()
                .zip(1..)
                .take_while(|&(_, length)| self.ends_s(length, clock_s) <= self.limits.duration_s)
                .map(|(n, _)| n)
                .sum()
        };
        self.limits.clocks_s.iter().map(of_clock).sum()
    }

    fn ends_s(&self, length: u32, clock_s: f64) -> f64 {
        self.limits.lead_s + f64::from(length) * clock_s
    }

    /// Every pattern and clock that fits into the record, each judged once, several at a time; `each` sees them in order, and
    /// they stop early where that says `false`.
    pub fn search(&self, mut each: impl FnMut(&EvaluatedInput) -> bool) -> Option<EvaluatedInput> {
        let lengths = |clock_s: f64| {
            (1..=self.limits.longest).take_while(move |&length| self.ends_s(length, clock_s) <= self.limits.duration_s)
        };
        let of_clock = |&clock_s: &f64| {
            let cuts = lengths(clock_s).flat_map(|length| (0..1_u32 << (length - 1)).map(move |cuts| (length, cuts)));
            cuts.filter_map(move |(length, cuts)| Some((pulses(length, cuts)?, clock_s)))
        };
        let all: Vec<(Vec<u32>, f64)> = self.limits.clocks_s.iter().flat_map(of_clock).collect();
        let mut best: Option<EvaluatedInput> = None;
        for some in all.chunks(AT_ONCE) {
            for judged in parallel_map(some, |(pattern, clock_s)| self.judge(pattern, *clock_s)) {
                if !each(&judged) {
                    return best;
                }
                if judged.cost.is_finite() && best.as_ref().is_none_or(|best| judged.cost < best.cost) {
                    best = Some(judged);
                }
            }
        }
        best
    }
}

/// To three significant digits: a hand knows no more.
fn rounded_down(amplitude: f64) -> f64 {
    // Divided by a whole power of ten, so that it prints as short as it is.
    let per_unit = libm::exp10(2.0 - libm::floor(libm::log10(amplitude)));
    if per_unit >= 1.0 { libm::floor(amplitude * per_unit) / per_unit } else { libm::floor(amplitude) }
}

/// Lengths of the pulses of a sequence: bit k of `cuts` changes the sign behind clock k. `None` where one is longer than nine
/// clocks, which is what a digit holds.
fn pulses(length: u32, cuts: u32) -> Option<Vec<u32>> {
    let mut pulses = Vec::new();
    let mut run = 1;
    for k in 0..length - 1 {
        if cuts & (1 << k) == 0 {
            run += 1;
        } else {
            pulses.push(run);
            run = 1;
        }
    }
    pulses.push(run);
    pulses.iter().all(|&run| run <= 9).then_some(pulses)
}

#[cfg(test)]
mod tests {
    use super::super::information::outputs;
    use super::*;
    use crate::flight::derivative::{Axis, Variable};
    use crate::flight::file::model_file::ModelFile;
    use crate::simulation::instrument::InstrumentSet;
    use std::collections::BTreeSet;

    #[test]
    fn every_pattern_comes_once() {
        let all: BTreeSet<Vec<u32>> = (0..1 << 6).filter_map(|cuts| pulses(7, cuts)).collect();
        assert_eq!(all.len(), 64);
        assert!(all.contains(&vec![3, 2, 1, 1]) && all.contains(&vec![7]) && all.contains(&vec![1; 7]));
        assert!(all.iter().all(|pattern| pattern.iter().sum::<u32>() == 7));
        // A pulse of ten clocks or more has no digit.
        let named = (0..1 << 11).filter(|&cuts| pulses(12, cuts).is_some()).count();
        let longest = |cuts: u32| {
            (0..11)
                .fold((1, 1), |(most, run), k| {
                    let run = if cuts & (1 << k) == 0 { run + 1 } else { 1 };
                    (std::cmp::max(most, run), run)
                })
                .0
        };
        assert_eq!(named, (0..1 << 11).filter(|&cuts| longest(cuts) <= 9).count());
    }

    #[test]
    fn the_best_is_no_worse_than_a_3211_and_keeps_every_limit() {
        let model = ModelFile::parse(include_str!("../../../replay/models/puma-like.toml")).unwrap().linear;
        let parameters = [(Axis::N, Variable::V), (Axis::N, Variable::P), (Axis::N, Variable::R), (Axis::N, Variable::Pedal)]
            .map(|(axis, variable)| DesignParameter { axis, variable });
        let outputs = outputs(&model, &InstrumentSet::flight_quality(1.0));
        let mut excursion = [f64::INFINITY; 8];
        excursion[6] = 0.1;
        let limits = DesignLimits {
            amplitude: 0.03,
            excursion,
            clocks_s: vec![0.5, 0.7, 1.0],
            longest: 7,
            lead_s: 1.0,
            duration_s: 15.0,
            rate_hz: 20.0,
        };
        for criterion in [Criterion::Trace(vec![1.0; 4]), Criterion::LogDeterminant] {
            let problem = DesignProblem {
                model: &model,
                parameters: &parameters,
                free: &[],
                outputs: &outputs,
                control: Control::Pedal,
                criterion: &criterion,
                limits: &limits,
                known: None,
            };
            let mut judged = 0;
            let best = problem
                .search(|candidate| {
                    judged += 1;
                    assert!(candidate.information.excursion[6] <= 0.1 && candidate.spec.amplitude <= 0.03);
                    true
                })
                .unwrap();
            assert_eq!((judged, problem.sequences()), (3 * 127, 3 * 127));
            for clock_s in [0.5, 0.7, 1.0] {
                assert!(best.cost <= problem.judge(&[3, 2, 1, 1], clock_s).cost);
                assert!(best.cost <= problem.judge(&[1, 1], clock_s).cost);
            }
            // Other yaw derivatives that are unknown too make it worse; a limit that nothing keeps leaves nothing.
            let free = [
                DesignParameter { axis: Axis::L, variable: Variable::P },
                DesignParameter { axis: Axis::Y, variable: Variable::V },
            ];
            let freed = DesignProblem { free: &free, ..problem.clone() }.judge(&[3, 2, 1, 1], 0.7);
            assert!(freed.cost > problem.judge(&[3, 2, 1, 1], 0.7).cost && freed.information.parameters.len() == 6);
            let mut excursion = [f64::INFINITY; 8];
            excursion[7] = 1e-12;
            let none = DesignProblem { limits: &DesignLimits { excursion, ..limits.clone() }, ..problem.clone() };
            let judged = none.judge(&[1, 1], 0.7);
            assert!(!judged.fits && judged.cost.is_infinite() && none.tightest(&judged.information) == 7);
            assert!(none.search(|_| true).is_none());
        }
    }
}
