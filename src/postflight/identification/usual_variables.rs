//! States, inputs and outputs where none were asked for, and why these.
//!
//! Consumes runs; produces names by what moved in them: of a helicopter all eight states, for its planes are coupled and a
//! model of one plane absorbs the other's derivatives; of an aeroplane the plane of motion whose controls moved, and both of
//! them where each was excited, without derivatives from one to the other. A plane is excited in a run where the rms of its
//! controls is at least `BESIDE` of that of the other plane's.

use super::columns::Columns;
use super::model_variables::{ModelVariables, axis, is_control};
use crate::flight::derivative::Variable;

/// A control that moves less than this (rms, rad) is at rest.
pub(crate) const STILL_RAD: f64 = 5e-4;
/// Part of the other plane's control motion (rms) from which a run excites a plane.
const BESIDE: f64 = 0.5;
/// Channels that measure all eight states and the specific force.
const MEASURING_ALL: [&str; 11] = ["tas", "alpha", "q", "theta", "beta", "p", "phi", "r", "ax", "ay", "az"];
/// Controls of each plane whose motion is an input to it: pitch, then roll and yaw.
const EXCITING: [[&str; 4]; 2] = [["lon_cyclic", "elevator", "", ""], ["lat_cyclic", "aileron", "pedal", "rudder"]];

/// Planes of motion of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelPlanes {
    /// All eight states, coupled.
    Coupled,
    /// Pitch alone.
    Longitudinal,
    /// Roll and yaw alone.
    Lateral,
    /// Both, without derivatives from one to the other.
    Separate,
}

/// A choice by the runs.
#[derive(Clone, Debug)]
pub struct UsualVariables {
    /// Names of states, inputs and outputs.
    pub variables: ModelVariables,
    /// Which planes they are of.
    pub planes: ModelPlanes,
    /// Whether each run excited the longitudinal plane, and the lateral one.
    pub excited: Vec<[bool; 2]>,
}

impl UsualVariables {
    /// By what moved.
    pub fn of(runs: &[Columns]) -> Self {
        let all = |name: &str| runs.iter().all(|run| run.has(name));
        let rms = |name: &str| {
            let of_run = |run: &Columns| run.deviations(name).map_or(0.0, |values| square_mean(&values));
            libm::sqrt(runs.iter().map(of_run).fold(0.0, f64::max))
        };
        let moved = |names: &[&str]| -> Vec<String> {
            let moved = |name: &&&str| all(name) && rms(name) > STILL_RAD;
            names.iter().filter(moved).map(|&name| name.to_owned()).collect()
        };
        let excited: Vec<[bool; 2]> = runs.iter().map(excited).collect();
        if all("lat_cyclic") && MEASURING_ALL.iter().all(|name| all(name)) {
            let variables = ModelVariables {
                states: owned(&["u", "w", "q", "theta", "v", "p", "phi", "r"]),
                inputs: moved(&["lon_cyclic", "collective", "lat_cyclic", "pedal"]),
                outputs: owned(&MEASURING_ALL),
            };
            return UsualVariables { variables, planes: ModelPlanes::Coupled, excited };
        }
        let planes = match [0, 1].map(|plane| excited.iter().any(|run| run.get(plane) == Some(&true))) {
            [true, true] if all("q") && all("p") && all("r") => ModelPlanes::Separate,
            _ if rms("q") > rms("p").max(rms("r")) => ModelPlanes::Longitudinal,
            _ => ModelPlanes::Lateral,
        };
        let longitudinal: (&[&str], &[&str]) = if all("alpha") { (&["w", "q"], &["alpha", "q", "az"]) } else { (&["q"], &["q"]) };
        let lateral: (&[&str], &[&str]) =
            if all("beta") { (&["v", "p", "phi", "r"], &["beta", "p", "phi", "r", "ay"]) } else { (&["p", "r"], &["p", "r"]) };
        let pitch = ["lon_cyclic", "elevator", "collective", "throttle"];
        let roll_and_yaw = ["lat_cyclic", "aileron", "pedal", "rudder"];
        let (states, outputs, inputs) = match planes {
            ModelPlanes::Longitudinal => (longitudinal.0.to_vec(), longitudinal.1.to_vec(), moved(&pitch)),
            ModelPlanes::Separate => (
                [longitudinal.0, lateral.0].concat(),
                [longitudinal.1, lateral.1].concat(),
                moved(&[pitch, roll_and_yaw].concat()),
            ),
            ModelPlanes::Lateral | ModelPlanes::Coupled => (lateral.0.to_vec(), lateral.1.to_vec(), moved(&roll_and_yaw)),
        };
        let outputs: Vec<&str> = outputs.into_iter().filter(|name| all(name)).collect();
        let variables = ModelVariables { states: owned(&states), inputs, outputs: owned(&outputs) };
        UsualVariables { variables, planes, excited }
    }

