//! Units of what an identified model has: its variables and its derivatives.

use sideslip::flight::channel::Channel;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::io::outputs::words::status_text::derivative_unit;
use sideslip::postflight::identification::model_variables::ModelVariables;

/// The SI unit of a state, an input or an output; `None` of a column that is no channel.
pub(super) fn variable_unit(name: &str) -> Option<&'static str> {
    match name {
        "u" | "v" | "w" => Some("m/s"),
        _ => Channel::from_name(name).map(|(channel, _)| channel.si_unit()),
    }
}

/// The unit of a derivative of that model; the equation of a flow angle is over airspeed, rad/s.
pub(super) fn unit_of_derivative(choice: &ModelVariables, axis: char, variable: &str) -> String {
    let over_airspeed = choice.states.iter().any(|state| matches!((state.as_str(), axis), ("beta", 'Y') | ("alpha", 'Z')));
    let by = variable_unit(variable);
    if over_airspeed {
        return match by {
            Some("m/s") => "rad/m".to_owned(),
            Some("rad/s") => "1".to_owned(),
            Some("rad") => "1/s".to_owned(),
            other => quotient("rad/s", other, variable),
        };
    }
    let Some(axis) = Axis::from_name(axis.encode_utf8(&mut [0; 4])) else { return String::new() };
    let like = match by {
        Some("m/s") => Some(Variable::V),
        Some("rad/s") => Some(Variable::R),
        Some("rad") => Some(Variable::Pedal),
        _ => None,
    };
    match like {
        Some(like) => derivative_unit(axis, Some(like)).to_owned(),
        None => quotient(derivative_unit(axis, None), by, variable),
    }
}

/// The unit of the constant in a state's equation.
pub(super) fn unit_of_equation(state: &str) -> &'static str {
    match state {
        "u" | "v" | "w" => "m/s^2",
        "p" | "q" | "r" => "rad/s^2",
        _ => "rad/s",
    }
}

fn quotient(row: &str, by: Option<&str>, variable: &str) -> String {
    format!("{row} per {}", by.unwrap_or(variable))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_the_equations() {
        let choice = |states: &[&str]| ModelVariables {
            states: states.iter().map(|&name| name.to_owned()).collect(),
            inputs: Vec::new(),
            outputs: Vec::new(),
        };
        let velocity = choice(&["v", "p", "phi", "r"]);
        let angle = choice(&["beta", "p", "phi", "r"]);
        for (model, axis, variable, unit) in [
            (&velocity, 'Y', "v", "1/s"),
            (&velocity, 'N', "v", "rad/(m s)"),
            (&velocity, 'Y', "rudder", "m/(s^2 rad)"),
            (&angle, 'Y', "beta", "1/s"),
            (&angle, 'Y', "p", "1"),
            (&angle, 'Y', "v", "rad/m"),
            (&angle, 'N', "beta", "1/s^2"),
            (&angle, 'N', "torque", "rad/s^2 per N m"),
            (&angle, 'N', "thrust", "rad/s^2 per thrust"),
        ] {
            assert_eq!(unit_of_derivative(model, axis, variable), unit, "{axis}_{variable}");
        }
    }
}
