//! The controls of a recorded run, as `simulate` flies them again.

use sideslip::error::Failure;
use sideslip::flight::channel::Channel;
use sideslip::flight::control::{CONTROLS, Control};
use sideslip::simulation::history::History;
use std::path::Path;

/// Controls and rotor speed of a run over its own time.
#[derive(Debug)]
pub(crate) struct ControlHistory {
    /// By [`Control`] place; `None` where the run has no such channel.
    pub(crate) controls: [Option<History>; CONTROLS],
    /// Rotor speed, where the run has it.
    pub(crate) rotor_speed: Option<History>,
    /// Times of the run's samples, s.
    pub(crate) times_s: Vec<f64>,
}

impl ControlHistory {
    /// The first sample's time, s.
    pub(crate) fn start_s(&self) -> f64 {
        self.times_s.first().copied().unwrap_or_default()
    }

    /// The last sample's time, s.
    pub(crate) fn end_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or_default()
    }
}

/// Reads the controls of a run file in SI units (a column with a unit in brackets is refused).
pub(crate) fn read_controls(path: &Path) -> Result<ControlHistory, Failure> {
    let text =
        std::fs::read_to_string(path).map_err(|error| Failure::file(path, format_args!("expected a run file: {error}")))?;
    let mut lines = text.lines().enumerate().map(|(place, line)| (place + 1, line)).filter(|(_, line)| !line.starts_with('#'));
    let Some((header_line, header)) = lines.next() else { return Err(Failure::file(path, "expected a header row, found none")) };
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let place_of = |wanted: &str| names.iter().position(|name| *name == wanted);
    let time = place_of("time").ok_or_else(|| Failure::at(path, header_line, 1, "expected a column `time`, found none"))?;
    let wanted: Vec<Channel> = Control::ALL.map(Control::channel).into_iter().chain([Channel::RotorSpeed]).collect();
    let mut columns: Vec<Option<usize>> = vec![None; wanted.len()];
    for (place, name) in names.iter().enumerate() {
        let bare = name.split('[').next().unwrap_or(name);
        let Some((channel, _)) = Channel::from_name(bare) else { continue };
        let Some((_, column)) = wanted.iter().zip(&mut columns).find(|(wanted, _)| **wanted == channel) else { continue };
        if bare != *name {
            return Err(Failure::at(path, header_line, 1, format_args!("column `{name}`: only SI units are read here")));
        }
        if column.replace(place).is_some() {
            return Err(Failure::at(path, header_line, 1, format_args!("column `{name}` stands twice")));
        }
    }
    let mut times_s = Vec::new();
    let mut points: Vec<Vec<(f64, f64)>> = vec![Vec::new(); wanted.len()];
    for (line, row) in lines.filter(|(_, row)| !row.trim().is_empty()) {
        let cells: Vec<&str> = row.split(',').map(str::trim).collect();
        let number = |place: usize| match cells.get(place).copied() {
            None | Some("") => Ok(None),
            Some(cell) => match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(Some(value)),
                _ => Err(Failure::at(
                    path,
                    line,
                    1,
                    format_args!("`{}`: expected a finite number, found `{cell}`", names.get(place).unwrap_or(&"")),
                )),
            },
        };
        let time_s = number(time)?.ok_or_else(|| Failure::at(path, line, 1, "expected a time, found an empty cell"))?;
        if times_s.last().is_some_and(|&last| time_s <= last) {
            return Err(Failure::at(path, line, 1, format_args!("time does not increase: {time_s} s")));
        }
        times_s.push(time_s);
        for (column, points) in columns.iter().zip(&mut points) {
            if let Some(value) = column.map(number).transpose()?.flatten() {
                points.push((time_s, value));
            }
        }
    }
    if times_s.is_empty() {
        return Err(Failure::file(path, "expected rows of samples, found none"));
    }
    let mut histories = points.into_iter().map(|points| History::through(points).ok());
    let controls = Control::ALL.map(|_| histories.next().flatten());
    Ok(ControlHistory { controls, rotor_speed: histories.next().flatten(), times_s })
}
