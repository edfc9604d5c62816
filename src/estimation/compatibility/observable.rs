//! What these runs cannot tell: channels that are not there, errors that would drown, axes that hardly move.
//!
//! The least error that is told has F above ENTER of `select` even where its estimate falls two standard errors short,
//!     least = sqrt(ENTER (c s^2 + sigma^2)) + 2 sqrt(c) s                                              (1)
//! A factor or lateness of one axis is seen through that axis' motion. Where the others move far more, a part of theirs that
//! nobody models (gyros turned against each other, platforms, curved flight) is as large as the error itself: it is then told
//! only if the axis moves at least [`EXCITED`] as much as the busiest.

use super::fit::{Run, place_of};
use super::parameter::{ACCELEROMETER_PLACE, ALPHA_PLACE, INPUT_CHANNELS, INPUTS, Kind, OUTPUT_CHANNELS, PARAMETERS, Parameter};
use super::record::Record;
use super::select::{ENTER, Found, is_gusty};
use super::series::Series;
use crate::flight::channel::{Channel, ControlNames};

/// What leaks from one axis into another, 2 %, is below the least factor worth finding, 5 %, of the axis' own motion.
pub const EXCITED: f64 = 0.4;
const GYRO: usize = 3;

/// Standard deviation of what a line does beyond its noise.
pub fn motion(series: &Series) -> f64 {
    let count = series.len() as f64;
    let mean = series.samples().map(|(_, value)| value).sum::<f64>() / count;
    let square = series.samples().map(|(_, value)| (value - mean) * (value - mean)).sum::<f64>() / count;
    let noise = series.noise_std();
    libm::sqrt((square - noise * noise).max(0.0))
}

/// How much the axis of a factor or a lateness moves, as part of the busiest; `None` where that does not matter.
fn part_of_motion(run: &Run, parameter: Parameter) -> Option<f64> {
    if !matches!(parameter.kind, Kind::Scale | Kind::Timing) {
        return None;
    }
    let axis = match parameter.measured? {
        gyro @ GYRO..INPUTS => gyro - GYRO,
        output => output.checked_sub(INPUTS + 3).filter(|axis| *axis < 3)?,
    };
    let moves = |axis: usize| run.record.inputs.get(GYRO + axis).and_then(Option::as_ref).map_or(0.0, motion);
    let most = (0..3).map(moves).fold(0.0, f64::max);
    Some(if most > 0.0 { moves(axis) / most } else { 0.0 })
}

/// The part of the busiest axis' motion that a parameter's own axis has, of the run where it has most; `None` where it moves
/// enough or need not.
pub fn idle(runs: &[Run], parameter: Parameter) -> Option<f64> {
    let parts = runs.iter().filter(|run| run.active.contains(&parameter.index));
    let most = parts.map(|run| part_of_motion(run, parameter)).try_fold(0.0, |most: f64, part| Some(most.max(part?)))?;
    (most < EXCITED).then_some(most)
}

/// What is said of a parameter that these runs would have different, but whose axis hardly moves.
pub fn doubted(parameter: Parameter, part: f64, value: f64, std: f64) -> String {
    let shown = if parameter.kind == Kind::Scale { 1.0 + value } else { value };
    format!("{}: {shown:.3} +- {std:.3} would fit, but {}", words(parameter), too_still(part))
}

fn too_still(part: f64) -> String {
    format!("its axis moves too little beside the others ({:.0} % of the busiest)", 100.0 * part)
}

