//! The table of estimates: modes, derivatives with standard errors, warnings; plain text, at most 100 columns.
//!
//! Colour (bold headings, yellow and red warnings) only if requested; [`Style::of_stream`] requests it on a terminal unless
//! `NO_COLOR` is set.

use crate::flight::channel::ControlNames;
use crate::io::outputs::event_ring::{FoldedEvent, FoldedText};
use crate::io::outputs::number::{Digits, Fixed, measured};
use crate::io::outputs::record::EventKind;
use crate::io::outputs::tables::wrapped::wrapped;
use crate::io::outputs::words::event_text::{Severity, event_severity};
use crate::io::outputs::words::printable::{printable, printable_lines, with_short_numbers};
use crate::io::outputs::words::status_text::{
    DUTCH_ROLL_WITHHELD, DerivativeLabel, WHOLE_NOT_AVAILABLE, derivative_unit, status_in_words,
};
use crate::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use crate::realtime::regression::record::{DerivativesRecord, EquationRecord, RegressionEvent, Status};
use std::borrow::Cow;
use std::f64::consts::{LN_2, TAU};
use std::fmt;
use std::io::IsTerminal;

/// The widest line, columns.
pub const WIDTH: usize = 100;

/// Every sequence that a style writes, in a spelling that nobody uses by accident: bold, red, yellow, plain again.
const SEQUENCES: [&str; 4] = ["\x1b[0;1m", "\x1b[0;31m", "\x1b[0;33m", PLAIN_AGAIN];

const PLAIN_AGAIN: &str = "\x1b[0;0m";

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

    /// A heading, in one line.
    pub fn bold(self, text: impl fmt::Display) -> String {
        self.paint("1", text)
    }

    fn paint(self, code: &'static str, text: impl fmt::Display) -> String {
        let text = text.to_string();
        let text = printable(&text);
        match self {
            Style::Plain => text.into_owned(),
            Style::Colour => format!("\x1b[0;{code}m{text}{PLAIN_AGAIN}"),
        }
    }

    /// Text for a stream of this style: what would steer a terminal is shown instead, whoever wrote it, and only the sequences
    /// that the style itself writes pass. A name that holds just these can make itself bold, red or yellow, and nothing else. A
    /// number of hundreds of digits is a power of ten.
    pub fn shown(self, text: &str) -> Cow<'_, str> {
        match with_short_numbers(text) {
            Cow::Borrowed(text) => self.steered(text),
            Cow::Owned(text) => Cow::Owned(self.steered(&text).into_owned()),
        }
    }

    fn steered(self, text: &str) -> Cow<'_, str> {
        if self == Style::Plain || !text.contains('\x1b') {
            return printable_lines(text);
        }
        let mut shown = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(at) = rest.find('\x1b') {
            let (before, from) = rest.split_at(at);
            shown.push_str(&printable_lines(before));
            let own = SEQUENCES.iter().find(|own| from.starts_with(**own));
            let sequence = own.map_or("\x1b", |own| *own);
            shown.push_str(if own.is_some() { sequence } else { "\\x1b" });
            rest = from.strip_prefix(sequence).unwrap_or_default();
        }
        shown.push_str(&printable_lines(rest));
        Cow::Owned(shown)
    }
}

/// What stands in the table.
#[derive(Clone, Copy, Debug)]
pub struct EstimateTable<'a> {
    /// How the controls are called.
    pub controls: ControlNames,
    /// The last derivatives.
    pub derivatives: Option<&'a DerivativesRecord>,
    /// The last modes.
    pub modes: Option<&'a ModesRecord>,
    /// Time of the newest data that they rest on, s, where it is known.
    pub excited_until_s: Option<f64>,
    /// What was noticed, repeats folded.
    pub events: &'a [FoldedEvent],
    /// What is to be said of the recording itself.
    pub notes: &'a [String],
    /// Whether it is coloured.
    pub style: Style,
}

impl fmt::Display for EstimateTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(modes) = self.modes {
            self.modes(f, modes)?;
        }
        if let Some(derivatives) = self.derivatives {
            let excited = if derivatives.excited { ", excited".to_owned() } else { self.data_until(derivatives.time_s) };
            self.heading(
                f,
                0,
                &format!("Derivatives at {} s{excited}, SI and radians, with standard errors", Fixed(derivatives.time_s, 2)),
            )?;
            for equation in derivatives.equations.iter().filter(|equation| !equation.terms.is_empty()) {
                self.equation(f, equation)?;
            }
            self.without_numbers(f, derivatives)?;
        }
        if self.modes.is_none() && self.derivatives.is_none() {
            writeln!(f, "No estimate: no sample came that has a time.")?;
        }
        self.events(f)
    }
}

