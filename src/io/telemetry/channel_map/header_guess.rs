//! What the header of another program's column probably means.
//!
//! Consumes the header's text; produces a guess: the time or a channel, the unit where the text states one, the sign. A guess is
//! shown to the user, in a message or a map to be checked, and never acted upon.

use super::unit_text::{name_and_unit, quantity_of, unit_of};
use crate::flight::unit::factor_to_si;

/// A guess.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeaderGuess {
    /// The channel's name, or `time`.
    pub name: &'static str,
    /// The unit that the header states, where it fits.
    pub unit: Option<&'static str>,
    /// Whether the usual sign of such a column is the other one.
    pub negative: bool,
    /// What to check, in words.
    pub doubt: Option<&'static str>,
}

impl HeaderGuess {
    /// The same with the sign of a load factor by what it mostly reads, in level flight one of the weight.
    pub fn with_sign_of(self, values: &[f64]) -> HeaderGuess {
        let negative = values.iter().filter(|value| **value < 0.0).count();
        let positive = values.iter().filter(|value| **value > 0.0).count();
        let down = 10 * negative >= 9 * values.len();
        let up = 10 * positive >= 9 * values.len();
        match self.doubt {
            Some(UPWARD) if values.is_empty() || down == up => self,
            Some(UPWARD) if down => HeaderGuess { negative: false, doubt: Some(READS_DOWN), ..self },
            Some(UPWARD) => HeaderGuess { negative: true, doubt: Some(READS_UP), ..self },
            _ => self,
        }
    }
}

/// Words that say nothing of the quantity.
const FILLERS: [&str; 27] = [
    "a",
    "ahrs",
    "adc",
    "angle",
    "body",
    "calibrated",
    "corrected",
    "data",
    "deflection",
    "fcc",
    "filtered",
    "imu",
    "ins",
    "measured",
    "meas",
    "of",
    "pos",
    "position",
    "raw",
    "sensor",
    "signal",
    "surface",
    "the",
    "value",
    "vane",
    "vehicle",
    "xyz",
];

const INDICATED: &str = "true airspeed is needed, not indicated or calibrated airspeed";
const UPWARD: &str = "load factor is usually positive upward, az is positive down";
const READS_UP: &str = "positive upward by what it reads, az is positive down";
const READS_DOWN: &str = "positive down by what it reads, as az is";
const ANGLE: &str = "controls are angles, positive as in the conventions";