/// Parameters whose error would drown.
pub fn drowned(found: &Found, number: usize) -> Vec<String> {
    let Some(run) = found.runs.get(number) else { return Vec::new() };
    let minimum = found.local.minimum(&found.point);
    let mut said = Vec::new();
    let mut rough = false;
    for index in 0..PARAMETERS {
        let parameter = Parameter::at(index);
        let place = place_of(number, index);
        if !parameter.can_be_fault() || !run.active.contains(&index) {
            continue;
        }
        let what = words(parameter);
        if parameter.is_feigned_by_gusts() && is_gusty(run) {
            rough = true;
            continue;
        }
        if found.point.free.contains(&place) {
            continue;
        }
        if let Some(part) = idle(&found.runs, parameter) {
            said.push(format!("{what}: {}", too_still(part)));
            continue;
        }
        // Of a sensor that is known to stand elsewhere nothing is missing.
        let (from, axis) = (ALPHA_PLACE, index.saturating_sub(ALPHA_PLACE) % 3);
        let known = |other: usize| found.point.free.contains(&place_of(number, from + 3 * other + axis));
        if (ALPHA_PLACE..ACCELEROMETER_PLACE + 3).contains(&index) && (0..4).any(known) {
            continue;
        }
        let let_go = found.local.let_go(&found.point, &minimum, place);
        let (Some(one), Some((normal, _))) = (let_go, found.point.priors(place)) else {
            said.push(format!("{what}: this motion shows nothing of it"));
            continue;
        };
        let variance = found.local.colour(&found.runs, place) * one.std * one.std;
        let least = libm::sqrt(ENTER * (variance + normal * normal)) + 2.0 * libm::sqrt(variance);
        if least > parameter.worth_finding() {
            let unit = unit(parameter);
            said.push(format!("{what}: less than {least:.2}{unit} could not be told, this motion shows too little of it"));
        }
    }
    if rough {
        said.push("errors of tas alpha beta ax ay az and positions: the air is too rough, gusts look the same".to_owned());
    }
    if run.record.outputs.get(5).is_some_and(Option::is_some) {
        said.push("psi bias: any heading may be the start".to_owned());
    }
    if run.record.outputs.get(6).is_some_and(Option::is_some) {
        said.push("altitude: rising air and static pressure look like errors of its instrument".to_owned());
    }
    said
}

fn unit(parameter: Parameter) -> String {
    match parameter.kind {
        Kind::Bias => parameter.channel().map_or(String::new(), |channel| format!(" {}", channel.si_unit())),
        Kind::Timing => " s".to_owned(),
        Kind::Scale => String::new(),
        _ => " m".to_owned(),
    }
}

/// Channels that are not there.
pub fn absent(record: &Record) -> Vec<String> {
    let name = |channel: &Channel| channel.name(ControlNames::Rotorcraft);
    let mut said = Vec::new();
    let inputs = INPUT_CHANNELS.iter().zip(&record.inputs).filter(|(_, series)| series.is_none());
    let inputs: Vec<&str> = inputs.map(|(channel, _)| name(channel)).collect();
    if !inputs.is_empty() {
        said.push(format!("{}: not measured", inputs.join(" ")));
    }
    if !record.velocities {
        let reason = if record.inputs.iter().take(3).any(Option::is_none) { "accelerometers" } else { "airspeed" };
        said.push(format!(
            "tas alpha beta altitude: without {reason} nothing says how the velocity moves; \
             only attitude and rates are compared"
        ));
    }
    let velocity = |channel: &Channel| !matches!(channel, Channel::Phi | Channel::Theta | Channel::Psi);
    for (channel, series) in OUTPUT_CHANNELS.iter().zip(&record.outputs) {
        if series.is_none() && (record.velocities || !velocity(channel)) {
            said.push(format!("{}: not measured", name(channel)));
        }
    }
    said
}

/// A parameter in words.
fn words(parameter: Parameter) -> String {
    let channel = parameter.channel().map_or("", |channel| channel.name(ControlNames::Rotorcraft));
    let axis = |axis: usize| ["x", "y", "z"].get(axis).copied().unwrap_or("");
    match parameter.kind {
        Kind::Bias => format!("{channel} bias"),
        Kind::Scale => format!("{channel} scale"),
        Kind::Timing => format!("{channel} lag or skew"),
        Kind::AlphaPlace(a) => format!("place of the alpha vane alone, {}", axis(a)),
        Kind::BetaPlace(a) => format!("place of the beta vane alone, {}", axis(a)),
        Kind::VanePlace(a) => format!("vane position {}", axis(a)),
        Kind::AccelerometerPlace(a) => format!("accelerometer position {}", axis(a)),
        Kind::Flow(_) | Kind::Turned(_) => String::new(),
    }
}