impl EstimateTable<'_> {
    /// Of numbers that are said again: until when data have contributed.
    fn data_until(&self, said_s: f64) -> String {
        let until_s = self.excited_until_s.filter(|until_s| *until_s < said_s);
        until_s.map_or_else(String::new, |until_s| format!(", from data until {} s", Fixed(until_s, 2)))
    }

    fn heading(&self, f: &mut fmt::Formatter<'_>, indent: usize, text: &str) -> fmt::Result {
        for (place, line) in wrapped(text, WIDTH - 6).into_iter().enumerate() {
            let indent = if place == 0 { indent } else { indent + 3 };
            writeln!(f, "{:indent$}{}", "", self.style.bold(line))?;
        }
        Ok(())
    }

    fn equation(&self, f: &mut fmt::Formatter<'_>, equation: &EquationRecord) -> fmt::Result {
        self.heading(f, 2, &format!("{}  {}", equation.axis.name(), status_in_words(equation.status, self.controls)))?;
        let unit = if equation.axis.is_force() { "m/s^2" } else { "rad/s^2" };
        writeln!(
            f,
            "     R2 {}, F {}, residual {} {unit}, {} samples, condition index {}",
            Fixed(equation.r_squared, 3),
            Digits(equation.f_total, 3),
            Digits(equation.residual_std, 2),
            Fixed(equation.samples, 0),
            Digits(equation.condition_index, 2)
        )?;
        if let Some((variable, apart)) = equation.disagreement() {
            let name = DerivativeLabel { axis: equation.axis, variable: Some(variable), controls: self.controls };
            let agrees = if apart.abs() <= EquationRecord::AGREE_WITHIN { "agrees" } else { "DISAGREES" };
            let apart = format!("{}", Fixed(apart.abs(), 1));
            writeln!(f, "     frequency domain {agrees}: differs by up to {apart} combined standard errors, in {name}")?;
        }
        let rows: Vec<_> = equation.terms.iter().map(|term| (term, measured(term.value, term.std))).collect();
        let wide = |text: fn(&(String, String)) -> &String| rows.iter().map(|(_, pair)| text(pair).len()).max().unwrap_or(0);
        let (value_width, std_width) = (wide(|pair| &pair.0), wide(|pair| &pair.1));
        // Values of one equation stand with their points below each other.
        let after_point = |text: &str| text.find('.').map_or(0, |point| text.len() - point);
        let decimals = rows.iter().map(|(_, pair)| after_point(&pair.0)).max().unwrap_or(0);
        let before = rows.iter().map(|(_, pair)| pair.0.len() - after_point(&pair.0)).max().unwrap_or(0);
        let value_width = value_width.max(before + decimals);
        for (term, (value, std)) in &rows {
            let name = DerivativeLabel { axis: equation.axis, variable: term.variable, controls: self.controls };
            let entered = match (term.variable, term.primary) {
                (None, _) => String::new(),
                (_, true) => format!("  F {}", Digits(term.partial_f(), 3)),
                (_, false) => format!("  F {}, entered at step {}", Digits(term.partial_f(), 3), term.step),
            };
            let place = before - (value.len() - after_point(value));
            let value = format!("{:place$}{value}", "");
            let unit = derivative_unit(equation.axis, term.variable);
            let line = format!("     {:<14} {value:<value_width$} +- {std:<std_width$}  {unit:<11}{entered}", name.to_string());
            writeln!(f, "{}", line.trim_end())?;
        }
        let unresolved: Vec<String> = equation
            .unresolved_variables()
            .map(|variable| {
                DerivativeLabel { axis: equation.axis, variable: Some(variable), controls: self.controls }.to_string()
            })
            .collect();
        if !unresolved.is_empty() {
            writeln!(
                f,
                "     not resolved (standard error above the value and not small beside the response, or moved by \
                 feedback alone): {}",
                unresolved.join(" ")
            )?;
        }
        Ok(())
    }

    /// Axes that have no numbers, those of one reason together.
    fn without_numbers(&self, f: &mut fmt::Formatter<'_>, derivatives: &DerivativesRecord) -> fmt::Result {
        let mut groups: Vec<(String, String)> = Vec::new();
        for equation in derivatives.equations.iter().filter(|equation| equation.terms.is_empty()) {
            let why = status_in_words(equation.status, self.controls);
            match groups.iter_mut().find(|(_, reason)| *reason == why) {
                Some((axes, _)) => {
                    axes.push(' ');
                    axes.push_str(equation.axis.name());
                }
                None => groups.push((equation.axis.name().to_owned(), why)),
            }
        }
        groups.iter().try_for_each(|(axes, why)| self.heading(f, 2, &format!("{axes}  {why}")))
    }

    fn modes(&self, f: &mut fmt::Formatter<'_>, modes: &ModesRecord) -> fmt::Result {
        let status = status_in_words(modes.status, self.controls);
        let stale = modes.status == Status::Stale;
        let until = if stale { self.data_until(modes.time_s) } else { String::new() };
        self.heading(f, 0, &format!("Lateral modes at {} s{until}: {status}", Fixed(modes.time_s, 2)))?;
        let numbers = modes.status.rank() >= Status::Stale.rank();
        if modes.dutch_roll.is_some() || modes.roll.is_some() {
            writeln!(f, "  (of the lateral subsystem v p phi r, unless marked whole)")?;
        }
        match &modes.dutch_roll {
            Some(pair) => oscillation(f, "Dutch roll", pair)?,
            None if numbers => self.heading(f, 2, &format!("Dutch roll       {DUTCH_ROLL_WITHHELD}"))?,
            None => {}
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
        match &modes.coupled {
            Some(pair) => oscillation(f, "Dutch roll whole", pair)?,
            None if modes.dutch_roll.is_some() => {
                writeln!(f, "  Dutch roll whole {WHOLE_NOT_AVAILABLE}")?;
            }
            None => {}
        }
        Ok(())
    }

    fn events(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = |event: &&FoldedEvent| {
            // The status of an equation is printed at the equation.
            event_severity(&event.kind) > Severity::Info
                && !matches!(event.kind, EventKind::Regression(RegressionEvent::StatusChanged { .. }))
        };
        let sentences = self.events.iter().filter(told).map(|event| {
            let lost = event_severity(&event.kind) == Severity::DataLost;
            let (code, mark) = if lost { ("31", "data lost: ") } else { ("33", "") };
            (code, format!("{mark}{}", FoldedText { event, controls: self.controls }))
        });
        let notes = self.notes.iter().map(|note| ("31", format!("recording: {note}")));
        let mut first = true;
        for (code, sentence) in notes.chain(sentences) {
            if std::mem::take(&mut first) {
                self.heading(f, 0, "Warnings")?;
            }
            for (place, line) in wrapped(&sentence, WIDTH - 5).into_iter().enumerate() {
                let margin = if place == 0 { "  " } else { "     " };
                writeln!(f, "{margin}{}", self.style.paint(code, line))?;
            }
        }
        Ok(())
    }
}

