//! What of a recording can be estimated, and why the rest cannot.
//!
//! Consumes the survey of a recording; produces sentences. The state needs the rate gyros and is aided by what else is
//! there; a force axis needs its accelerometer; v needs airspeed and the sideslip vane, w the incidence vane; a control
//! that stands still says nothing about its own derivatives; the Dutch roll needs L, N and Y with respect to v, p and r.

use super::survey::Survey;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::realtime::estimation::record::Aid;

/// The slowest rates that derivatives are estimated from, Hz.
const RATE_MIN_HZ: f64 = 8.0;
/// Jitter of time stamps that is let pass when a rate is held against the least one, relative.
const RATE_SLACK: f64 = 0.005;
/// Derivatives need a recording of so long, s: a short period of a small aircraft, or half of a Dutch roll.
const LENGTH_MIN_S: f64 = 2.0;
/// Rates that move less from end to end are those of an aircraft that stands, rad/s.
const RATE_EXCURSION_MIN: f64 = 0.03;
/// A control that moves less from end to end hardly excites anything, rad.
const EXCURSION_MIN: f64 = 0.01;

/// Whether something can be estimated; if not, or not wholly, why.
#[derive(Debug)]
pub(super) struct Feasibility<T> {
    pub(super) what: T,
    pub(super) possible: bool,
    /// What stands in the way, or limits it; each a phrase.
    pub(super) reasons: Vec<String>,
}

impl<T> Feasibility<T> {
    fn from_obstacles(what: T, reasons: Vec<String>) -> Self {
        Feasibility { what, possible: reasons.is_empty(), reasons }
    }
}

#[derive(Debug)]
pub(super) struct EstimableQuantities {
    pub(super) state: Feasibility<()>,
    pub(super) aids: Vec<&'static str>,
    pub(super) aids_missing: Vec<&'static str>,
    /// The derivatives of each axis.
    pub(super) axes: Vec<Feasibility<Axis>>,
    /// What derivatives can be taken with respect to.
    pub(super) variables: Vec<Feasibility<Variable>>,
    pub(super) dutch_roll: Feasibility<()>,
}

