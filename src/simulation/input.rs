//! Test inputs on the controls: steps, doublets, 3211s and any multistep, at the finite rate of a pilot's hand.
//!
//! Consumes `control:shape:amplitude:clock[:start]` (rad, s, s); produces the control's deviation over time. Shapes:
//! `step` moves to the amplitude and stays there (its clock may be left out: it has none); `doublet` is the multistep
//! `11`; a multistep is a pattern of digits, each the length of one pulse in clocks, pulses of alternating sign, the
//! first positive; `prbs3` to `prbs8` is the multistep of a pseudo-random binary sequence (`prbs`), 7 to 255 clocks long (the
//! first of them is the 3211).
//! After the last pulse the control is back at trim. The hand moves at no more than its rate, [`HAND_RATE`] by default,
//! starting at each switching time, so a pulse shorter than that takes does not reach its amplitude.

use crate::flight::channel::Channel;
use crate::flight::signal::piecewise_linear::History;
use crate::simulation::prbs;
use std::fmt;

/// How fast the hand moves a control, rad of blade pitch a second.
pub const HAND_RATE: f64 = 0.5;

/// What the pilot does with one control.
#[derive(Clone, Debug, PartialEq)]
pub struct InputSpec {
    /// One of the four controls, or [`Channel::RotorSpeed`] (its amplitude is in rad/s).
    pub channel: Channel,
    /// Lengths of the pulses in clocks; empty for a step.
    pub pattern: Vec<u32>,
    /// Deviation from trim of the first pulse.
    pub amplitude: f64,
    /// Length of one clock, s; zero for a step.
    pub clock_s: f64,
    /// When it starts, s; `None` leaves it to the lead.
    pub start_s: Option<f64>,
}

/// Which part of an input's text is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("input \"{text}\": {what}; written control:shape:amplitude:clock[:start], for example pedal:3211:0.02:0.7")]
pub struct InputError {
    /// The whole text.
    pub text: String,
    /// What was expected and what was found.
    pub what: String,
}

impl InputSpec {
    /// Reads `control:shape:amplitude:clock[:start]`.
    ///
    /// # Errors
    /// [`InputError`] with the part that is wrong.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let refuse = |what: String| InputError { text: text.to_owned(), what };
        let parts: Vec<&str> = text.split(':').collect();
        let (control, shape, amplitude, rest) = match parts.as_slice() {
            [control, shape, amplitude, rest @ ..] if rest.len() <= 2 => (*control, *shape, *amplitude, rest),
            _ => return Err(refuse(format!("expected 4 or 5 parts, found {}", parts.len()))),
        };
        let channel = match Channel::from_name(control) {
            Some((channel, _)) if Channel::CONTROLS.contains(&channel) || channel == Channel::RotorSpeed => channel,
            _ => return Err(refuse(format!("expected a control (lon_cyclic lat_cyclic collective pedal), found `{control}`"))),
        };
        let number = |name: &str, part: &str| match part.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(refuse(format!("expected a finite number as {name}, found `{part}`"))),
        };
        let amplitude = number("amplitude", amplitude)?;
        let pattern = pattern(shape)
            .ok_or_else(|| refuse(format!("expected step, doublet, digits 1 to 9 or prbs3 to prbs8, found `{shape}`")))?;
        let clock_s = match rest.first() {
            Some(part) => number("clock", part)?,
            None if pattern.is_empty() => 0.0,
            None => return Err(refuse(format!("expected a clock in seconds for {shape}, found none"))),
        };
        if clock_s < 0.0 || (clock_s == 0.0 && !pattern.is_empty()) {
            return Err(refuse(format!("expected a clock of more than zero seconds, found {clock_s}")));
        }
        let start_s = rest.get(1).map(|part| number("start", part)).transpose()?;
        if start_s.is_some_and(|start| start < 0.0) {
            return Err(refuse("expected a start of zero seconds or more".to_owned()));
        }
        Ok(InputSpec { channel, pattern, amplitude, clock_s, start_s })
    }

    /// When the last pulse ends, s, started at the given time unless it has its own.
    pub fn end_s(&self, lead_s: f64) -> f64 {
        self.start_s.unwrap_or(lead_s) + self.clock_s * f64::from(self.pattern.iter().sum::<u32>())
    }

    /// The deviation from trim over time, by a hand of the usual rate.
    pub fn deviation(&self, lead_s: f64) -> History {
        self.deviation_by_hand(lead_s, HAND_RATE)
    }

    /// The deviation from trim over time, by a hand that moves a control at no more than that rate, rad/s; a rotor speed is
    /// moved by no hand.
    pub fn deviation_by_hand(&self, lead_s: f64, hand_rate: f64) -> History {
        let start_s = self.start_s.unwrap_or(lead_s);
        let mut targets = Vec::new();
        let (mut time_s, mut sign) = (start_s, 1.0);
        for &length in &self.pattern {
            targets.push((time_s, sign * self.amplitude));
            time_s += f64::from(length) * self.clock_s;
            sign = -sign;
        }
        targets.push((time_s, if self.pattern.is_empty() { self.amplitude } else { 0.0 }));
        by_hand(start_s, &targets, if self.channel == Channel::RotorSpeed { f64::MAX } else { hand_rate })
    }
}

impl fmt::Display for InputSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.channel.name(crate::flight::channel::ControlNames::Rotorcraft))?;
        match self.pattern.as_slice() {
            [] => f.write_str("step")?,
            [1, 1] => f.write_str("doublet")?,
            pattern => match prbs::order_of(pattern) {
                Some(order) if order > 3 => write!(f, "prbs{order}")?,
                _ => pattern.iter().try_for_each(|digit| write!(f, "{digit}"))?,
            },
        }
        write!(f, ":{}:{}", self.amplitude, self.clock_s)?;
        self.start_s.map_or(Ok(()), |start| write!(f, ":{start}"))
    }
}

