//! Gross errors of instruments: a wrong unit, a reversed sign, two channels exchanged.
//!
//! Consumes nothing; produces the errors that a record is tested for, and how each is corrected.

use crate::flight::channel::Channel;
use crate::flight::unit::{DEGREE, FOOT, STANDARD_GRAVITY};

/// A gross error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GrossError {
    /// These read with the opposite sign.
    Turned(&'static [Channel]),
    /// These read in that unit; its size in SI.
    Unit(&'static [Channel], &'static str, f64),
    /// Two are exchanged.
    Swapped([Channel; 2]),
}

const P: &[Channel] = &[Channel::P];
const Q: &[Channel] = &[Channel::Q];
const R: &[Channel] = &[Channel::R];
const PHI: &[Channel] = &[Channel::Phi];
const THETA: &[Channel] = &[Channel::Theta];
const PSI: &[Channel] = &[Channel::Psi];
const ALPHA: &[Channel] = &[Channel::Alpha];
const BETA: &[Channel] = &[Channel::Beta];
const AX: &[Channel] = &[Channel::Ax];
const AY: &[Channel] = &[Channel::Ay];
const AZ: &[Channel] = &[Channel::Az];
const TAS: &[Channel] = &[Channel::Tas];
const ALTITUDE: &[Channel] = &[Channel::Altitude];
const GYROS: &[Channel] = &Channel::GYROS;
const ATTITUDE: &[Channel] = &[Channel::Phi, Channel::Theta, Channel::Psi];
const VANES: &[Channel] = &[Channel::Alpha, Channel::Beta];
const ANGLES: &[Channel] = &[Channel::Phi, Channel::Theta, Channel::Psi, Channel::Alpha, Channel::Beta];
const ALL_ANGLES: &[Channel] =
    &[Channel::P, Channel::Q, Channel::R, Channel::Phi, Channel::Theta, Channel::Psi, Channel::Alpha, Channel::Beta];
const FORCES: &[Channel] = &Channel::ACCELEROMETERS;
const ROLL: &[Channel] = &[Channel::P, Channel::Phi];
const PITCH: &[Channel] = &[Channel::Q, Channel::Theta];
const YAW: &[Channel] = &[Channel::R, Channel::Psi];

/// Units of airspeed, in m/s.
pub const SPEEDS: [(&str, f64); 4] = [("kn", 1852.0 / 3600.0), ("km/h", 1.0 / 3.6), ("ft/s", FOOT), ("mph", 0.447_04)];

/// Load factor up to which, and from whose inverse on, a mean is one of nearly level flight.
const LOAD_FACTOR: f64 = 1.5;
/// How many gross errors a record is tested for.
pub const GROSS_ERRORS: usize = 70;

