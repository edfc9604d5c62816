//! `--derivatives`: the estimates against time as a table, a row each publication.
//!
//! Consumes derivatives and modes as they are published; produces a CSV in the form of a run file: the run's keys, a header with
//! units, and for each derivative that ever had a number its value and standard error (`N_r`, `std_N_r`), then the Dutch roll.
//! A cell is empty where there is no number at that time.

use super::output_per_recording::OutputPerRecording;
use crate::command::terminal::output_file::write_whole;
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::outputs::words::status_text::{DerivativeLabel, derivative_unit};
use sideslip::realtime::modes::record::ModesRecord;
use sideslip::realtime::regression::record::DerivativesRecord;
use std::io::Write;
use std::path::Path;

/// The files of the option.
pub(super) const HISTORIES: OutputPerRecording = OutputPerRecording { option: "--derivatives", endings: &["csv"] };

/// The bias, then the variables.
const PLACES: usize = AXES * (1 + VARIABLES);

const MODES: [(&str, &str); 6] = [
    ("dutch_roll_omega", "rad/s"),
    ("std_dutch_roll_omega", "rad/s"),
    ("dutch_roll_zeta", "1"),
    ("std_dutch_roll_zeta", "1"),
    ("dutch_roll_real", "1/s"),
    ("dutch_roll_imag", "rad/s"),
];

struct HistoryRow {
    time_s: f64,
    /// Place, value and standard error of each term with a number.
    terms: Vec<(usize, f64, f64)>,
    dutch_roll: Option<[f64; MODES.len()]>,
}

/// What was published so far.
pub(super) struct DerivativeHistory {
    rows: Vec<HistoryRow>,
    seen: [bool; PLACES],
}

impl Default for DerivativeHistory {
    fn default() -> Self {
        DerivativeHistory { rows: Vec::new(), seen: [false; PLACES] }
    }
}

fn place(axis: Axis, variable: Option<Variable>) -> usize {
    axis.index() * (1 + VARIABLES) + variable.map_or(0, |variable| 1 + variable.index())
}

/// Axis and variable of every place.
fn places() -> impl Iterator<Item = (Axis, Option<Variable>)> {
    let of = |axis: Axis| std::iter::once(None).chain(Variable::ALL.map(Some)).map(move |variable| (axis, variable));
    Axis::ALL.into_iter().flat_map(of)
}

impl DerivativeHistory {
    /// Takes the newest publication where it is newer than the last one.
    pub(super) fn take(&mut self, derivatives: Option<&DerivativesRecord>, modes: Option<&ModesRecord>) {
        let Some(newest) = derivatives else { return };
        if self.rows.last().is_some_and(|last| !(newest.time_s > last.time_s)) {
            return;
        }
        let of_axis = newest
            .equations
            .iter()
            .flat_map(|equation| equation.terms.iter().map(|term| (place(equation.axis, term.variable), term.value, term.std)));
        let terms: Vec<_> = of_axis.filter(|(_, value, _)| value.is_finite()).collect();
        for (place, ..) in &terms {
            if let Some(seen) = self.seen.get_mut(*place) {
                *seen = true;
            }
        }
        let pair = modes.and_then(|modes| modes.dutch_roll);
        let dutch_roll = pair.map(|pair| [pair.omega, pair.std_omega, pair.zeta, pair.std_zeta, pair.real, pair.imag]);
        self.rows.push(HistoryRow { time_s: newest.time_s, terms, dutch_roll });
    }

    /// Writes the table, whole or not at all; how many rows it has.
    pub(super) fn write(&self, path: &Path, info: &RunInfo) -> Result<usize, Failure> {
        let controls = info.geometry().controls;
        write_whole(path, |file| {
            for line in info.to_toml().lines() {
                writeln!(file, "# {line}")?;
            }
            self.header(file, controls)?;
            self.rows.iter().try_for_each(|row| self.row(file, row))
        })?;
        Ok(self.rows.len())
    }

    fn header(&self, file: &mut dyn Write, controls: ControlNames) -> std::io::Result<()> {
        write!(file, "time[s]")?;
        for ((axis, variable), _) in places().zip(self.seen).filter(|(_, seen)| *seen) {
            let (name, unit) = (DerivativeLabel { axis, variable, controls }, derivative_unit(axis, variable));
            write!(file, ",{name}[{unit}],std_{name}[{unit}]")?;
        }
        MODES.iter().try_for_each(|(name, unit)| write!(file, ",{name}[{unit}]"))?;
        writeln!(file)
    }

    fn row(&self, file: &mut dyn Write, row: &HistoryRow) -> std::io::Result<()> {
        write!(file, "{}", row.time_s)?;
        for place in (0..PLACES).filter(|place| self.seen.get(*place) == Some(&true)) {
            match row.terms.iter().find(|(own, ..)| *own == place) {
                Some((_, value, std)) => write!(file, ",{value},{std}")?,
                None => write!(file, ",,")?,
            }
        }
        for number in row.dutch_roll.map_or([None; MODES.len()], |numbers| numbers.map(Some)) {
            match number.filter(|number| number.is_finite()) {
                Some(number) => write!(file, ",{number}")?,
                None => write!(file, ",")?,
            }
        }
        writeln!(file)
    }
}
