//! The table of section 4 of Padfield et al. 1987: simulation, live estimate, extended model and truth at each test point.

use super::test_flight::TEST_POINTS;
use super::test_run::FlownRun;
use serde_json::Value;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::io::outputs::number::{Digits, Fixed, measured_text};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::status_text::DerivativeLabel;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::modes::record::OscillatoryMode;
use sideslip::realtime::regression::record::{LateralDerivatives, Status};
use std::fmt;

/// Lateral derivatives that are printed.
const SHOWN: [(Axis, Variable); 7] = [
    (Axis::N, Variable::V),
    (Axis::N, Variable::P),
    (Axis::N, Variable::R),
    (Axis::L, Variable::V),
    (Axis::L, Variable::P),
    (Axis::L, Variable::R),
    (Axis::Y, Variable::V),
];

/// Everything that the flights came to.
pub(super) struct ResultTable<'a> {
    /// The runs that were fitted, by test point.
    pub(super) flown: &'a [&'a FlownRun],
    /// What `diagnose` answered.
    pub(super) answer: &'a Value,
    pub(super) style: Style,
}

struct ResultTableRow {
    name: String,
    simulation: Option<f64>,
    estimate: Option<(f64, f64)>,
    extended: Option<f64>,
    extended_std: Option<f64>,
    truth: Option<f64>,
}

/// Real and imaginary part with their standard errors: real = -zeta omega, imag = omega sqrt(1 - zeta^2).
fn parts(pair: &OscillatoryMode) -> [(f64, f64); 2] {
    let OscillatoryMode { real, imag, omega, zeta, std_omega, std_zeta } = *pair;
    let root = libm::sqrt(1.0 - zeta * zeta);
    let std = [libm::hypot(zeta * std_omega, omega * std_zeta), libm::hypot(root * std_omega, omega * zeta / root * std_zeta)];
    [(real, std[0]), (imag, std[1])]
}

impl ResultTable<'_> {
    fn lines(&self, flown: &FlownRun, point: &Value) -> Vec<ResultTableRow> {
        let truth = &flown.flight.truth;
        let mut lines = Vec::new();
        let pair = lateral::modes(0.0, Status::Converged, &LateralDerivatives::of(truth)).and_then(|modes| modes.dutch_roll);
        let found = flown.estimate.modes.dutch_roll.as_ref().map(parts);
        for (place, part) in ["real", "imag"].into_iter().enumerate() {
            let of = |which: &str| point["lateral_roots"][which][part].as_f64();
            lines.push(ResultTableRow {
                name: format!("Dutch roll {part}"),
                simulation: of("model"),
                estimate: found.and_then(|parts| parts.get(place).copied()),
                extended: of("extended"),
                extended_std: None,
                truth: pair.map(|pair| if part == "real" { pair.real } else { pair.imag }),
            });
        }
        for (axis, variable) in SHOWN {
            let name = DerivativeLabel { axis, variable: Some(variable), controls: ControlNames::Rotorcraft }.to_string();
            let of = |which: &str| point["lateral"][&name][which].as_f64();
            let equation = flown.estimate.derivatives.equations.get(axis.index());
            let term = equation.and_then(|equation| equation.term(variable));
            lines.push(ResultTableRow {
                simulation: of("model"),
                estimate: term.map(|term| (term.value, term.std)),
                extended: of("extended"),
                extended_std: of("std"),
                truth: Some(truth.derivative(axis, variable)),
                name,
            });
        }
        lines
    }
}

fn plain(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| Digits(value, 3).to_string())
}

fn with_error(value: Option<(f64, f64)>) -> String {
    value.map_or_else(|| "-".to_owned(), |(value, std)| measured_text(value, std))
}

impl fmt::Display for ResultTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.style.bold("Dutch roll against flight path, of the lateral subsystem v p phi r, SI and radians"))?;
        writeln!(f, "  {:<16}{:>10}   {:<22}{:<22}{:>9}", "", "simulation", "live estimate", "extended model", "truth")?;
        let (mut within, mut all) = (0_usize, 0_usize);
        for ((point, flown), answer) in
            TEST_POINTS.iter().zip(self.flown).zip(self.answer["test_points"].as_array().into_iter().flatten())
        {
            let path_deg = answer["path_rad"].as_f64().unwrap_or(f64::NAN).to_degrees();
            writeln!(f, "{}", self.style.bold(format!("{}, flight path {:+} deg", point.name, Fixed(path_deg, 1))))?;
            for line in self.lines(flown, answer) {
                let off = line.estimate.zip(line.truth).map(|((value, std), truth)| (value - truth).abs() / std);
                within += usize::from(off.is_some_and(|off| off <= 3.0));
                all += usize::from(off.is_some());
                let extended = match line.extended_std {
                    Some(std) => with_error(line.extended.map(|value| (value, std))),
                    None => plain(line.extended),
                };
                let (simulation, estimate, truth) = (plain(line.simulation), with_error(line.estimate), plain(line.truth));
                writeln!(f, "  {:<16}{simulation:>10}   {estimate:<22}{extended:<22}{truth:>9}", line.name)?;
            }
            let ratio = &answer["gain"]["holdout"]["pooled"]["ratio"];
            match ratio.as_f64() {
                Some(ratio) => writeln!(f, "  error of the extended model on the hold-out run: {ratio:.2} of the simulation's")?,
                None => writeln!(f, "  no improvement on the hold-out run")?,
            }
        }
        writeln!(f, "\n{within} of {all} live estimates are within 3 standard errors of the truth.")
    }
}
