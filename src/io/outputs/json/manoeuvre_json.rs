//! The interpretation for a program: the value of the key `interpretation` of `check --json`. SI and radians.
//!
//! ```text
//! {"runs": [{"run": "..", "sentences": ["one sentence for a person"], "reason": "why there is no manoeuvre, or null",
//!    "manoeuvres": [{"control": "pedal", "shape": "3211", "start": s, "end": s, "amplitude": M (first pulse, signed, rad),
//!       "travel": rad, "pulses": [{"start": s, "end": s or null (not ended), "level": rad}],
//!       "other_controls": {"aileron": rad},
//!       "trim": T {"from": s, "to": s, "tas": M, "acceleration": M, "rho": kg/m^3, "altitude": m, "climb": M (m/s),
//!                  "rates_rms": {"p": rad/s, "q": .., "r": ..}, "steady": bool, "unsteady": ["reason"]},
//!       "oscillation": T {"plane": "lateral", "omega": M, "zeta": M, "from": s, "to": s, "cycles": n, "explained": 0..1,
//!                  "channels": {"r": size at `from`}, "control_motion": part of the travel,
//!                  "decrement": {"omega": M, "zeta": M} or null, "earlier": {"from": s, "zeta": M} or null},
//!       "sensitivity": {"r": {"acceleration": M or null (rad/s^2 per rad), "rate": M (rad/s per rad), "peak": M, "after": s,
//!                  "significant": bool}},
//!       "coupling": T {"on_axis": "r", "ratio": {"p": {"value", "std", "significant", "exceeds_after": s or null}},
//!                  "level": 0.25},
//!       "span": M or null}]}],
//!  "test_points": [{"control", "shape", "amplitude": rad, "tas": m/s, "climb": m/s, "runs": [{"run": "..", "manoeuvre": 0}],
//!       "enough": bool (three runs or more), "scatter": T {"r": {"value", "std", "noise"}} (parts of the response)}],
//!  "linearity": [{"control", "shape", "channel", "response": "initial" or "span", "side": 1, -1 or 0 (both),
//!       "amplitudes": [least, most], "runs": n,
//!       "line": T {"slope": M, "growth": M, "linear": bool, "curvature": L, "offset": L or null, "asymmetry": L or null}}],
//!  "sentences": [".."]}
//! ```
//! M is `{"value", "std"}`; L is `{"value", "std", "score", "limit", "significant"}`; T is the object as written, or
//! `{"reason": ".."}` where it cannot be estimated. A number that is absent or not finite is null.

use crate::flight::channel::{Channel, ControlNames};
use crate::io::outputs::words::manoeuvre_sentences;
use crate::postflight::manoeuvres::record::{
    COUPLING_LEVEL, Coupling, FreeOscillation, Interpretation, LineTest, Linearity, Manoeuvre, Measured, NotEstimable, Plane,
    Pulse, RUNS_A_POINT, Response, RunInterpretation, TestPoint, TrimState, on_axis,
};
use serde_json::{Map, Value, json};

/// The whole.
pub fn document(all: &Interpretation) -> Value {
    let controls = all.runs.first().map_or(ControlNames::default(), |run| run.controls);
    json!({
        "runs": all.runs.iter().map(run).collect::<Vec<_>>(),
        "test_points": all.points.iter().map(|one| point(one, all, controls)).collect::<Vec<_>>(),
        "linearity": all.linearity.iter().map(|one| linearity(one, controls)).collect::<Vec<_>>(),
        "sentences": manoeuvre_sentences::of_all(all),
    })
}

fn measured(one: Measured) -> Value {
    json!({"value": one.value, "std": one.std})
}

fn maybe(one: Option<Measured>) -> Value {
    one.map_or(Value::Null, measured)
}

fn told<T>(one: &Result<T, NotEstimable>, controls: ControlNames, document: impl Fn(&T) -> Value) -> Value {
    match one {
        Ok(one) => document(one),
        Err(NotEstimable::StillMoves(control, longest_s)) => {
            let reason = format!("{} still moves (still for {longest_s:.1} s at most)", control.name(controls));
            json!({"reason": reason})
        }
        Err(reason) => json!({"reason": reason.to_string()}),
    }
}

fn run(run: &RunInterpretation) -> Value {
    json!({
        "run": run.run,
        "reason": run.nothing,
        "manoeuvres": run.manoeuvres.iter().map(|one| manoeuvre(one, run.controls)).collect::<Vec<_>>(),
        "sentences": manoeuvre_sentences::of_run(run),
    })
}

