//! Preliminary interpretation: what runs show at a first look, before any model.
//!
//! In: samples of one or several runs. Out, each number with its standard error or the reason why there is none: which control
//! moved, when and how far, and from what trim; rough damping and frequency of the free response; initial response a radian of
//! control; how much the other axes do; how well runs of one test point repeat; whether the response grows in proportion.
//! Assumed: one trim at the begin of a run; small manoeuvres, so that responses add and change sign with the control.
//! Refused: damping while a control moves, a scatter from one run, a linearity from one amplitude.

pub mod channels;
pub mod coupling;
pub mod damped_sine;
pub mod decrement;
pub mod free_response;
pub mod linearity;
pub mod manoeuvre;
#[cfg(test)]
mod manoeuvre_tests;
pub mod record;
pub mod sensitivity;
pub mod test_point;
pub mod trace;
pub mod trim_state;

use crate::flight::channel::ControlNames;
use crate::flight::control::Control;
use crate::flight::sample::Sample;
use channels::{Channels, Rest};
use manoeuvre::Flown;
use record::{Interpretation, Manoeuvre, RunInterpretation, on_axis};
use test_point::Candidate;

/// Before the next manoeuvre starts (half its first level) its hand already moves, s.
const HAND_S: f64 = 0.25;
/// Other controls that move by more than this of the manoeuvre's travel are said.
const OTHERS: f64 = 0.25;

/// A run to look at.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its samples in order of time.
    pub samples: &'a [Sample],
    /// How its controls are called.
    pub controls: ControlNames,
}

/// Looks at every run, and at all of them together.
pub fn interpret(runs: &[Run<'_>]) -> Interpretation {
    let looked: Vec<Looked> = runs.iter().map(of_run).collect();
    let mut candidates = Vec::new();
    for (run, (channels, flown, interpretation)) in looked.iter().enumerate() {
        for (place, (manoeuvre, (flown, until_s))) in interpretation.manoeuvres.iter().zip(flown).enumerate() {
            if manoeuvre.trim.is_ok() {
                candidates.push(Candidate { place: (run, place), manoeuvre, flown, channels, until_s: *until_s });
            }
        }
    }
    let (points, linearity) = (test_point::points(&candidates), linearity::linearity(&candidates));
    let runs = looked.into_iter().map(|(_, _, interpretation)| interpretation).collect();
    Interpretation { runs, points, linearity }
}

/// A run's channels, its manoeuvres as detected with the time until which nothing else is flown, and what was made of them.
type Looked = (Channels, Vec<(Flown, f64)>, RunInterpretation);

fn of_run(run: &Run<'_>) -> Looked {
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
            let looked = of_manoeuvre(&channels, one, before_s, *until_s);
            before_s = before_s.max(one.end_s() + HAND_S);
            looked
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
