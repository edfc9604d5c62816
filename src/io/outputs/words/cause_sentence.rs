//! Findings in words: one sentence a cause, and the manoeuvre that would distinguish two causes.

use crate::flight::channel::ControlNames;
use crate::flight::derivative::Axis;
use crate::flight::effect::{Effect, EffectKind, Family, PositionedSensor};
use crate::flight::model::LinearModel;
use crate::io::outputs::number::{band_text, estimate_text};
use crate::postflight::diagnosis::record::{RankedCause, UnexplainedAxis};

fn axis_in_words(axis: Axis) -> &'static str {
    match axis {
        Axis::X => "longitudinal force",
        Axis::Y => "side force",
        Axis::Z => "normal force",
        Axis::L => "rolling moment",
        Axis::M => "pitching moment",
        Axis::N => "yawing moment",
    }
}

/// One sentence for a person.
pub fn statement(cause: &RankedCause, model: &LinearModel, naming: ControlNames) -> String {
    let with = |number: f64| estimate_text(number, cause.std);
    match cause.effect {
        Effect::Derivative { axis, variable, delta } => {
            let name = format!("{}_{}", axis.name(), variable.name(naming));
            let was = model.derivative(axis, variable);
            let now = estimate_text(was + delta, cause.std);
            if was == 0.0 {
                format!("the model lacks {name}: flight shows {now}")
            } else if libm::fabs(was + delta) < 2.0 * cause.std {
                format!("{name} is {was:.4} in the model, where flight shows none: {now}")
            } else {
                let size = if libm::fabs(was + delta) > libm::fabs(was) { "too small" } else { "too large" };
                let size = if was * (was + delta) < 0.0 { "of the wrong sign" } else { size };
                format!("{name} is {size} in the model: {was:.4}, where flight shows {now}")
            }
        }
        Effect::Nonlinear { axis, term, coefficient } => format!(
            "the model lacks a nonlinear term of the {}, {term}: {} = {}",
            axis_in_words(axis),
            format_args!("{}_{term}", axis.name()),
            with(coefficient)
        ),
        Effect::ControlEffectiveness { control, factor } if factor < 0.0 => {
            format!("{} is recorded, or acts in the model, with the sign turned: factor {}", control.name(naming), with(factor))
        }
        Effect::ControlEffectiveness { control, factor } => {
            format!("{} has {} times the effectiveness of the model, the same in all axes", control.name(naming), with(factor))
        }
        Effect::ActuatorLag { control, tau } => {
            let reaches = if control.name(naming) == "pedal" {
                "the pedal reaches the tail rotor"
            } else {
                "the control reaches its blade"
            };
            format!("{}: {reaches} with a lag of {} s: an actuator is missing in the model", control.name(naming), with(tau))
        }
        Effect::TransportDelay { control, delay } => {
            format!(
                "{} acts with a delay of {} s, its edges kept sharp: a transport delay is missing in the model",
                control.name(naming),
                with(delay)
            )
        }
        Effect::RateLimit { control, rate } => {
            format!(
                "{} reaches its blade no faster than {} rad/s: a rate limit is missing in the model",
                control.name(naming),
                with(rate)
            )
        }
        Effect::DeadZone { control, half_width } => {
            format!(
                "{} moves nothing within {} rad about its trim: a dead zone is missing in the model",
                control.name(naming),
                with(half_width)
            )
        }
        Effect::CrossFeed { from, to, gain } => {
            format!(
                "{} moves {} too, {} rad per rad: an interlink is missing in the model",
                from.name(naming),
                to.name(naming),
                with(gain)
            )
        }
        Effect::RotorSpeed { axis, coefficient } => {
            format!(
                "the {} depends on the rotor's speed, which the model omits: {} per rad/s",
                axis_in_words(axis),
                with(coefficient)
            )
        }
        Effect::RotorReaction { reaction } => {
            format!(
                "the reaction of the rotor's acceleration turns the fuselage, which the model omits: {} of it, and as much less of every \
                 yawing moment (a rotor that turns {} positive yaw; its speed is a state, no input)",
                with(reaction),
                if reaction > 0.0 { "against" } else { "with" }
            )
        }
        Effect::FlightPath { axis, variable, slope } => {
            format!(
                "{}_{} changes with the flight path by {} per radian of climb, which is constant in the model",
                axis.name(),
                variable.name(naming),
                with(slope)
            )
        }
        Effect::Turbulence { sigma, length } => {
            format!("gusts of {} m/s (scale {length:.0} m) disturb the aircraft: no error of the model", with(sigma))
        }
        Effect::SensorBias { channel, value: bias } => {
            format!("{} has a bias of {} {}", channel.name(naming), with(bias), channel.si_unit())
        }
        Effect::SensorScale { channel, factor } if factor < 0.0 => {
            format!("{} is recorded with the sign turned: it reads {} times the true value", channel.name(naming), with(factor))
        }
        Effect::SensorScale { channel, factor } => {
            format!("{} has a scale factor of {}", channel.name(naming), with(factor))
        }
        Effect::SensorLag { channel, tau } => format!("{} is measured with a lag of {} s", channel.name(naming), with(tau)),
        Effect::SensorDelay { channel, delay } => {
            let late = if delay >= 0.0 { "late" } else { "early" };
            format!("{} is measured {} s {late}", channel.name(naming), estimate_text(libm::fabs(delay), cause.std))
        }
        Effect::SensorPosition { sensor, offset_m: [x, y, z] } => {
            let what = match sensor {
                PositionedSensor::Accelerometer => "the accelerometers are",
                PositionedSensor::Vane => "the vanes are",
            };
            format!(
                "{what} not where the run declares them: {x:.2} m ahead, {y:.2} m to the right, {z:.2} m below (+- {:.2} m)",
                cause.std
            )
        }
        Effect::Exchanged { channels: [one, other] } => {
            format!("{} and {} are exchanged: each is recorded under the other's name", one.name(naming), other.name(naming))
        }
        Effect::None => "the model explains the data within their noise and its own tolerance".to_owned(),
        Effect::Unknown { axis } => format!("an effect on the {} is explained by no hypothesis", axis_in_words(axis)),
    }
}

