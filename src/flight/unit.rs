//! Units at the border of the program: what a bracket in a header means, as a factor to SI.
//!
//! Consumes a unit's text; produces its [`Quantity`] and the factor `si = factor * value`.
//! Factors are exact by definition: international foot 0.3048 m, nautical mile 1852 m, avoirdupois pound
//! 0.45359237 kg, standard gravity 9.80665 m/s^2 (BIPM, SI Brochure, 9th ed.; NIST SP 811, app. B).

use core::f64::consts::PI;

/// Standard gravity, m/s^2.
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// A physical quantity that a channel or a model value measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// s.
    Time,
    /// m.
    Length,
    /// m/s.
    Speed,
    /// m/s^2.
    Acceleration,
    /// rad.
    Angle,
    /// rad/s.
    AngularRate,
    /// rad/s^2.
    AngularAcceleration,
    /// kg.
    Mass,
    /// N.
    Force,
    /// N m.
    Torque,
    /// Pa.
    Pressure,
    /// kg/m^3.
    Density,
    /// 1.
    Ratio,
}

impl Quantity {
    /// The SI unit as written in files.
    pub const fn si_unit(self) -> &'static str {
        match self {
            Quantity::Time => "s",
            Quantity::Length => "m",
            Quantity::Speed => "m/s",
            Quantity::Acceleration => "m/s^2",
            Quantity::Angle => "rad",
            Quantity::AngularRate => "rad/s",
            Quantity::AngularAcceleration => "rad/s^2",
            Quantity::Mass => "kg",
            Quantity::Force => "N",
            Quantity::Torque => "N m",
            Quantity::Pressure => "Pa",
            Quantity::Density => "kg/m^3",
            Quantity::Ratio => "1",
        }
    }
}

/// A degree, rad.
pub const DEGREE: f64 = PI / 180.0;
/// A turn a minute, rad/s.
pub const RPM: f64 = PI / 30.0;
const POUND: f64 = 0.453_592_37;
const POUND_FORCE: f64 = POUND * STANDARD_GRAVITY;
/// An international foot, m.
pub const FOOT: f64 = 0.304_8;

/// Every unit that a header may name. A text stands twice where it can mean two quantities (`g`: gravity or gram).
const UNITS: &[(&str, Quantity, f64)] = &[
    ("s", Quantity::Time, 1.0),
    ("ms", Quantity::Time, 1e-3),
    ("us", Quantity::Time, 1e-6),
    ("ns", Quantity::Time, 1e-9),
    ("min", Quantity::Time, 60.0),
    ("h", Quantity::Time, 3600.0),
    ("day", Quantity::Time, 86_400.0),
    ("m", Quantity::Length, 1.0),
    ("mm", Quantity::Length, 1e-3),
    ("cm", Quantity::Length, 1e-2),
    ("km", Quantity::Length, 1e3),
    ("ft", Quantity::Length, FOOT),
    ("m/s", Quantity::Speed, 1.0),
    ("cm/s", Quantity::Speed, 1e-2),
    ("mm/s", Quantity::Speed, 1e-3),
    ("km/h", Quantity::Speed, 1.0 / 3.6),
    ("kn", Quantity::Speed, 1852.0 / 3600.0),
    ("ft/s", Quantity::Speed, FOOT),
    ("ft/min", Quantity::Speed, FOOT / 60.0),
    ("m/s^2", Quantity::Acceleration, 1.0),
    ("cm/s^2", Quantity::Acceleration, 1e-2),
    ("mm/s^2", Quantity::Acceleration, 1e-3),
    ("ft/s^2", Quantity::Acceleration, FOOT),
    ("g", Quantity::Acceleration, STANDARD_GRAVITY),
    ("mg", Quantity::Acceleration, STANDARD_GRAVITY * 1e-3),
    ("rad", Quantity::Angle, 1.0),
    ("mrad", Quantity::Angle, 1e-3),
    ("deg", Quantity::Angle, DEGREE),
    ("rad/s", Quantity::AngularRate, 1.0),
    ("mrad/s", Quantity::AngularRate, 1e-3),
    ("deg/s", Quantity::AngularRate, DEGREE),
    ("rpm", Quantity::AngularRate, RPM),
    ("rad/s^2", Quantity::AngularAcceleration, 1.0),
    ("deg/s^2", Quantity::AngularAcceleration, DEGREE),
    ("kg", Quantity::Mass, 1.0),
    ("g", Quantity::Mass, 1e-3),
    ("lb", Quantity::Mass, POUND),
    ("slug", Quantity::Mass, POUND_FORCE / FOOT),
    ("N", Quantity::Force, 1.0),
    ("kN", Quantity::Force, 1e3),
    ("lbf", Quantity::Force, POUND_FORCE),
    ("N m", Quantity::Torque, 1.0),
    ("kN m", Quantity::Torque, 1e3),
    ("ft lbf", Quantity::Torque, FOOT * POUND_FORCE),
    ("lbf ft", Quantity::Torque, FOOT * POUND_FORCE),
    ("Pa", Quantity::Pressure, 1.0),
    ("hPa", Quantity::Pressure, 1e2),
    ("kPa", Quantity::Pressure, 1e3),
    ("mbar", Quantity::Pressure, 1e2),
    ("inHg", Quantity::Pressure, 3_386.388_640_341),
    ("kg/m^3", Quantity::Density, 1.0),
    ("g/cm^3", Quantity::Density, 1e3),
    ("slug/ft^3", Quantity::Density, POUND_FORCE / (FOOT * FOOT * FOOT * FOOT)),
    ("1", Quantity::Ratio, 1.0),
    ("percent", Quantity::Ratio, 1e-2),
];

