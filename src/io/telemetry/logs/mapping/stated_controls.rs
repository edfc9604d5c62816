//! Controls in radians where the log itself states their scale, by parameters.
//!
//! Consumes parameters of the log, and the outputs of its servos; produces the angle of each control whose scale is stated:
//!     angle = (output - MID) DEG                                                                      (1)
//! | SIDESLIP_xxx_OUT | number of the output, from 1 |
//! | SIDESLIP_xxx_MID | the output at zero, in its own unit |
//! | SIDESLIP_xxx_DEG | degrees for one of that unit, negative where more of it means less |
//! with xxx one of LON, LAT, COL, PED or ELE, AIL, THR, RUD. A script on board can define such parameters; simulated flights have
//! them. Without all three of a control nothing is said of its angle: counts and pulse widths are no radians.
//! Refused: output numbers beyond 16, scales that are zero or no numbers.

use super::{LogChannel, channel};
use crate::flight::channel::{Channel, ControlNames};

/// What the name of every such parameter begins with.
const PREFIX: &str = "SIDESLIP_";
/// Outputs that can be named.
const OUTPUTS: f64 = 16.0;

/// Every control under both of its names.
const CONTROLS: [(&str, LogChannel); 8] = [
    ("LON", channel("lon_cyclic", "rad")),
    ("LAT", channel("lat_cyclic", "rad")),
    ("COL", channel("collective", "rad")),
    ("PED", channel("pedal", "rad")),
    ("ELE", channel("elevator", "rad")),
    ("AIL", channel("aileron", "rad")),
    ("THR", channel("throttle", "rad")),
    ("RUD", channel("rudder", "rad")),
];

/// The scale of a control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedScale {
    /// Which output, from 1.
    pub output: usize,
    /// The output at zero.
    pub zero: f64,
    /// Degrees for one of the output's unit.
    pub degrees: f64,
}

impl StatedScale {
    /// rad, by (1).
    pub fn angle(&self, output: f64) -> f64 {
        ((output - self.zero) * self.degrees).to_radians()
    }

    /// The output that stands for an angle, rad.
    pub fn output_at(&self, angle: f64) -> f64 {
        self.zero + angle.to_degrees() / self.degrees
    }

    /// The parameters that state it; `None` of a channel that is no control.
    pub fn parameters(&self, channel: Channel, controls: ControlNames) -> Option<[(String, f64); 3]> {
        let name = channel.name(controls);
        let (short, _) = CONTROLS.iter().find(|(_, control)| control.name == name)?;
        let parameter = |what: &str| format!("{PREFIX}{short}_{what}");
        Some([(parameter("OUT"), self.output as f64), (parameter("MID"), self.zero), (parameter("DEG"), self.degrees)])
    }
}

/// What was stated of a control so far.
#[derive(Clone, Copy, Debug, Default)]
struct Stated {
    output: Option<usize>,
    zero: Option<f64>,
    degrees: Option<f64>,
}

/// The scales that a log states.
#[derive(Clone, Copy, Debug, Default)]
pub struct StatedControls {
    stated: [Stated; CONTROLS.len()],
}

impl StatedControls {
    /// Takes in a parameter; one of another name says nothing here.
    pub fn parameter(&mut self, name: &str, value: f64) {
        let Some((short, what)) = name.strip_prefix(PREFIX).and_then(|rest| rest.split_once('_')) else { return };
        let Some(place) = CONTROLS.iter().position(|(known, _)| *known == short) else { return };
        let Some(stated) = self.stated.get_mut(place) else { return };
        match what {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 16")]
            "OUT" => stated.output = (1.0..=OUTPUTS).contains(&value).then_some(value as usize),
            "MID" => stated.zero = Some(value).filter(|zero| zero.is_finite()),
            "DEG" => stated.degrees = Some(value).filter(|degrees| degrees.is_finite() && *degrees != 0.0),
            _ => {}
        }
    }

    /// The angles that are known of outputs, which are numbered from 1.
    pub(super) fn angles(&self, output: impl Fn(usize) -> Option<f64>) -> ([(LogChannel, f64); CONTROLS.len()], usize) {
        let mut angles = [(CONTROLS[0].1, 0.0); CONTROLS.len()];
        let mut count = 0;
        for ((_, control), stated) in CONTROLS.iter().zip(&self.stated) {
            let Stated { output: Some(number), zero: Some(zero), degrees: Some(degrees) } = *stated else { continue };
            if let (Some(found), Some(place)) = (output(number), angles.get_mut(count)) {
                *place = (*control, StatedScale { output: number, zero, degrees }.angle(found));
                count += 1;
            }
        }
        (angles, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles(stated: &StatedControls, outputs: &[f64]) -> Vec<(&'static str, f64)> {
        let (all, count) = stated.angles(|number| outputs.get(number - 1).copied());
        all[..count].iter().map(|(channel, angle)| (channel.name, *angle)).collect()
    }

    #[test]
    fn what_is_stated_comes_back_and_half_a_statement_is_none() {
        let scale = StatedScale { output: 2, zero: 1500.0, degrees: -0.02 };
        let mut stated = StatedControls::default();
        let [first, second, third] = scale.parameters(Channel::Pedal, ControlNames::FixedWing).unwrap();
        assert_eq!([first.0.as_str(), &second.0, &third.0], ["SIDESLIP_RUD_OUT", "SIDESLIP_RUD_MID", "SIDESLIP_RUD_DEG"]);
        stated.parameter(&first.0, first.1);
        stated.parameter(&second.0, second.1);
        assert_eq!(angles(&stated, &[1.0, 1600.0]), []);
        stated.parameter(&third.0, third.1);
        let found = angles(&stated, &[1.0, 1600.0]);
        assert!(found[0].0 == "rudder" && (found[0].1.to_degrees() + 2.0).abs() < 1e-12, "{found:?}");
        assert_eq!(angles(&stated, &[1.0]), []);
        assert!((scale.output_at(scale.angle(1433.0)) - 1433.0).abs() < 1e-9);
        for (name, value) in [("SIDESLIP_RUD_OUT", 17.0), ("SIDESLIP_RUD_DEG", 0.0), ("SIDESLIP_RUD_MID", f64::NAN)] {
            let mut spoilt = stated;
            spoilt.parameter(name, value);
            assert_eq!(angles(&spoilt, &[1.0, 1600.0]), [], "{name}");
        }
        stated.parameter("SERVO1_TRIM", 1400.0);
        stated.parameter("SIDESLIP_XYZ_OUT", 1.0);
        assert_eq!(angles(&stated, &[1.0, 1600.0]), found);
        assert_eq!(scale.parameters(Channel::Ax, ControlNames::Rotorcraft), None);
    }
}
