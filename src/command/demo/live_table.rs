//! The table of truth and estimate while it flies.

use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::model::LinearModel;
use sideslip::io::bus::reader::NewestEstimate;
use sideslip::io::outputs::number::{Digits, measured};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::status_text::{DerivativeLabel, StatusText, derivative_unit};
use sideslip::realtime::modes::coupled::dutch_roll;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::modes::record::ModesRecord;
use sideslip::realtime::regression::record::{LateralDerivatives, SixAxisDerivatives, Status};
use std::fmt;

/// What is compared: the derivatives that make the lateral modes, and those of the controls.
const SHOWN: [(Axis, Variable); 12] = [
    (Axis::N, Variable::V),
    (Axis::N, Variable::P),
    (Axis::N, Variable::R),
    (Axis::N, Variable::Pedal),
    (Axis::L, Variable::V),
    (Axis::L, Variable::P),
    (Axis::L, Variable::R),
    (Axis::L, Variable::LatCyclic),
    (Axis::L, Variable::Pedal),
    (Axis::Y, Variable::V),
    (Axis::Y, Variable::P),
    (Axis::Y, Variable::R),
];

const NAMES: ControlNames = ControlNames::Rotorcraft;

pub(super) struct LiveTable<'a> {
    pub(super) truth: &'a LinearModel,
    pub(super) estimate: Option<&'a NewestEstimate>,
    pub(super) style: Style,
}

/// One line: what is true, and what was found with its standard error and the standing of its equation.
struct LiveTableRow {
    name: String,
    unit: &'static str,
    truth: f64,
    found: Option<(f64, f64)>,
    status: Status,
}

impl LiveTableRow {
    /// By how many standard errors the estimate is off.
    fn off(&self) -> Option<f64> {
        let (value, std) = self.found?;
        (std > 0.0).then(|| (value - self.truth) / std)
    }
}

fn mode_lines(truth: &ModesRecord, estimate: Option<&NewestEstimate>) -> Vec<LiveTableRow> {
    let found = estimate.map(|estimate| &estimate.modes);
    // Its status when it was new; the heading says its age.
    let status = found.map_or(Status::Waiting, |modes| modes.status);
    let line = |name: &str, unit, truth: Option<f64>, found: Option<(f64, f64)>| {
        Some(LiveTableRow { name: name.to_owned(), unit, truth: truth?, found, status })
    };
    let [pair, whole] = [found.and_then(|modes| modes.dutch_roll), found.and_then(|modes| modes.coupled)];
    let [roll, spiral] = [found.and_then(|modes| modes.roll), found.and_then(|modes| modes.spiral)];
    let lines = [
        line("Dutch roll omega", "rad/s", truth.coupled.map(|pair| pair.omega), whole.map(|pair| (pair.omega, pair.std_omega))),
        line("Dutch roll zeta", "", truth.coupled.map(|pair| pair.zeta), whole.map(|pair| (pair.zeta, pair.std_zeta))),
        line("lateral omega", "rad/s", truth.dutch_roll.map(|pair| pair.omega), pair.map(|pair| (pair.omega, pair.std_omega))),
        line("lateral zeta", "", truth.dutch_roll.map(|pair| pair.zeta), pair.map(|pair| (pair.zeta, pair.std_zeta))),
        line("roll root", "1/s", truth.roll.map(|root| root.value), roll.map(|root| (root.value, root.std))),
        line("spiral root", "1/s", truth.spiral.map(|root| root.value), spiral.map(|root| (root.value, root.std))),
    ];
    lines.into_iter().flatten().collect()
}

fn derivative_lines(truth: &LinearModel, estimate: Option<&NewestEstimate>) -> Vec<LiveTableRow> {
    let line = |&(axis, variable): &(Axis, Variable)| {
        let equation = estimate.and_then(|estimate| estimate.derivatives.equations.get(axis.index()));
        let term = equation.and_then(|equation| equation.term(variable));
        LiveTableRow {
            name: DerivativeLabel { axis, variable: Some(variable), controls: NAMES }.to_string(),
            unit: derivative_unit(axis, Some(variable)),
            truth: truth.derivative(axis, variable),
            found: term.map(|term| (term.value, term.std)),
            status: equation.map_or(Status::Waiting, |equation| equation.status),
        }
    };
    SHOWN.iter().map(line).collect()
}

impl fmt::Display for LiveTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.estimate {
            None => writeln!(f, "no estimate yet")?,
            Some(estimate) => {
                let status = StatusText { status: estimate.status, controls: NAMES };
                let title =
                    format!("Estimate at {:.1} s, {:.2} s old: {status}", estimate.modes.time_s, estimate.age.as_secs_f64());
                writeln!(f, "{}", self.style.bold(title))?;
            }
        }
        let subsystem = LateralDerivatives::of(self.truth);
        let modes = lateral::modes(0.0, Status::Converged, &subsystem).map(|modes| ModesRecord {
            coupled: modes.dutch_roll.and_then(|alone| dutch_roll(&SixAxisDerivatives::of(self.truth), &subsystem, &alone, 0.0)),
            ..modes
        });
        let mut lines = modes.map(|modes| mode_lines(&modes, self.estimate)).unwrap_or_default();
        lines.extend(derivative_lines(self.truth, self.estimate));
        writeln!(
            f,
            "  {:<17} {:>10}   {:>10}    {:<9} {:<12} {:>8}  status",
            "", "truth", "estimate", "std error", "unit", "off by"
        )?;
        for line in &lines {
            let (value, std) = line.found.map_or(("-".into(), "-".into()), |(value, std)| measured(value, std));
            let off = line.off().map_or("-".to_owned(), |off| format!("{off:+.1} s.e."));
            let status = StatusText { status: line.status, controls: NAMES };
            let (name, truth, unit) = (&line.name, Digits(line.truth, 5).to_string(), line.unit);
            writeln!(f, "  {name:<17} {truth:>10}   {value:>10} +- {std:<9} {unit:<12} {off:>8}  {status}")?;
        }
        Ok(())
    }
}
