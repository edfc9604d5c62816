//! From a parameter to a correction: the effect it is, what else it may be, what would tell these apart.

use super::fault_selection::FaultKey;
use super::fit::parameter_at;
use super::record::{InstrumentErrorKind, Separation};
use crate::flight::channel::Channel;
use crate::flight::effect::{Effect, PositionedSensor};
use crate::flight::file::effect_file::DeclaredEffect;

/// What else an error may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// The effect, with its standard error.
    pub effect: DeclaredEffect,
    /// The one vane that it is of, where it is of one.
    pub vane: Option<Channel>,
}

/// One instrument's error.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// What it is, with its standard error.
    pub effect: DeclaredEffect,
    /// The one vane that stands elsewhere, where the other does not show it.
    pub vane: Option<Channel>,
    /// Of a position: the standard error along each axis that it is moved along, m.
    pub axis_stds_m: [Option<f64>; 3],
    /// F against noise and what is normal.
    pub significance: f64,
    /// What else it may be.
    pub alternatives: Vec<Alternative>,
    /// What would tell these apart; empty where there is one explanation.
    pub split_by: Vec<Separation>,
    /// Of the bias of ax or ay: the angle, rad, by which accelerometers that are turned would read so much of gravity.
    pub turned: Option<f64>,
    /// What each run of several says alone: run, value, standard error.
    pub by_run: Vec<(String, f64, f64)>,
}

/// The effect of that name, and which vane it is where only one.
pub(crate) fn effect_of(name: FaultKey, value: f64) -> Option<(Effect, Option<Channel>)> {
    let (parameter, _) = parameter_at(name.place);
    let along = |axis: usize| core::array::from_fn(|i| if i == axis { value } else { 0.0 });
    let vane = |axis| Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: along(axis) };
    Some(match parameter.kind {
        InstrumentErrorKind::Bias => (Effect::SensorBias { channel: parameter.channel()?, value }, None),
        InstrumentErrorKind::Scale => (Effect::SensorScale { channel: parameter.channel()?, factor: 1.0 + value }, None),
        InstrumentErrorKind::Timing if name.lag => {
            (Effect::SensorLag { channel: parameter.channel()?, tau: value.max(0.0) }, None)
        }
        InstrumentErrorKind::Timing => (Effect::SensorDelay { channel: parameter.channel()?, delay: value }, None),
        InstrumentErrorKind::VanePlace(axis) => (vane(axis), None),
        InstrumentErrorKind::AlphaPlace(axis) => (vane(axis), Some(Channel::Alpha)),
        InstrumentErrorKind::BetaPlace(axis) => (vane(axis), Some(Channel::Beta)),
        InstrumentErrorKind::AccelerometerPlace(axis) => {
            (Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m: along(axis) }, None)
        }
        InstrumentErrorKind::Flow(_) | InstrumentErrorKind::Misalignment(_) => return None,
    })
}

/// Components of one sensor's offset in one correction; its standard error is that of the largest.
pub(crate) fn merged(corrections: Vec<Correction>) -> Vec<Correction> {
    let mut merged: Vec<Correction> = Vec::new();
    for one in corrections {
        let place = |correction: &Correction| match correction.effect.effect {
            Effect::SensorPosition { sensor, offset_m } => Some((sensor, offset_m)),
            _ => None,
        };
        let same = merged.iter_mut().find(|other| {
            other.vane == one.vane && matches!((place(other), place(&one)), (Some((a, _)), Some((b, _))) if a == b)
        });
        match (same, place(&one)) {
            (Some(other), Some((sensor, added))) => {
                let Some((_, mut offset_m)) = place(other) else { continue };
                let stds = [0, 1, 2].map(|axis| other.axis_stds_m[axis].or(one.axis_stds_m[axis]));
                offset_m.iter_mut().zip(added).for_each(|(part, more)| *part += more);
                let largest = (0..3).max_by(|&a, &b| offset_m[a].abs().total_cmp(&offset_m[b].abs())).unwrap_or(0);
                other.axis_stds_m = stds;
                other.effect = DeclaredEffect { effect: Effect::SensorPosition { sensor, offset_m }, std: stds[largest] };
                other.alternatives.extend(one.alternatives);
                // Values by run are of one axis, which would not be said.
                other.by_run.clear();
                let split_by = one.split_by.into_iter().filter(|pair| !other.split_by.contains(pair));
                let split_by: Vec<Separation> = split_by.collect();
                other.split_by.extend(split_by);
            }
            _ => merged.push(one),
        }
    }
    for one in &mut merged {
        one.alternatives = once(one, one.alternatives.clone());
    }
    merged
}

