//! The table for a person: derivatives with their standard errors, modes, warnings; plain text, 100 columns at most.
//!
//! Colour (bold headings, yellow and red warnings) only where asked for; [`Style::of_stream`] asks for it on a terminal
//! unless `NO_COLOR` is set to anything.

use super::event_ring::FoldedEvent;
use super::text::{Digits, EventText, Severity, StatusText, TermName, derivative_unit, event_severity};
use crate::flight::channel::ControlNames;
use crate::modes::record::{ModesRecord, Oscillation, RealRoot};
use crate::regression::record::{DerivativesRecord, EquationRecord};
use std::f64::consts::{LN_2, TAU};
use std::fmt::{self, Write};
use std::io::IsTerminal;

/// The widest line, columns.
pub const WIDTH: usize = 100;

/// Whether text is coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Style {
    /// Text alone.
    #[default]
    Plain,
    /// With ANSI colours.
    Colour,
}

impl Style {
    /// Colour where the stream is a terminal and `NO_COLOR` is not set (or empty).
    pub fn of_stream(stream: &impl IsTerminal) -> Self {
        let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        if stream.is_terminal() && !refused { Style::Colour } else { Style::Plain }
    }

    fn paint(self, code: &'static str, text: impl fmt::Display) -> String {
        match self {
            Style::Plain => text.to_string(),
            Style::Colour => format!("\x1b[{code}m{text}\x1b[0m"),
        }
    }
}

/// What stands in the table.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    /// The run's name.
    pub run: &'a str,
    /// How its controls are called.
    pub controls: ControlNames,
    /// Its last derivatives.
    pub derivatives: Option<&'a DerivativesRecord>,
    /// Its last modes.
    pub modes: Option<&'a ModesRecord>,
    /// What was noticed, repeats folded.
    pub events: &'a [FoldedEvent],
    /// Whether it is coloured.
    pub style: Style,
}

impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(derivatives) = self.derivatives {
            let excited = if derivatives.excited { ", being excited" } else { "" };
            let title = format!("{}: derivatives at {:.2} s{excited} (SI, radians)", self.run, derivatives.time_s);
            for line in wrapped(&title, WIDTH) {
                writeln!(f, "{}", self.style.paint("1", line))?;
            }
            for equation in &derivatives.equations {
                self.equation(f, equation)?;
            }
        }
        if let Some(modes) = self.modes {
            self.modes(f, modes)?;
        }
        self.events(f)
    }
}

impl Table<'_> {
    fn equation(&self, f: &mut fmt::Formatter<'_>, equation: &EquationRecord) -> fmt::Result {
        let status = StatusText { status: equation.status, controls: self.controls };
        let heading = format!("{}  {status}", equation.axis.name());
        for (place, line) in wrapped(&heading, WIDTH - 3).into_iter().enumerate() {
            let margin = if place == 0 { "" } else { "   " };
            writeln!(f, "{margin}{}", self.style.paint("1", line))?;
        }
        if equation.terms.is_empty() {
            return Ok(());
        }
        let unit = if equation.axis.is_force() { "m/s^2" } else { "rad/s^2" };
        writeln!(
            f,
            "   R2 {:.3}, F total {}, {:.0} samples, residual {} {unit}, condition index {}",
            equation.r_squared,
            Digits(equation.f_total, 3),
            equation.samples,
            Digits(equation.residual_std, 3),
            Digits(equation.condition_index, 3)
        )?;
        writeln!(f, "   {:<16} {:>12} {:>12}  {:<12} {:>12}  entered", "term", "value", "std error", "unit", "partial F")?;
        for term in &equation.terms {
            let name = TermName { axis: equation.axis, variable: term.variable, controls: self.controls };
            let entered = match (term.variable, term.primary) {
                (None, _) => "bias".to_owned(),
                (_, true) => "primary".to_owned(),
                (_, false) => format!("step {}", term.step),
            };
            writeln!(
                f,
                "   {:<16} {:>12} {:>12}  {:<12} {:>12}  {entered}",
                name.to_string(),
                Digits(term.value, 4).to_string(),
                Digits(term.std, 2).to_string(),
                derivative_unit(equation.axis, term.variable),
                Digits(term.partial_f(), 3).to_string()
            )?;
        }
        Ok(())
    }

    fn modes(&self, f: &mut fmt::Formatter<'_>, modes: &ModesRecord) -> fmt::Result {
        let status = StatusText { status: modes.status, controls: self.controls };
        let title = format!("{}: lateral modes at {:.2} s: {status}", self.run, modes.time_s);
        for line in wrapped(&title, WIDTH) {
            writeln!(f, "{}", self.style.paint("1", line))?;
        }
        if let Some(pair) = &modes.dutch_roll {
            oscillation(f, "Dutch roll", pair)?;
        }
        if let Some(pair) = &modes.lateral_phugoid {
            oscillation(f, "lateral phugoid", pair)?;
        }
        if let Some(root) = &modes.roll {
            real_root(f, "roll", root)?;
        }
        if let Some(root) = &modes.spiral {
            real_root(f, "spiral", root)?;
        }
        Ok(())
    }

    fn events(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for event in self.events {
            let severity = event_severity(&event.kind);
            let code = match severity {
                Severity::Info => continue,
                Severity::Warning => "33",
                Severity::DataLost => "31",
            };
            let mut sentence = format!("{}: {}", severity.name(), EventText { kind: &event.kind, controls: self.controls });
            if event.count > 1 {
                write!(sentence, " ({} times, {:.2} to {:.2} s)", event.count, event.first_s, event.last_s)?;
            } else {
                write!(sentence, " (at {:.2} s)", event.last_s)?;
            }
            for (place, line) in wrapped(&sentence, WIDTH - 3).into_iter().enumerate() {
                let margin = if place == 0 { "" } else { "   " };
                writeln!(f, "{margin}{}", self.style.paint(code, line))?;
            }
        }
        Ok(())
    }
}