fn oscillation(f: &mut fmt::Formatter<'_>, name: &str, pair: &OscillatoryMode) -> fmt::Result {
    let ((omega, std_omega), (zeta, std_zeta)) = (measured(pair.omega, pair.std_omega), measured(pair.zeta, pair.std_zeta));
    writeln!(
        f,
        "  {name:<16} omega {omega} +- {std_omega} rad/s, zeta {zeta} +- {std_zeta}\n  {:<16} period {} s, {}",
        "",
        Digits(TAU / pair.imag, 3),
        half_or_double(pair.real)
    )
}

fn real_root(f: &mut fmt::Formatter<'_>, name: &str, root: &RealRoot) -> fmt::Result {
    let (value, std) = measured(root.value, root.std);
    writeln!(f, "  {name:<16} root {value} +- {std} 1/s, {}", half_or_double(root.value))
}

/// Time to half or to double the amplitude, ln 2 over the size of the real part.
pub fn half_or_double(real: f64) -> String {
    if real < 0.0 {
        format!("time to half {} s", Digits(-LN_2 / real, 3))
    } else if real > 0.0 {
        format!("time to double {} s", Digits(LN_2 / real, 3))
    } else {
        "neither grows nor decays".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;
    use crate::flight::derivative::{Axis, Variable};
    use crate::io::outputs::record::EventKind;
    use crate::realtime::estimation::record::EstimationEvent;
    use crate::realtime::regression::record::{Reason, Status, TermRecord};

    fn example() -> (DerivativesRecord, ModesRecord, [FoldedEvent; 2]) {
        let reason = Reason::Unobserved { variable: Variable::V, missing: Channel::Beta };
        let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::NotIdentifiable(reason)));
        let yaw = &mut equations[Axis::N.index()];
        *yaw = EquationRecord { r_squared: 0.98712, f_total: 1234.4, samples: 400.0, residual_std: 0.0123, ..yaw.clone() };
        yaw.status = Status::Converged;
        let term = |variable, value, primary| TermRecord {
            variable,
            value,
            std: 0.01,
            std_white: 0.005,
            step: 2,
            primary,
            frequency: None,
        };
        for term in
            [term(None, 1e-7, false), term(Some(Variable::V), 0.018_23, true), term(Some(Variable::LatCyclic), -123_456.7, false)]
        {
            yaw.terms.push(term).unwrap();
        }
        let pair = OscillatoryMode { real: -0.16, imag: 1.8, omega: 1.807, zeta: 0.0885, std_omega: 0.02, std_zeta: 0.01 };
        let modes = ModesRecord {
            time_s: 12.4,
            status: Status::Converged,
            dutch_roll: Some(pair),
            roll: Some(RealRoot { value: -2.0, std: 0.1 }),
            spiral: Some(RealRoot { value: 0.01, std: 0.004 }),
            lateral_phugoid: None,
            coupled: None,
        };
        let event = |event| FoldedEvent { first_s: 1.0, last_s: 2.0, count: 7, kind: EventKind::Estimation(event) };
        let events =
            [event(EstimationEvent::OutOfRange { channel: Channel::Beta, value: 45.0 }), event(EstimationEvent::Initialised)];
        (DerivativesRecord { time_s: 12.4, equations, lateral: None, excited: true }, modes, events)
    }

    fn table(style: Style) -> String {
        let (derivatives, modes, events) = example();
        let (derivatives, modes) = (Some(&derivatives), Some(&modes));
        EstimateTable {
            controls: ControlNames::Rotorcraft,
            derivatives,
            modes,
            excited_until_s: None,
            events: &events,
            notes: &[],
            style,
        }
        .to_string()
    }

    #[test]
    fn the_table_says_it_all_within_its_width() {
        let text = table(Style::Plain);
        for line in text.lines() {
            assert!(line.chars().count() <= WIDTH && line.trim_end() == line, "{line:?}");
        }
        for expected in [
            "  N  converged\n     R2 0.987, F 1234, residual 0.012 rad/s^2, 400 samples",
            "\n     N_v                  0.018 +- 0.010  rad/(m s)    F 3.32\n",
            "\n     N_lat_cyclic   -123456.700 +- 0.010  1/s^2        F 1.52e14, entered at step 2\n",
            "  Dutch roll       omega 1.807 +- 0.020 rad/s, zeta 0.088 +- 0.010\n                   period 3.49 s, time to half 4.33 s",
            "  spiral           root 0.0100 +- 0.0040 1/s, time to double 69.3 s",
            "  X Y Z L M  not identifiable: v is not observable; the channel beta would make it so\n",
            "  data lost: beta read 45.00 rad, which no aircraft reaches (wrong unit?)",
            "(7 times, 1.00 to 2.00 s)",
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

    #[test]
    fn only_its_own_sequences_reach_a_terminal() {
        let own = format!("{}\n{}\n", Style::Colour.bold("run \x1b[2J\n7"), Style::Colour.paint("31", "lost"));
        assert_eq!(Style::Colour.shown(&own), own);
        assert!(own.contains("run \\x1b[2J\\n7"), "{own:?}");
        let theirs = "a\x1b[31mb\x1b[0mc\x1b]0;title\x07\u{9b}2J\u{202e}d\x1b";
        let expected = "a\\x1b[31mb\\x1b[0mc\\x1b]0;title\\x07\\u{9b}2J\\u{202e}d\\x1b";
        assert_eq!((Style::Colour.shown(theirs), Style::Plain.shown(theirs)), (expected.into(), expected.into()));
        assert_eq!(Style::Plain.shown(&Style::Colour.bold("x")), "\\x1b[0;1mx\\x1b[0;0m");
        assert_eq!(Style::Colour.shown("\u{f6}\n\tb"), "\u{f6}\n\tb");
    }
}
