//! Units as people write them: `°/s`, `dps`, `deg/sec`, `kts`, `m/s²`, `Roll Rate [deg/s]`, `roll_rate_dps`.
//!
//! Consumes a text; produces the unit as [`crate::flight::unit`] has it. A unit is never concluded from anything but its text.

use crate::flight::channel::Channel;
use crate::flight::unit::{Quantity, factor_to_si};

/// Every quantity that a channel or the time has.
const QUANTITIES: [Quantity; 9] = [
    Quantity::Time,
    Quantity::Length,
    Quantity::Speed,
    Quantity::Acceleration,
    Quantity::Angle,
    Quantity::AngularRate,
    Quantity::Torque,
    Quantity::Density,
    Quantity::Pressure,
];

/// Other writings, in lower case and without spaces, and the unit that each means.
const OTHER_WRITINGS: &[(&str, &str)] = &[
    ("sec", "s"),
    ("secs", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("msec", "ms"),
    ("millis", "ms"),
    ("millisecond", "ms"),
    ("milliseconds", "ms"),
    ("usec", "us"),
    ("micros", "us"),
    ("microsecond", "us"),
    ("microseconds", "us"),
    ("days", "day"),
    ("nsec", "ns"),
    ("nanos", "ns"),
    ("nanosecond", "ns"),
    ("nanoseconds", "ns"),
    ("meter", "m"),
    ("meters", "m"),
    ("metre", "m"),
    ("metres", "m"),
    ("feet", "ft"),
    ("foot", "ft"),
    ("mps", "m/s"),
    ("m/sec", "m/s"),
    ("ms-1", "m/s"),
    ("ms^-1", "m/s"),
    ("kt", "kn"),
    ("kts", "kn"),
    ("knot", "kn"),
    ("knots", "kn"),
    ("ktas", "kn"),
    ("kmh", "km/h"),
    ("kph", "km/h"),
    ("kmph", "km/h"),
    ("fps", "ft/s"),
    ("ft/sec", "ft/s"),
    ("fpm", "ft/min"),
    ("m/s2", "m/s^2"),
    ("m/s/s", "m/s^2"),
    ("m/sec2", "m/s^2"),
    ("m/sec^2", "m/s^2"),
    ("mps2", "m/s^2"),
    ("ms-2", "m/s^2"),
    ("ms^-2", "m/s^2"),
    ("ft/s2", "ft/s^2"),
    ("ft/s/s", "ft/s^2"),
    ("ft/sec^2", "ft/s^2"),
    ("g's", "g"),
    ("gs", "g"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("dps", "deg/s"),
    ("deg/sec", "deg/s"),
    ("degree/s", "deg/s"),
    ("degrees/s", "deg/s"),
    ("degs-1", "deg/s"),
    ("degs^-1", "deg/s"),
    ("rad/sec", "rad/s"),
    ("rads/s", "rad/s"),
    ("radian/s", "rad/s"),
    ("radians/s", "rad/s"),
    ("rads-1", "rad/s"),
    ("rads^-1", "rad/s"),
    ("rev/min", "rpm"),
    ("1/min", "rpm"),
    ("nm", "N m"),
    ("n*m", "N m"),
    ("n-m", "N m"),
    ("knm", "kN m"),
    ("ftlb", "ft lbf"),
    ("ft-lb", "ft lbf"),
    ("ft-lbf", "ft lbf"),
    ("lb-ft", "lbf ft"),
    ("lbft", "lbf ft"),
    ("kg/m3", "kg/m^3"),
    ("slug/ft3", "slug/ft^3"),
    ("slugs/ft3", "slug/ft^3"),
    ("slugs/ft^3", "slug/ft^3"),
    ("hpa", "hPa"),
    ("mb", "mbar"),
    ("inhg", "inHg"),
    ("\"hg", "inHg"),
];

/// Ends of names that state a unit, longest first where one ends with another.
const SUFFIXES: &[(&str, &str)] = &[
    ("_deg_per_sec", "deg/s"),
    ("_rad_per_sec", "rad/s"),
    ("_deg_per_s", "deg/s"),
    ("_rad_per_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_degs", "deg/s"),
    ("_dps", "deg/s"),
    ("_rad_s", "rad/s"),
    ("_rads", "rad/s"),
    ("_m_s2", "m/s^2"),
    ("_m_s_2", "m/s^2"),
    ("_mps2", "m/s^2"),
    ("_ft_s2", "ft/s^2"),
    ("_mps", "m/s"),
    ("_m_s", "m/s"),
    ("_ft_s", "ft/s"),
    ("_fps", "ft/s"),
    ("_fpm", "ft/min"),
    ("_kmh", "km/h"),
    ("_kn", "kn"),
    ("_kt", "kn"),
    ("_kts", "kn"),
    ("_knots", "kn"),
    ("_deg", "deg"),
    ("_degrees", "deg"),
    ("_rad", "rad"),
    ("_radians", "rad"),
    ("_rpm", "rpm"),
    ("_feet", "ft"),
    ("_ft", "ft"),
    ("_meter", "m"),
    ("_meters", "m"),
    ("_m", "m"),
    ("_g", "g"),
    ("_nm", "N m"),
    ("_kgm3", "kg/m^3"),
    ("_msec", "ms"),
    ("_ms", "ms"),
    ("_usec", "us"),
    ("_us", "us"),
    ("_ns", "ns"),
    ("_sec", "s"),
    ("_s", "s"),
];

/// The unit that the text means, of the units of channels and of time; `None` where it is none of them.
pub fn unit_of(text: &str) -> Option<&'static str> {
    let plain = text.trim().replace('°', "deg").replace('²', "^2").replace('³', "^3").replace("**", "^").replace(['µ', 'μ'], "u");
    if let Some((_, unit)) = every_unit().find(|(_, unit)| *unit == plain) {
        return Some(unit);
    }
    let lower: String = plain.to_lowercase().chars().filter(|letter| !letter.is_whitespace()).collect();
    let other = OTHER_WRITINGS.iter().find(|(writing, _)| *writing == lower).map(|(_, unit)| *unit);
    let same = || every_unit().find(|(_, unit)| unit.to_lowercase().replace(' ', "") == lower).map(|(_, unit)| unit);
    other.or_else(same)
}

/// Units by what they measure.
fn every_unit() -> impl Iterator<Item = (Quantity, &'static str)> {
    let writings = OTHER_WRITINGS.iter().chain(SUFFIXES).map(|(_, unit)| *unit);
    let units = writings.chain(["s", "m", "km", "cm", "rad", "mrad", "mrad/s", "deg/s^2", "Pa", "kPa", "ft", "km/h", "h", "min"]);
    units.flat_map(|unit| {
        QUANTITIES.into_iter().filter(move |quantity| factor_to_si(unit, *quantity).is_ok()).map(move |quantity| (quantity, unit))
    })
}

/// Units that a channel may have, for messages: SI first.
pub fn units_of(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Time => "s, ms, us, ns",
        Quantity::Length => "m, ft",
        Quantity::Speed => "m/s, kn, km/h, ft/s",
        Quantity::Acceleration => "m/s^2, g, ft/s^2",
        Quantity::Angle => "rad, deg",
        Quantity::AngularRate => "rad/s, deg/s, rpm",
        Quantity::Torque => "N m, kN m, ft lbf",
        Quantity::Density => "kg/m^3, slug/ft^3",
        other => other.si_unit(),
    }
}