/// What a unit's text turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnitError {
    /// No such unit.
    Unknown,
    /// The unit is known and measures something else.
    Mismatch {
        /// What the channel measures.
        expected: Quantity,
        /// What the unit measures.
        found: Quantity,
    },
}

/// Factor to SI of the unit `text` for a value of that quantity: `si = factor * value`.
///
/// # Errors
/// [`UnitError`] where there is no such unit, or it measures something else.
pub fn factor_to_si(text: &str, quantity: Quantity) -> Result<f64, UnitError> {
    let mut other = None;
    for &(name, measures, factor) in UNITS {
        if name == text {
            if measures == quantity {
                return Ok(factor);
            }
            other = Some(measures);
        }
    }
    match other {
        Some(found) => Err(UnitError::Mismatch { expected: quantity, found }),
        None => Err(UnitError::Unknown),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_factor(text: &str, quantity: Quantity, expected: f64) {
        let found = factor_to_si(text, quantity).unwrap();
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{text}: {found} is not {expected}");
    }

    #[test]
    fn factors_are_the_published_ones() {
        // NIST SP 811, appendix B.8.
        assert_factor("kn", Quantity::Speed, 0.514_444_444_444_444_4);
        assert_factor("slug", Quantity::Mass, 14.593_902_937_206_364);
        assert_factor("lbf", Quantity::Force, 4.448_221_615_260_5);
        assert_factor("rpm", Quantity::AngularRate, 0.104_719_755_119_659_77);
        assert_factor("ft/min", Quantity::Speed, 0.005_08);
        assert_factor("g", Quantity::Acceleration, 9.806_65);
        assert_factor("g", Quantity::Mass, 1e-3);
        assert_factor("slug/ft^3", Quantity::Density, 515.378_818_393_196_4);
    }

    #[test]
    fn a_unit_of_another_quantity_is_told_from_an_unknown_one() {
        assert_eq!(factor_to_si("furlong", Quantity::Length), Err(UnitError::Unknown));
        let mismatch = UnitError::Mismatch { expected: Quantity::Speed, found: Quantity::AngularRate };
        assert_eq!(factor_to_si("deg/s", Quantity::Speed), Err(mismatch));
    }
}