impl EstimableQuantities {
    /// Judges a survey; `controls` says how the controls are called.
    pub(super) fn of(survey: &Survey, controls: ControlNames) -> Self {
        let missing = |channels: &[Channel]| -> Option<String> {
            let names: Vec<String> = channels
                .iter()
                .filter(|&&channel| survey.of(channel).is_none())
                .map(|channel| format!("`{}`", channel.name(controls)))
                .collect();
            (!names.is_empty()).then(|| format!("no {}", names.join(", ")))
        };
        let too_slow = |channels: &[Channel]| -> Option<String> {
            let rate = |channel: &Channel| survey.of(*channel).and_then(|column| column.times.rate_hz());
            let slowest = channels.iter().filter_map(rate).reduce(f64::min)?;
            (slowest < RATE_MIN_HZ * (1.0 - RATE_SLACK)).then_some(())?;
            let of = channels.iter().map(|channel| channel.name(controls)).collect::<Vec<_>>().join(" ");
            Some(format!("{of} come at {slowest:.1} Hz, derivatives need {RATE_MIN_HZ} Hz"))
        };
        let gyros = [Channel::P, Channel::Q, Channel::R];
        let no_rates = missing(&gyros);
        let range = |channel: &Channel| survey.of(*channel).and_then(|column| column.range).map(|(least, most)| most - least);
        let length_s = |channel: &Channel| survey.of(*channel)?.times.range_s.map(|(first_s, last_s)| last_s - first_s);
        let too_short = gyros.iter().filter_map(length_s).reduce(f64::min).filter(|length_s| *length_s < LENGTH_MIN_S);
        let too_short =
            too_short.map(|length_s| format!("it is {length_s:.2} s long, derivatives need {LENGTH_MIN_S} s or more"));
        let no_control = Channel::CONTROLS.iter().all(|channel| survey.of(*channel).is_none());
        let no_control = no_control.then(|| NO_CONTROL.to_owned());
        let moments = no_rates.clone().into_iter().chain(too_slow(&gyros)).chain(too_short).chain(no_control.clone());
        let moments: Vec<String> = moments.collect();
        // Said beside what is possible: nothing may have been excited.
        let most = gyros.iter().filter_map(range).fold(0.0, f64::max);
        let stands = (moments.is_empty() && most < RATE_EXCURSION_MIN)
            .then(|| format!("p q r move by {most:.3} rad/s from end to end only, as of an aircraft that stands"));

        let axis = |axis: Axis| {
            let accelerometer = match axis {
                Axis::X => Some(Channel::Ax),
                Axis::Y => Some(Channel::Ay),
                Axis::Z => Some(Channel::Az),
                Axis::L | Axis::M | Axis::N => None,
            };
            let mut reasons = moments.clone();
            reasons.extend(accelerometer.and_then(|channel| missing(&[channel])));
            if moments.is_empty() {
                reasons.extend(accelerometer.and_then(|channel| too_slow(&[channel])));
            }
            let mut judged = Feasibility::from_obstacles(axis, reasons);
            judged.reasons.extend(stands.clone());
            judged
        };
        let variable = |variable: Variable| {
            let needs: &[Channel] = match variable {
                Variable::U => &[Channel::Tas],
                Variable::V => &[Channel::Tas, Channel::Beta],
                Variable::W => &[Channel::Tas, Channel::Alpha],
                Variable::P => &[Channel::P],
                Variable::Q => &[Channel::Q],
                Variable::R => &[Channel::R],
                Variable::LonCyclic | Variable::LatCyclic | Variable::Collective | Variable::Pedal => &[],
            };
            let Some(channel) = variable.control_channel() else {
                let reason = missing(needs).map(|missing| unobserved(variable, &missing));
                return Feasibility::from_obstacles(variable, reason.into_iter().collect());
            };
            let excursion = survey.of(channel).and_then(|control| control.range).map(|(least, greatest)| greatest - least);
            let (possible, reason) = match excursion {
                None => (false, Some("not measured".into())),
                Some(excursion) if excursion <= 0.0 => (false, Some("never moves".into())),
                Some(excursion) if excursion < EXCURSION_MIN => {
                    (true, Some(format!("it moves {excursion:.4} rad from end to end only")))
                }
                Some(_) => (true, None),
            };
            Feasibility { what: variable, possible, reasons: reason.into_iter().collect() }
        };

        let axes: Vec<_> = Axis::ALL.into_iter().map(axis).collect();
        let variables: Vec<_> = Variable::ALL.into_iter().map(variable).collect();
        let mut obstacles = moments.clone();
        let v_unobserved = variables.iter().filter(|answer| answer.what == Variable::V).flat_map(|answer| &answer.reasons);
        obstacles.extend(v_unobserved.cloned());
        obstacles.extend(missing(&[Channel::Ay]).map(|missing| format!("{missing}: Y_v, and so its damping, stays unknown")));
        let mut dutch_roll = Feasibility::from_obstacles((), obstacles);
        let lateral = [Variable::LatCyclic, Variable::Pedal];
        let excites = |answer: &Feasibility<Variable>| lateral.contains(&answer.what) && answer.reasons.is_empty();
        if no_control.is_none() && !variables.iter().any(excites) {
            let names = lateral.map(|variable| variable.name(controls)).join(" nor ");
            dutch_roll.reasons.push(format!("neither {names} moves enough: only gusts or a free motion can excite it"));
        }
        dutch_roll.reasons.extend(stands.clone());
        let (with, without): (Vec<Aid>, Vec<Aid>) = Aid::ALL.into_iter().partition(|aid| survey.of(aid.channel()).is_some());
        let names = |aids: Vec<Aid>| aids.into_iter().map(|aid| aid.channel().name(controls)).collect();
        let mut state_obstacles: Vec<String> = no_rates.into_iter().collect();
        if with.is_empty() {
            state_obstacles.push("no aid at all".into());
        }
        EstimableQuantities {
            state: Feasibility::from_obstacles((), state_obstacles),
            aids: names(with),
            aids_missing: names(without),
            axes,
            variables,
            dutch_roll,
        }
    }
}

/// Why nothing is estimated from a recording without controls.
const NO_CONTROL: &str = "no control is recorded as a deflection (rad or deg): an input is not told from gusts";