impl GrossError {
    /// Every error that is tested.
    pub const ALL: &'static [GrossError; GROSS_ERRORS] = &{
        use GrossError::{Swapped, Turned, Unit};
        const AS_RATE: &str = "rad/s, declared as deg/s";
        const AS_ANGLE: &str = "rad, declared as deg";
        const FEET: &str = "ft/s^2";
        const RADIAN: f64 = 1.0 / DEGREE;
        let [kn, km_h, ft_s, mph] = SPEEDS;
        [
            Turned(P),
            Turned(Q),
            Turned(R),
            Turned(PHI),
            Turned(THETA),
            Turned(PSI),
            Turned(ALPHA),
            Turned(BETA),
            Turned(AX),
            Turned(AY),
            Turned(GYROS),
            Turned(ATTITUDE),
            Turned(VANES),
            Unit(P, "deg/s", DEGREE),
            Unit(Q, "deg/s", DEGREE),
            Unit(R, "deg/s", DEGREE),
            Unit(PHI, "deg", DEGREE),
            Unit(THETA, "deg", DEGREE),
            Unit(PSI, "deg", DEGREE),
            Unit(ALPHA, "deg", DEGREE),
            Unit(BETA, "deg", DEGREE),
            Unit(GYROS, "deg/s", DEGREE),
            Unit(ATTITUDE, "deg", DEGREE),
            Unit(VANES, "deg", DEGREE),
            Unit(ANGLES, "deg", DEGREE),
            Unit(ALL_ANGLES, "deg", DEGREE),
            Unit(P, AS_RATE, RADIAN),
            Unit(Q, AS_RATE, RADIAN),
            Unit(R, AS_RATE, RADIAN),
            Unit(PHI, AS_ANGLE, RADIAN),
            Unit(THETA, AS_ANGLE, RADIAN),
            Unit(PSI, AS_ANGLE, RADIAN),
            Unit(ALPHA, AS_ANGLE, RADIAN),
            Unit(BETA, AS_ANGLE, RADIAN),
            Unit(GYROS, AS_RATE, RADIAN),
            Unit(ATTITUDE, AS_ANGLE, RADIAN),
            Unit(VANES, AS_ANGLE, RADIAN),
            Unit(ANGLES, AS_ANGLE, RADIAN),
            Unit(AX, "g", STANDARD_GRAVITY),
            Unit(AY, "g", STANDARD_GRAVITY),
            Unit(FORCES, "g", STANDARD_GRAVITY),
            Unit(AX, FEET, FOOT),
            Unit(AY, FEET, FOOT),
            Unit(FORCES, FEET, FOOT),
            Unit(FORCES, "m/s^2, declared as g", 1.0 / STANDARD_GRAVITY),
            Unit(FORCES, "m/s^2, declared as ft/s^2", 1.0 / FOOT),
            Turned(AZ),
            Unit(AZ, "g", STANDARD_GRAVITY),
            Unit(AZ, FEET, FOOT),
            Unit(AZ, "m/s^2, declared as g", 1.0 / STANDARD_GRAVITY),
            Unit(AZ, "m/s^2, declared as ft/s^2", 1.0 / FOOT),
            Unit(TAS, kn.0, kn.1),
            Unit(TAS, km_h.0, km_h.1),
            Unit(TAS, ft_s.0, ft_s.1),
            Unit(TAS, mph.0, mph.1),
            Unit(TAS, "m/s, declared as kn", 1.0 / kn.1),
            Unit(TAS, "m/s, declared as km/h", 1.0 / km_h.1),
            Unit(TAS, "m/s, declared as ft/s", 1.0 / ft_s.1),
            Unit(TAS, "m/s, declared as mph", 1.0 / mph.1),
            Unit(ALTITUDE, "ft", FOOT),
            Unit(ALTITUDE, "m, declared as ft", 1.0 / FOOT),
            Swapped([Channel::P, Channel::Q]),
            Swapped([Channel::P, Channel::R]),
            Swapped([Channel::Q, Channel::R]),
            Swapped([Channel::Phi, Channel::Theta]),
            Swapped([Channel::Alpha, Channel::Beta]),
            Swapped([Channel::Ax, Channel::Ay]),
            Turned(ROLL),
            Turned(PITCH),
            Turned(YAW),
        ]
    };

    /// Place in [`GrossError::ALL`].
    pub fn index(&self) -> usize {
        GrossError::ALL.iter().position(|other| other == self).unwrap_or(GROSS_ERRORS)
    }

    /// The channels that it is of.
    pub fn channels(&self) -> &[Channel] {
        match self {
            GrossError::Turned(these) | GrossError::Unit(these, ..) => these,
            GrossError::Swapped(two) => two,
        }
    }

    /// Whether az, alone or with the other accelerometers, reads in another unit: its mean shows that.
    pub fn is_unit_of_weight(&self) -> bool {
        matches!(self, GrossError::Unit(these, ..) if *these == FORCES || *these == AZ)
    }

    /// Whether the other is the same error of these and, perhaps, more channels.
    pub fn is_part_of(&self, other: &GrossError) -> bool {
        let same = match (self, other) {
            (GrossError::Turned(_), GrossError::Turned(_)) => true,
            (GrossError::Unit(_, _, size), GrossError::Unit(_, _, other)) => (size - other).abs() < 1e-12 * size.abs(),
            _ => self == other,
        };
        same && self.channels().iter().all(|channel| other.channels().contains(channel))
    }

    /// The channel whose reading corrects this one, and the factor on it.
    pub fn corrected_by(&self, channel: Channel) -> (Channel, f64) {
        match self {
            GrossError::Turned(these) if these.contains(&channel) => (channel, -1.0),
            GrossError::Unit(these, _, size) if these.contains(&channel) => (channel, *size),
            GrossError::Swapped([a, b]) if *a == channel => (*b, 1.0),
            GrossError::Swapped([a, b]) if *b == channel => (*a, 1.0),
            _ => (channel, 1.0),
        }
    }
}

/// Whether a mean of az, m/s^2, is that of nearly level flight.
pub fn weighs_g(mean_az: f64) -> bool {
    let weight = mean_az.abs() / STANDARD_GRAVITY;
    weight > 1.0 / LOAD_FACTOR && weight < LOAD_FACTOR
}

/// The error of az that its mean over upright flight agrees with, m/s^2: level flight weighs g, upwards. Of ax and ay it says
/// nothing.
pub fn error_by_weight(mean_az: f64) -> Option<&'static GrossError> {
    if weighs_g(mean_az) {
        return GrossError::ALL.iter().find(|error| mean_az > 0.0 && matches!(error, GrossError::Turned(these) if *these == AZ));
    }
    let corrected = |size: f64| mean_az.abs() * size;
    GrossError::ALL
        .iter()
        .find(|error| matches!(error, GrossError::Unit(these, _, size) if *these == AZ && weighs_g(corrected(*size))))
}

/// The unit of speed other than m/s that a scale factor with this standard error agrees with.
pub fn speed_unit(factor: f64, std: f64) -> Option<&'static str> {
    let off = |size: f64| (factor * size - 1.0).abs();
    SPEEDS.into_iter().find(|(_, size)| off(*size) < 3.0 * std * size && off(*size) < 0.05).map(|(unit, _)| unit)
}