fn sensor(effect: &Effect) -> Option<PositionedSensor> {
    match effect {
        Effect::SensorPosition { sensor, .. } => Some(*sensor),
        _ => None,
    }
}

/// Each explanation once, and none that is a part of the correction itself: offsets of one sensor along several axes are one,
/// with the standard error of the largest.
fn once(correction: &Correction, explanations: Vec<Alternative>) -> Vec<Alternative> {
    let largest = |offset: &[f64; 3]| offset.iter().fold(0.0f64, |most, part| most.max(part.abs()));
    let own = sensor(&correction.effect.effect);
    let mut all: Vec<Alternative> = Vec::new();
    for one in
        explanations.into_iter().filter(|one| own.is_none() || sensor(&one.effect.effect) != own || one.vane != correction.vane)
    {
        let alike = |other: &&mut Alternative| {
            let (a, b) = (&other.effect.effect, &one.effect.effect);
            a.kind() == b.kind() && a.sensor_channel() == b.sensor_channel() && sensor(a) == sensor(b) && other.vane == one.vane
        };
        match (all.iter_mut().find(alike), one.effect.effect) {
            (None, _) => all.push(one),
            (Some(other), Effect::SensorPosition { offset_m: added, .. }) => {
                let Effect::SensorPosition { ref mut offset_m, .. } = other.effect.effect else { continue };
                if largest(&added) > largest(offset_m) {
                    other.effect.std = one.effect.std;
                }
                for (part, more) in offset_m.iter_mut().zip(added) {
                    *part = if part.abs() < more.abs() { more } else { *part };
                }
            }
            (Some(_), _) => {}
        }
    }
    all
}

/// What distinguishes a fault from its rivals.
pub(crate) fn splits(name: FaultKey, rivals: impl Iterator<Item = FaultKey>) -> Vec<Separation> {
    let kind = |name: FaultKey| parameter_at(name.place).0.kind;
    let is_place = |kind: InstrumentErrorKind| {
        matches!(
            kind,
            InstrumentErrorKind::AlphaPlace(_)
                | InstrumentErrorKind::BetaPlace(_)
                | InstrumentErrorKind::VanePlace(_)
                | InstrumentErrorKind::AccelerometerPlace(_)
        )
    };
    let mut separations = Vec::new();
    for rival in rivals {
        let separation = match (kind(name), kind(rival)) {
            (InstrumentErrorKind::Timing, InstrumentErrorKind::Timing) if name.place == rival.place => Separation::LagOrSkew,
            (a, b) if is_place(a) && is_place(b) => Separation::VaneOrAccelerometers,
            (a, InstrumentErrorKind::Timing) | (InstrumentErrorKind::Timing, a) if is_place(a) => Separation::PositionOrDelay,
            (InstrumentErrorKind::Scale, InstrumentErrorKind::Scale) => Separation::ScaleOrScale,
            (InstrumentErrorKind::Bias, InstrumentErrorKind::Bias) => Separation::BiasOrBias,
            (InstrumentErrorKind::Bias, InstrumentErrorKind::Scale) | (InstrumentErrorKind::Scale, InstrumentErrorKind::Bias) => {
                Separation::BiasOrScale
            }
            _ => Separation::OtherInput,
        };
        if !separations.contains(&separation) {
            separations.push(separation);
        }
    }
    separations
}