fn unobserved(variable: Variable, missing: &str) -> String {
    let name = variable.name(ControlNames::default());
    match variable {
        Variable::V => format!("{missing}: v is not observed, so N_v and L_v are not identifiable"),
        Variable::W => format!("{missing}: w is not observed, so Z_w and M_w are not identifiable"),
        Variable::U => format!("{missing}: u is not observed"),
        _ => format!("{missing}: {name} is not measured"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sideslip::flight::file::run_file::RecordingColumn;
    use sideslip::flight::sample::Sample;
    use sideslip::io::telemetry::record::RecordingRow;

    /// A hundred samples of every named channel at that rate; all move but those in `still`.
    fn judged(names: &str, rate_hz: f64, still: &[Channel]) -> EstimableQuantities {
        let columns: Vec<RecordingColumn> = names.split(' ').map(|name| RecordingColumn::new(name, None).unwrap()).collect();
        let mut survey = Survey::new(&columns);
        for step in 0..100_u32 {
            let mut sample = Sample::new(f64::from(step) / rate_hz);
            for name in names.split(' ') {
                let (channel, _) = Channel::from_name(name).unwrap();
                sample.set(channel, if still.contains(&channel) { 0.1 } else { f64::from(step) });
            }
            survey.add(&RecordingRow { number: 1, sample, others: Vec::new() });
        }
        EstimableQuantities::of(&survey, ControlNames::FixedWing)
    }

    const ALL: &str = "ax ay az p q r phi theta psi tas alpha beta altitude elevator aileron throttle rudder";

    #[test]
    fn a_full_recording_gives_everything() {
        let answer = judged(ALL, 25.0, &[]);
        assert!(answer.state.possible && answer.dutch_roll.possible && answer.dutch_roll.reasons.is_empty());
        assert!(answer.axes.iter().all(|axis| axis.possible) && answer.variables.iter().all(|variable| variable.possible));
        assert_eq!((answer.aids.len(), answer.aids_missing.len()), (7, 0));
    }

    #[test]
    fn slow_rates_give_a_sentence_and_no_derivatives() {
        let answer = judged(ALL, 4.0, &[]);
        assert!(answer.state.possible && !answer.dutch_roll.possible && answer.axes.iter().all(|axis| !axis.possible));
        assert_eq!(answer.dutch_roll.reasons, ["p q r come at 4.0 Hz, derivatives need 8 Hz"]);
        assert!(judged(ALL, 8.0, &[]).dutch_roll.possible);
    }

    #[test]
    fn a_recording_that_is_too_short_or_stands_still_says_so() {
        let short = judged(ALL, 100.0, &[]);
        assert!(short.state.possible && short.axes.iter().all(|axis| !axis.possible) && !short.dutch_roll.possible);
        assert_eq!(short.axes[3].reasons, ["it is 0.99 s long, derivatives need 2 s or more"]);
        let still = judged(ALL, 25.0, &[Channel::P, Channel::Q, Channel::R]);
        assert!(still.axes.iter().all(|axis| axis.possible));
        assert_eq!(still.axes[3].reasons, ["p q r move by 0.000 rad/s from end to end only, as of an aircraft that stands"]);
        assert_eq!(still.dutch_roll.reasons, still.axes[3].reasons);
    }

    #[test]
    fn what_is_missing_is_named_with_what_it_costs() {
        let answer = judged("p q r phi theta tas alpha elevator aileron rudder", 10.0, &[Channel::Pedal]);
        let possible: Vec<&str> = answer.axes.iter().filter(|axis| axis.possible).map(|axis| axis.what.name()).collect();
        assert_eq!(possible, ["L", "M", "N"]);
        assert_eq!(answer.axes[0].reasons, ["no `ax`"]);
        let reasons = |variable: Variable| answer.variables[variable.index()].reasons.join("; ");
        assert_eq!(reasons(Variable::V), "no `beta`: v is not observed, so N_v and L_v are not identifiable");
        assert_eq!((reasons(Variable::Pedal), reasons(Variable::Collective)), ("never moves".into(), "not measured".into()));
        assert_eq!((answer.dutch_roll.possible, answer.dutch_roll.reasons.len()), (false, 2));
        assert_eq!(answer.aids_missing, ["beta", "psi", "altitude"]);
        let blind = judged("tas alpha beta", 10.0, &[]);
        assert!(!blind.state.possible && blind.state.reasons[0] == "no `p`, `q`, `r`");
        assert!(blind.dutch_roll.reasons.iter().any(|reason| reason == NO_CONTROL), "{:?}", blind.dutch_roll.reasons);
        let still = judged(ALL, 10.0, &[Channel::LatCyclic, Channel::Pedal]);
        assert_eq!(
            still.dutch_roll.reasons.last().unwrap(),
            "neither aileron nor rudder moves enough: only gusts or a free motion can excite it"
        );
    }
}
