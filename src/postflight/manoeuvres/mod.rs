//! Preliminary interpretation: manoeuvres, damping, control sensitivity and repeatability of runs, without a model.
//!
//! In: samples of one or several runs. Out, each number with its standard error or the reason why it is not estimable: which
//! control moved, when and how far, and from what trim; rough damping and frequency of the free response; initial response a
//! radian of control; coupling into the other axes; repeatability of runs of one test point; proportionality of response to
//! amplitude.
//! Assumed: one trim at the beginning of a run; small manoeuvres, so that responses superpose and change sign with the control.
//! Refused: damping while a control moves, a scatter from one run, a linearity from one amplitude.

pub(crate) mod channels;
pub(crate) mod coupling;
pub(crate) mod damped_sine;
pub(crate) mod decrement;
pub mod flight_parts;
pub(crate) mod free_response;
pub(crate) mod linearity;
pub mod manoeuvre;
#[cfg(test)]
mod manoeuvre_tests;
pub mod record;
pub(crate) mod sensitivity;
pub(crate) mod test_point;
pub(crate) mod trim_state;

use crate::flight::channel::ControlNames;
use crate::flight::control::Control;
use crate::flight::sample::Sample;
use channels::{Channels, Rest};
use manoeuvre::Flown;
use record::{Interpretation, Manoeuvre, RunInterpretation, on_axis};
use test_point::RunManoeuvre;

/// Time before the start of a manoeuvre (half its first level) from which its control may move already, s.
const HAND_S: f64 = 0.25;
/// Travel of another control, relative to the manoeuvre's, above which it is reported.
const OTHERS: f64 = 0.25;

/// A recorded run.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Name of the run.
    pub name: &'a str,
    /// Its samples in order of time.
    pub samples: &'a [Sample],
    /// Names of the controls.
    pub controls: ControlNames,
}

/// Interprets every run by itself, then all of them together.
pub fn interpret(runs: &[Run<'_>]) -> Interpretation {
    let interpreted: Vec<InterpretedRun> = runs.iter().map(of_run).collect();
    let mut candidates = Vec::new();
    for (run, (channels, flown, interpretation)) in interpreted.iter().enumerate() {
        for (place, (manoeuvre, (flown, until_s))) in interpretation.manoeuvres.iter().zip(flown).enumerate() {
            if manoeuvre.trim.is_ok() {
                candidates.push(RunManoeuvre { place: (run, place), manoeuvre, flown, channels, until_s: *until_s });
            }
        }
    }
    let (points, linearity) = (test_point::points(&candidates), linearity::linearity(&candidates));
    let runs = interpreted.into_iter().map(|(_, _, interpretation)| interpretation).collect();
    Interpretation { runs, points, linearity }
}

/// A run's channels, its manoeuvres with the time until which no other one begins (s), and their interpretation.
type InterpretedRun = (Channels, Vec<(Flown, f64)>, RunInterpretation);

fn of_run(run: &Run<'_>) -> InterpretedRun {
    let channels = Channels::of(run.samples);
    let controls = channels.controls();
    let (begin_s, end_s) = channels.range_s();
    let found = manoeuvre::manoeuvres(&controls);
    let starts: Vec<f64> = found.iter().map(Flown::start_s).collect();
    let flown: Vec<(Flown, f64)> = found
        .into_iter()
        .enumerate()
        .map(|(place, one)| {
            let next_s = starts.get(place + 1).map_or(end_s, |start_s| start_s - HAND_S);
            (one, next_s.max(starts.get(place).copied().unwrap_or(begin_s)))
        })
        .collect();
    let mut before_s = begin_s;
    let manoeuvres: Vec<Manoeuvre> = flown
        .iter()
        .map(|(one, until_s)| {
            let interpreted = of_manoeuvre(&channels, one, before_s, *until_s);
            before_s = before_s.max(one.end_s() + HAND_S);
            interpreted
        })
        .collect();
    let nothing = if controls.iter().all(Option::is_none) {
        Some("no control is recorded".to_owned())
    } else {
        manoeuvres.is_empty().then(|| "no control moves".to_owned())
    };
    let name = run.name.to_owned();
    (channels, flown, RunInterpretation { run: name, controls: run.controls, manoeuvres, nothing })
}

fn of_manoeuvre(channels: &Channels, flown: &Flown, before_s: f64, until_s: f64) -> Manoeuvre {
    let (start_s, end_s) = (flown.start_s(), flown.end_s());
    let window = trim_state::window(before_s, start_s);
    let others = Control::ALL.into_iter().filter(|control| *control != flown.control).filter_map(|control| {
        let trace = channels.get(control.channel())?;
        let travel = manoeuvre::travel(trace, start_s - HAND_S, end_s + HAND_S);
        (travel > OTHERS * flown.travel && travel > manoeuvre::TRAVEL_MIN).then_some((control, travel))
    });
    let on = on_axis(flown.control);
    let span = window.as_ref().ok().and_then(|&(from_s, to_s)| {
        let trace = channels.get(on)?;
        let rest = Rest::of(trace, from_s, to_s)?;
        let stretch = coupling::stretch(flown, until_s);
        sensitivity::span(trace, &rest, stretch.0, stretch.1)
    });
    Manoeuvre {
        control: flown.control,
        start_s,
        end_s,
        amplitude: flown.pulses.first().map_or(0.0, |pulse| pulse.level),
        amplitude_std: sensitivity::level_std(channels, flown),
        travel: flown.travel,
        shape: flown.shape.clone(),
        pulses: flown.pulses.clone(),
        others: others.collect(),
        trim: window.clone().map(|(from_s, to_s)| trim_state::state(channels, from_s, to_s)),
        oscillation: free_response::oscillation(channels, flown, until_s),
        sensitivities: window
            .clone()
            .map_or(Vec::new(), |(from_s, to_s)| sensitivity::sensitivities(channels, flown, from_s, to_s)),
        couplings: window.and_then(|window| coupling::couplings(channels, flown, window, until_s)),
        span,
    }
}