fn pattern(shape: &str) -> Option<Vec<u32>> {
    match shape {
        "step" => Some(Vec::new()),
        "doublet" => Some(vec![1, 1]),
        "" => None,
        sequence if sequence.starts_with("prbs") => prbs::pattern(sequence.get(4..)?.parse().ok()?),
        digits => digits.chars().map(|digit| digit.to_digit(10).filter(|&length| length > 0)).collect(),
    }
}

/// Shortest time in which even an unlimited hand moves, s: a jump would be no function of time.
const SHORTEST_MOVE_S: f64 = 1e-3;

/// The way of a hand that from each switching time on moves to the target of that time.
fn by_hand(start_s: f64, targets: &[(f64, f64)], rate: f64) -> History {
    let mut points = vec![(start_s, 0.0)];
    let mut value = 0.0;
    for (place, &(from_s, target)) in targets.iter().enumerate() {
        let until_s = targets.get(place + 1).map_or(f64::INFINITY, |&(time_s, _)| time_s);
        let way: f64 = target - value;
        if way == 0.0 {
            continue;
        }
        let takes_s = (way.abs() / rate).max(SHORTEST_MOVE_S);
        let moves_s = takes_s.min(until_s - from_s);
        if points.last().is_some_and(|&(last, _)| last < from_s) {
            points.push((from_s, value));
        }
        value = if moves_s < takes_s { value + way * (moves_s / takes_s) } else { target };
        points.push((from_s + moves_s, value));
    }
    History::through(points).unwrap_or_else(|_| History::constant(0.0))
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are carried, or exact in binary")]
mod tests {
    use super::*;

    #[test]
    fn a_3211_goes_up_down_up_down_and_back() {
        let spec = InputSpec::parse("pedal:3211:0.02:0.5:1").unwrap();
        assert_eq!(spec.end_s(9.0), 4.5);
        let x = spec.deviation(9.0);
        for (time, wanted) in
            [(0.5, 0.0), (1.02, 0.01), (1.5, 0.02), (2.54, 0.0), (3.0, -0.02), (3.75, 0.02), (4.25, -0.02), (5.0, 0.0)]
        {
            assert!((x.at(time) - wanted).abs() < 1e-12, "{time}: {}", x.at(time));
        }
        let steepest = x.points().windows(2).map(|p| ((p[1].1 - p[0].1) / (p[1].0 - p[0].0)).abs()).fold(0.0, f64::max);
        assert!((steepest - HAND_RATE).abs() < 1e-9, "{steepest}");
    }

    #[test]
    fn a_step_stays_and_starts_with_the_lead() {
        let x = InputSpec::parse("rudder:step:-0.1").unwrap().deviation(2.0);
        assert_eq!([x.at(2.0), x.at(2.2), x.at(60.0)], [0.0, -0.1, -0.1]);
        assert!((x.at(2.1) + 0.05).abs() < 1e-12);
    }

    #[test]
    fn a_pulse_too_short_for_the_hand_does_not_reach_its_amplitude() {
        let x = InputSpec::parse("pedal:doublet:1.0:0.5:0").unwrap().deviation(0.0);
        assert_eq!([x.at(0.5), x.at(1.0), x.at(2.0)], [0.25, 0.0, 0.0]);
    }

    #[test]
    fn the_rate_is_the_hand_s() {
        let spec = InputSpec::parse("pedal:prbs3:0.02:0.5:0").unwrap();
        let x = spec.deviation_by_hand(0.0, 0.1);
        let steepest = x.points().windows(2).map(|p| ((p[1].1 - p[0].1) / (p[1].0 - p[0].0)).abs()).fold(0.0, f64::max);
        assert!((steepest - 0.1).abs() < 1e-12, "{steepest}");
        // 1 1 1 -1 -1 1 -1: up for 1.5 s, down for 1 s, up and down for half a second each.
        for (time, wanted) in [(0.1, 0.01), (1.4, 0.02), (2.4, -0.02), (2.9, 0.02), (3.4, -0.02), (4.0, 0.0)] {
            assert!((x.at(time) - wanted).abs() < 1e-12, "{time}: {}", x.at(time));
        }
    }

    #[test]
    fn specs_come_back_and_wrong_ones_say_why() {
        for text in ["pedal:3211:0.02:0.7", "lat_cyclic:doublet:-0.01:1:3.5", "collective:2112:0.1:2", "pedal:prbs5:0.02:0.4"] {
            assert_eq!(InputSpec::parse(text).unwrap().to_string(), text);
        }
        for (text, part) in [
            ("pedal", "parts"),
            ("pdal:3211:0.02:0.7", "`pdal`"),
            ("beta:3211:0.02:0.7", "`beta`"),
            ("pedal:wave:0.02:0.7", "`wave`"),
            ("pedal:prbs2:0.02:0.7", "`prbs2`"),
            ("pedal:prbs9:0.02:0.7", "`prbs9`"),
            ("pedal:prbs:0.02:0.7", "prbs3 to prbs8"),
            ("pedal:3011:0.02:0.7", "`3011`"),
            ("pedal::0.02:0.7", "digits"),
            ("pedal:3211:nan:0.7", "amplitude"),
            ("pedal:3211:0.02:0", "clock"),
            ("pedal:3211:0.02", "clock"),
            ("pedal:3211:0.02:0.7:-1", "start"),
            ("pedal:3211:0.02:0.7:1:1", "parts"),
        ] {
            let error = InputSpec::parse(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