/// The same of something unknown.
pub fn unknown(unknown: &UnexplainedAxis) -> String {
    let band = band_text(unknown.band_hz);
    let band = match band.split_once('-') {
        Some((low, high)) => format!("between {low} and {high} Hz"),
        None => format!("at {band} Hz"),
    };
    format!("an effect on the {}, mostly {band}, is explained by no hypothesis", axis_in_words(unknown.axis))
}

/// What to fly so that two causes are distinguished.
pub fn manoeuvre(a: &Effect, b: &Effect) -> &'static str {
    use EffectKind::{ActuatorLag, DeadZone, RateLimit, SensorDelay, SensorLag, TransportDelay};
    let (first, second) = (a.kind(), b.kind());
    let pair = |x: EffectKind, y: EffectKind| (first == x && second == y) || (first == y && second == x);
    if pair(ActuatorLag, TransportDelay) || pair(SensorLag, SensorDelay) {
        "sharp doublets with edges above 1 Hz: a lag attenuates them, a delay does not"
    } else if first == RateLimit || second == RateLimit || first == DeadZone || second == DeadZone {
        "the same input at half and at twice the amplitude: the effect of a limit or a dead zone changes with it"
    } else if first.family() == Family::Instrument && second.family() == Family::Instrument {
        "another speed, and a steady turn: there the kinematics relate the two instruments differently"
    } else if first.family() == Family::Instrument || second.family() == Family::Instrument {
        "free response with the controls held: an instrument's error remains, that of a control does not"
    } else if first.family() == Family::Nonlinear || second.family() == Family::Nonlinear {
        "the same input at twice the amplitude, and a steady-heading sideslip: a nonlinear part grows faster"
    } else {
        "an input on another control, so that the regressors of the two causes are no longer correlated"
    }
}