type Rule = (&'static str, &'static [&'static str], Option<&'static str>);

/// A name, the words of a header that mean it (all of them), and what to check.
const RULES: &[Rule] = &[
    ("time", &["time"], None),
    ("time", &["timestamp"], None),
    ("time", &["time", "stamp"], None),
    ("time", &["t"], None),
    ("time", &["date", "time"], None),
    ("time", &["datetime"], None),
    ("time", &["utc"], None),
    ("time", &["utc", "time"], None),
    ("time", &["gps", "time"], None),
    ("time", &["elapsed", "time"], None),
    ("time", &["zeit"], None),
    ("p", &["p"], None),
    ("p", &["roll", "rate"], None),
    ("p", &["rollrate"], None),
    ("p", &["rollspeed"], None),
    ("p", &["gyro", "x"], None),
    ("p", &["gyr", "x"], None),
    ("p", &["omega", "x"], None),
    ("p", &["angular", "velocity", "x"], None),
    ("p", &["rollgeschwindigkeit"], None),
    ("q", &["q"], None),
    ("q", &["pitch", "rate"], None),
    ("q", &["pitchrate"], None),
    ("q", &["pitchspeed"], None),
    ("q", &["gyro", "y"], None),
    ("q", &["gyr", "y"], None),
    ("q", &["omega", "y"], None),
    ("q", &["angular", "velocity", "y"], None),
    ("q", &["nickrate"], None),
    ("q", &["nickgeschwindigkeit"], None),
    ("r", &["r"], None),
    ("r", &["yaw", "rate"], None),
    ("r", &["yawrate"], None),
    ("r", &["yawspeed"], None),
    ("r", &["gyro", "z"], None),
    ("r", &["gyr", "z"], None),
    ("r", &["omega", "z"], None),
    ("r", &["angular", "velocity", "z"], None),
    ("r", &["gierrate"], None),
    ("r", &["giergeschwindigkeit"], None),
    ("ax", &["ax"], None),
    ("ax", &["accel", "x"], None),
    ("ax", &["acc", "x"], None),
    ("ax", &["acceleration", "x"], None),
    ("ax", &["linear", "acceleration", "x"], None),
    ("ax", &["longitudinal", "acceleration"], None),
    ("ax", &["longitudinal", "accel"], None),
    ("ax", &["nx"], None),
    ("ax", &["accelerometer", "x"], None),
    ("ay", &["accelerometer", "y"], None),
    ("az", &["accelerometer", "z"], None),
    ("ay", &["ay"], None),
    ("ay", &["accel", "y"], None),
    ("ay", &["acc", "y"], None),
    ("ay", &["acceleration", "y"], None),
    ("ay", &["linear", "acceleration", "y"], None),
    ("ay", &["lateral", "acceleration"], None),
    ("ay", &["lateral", "accel"], None),
    ("ay", &["ny"], None),
    ("az", &["az"], None),
    ("az", &["accel", "z"], None),
    ("az", &["acc", "z"], None),
    ("az", &["acceleration", "z"], None),
    ("az", &["linear", "acceleration", "z"], None),
    ("az", &["normal", "acceleration"], Some(UPWARD)),
    ("az", &["normal", "accel"], Some(UPWARD)),
    ("az", &["vertical", "acceleration"], Some(UPWARD)),
    ("az", &["load", "factor"], Some(UPWARD)),
    ("az", &["nz"], Some(UPWARD)),
    ("phi", &["phi"], None),
    ("phi", &["roll"], None),
    ("phi", &["bank"], None),
    ("phi", &["roll", "attitude"], None),
    ("phi", &["rollwinkel"], None),
    ("phi", &["querneigung"], None),
    ("theta", &["theta"], None),
    ("theta", &["pitch"], None),
    ("theta", &["pitch", "attitude"], None),
    ("theta", &["nickwinkel"], None),
    ("theta", &["längsneigung"], None),
    ("psi", &["psi"], None),
    ("psi", &["yaw"], None),
    ("psi", &["heading"], None),
    ("psi", &["hdg"], None),
    ("psi", &["true", "heading"], None),
    ("psi", &["magnetic", "heading"], None),
    ("psi", &["gierwinkel"], None),
    ("psi", &["steuerkurs"], None),
    ("tas", &["tas"], None),
    ("tas", &["vtas"], None),
    ("tas", &["ktas"], None),
    ("tas", &["true", "airspeed"], None),
    ("tas", &["true", "air", "speed"], None),
    ("tas", &["airspeed"], Some(INDICATED)),
    ("tas", &["air", "speed"], Some(INDICATED)),
    ("tas", &["ias"], Some(INDICATED)),
    ("tas", &["kias"], Some(INDICATED)),
    ("tas", &["cas"], Some(INDICATED)),
    ("tas", &["kcas"], Some(INDICATED)),
    ("tas", &["eas"], Some(INDICATED)),
    ("tas", &["indicated", "airspeed"], Some(INDICATED)),
    ("tas", &["fluggeschwindigkeit"], Some(INDICATED)),
    ("alpha", &["alpha"], None),
    ("alpha", &["aoa"], None),
    ("alpha", &["attack"], None),
    ("alpha", &["incidence"], None),
    ("alpha", &["anstellwinkel"], None),
    ("beta", &["beta"], None),
    ("beta", &["aos"], None),
    ("beta", &["sideslip"], None),
    ("beta", &["side", "slip"], None),
    ("beta", &["schiebewinkel"], None),
    ("altitude", &["altitude"], None),
    ("altitude", &["alt"], None),
    ("altitude", &["pressure", "altitude"], None),
    ("altitude", &["pressure", "alt"], None),
    ("altitude", &["baro", "altitude"], None),
    ("altitude", &["baro", "alt"], None),
    ("altitude", &["hp"], None),
    ("altitude", &["h"], None),
    ("altitude", &["höhe"], None),
    ("altitude", &["druckhöhe"], None),
    ("lon_cyclic", &["lon", "cyclic"], Some(ANGLE)),
    ("lon_cyclic", &["longitudinal", "cyclic"], Some(ANGLE)),
    ("lat_cyclic", &["lat", "cyclic"], Some(ANGLE)),
    ("lat_cyclic", &["lateral", "cyclic"], Some(ANGLE)),
    ("collective", &["collective"], Some(ANGLE)),
    ("pedal", &["pedal"], Some(ANGLE)),
    ("pedal", &["pedals"], Some(ANGLE)),
    ("elevator", &["elevator"], Some(ANGLE)),
    ("elevator", &["elev"], Some(ANGLE)),
    ("elevator", &["de"], Some(ANGLE)),
    ("elevator", &["delta", "e"], Some(ANGLE)),
    ("elevator", &["höhenruder"], Some(ANGLE)),
    ("aileron", &["aileron"], Some(ANGLE)),
    ("aileron", &["ail"], Some(ANGLE)),
    ("aileron", &["da"], Some(ANGLE)),
    ("aileron", &["delta", "a"], Some(ANGLE)),
    ("aileron", &["querruder"], Some(ANGLE)),
    ("throttle", &["throttle"], Some(ANGLE)),
    ("rudder", &["rudder"], Some(ANGLE)),
    ("rudder", &["rud"], Some(ANGLE)),
    ("rudder", &["dr"], Some(ANGLE)),
    ("rudder", &["delta", "r"], Some(ANGLE)),
    ("rudder", &["seitenruder"], Some(ANGLE)),
    ("rotor_speed", &["nr"], None),
    ("rotor_speed", &["rotor", "speed"], None),
    ("rotor_speed", &["rotor", "rpm"], None),
    ("torque", &["torque"], None),
    ("torque", &["engine", "torque"], None),
    ("rho", &["rho"], None),
    ("rho", &["density"], None),
    ("rho", &["air", "density"], None),
];

/// The words of a name in lower case: parted at anything but letters and digits, and before a capital within.
fn words_of(name: &str, at_capitals: bool) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for letter in name.chars() {
        if letter.is_alphanumeric() {
            let begins = !before.is_alphanumeric() || (at_capitals && letter.is_uppercase() && before.is_lowercase());
            match words.last_mut() {
                Some(word) if !begins => word.extend(letter.to_lowercase()),
                _ => words.push(letter.to_lowercase().collect()),
            }
        }
        before = letter;
    }
    words
}