/// What a channel of that name, or the time, measures.
pub fn quantity_of(name: &str) -> Option<Quantity> {
    if name == "time" { Some(Quantity::Time) } else { Channel::from_name(name).map(|(channel, _)| channel.quantity()) }
}

/// The header's text in two: the name, and the unit where brackets, parentheses, a comma or the end of the name state one.
pub fn name_and_unit(header: &str) -> (&str, Option<&str>) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, rest)) = header.rsplit_once(open)
            && let Some(unit) = rest.strip_suffix(close)
            && !name.trim().is_empty()
            && (open == '[' || unit_of(unit).is_some())
            && !unit.trim().chars().all(|letter| letter.is_ascii_digit())
        {
            return (name.trim(), Some(unit.trim()));
        }
    }
    if let Some((name, unit)) = header.rsplit_once(',')
        && unit_of(unit).is_some()
    {
        return (name.trim(), Some(unit.trim()));
    }
    // The place in a vector stands behind the unit.
    let whole = header;
    let is_place = |place: &str| !place.is_empty() && place.bytes().all(|digit| digit.is_ascii_digit());
    let vector = header.strip_suffix(']').and_then(|vector| vector.rsplit_once('[')).filter(|(_, place)| is_place(place));
    let header = vector.map_or(header, |(vector, _)| vector);
    let lower = header.to_ascii_lowercase();
    let end = SUFFIXES.iter().find(|(suffix, _)| lower.len() > suffix.len() && lower.ends_with(suffix));
    match end.and_then(|(suffix, unit)| Some((header.get(..header.len() - suffix.len())?, *unit))) {
        Some((name, unit)) => (name, Some(unit)),
        None => (whole, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_understood_as_people_write_them() {
        for (text, unit) in [
            ("°/s", "deg/s"),
            ("dps", "deg/s"),
            ("Deg/Sec", "deg/s"),
            ("rad/s", "rad/s"),
            ("KTS", "kn"),
            ("knots", "kn"),
            ("Feet", "ft"),
            ("m/s²", "m/s^2"),
            ("m / s2", "m/s^2"),
            ("G", "g"),
            ("µs", "us"),
            ("msec", "ms"),
            ("RPM", "rpm"),
            ("Nm", "N m"),
            ("inHg", "inHg"),
            ("hPa", "hPa"),
        ] {
            assert_eq!(unit_of(text), Some(unit), "{text}");
        }
        for text in ["", "V", "counts", "furlong", "deg C"] {
            assert_eq!(unit_of(text), None, "{text}");
        }
    }

    #[test]
    fn every_unit_that_a_text_can_mean_has_a_factor() {
        for (text, unit) in OTHER_WRITINGS.iter().chain(SUFFIXES) {
            assert!(QUANTITIES.iter().any(|quantity| factor_to_si(unit, *quantity).is_ok()), "{text} means {unit}");
        }
    }

    #[test]
    fn a_header_states_its_unit_in_brackets_behind_a_comma_or_at_its_end() {
        for (header, parts) in [
            ("Roll Rate [deg/s]", ("Roll Rate", Some("deg/s"))),
            ("p (deg/s)", ("p", Some("deg/s"))),
            ("roll_rate_dps", ("roll_rate", Some("deg/s"))),
            ("Roll Rate, °/s", ("Roll Rate", Some("°/s"))),
            ("accelerometer_m_s2[0]", ("accelerometer", Some("m/s^2"))),
            ("xyz[0]", ("xyz[0]", None)),
            ("Alpha (vane)", ("Alpha (vane)", None)),
            ("egt[deg C]", ("egt", Some("deg C"))),
            ("indicated_airspeed_m_s", ("indicated_airspeed", Some("m/s"))),
            ("time_ms", ("time", Some("ms"))),
            ("p", ("p", None)),
        ] {
            assert_eq!(name_and_unit(header), parts, "{header}");
        }
    }
}