fn oscillation(f: &mut fmt::Formatter<'_>, name: &str, pair: &Oscillation) -> fmt::Result {
    writeln!(
        f,
        "   {name:<16} omega {} +- {} rad/s, zeta {} +- {}\n   {:<16} period {} s, {}",
        Digits(pair.omega, 4),
        Digits(pair.std_omega, 2),
        Digits(pair.zeta, 3),
        Digits(pair.std_zeta, 2),
        "",
        Digits(TAU / pair.imag, 3),
        half_or_double(pair.real)
    )
}

fn real_root(f: &mut fmt::Formatter<'_>, name: &str, root: &RealRoot) -> fmt::Result {
    writeln!(f, "   {name:<16} root {} +- {} 1/s, {}", Digits(root.value, 4), Digits(root.std, 2), half_or_double(root.value))
}

/// Time to half or to double the amplitude, ln 2 over the size of the real part.
fn half_or_double(real: f64) -> String {
    if real < 0.0 {
        format!("time to half {} s", Digits(-LN_2 / real, 3))
    } else if real > 0.0 {
        format!("time to double {} s", Digits(LN_2 / real, 3))
    } else {
        "neither grows nor decays".to_owned()
    }
}

/// The text in lines of at most that many characters, broken at spaces where there are any.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut used = 0;
    for word in text.split(' ') {
        let length = word.chars().count();
        let gap = usize::from(used > 0);
        if used + gap + length > width && used > 0 {
            lines.push(String::new());
            used = 0;
        }
        if let Some(line) = lines.last_mut() {
            if used > 0 {
                line.push(' ');
                used += 1;
            }
            line.push_str(word);
            used += length;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::record::EstimationEvent;
    use crate::flight::channel::Channel;
    use crate::flight::derivative::{Axis, Variable};
    use crate::outputs::record::EventKind;
    use crate::regression::record::{Reason, Status, TermRecord};

    fn example() -> (DerivativesRecord, ModesRecord, [FoldedEvent; 2]) {
        let reason = Reason::Unobserved { variable: Variable::V, missing: Channel::Beta };
        let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::NotIdentifiable(reason)));
        let yaw = &mut equations[Axis::N.index()];
        *yaw = EquationRecord { r_squared: 0.98712, f_total: 1234.4, samples: 400.0, residual_std: 0.0123, ..yaw.clone() };
        yaw.status = Status::Converged;
        let term = |variable, value, primary| TermRecord { variable, value, std: 0.01, std_white: 0.005, step: 2, primary };
        for term in
            [term(None, 1e-7, false), term(Some(Variable::V), 0.018_23, true), term(Some(Variable::LatCyclic), -123_456.7, false)]
        {
            yaw.terms.push(term).unwrap();
        }
        let pair = Oscillation { real: -0.16, imag: 1.8, omega: 1.807, zeta: 0.0885, std_omega: 0.02, std_zeta: 0.01 };
        let modes = ModesRecord {
            time_s: 12.4,
            status: Status::Converged,
            dutch_roll: Some(pair),
            roll: Some(RealRoot { value: -2.0, std: 0.1 }),
            spiral: Some(RealRoot { value: 0.01, std: 0.004 }),
            lateral_phugoid: None,
        };
        let event = |event| FoldedEvent { first_s: 1.0, last_s: 2.0, count: 7, kind: EventKind::Estimation(event) };
        let events =
            [event(EstimationEvent::OutOfRange { channel: Channel::Beta, value: 45.0 }), event(EstimationEvent::Initialised)];
        (DerivativesRecord { time_s: 12.4, equations, lateral: None, excited: true }, modes, events)
    }

    fn table(style: Style) -> String {
        let (derivatives, modes, events) = example();
        let (derivatives, modes) = (Some(&derivatives), Some(&modes));
        Table { run: "467/10/11", controls: ControlNames::Rotorcraft, derivatives, modes, events: &events, style }.to_string()
    }

    #[test]
    fn the_table_says_it_all_within_its_width() {
        let text = table(Style::Plain);
        for line in text.lines() {
            assert!(line.chars().count() <= WIDTH && line.trim_end() == line, "{line:?}");
        }
        for expected in [
            "N  converged\n   R2 0.987, F total 1234, 400 samples, residual 0.0123 rad/s^2",
            "N_v                   0.01823        0.010  rad/(m s)            3.32  primary",
            "N_lat_cyclic          -123457        0.010  1/s^2             1.52e14  step 2",
            "Dutch roll       omega 1.807 +- 0.020 rad/s, zeta 0.0885 +- 0.010\n                    period 3.49 s, time to half 4.33 s",
            "spiral           root 0.01000 +- 0.0040 1/s, time to double 69.3 s",
            "data lost: beta read 45.00 rad, which no aircraft reaches (wrong unit?); taken as not sampled (7",
        ] {
            assert!(text.contains(expected), "{expected}\n\n{text}");
        }
        assert!(!text.contains("the filter has a state"), "what is merely worth knowing has no place here");
    }

    #[test]
    fn colour_adds_nothing_but_colour() {
        let coloured = table(Style::Colour);
        let mut plain = String::new();
        let mut rest = coloured.as_str();
        while let Some((before, after)) = rest.split_once('\x1b') {
            plain.push_str(before);
            rest = after.split_once('m').unwrap().1;
        }
        plain.push_str(rest);
        assert_eq!(plain, table(Style::Plain));
        assert_ne!(coloured, plain);
    }
}