    /// The derivatives of a model of both planes that is not coupled: those within each plane, and of what is no control all;
    /// `None` of another model.
    pub fn only(&self, variables: &ModelVariables) -> Option<Vec<(char, String)>> {
        if self.planes != ModelPlanes::Separate {
            return None;
        }
        let free = |state: &String, variable: &&String| {
            let (own, other) = (plane_of(state), plane_of(variable));
            own == other || other.is_none()
        };
        let row = |state: &String| {
            let (axis, all) = (axis(state), variables.states.iter().chain(&variables.inputs));
            let free = all.filter(|variable| free(state, variable)).cloned().collect::<Vec<_>>();
            free.into_iter().filter_map(move |variable| Some((axis?, variable)))
        };
        Some(variables.states.iter().flat_map(row).collect())
    }
}

/// Whether a model has states of both planes and no derivative from one to the other.
pub(crate) fn are_separate(variables: &ModelVariables, only: &[(char, String)]) -> bool {
    let planes = |plane: usize| variables.states.iter().any(|state| plane_of(state) == Some(plane));
    let own = |axis: char| usize::from(matches!(axis, 'Y' | 'L' | 'N'));
    planes(0) && planes(1) && only.iter().all(|(axis, name)| plane_of(name).is_none_or(|plane| plane == own(*axis)))
}

/// 0 of pitch, 1 of roll and yaw; `None` of what belongs to neither.
pub(crate) fn plane_of(name: &str) -> Option<usize> {
    match name {
        "u" | "w" | "alpha" | "q" | "theta" | "tas" | "ax" | "az" => Some(0),
        "v" | "beta" | "p" | "r" | "phi" | "ay" => Some(1),
        control if is_control(control) => Some(usize::from(Variable::from_name(control).is_none_or(Variable::is_lateral))),
        _ => None,
    }
}

/// Which planes a run excited, the longitudinal and the lateral one.
pub(crate) fn excited(run: &Columns) -> [bool; 2] {
    let [longitudinal, lateral] = EXCITING.map(|names| {
        let square = |name: &&str| run.deviations(name).map_or(0.0, |values| square_mean(&values));
        libm::sqrt(names.iter().map(square).fold(0.0, f64::max))
    });
    let beside = |own: f64, other: f64| own > STILL_RAD && own >= BESIDE * other;
    [beside(longitudinal, lateral), beside(lateral, longitudinal)]
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

pub(crate) fn square_mean(values: &[f64]) -> f64 {
    let known = values.iter().filter(|value| value.is_finite());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::run::RunGeometry;

    fn run(elevator: f64, rudder: f64) -> Columns {
        let times_s: Vec<f64> = (0..100).map(|place| 0.1 * f64::from(place)).collect();
        let moved = |size: f64| times_s.iter().map(|time_s| if *time_s > 2.0 { size } else { 0.0 }).collect::<Vec<f64>>();
        let names = ["alpha", "q", "az", "beta", "p", "phi", "r", "ay"];
        let columns = names
            .iter()
            .map(|name| ((*name).to_owned(), moved(0.1)))
            .chain([("elevator".to_owned(), moved(elevator)), ("rudder".to_owned(), moved(rudder))]);
        Columns::new("a".to_owned(), RunGeometry::DEFAULT, times_s.clone(), columns.collect(), 1.0).unwrap()
    }

    #[test]
    fn runs_of_elevator_and_of_rudder_together_are_a_model_of_both_planes() {
        let usual = UsualVariables::of(&[run(0.05, 0.002), run(0.001, 0.04)]);
        assert_eq!((usual.planes, usual.excited.as_slice()), (ModelPlanes::Separate, &[[true, false], [false, true]][..]));
        assert_eq!(usual.variables.states, ["w", "q", "v", "p", "phi", "r"]);
        assert_eq!(usual.variables.inputs, ["elevator", "rudder"]);
        let only = usual.only(&usual.variables).unwrap();
        let has = |axis: char, name: &str| only.contains(&(axis, name.to_owned()));
        assert!(has('M', "elevator") && has('N', "rudder") && has('L', "v") && has('Z', "q"), "{only:?}");
        assert!(!has('M', "rudder") && !has('N', "elevator") && !has('L', "w") && !has('Z', "p"), "{only:?}");
    }

    #[test]
    fn runs_of_one_plane_are_a_model_of_that_plane() {
        let usual = UsualVariables::of(&[run(0.002, 0.04)]);
        assert_eq!((usual.planes, usual.only(&usual.variables)), (ModelPlanes::Lateral, None));
    }
}