fn manoeuvre(one: &Manoeuvre, controls: ControlNames) -> Value {
    let pulse = |pulse: &Pulse| json!({"start": pulse.start_s, "end": pulse.ended.then_some(pulse.end_s), "level": pulse.level});
    let others: Map<String, Value> =
        one.others.iter().map(|(control, travel)| (control.name(controls).into(), json!(travel))).collect();
    let sensitivity: Map<String, Value> = one
        .sensitivities
        .iter()
        .map(|axis| {
            let value = json!({
                "acceleration": maybe(axis.acceleration),
                "rate": measured(axis.rate),
                "peak": measured(axis.peak),
                "after": axis.after_s,
                "significant": axis.significant,
            });
            (axis.channel.name(controls).into(), value)
        })
        .collect();
    let on = on_axis(one.control).name(controls);
    json!({
        "control": one.control.name(controls),
        "shape": one.shape.to_string(),
        "start": one.start_s,
        "end": one.end_s,
        "amplitude": measured(Measured { value: one.amplitude, std: one.amplitude_std }),
        "travel": one.travel,
        "pulses": one.pulses.iter().map(pulse).collect::<Vec<_>>(),
        "other_controls": others,
        "trim": told(&one.trim, controls, trim_state),
        "oscillation": told(&one.oscillation, controls, |found| oscillation(found, Plane::of(one.control), controls)),
        "sensitivity": sensitivity,
        "coupling": told(&one.couplings, controls, |all| coupling(all, on, controls)),
        "span": maybe(one.span),
    })
}

fn trim_state(trim: &TrimState) -> Value {
    let [p, q, r] = trim.rates;
    json!({
        "from": trim.from_s,
        "to": trim.to_s,
        "tas": maybe(trim.tas),
        "acceleration": maybe(trim.acceleration),
        "rho": trim.rho,
        "altitude": trim.altitude,
        "climb": maybe(trim.climb),
        "rates_rms": {"p": p, "q": q, "r": r},
        "steady": trim.unsteady.is_empty(),
        "unsteady": trim.unsteady,
    })
}

fn oscillation(found: &FreeOscillation, plane: Plane, controls: ControlNames) -> Value {
    let channels: Map<String, Value> =
        found.channels.iter().map(|(channel, size)| (channel.name(controls).into(), json!(size))).collect();
    json!({
        "plane": plane.word(),
        "omega": measured(found.omega),
        "zeta": measured(found.zeta),
        "from": found.from_s,
        "to": found.to_s,
        "cycles": found.cycles,
        "explained": found.explained,
        "channels": channels,
        "control_motion": found.control_motion,
        "decrement": found.decrement.map(|(omega, zeta)| json!({"omega": measured(omega), "zeta": measured(zeta)})),
        "earlier": found.earlier.map(|(from_s, zeta)| json!({"from": from_s, "zeta": measured(zeta)})),
    })
}

fn coupling(all: &[Coupling], on: &str, controls: ControlNames) -> Value {
    let one = |one: &Coupling| {
        let Measured { value, std } = one.ratio;
        json!({"value": value, "std": std, "significant": one.significant, "exceeds_after": one.exceeds_after_s})
    };
    let ratio: Map<String, Value> = all.iter().map(|axis| (axis.channel.name(controls).into(), one(axis))).collect();
    json!({"on_axis": on, "ratio": ratio, "level": COUPLING_LEVEL})
}

fn point(point: &TestPoint, all: &Interpretation, controls: ControlNames) -> Value {
    let member = |(run, place): &(usize, usize)| json!({"run": all.runs.get(*run).map(|run| &run.run), "manoeuvre": place});
    json!({
        "control": point.control.name(controls),
        "shape": point.shape.to_string(),
        "amplitude": point.amplitude,
        "tas": point.tas,
        "climb": point.climb,
        "runs": point.members.iter().map(member).collect::<Vec<_>>(),
        "enough": point.members.len() >= RUNS_A_POINT,
        "scatter": told(&point.scatter, controls, |scatter| {
            let one = |one: &crate::postflight::manoeuvres::record::Scatter| {
                json!({"value": one.scatter.value, "std": one.scatter.std, "noise": one.noise})
            };
            let name = |channel: Channel| channel.name(controls).to_owned();
            scatter.iter().map(|channel| (name(channel.channel), one(channel))).collect::<Map<_, _>>().into()
        }),
    })
}

fn linearity(one: &Linearity, controls: ControlNames) -> Value {
    let test = |test: LineTest| {
        json!({
            "value": test.found.value,
            "std": test.found.std,
            "score": test.score,
            "limit": test.limit,
            "significant": test.significant(),
        })
    };
    json!({
        "control": one.control.name(controls),
        "shape": one.shape.to_string(),
        "channel": one.channel.name(controls),
        "response": match one.response { Response::Initial => "initial", Response::Span => "span" },
        "side": one.side,
        "amplitudes": [one.amplitudes.0, one.amplitudes.1],
        "runs": one.runs,
        "line": told(&one.line, controls, |line| json!({
            "slope": measured(line.slope),
            "growth": measured(line.growth),
            "linear": !line.nonlinear,
            "curvature": test(line.curvature),
            "offset": line.offset.map(test),
            "asymmetry": line.asymmetry.map(test),
        })),
    })
}