/// The rule with exactly these words, else with those that are no fillers.
fn rule_of(mut words: Vec<String>) -> Option<&'static Rule> {
    let of_exactly = |words: &[String]| {
        RULES.iter().find(|rule| rule.1.len() == words.len() && rule.1.iter().all(|word| words.iter().any(|own| own == word)))
    };
    of_exactly(&words).or_else(|| {
        words.retain(|word| !FILLERS.contains(&word.as_str()));
        of_exactly(&words)
    })
}

/// What the header means, where its words say it.
pub fn guess(header: &str) -> Option<HeaderGuess> {
    let (name, unit_text) = name_and_unit(header);
    let (name, _, doubt) = rule_of(words_of(name, true)).or_else(|| rule_of(words_of(name, false)))?;
    let quantity = quantity_of(name)?;
    let stated = unit_text.and_then(unit_of);
    let unit = stated.filter(|unit| factor_to_si(unit, quantity).is_ok());
    if stated.is_some() && unit.is_none() {
        return None;
    }
    Some(HeaderGuess { name, unit, negative: *doubt == Some(UPWARD), doubt: *doubt })
}

/// The same for an element of a vector, `gyro_rad[0]` or, of a file or topic called so, `xyz[0]`.
pub fn guess_in(context: &str, header: &str) -> Option<HeaderGuess> {
    let element = || {
        let (base, place) = header.trim().strip_suffix(']')?.rsplit_once('[')?;
        let axis = ["x", "y", "z"].get(place.parse::<usize>().ok()?)?;
        let (name, unit) = name_and_unit(base);
        let stem = context.split('.').next().unwrap_or_default().trim_end_matches(|letter: char| letter.is_ascii_digit());
        let named = rule_of(words_of(&format!("{name} {axis}"), false));
        let (name, _, doubt) = named.or_else(|| rule_of(words_of(&format!("{stem} {name} {axis}"), false)))?;
        let quantity = quantity_of(name)?;
        let unit = unit.and_then(unit_of).filter(|unit| factor_to_si(unit, quantity).is_ok());
        Some(HeaderGuess { name, unit, negative: false, doubt: *doubt })
    };
    guess(header).or_else(element)
}

/// The guess in words: `p in deg/s`, or `p (its unit is not stated)`.
pub fn in_words(guess: &HeaderGuess) -> String {
    let sign = if guess.negative { "-" } else { "" };
    match guess.unit {
        Some(unit) => format!("{sign}{} in {unit}", guess.name),
        None => format!("{sign}{} (its unit is not stated)", guess.name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_other_programs_are_guessed() {
        for (header, words) in [
            ("p (deg/s)", "p in deg/s"),
            ("Roll Rate [deg/s]", "p in deg/s"),
            ("roll_rate_dps", "p in deg/s"),
            ("RollRate", "p (its unit is not stated)"),
            ("IMU Gyro X (rad/s)", "p in rad/s"),
            ("Pitch Angle [deg]", "theta in deg"),
            ("Bank Angle (°)", "phi in deg"),
            ("Heading", "psi (its unit is not stated)"),
            ("KTAS", "tas (its unit is not stated)"),
            ("True Airspeed [kt]", "tas in kn"),
            ("Angle of Attack [deg]", "alpha in deg"),
            ("Side Slip Angle, deg", "beta in deg"),
            ("AoA [deg]", "alpha in deg"),
            ("nz [g]", "-az in g"),
            ("Pressure Altitude (feet)", "altitude in ft"),
            ("Elevator Position [deg]", "elevator in deg"),
            ("Nr [%]", "rotor_speed (its unit is not stated)"),
            ("Rotor RPM", "rotor_speed (its unit is not stated)"),
            ("Time (ms)", "time in ms"),
            ("TIMESTAMP", "time (its unit is not stated)"),
            ("DE [deg]", "elevator in deg"),
            ("delta_a", "aileron (its unit is not stated)"),
            ("KIAS", "tas (its unit is not stated)"),
            ("h [ft]", "altitude in ft"),
            ("Schiebewinkel [Grad]", "beta (its unit is not stated)"),
            ("H\u{f6}henruder [deg]", "elevator in deg"),
        ] {
            assert_eq!(guess(header).as_ref().map(in_words).as_deref(), Some(words), "{header}");
        }
        for header in ["oil", "gear", "egt[deg C]", "", "[]", "gps_altitude_error", "roll rate command"] {
            assert_eq!(guess(header), None, "{header}");
        }
    }
}
