//! The answer of `inspect` for a person: aligned text, values in the units of the file.

use super::estimable::{EstimableQuantities, Feasibility};
use super::survey::{ColumnSurvey, Survey};
use crate::command::inspect::traffic;
use sideslip::flight::channel::Channel;
use sideslip::flight::derivative::Axis;
use sideslip::flight::file::run_file::{RecordingColumn, RunInfo};
use sideslip::flight::unit::factor_to_si;
use sideslip::io::outputs::number::decimals;
use sideslip::io::outputs::words::control_scale::{assumed_names, assumed_scale};
use sideslip::io::outputs::words::printable::printable;
use sideslip::io::telemetry::alignment::dropout::Dropout;
use sideslip::io::telemetry::alignment::reorder::events::ReorderTally;
use sideslip::io::telemetry::alignment::row_alignment::RowAlignment;
use sideslip::io::telemetry::recording::Recording;
use sideslip::simulation::flight_model::CONDITION;
use std::fmt::Write;
use std::path::Path;

const GAPS_SHOWN: usize = 5;

pub(super) fn text(
    file: &Path,
    recording: &Recording,
    info: &RunInfo,
    survey: &Survey,
    order: &RowAlignment,
    estimable: &EstimableQuantities,
) -> String {
    let mut lines =
        vec![format!("{}: {}, {}", printable(&file.display().to_string()), recording.format(), counted(survey.rows, "row"))];
    lines.extend(run_lines(info));
    lines.extend(time_lines(survey));
    lines.extend(dropout_lines(recording, order));
    lines.extend(row_lines(recording, info));
    lines.extend(recording.traffic().into_iter().flat_map(traffic::lines));
    lines.push(String::new());
    lines.extend(channel_lines(recording, info, survey));
    lines.push(String::new());
    lines.extend(estimable_lines(recording, estimable));
    let mut text = String::new();
    for line in lines {
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

fn run_lines(info: &RunInfo) -> Vec<String> {
    let document = info.document();
    let width = document.keys().map(|key| key.chars().count()).max().unwrap_or(0);
    let line = |key: &str, value: &str| format!("  {:width$}  {}", printable(key), printable(value));
    let lines = document.iter().flat_map(|(key, value)| match value.as_table() {
        None => vec![line(key, &value.to_string())],
        Some(table) => table
            .iter()
            .zip(0..)
            .map(|((part, value), place)| {
                line(
                    if place == 0 { key } else { "" },
                    &format!("{part}: {}", listed_values(key == "level1" && part == "flight", value)),
                )
            })
            .collect(),
    });
    lines.collect()
}

/// The entries of a table within the run's own; those of a flight condition with their units.
fn listed_values(is_condition: bool, value: &toml::Value) -> String {
    let Some(table) = value.as_table() else { return value.to_string() };
    let unit = |key: &str| CONDITION.iter().find(|(name, _)| is_condition && *name == key).map_or("", |(_, unit)| unit);
    let shown = |value: &toml::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let entries = table.iter().map(|(key, value)| format!("{key} {} {}", shown(value), unit(key)).trim_end().to_owned());
    entries.collect::<Vec<_>>().join(", ")
}

fn time_lines(survey: &Survey) -> Vec<String> {
    let times = &survey.times;
    let Some((from, to)) = times.range_s else { return vec!["  time: no row has one that is a number".into()] };
    let rate = times.rate_hz().map_or("of one sample".into(), |rate| format!("median rate {} Hz", number(rate)));
    let mut lines = vec![format!("  time {} to {} s ({} s), {rate}", number(from), number(to), number(to - from))];
    for (count, what) in [
        (times.duplicates, "with the time of the row before"),
        (times.went_back, "where it goes back"),
        (times.not_finite, "where it is not finite"),
    ] {
        if count > 0 {
            lines.push(format!("  time: {} {what}", counted(count, "row")));
        }
    }
    let gaps: Vec<_> = times.gaps().collect();
    for gap in gaps.iter().take(GAPS_SHOWN) {
        lines.push(format!("  gap of {} s from {} s", number(gap.to_s - gap.from_s), number(gap.from_s)));
    }
    if gaps.len() > GAPS_SHOWN {
        lines.push(format!("  further gaps: {}", gaps.len() - GAPS_SHOWN));
    }
    lines
}

/// Samples whose times are out of order, and samples that are missing at the rate of their channel.
fn dropout_lines(recording: &Recording, order: &RowAlignment) -> Vec<String> {
    let tally = order.tally();
    let (reordered, rest) = (tally.reordered, ReorderTally { reordered: 0, ..tally });
    let disorder = format!("{reordered} of {} samples are out of order; latency_s in the run puts them in order", tally.taken);
    let found = Some(disorder).filter(|_| reordered > 0).into_iter().chain(rest.losses()).chain(rest.notes());
    let mut lines: Vec<String> = found.map(|what| format!("  times: {what}")).collect();
    let mut dropouts: Vec<&Dropout> = order.dropouts().iter().collect();
    if dropouts.is_empty() {
        return lines;
    }
    lines.push(format!("  {} with {} missing", counted(tally.dropouts, "dropout"), counted(tally.missing, "sample")));
    dropouts.sort_by(|one, other| other.missing.cmp(&one.missing).then(one.from_s.total_cmp(&other.from_s)));
    for dropout in dropouts.iter().take(GAPS_SHOWN) {
        let name = column_name(recording, dropout.channel);
        lines.push(format!("    {} of {name}, {} to {} s", dropout.missing, number(dropout.from_s), number(dropout.to_s)));
    }
    lines
}

/// The name of a column by its place among channels, then other columns.
pub(super) fn column_name(recording: &Recording, place: usize) -> String {
    if let Some(channel) = Channel::ALL.get(place) {
        return channel.name(recording.info().geometry().controls).to_owned();
    }
    RecordingColumn::others(recording.columns())
        .map(|column| column.name.clone())
        .nth(place - Channel::ALL.len())
        .unwrap_or_default()
}

fn row_lines(recording: &Recording, info: &RunInfo) -> Vec<String> {
    let skipped = recording.skipped().reasons().iter();
    let mut lines: Vec<String> = skipped
        .map(|rows| {
            format!(
                "  skipped {} rows: {}; first at {} {}: {}",
                rows.rows,
                rows.reason.words(),
                recording.counted_in(),
                rows.first,
                rows.example
            )
        })
        .collect();
    lines.extend(assumed_scale(info).map(|note| format!("  {note}")));
    lines.extend(recording.found_out().iter().map(|found| format!("  {found}")));
    lines.extend(recording.shortfall().map(|shortfall| format!("  {shortfall}")));
    if recording.ends_abruptly() && recording.format() == "CSV" {
        lines.push("  the last line has no end: the file may have been cut short, and the last value with it".into());
    }
    lines
}

fn channel_lines(recording: &Recording, info: &RunInfo, survey: &Survey) -> Vec<String> {
    let titles = ["channel", "unit", "samples", "rate Hz", "min", "max", "not finite", "gaps", ""].map(String::from);
    let rows: Vec<_> =
        std::iter::once(titles).chain(survey.columns.iter().map(|column| cells(recording, info, column))).collect();
    let width = |place: usize| rows.iter().filter_map(|row| row.get(place)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..9).map(width).collect();
    let line = |row: &[String; 9]| {
        let mut line = String::new();
        for (place, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            // Words stand on the left of their column, numbers on the right.
            let _ = if matches!(place, 0 | 1 | 8) { write!(line, "  {cell:<width$}") } else { write!(line, "  {cell:>width$}") };
        }
        line
    };
    rows.iter().map(line).collect()
}

fn cells(recording: &Recording, info: &RunInfo, survey: &ColumnSurvey) -> [String; 9] {
    let column = &survey.column;
    // A map may turn the sign or scale: the unit alone counts here.
    let unit = survey.channel().zip(column.unit_text.as_deref());
    let factor = unit.and_then(|(channel, unit)| factor_to_si(unit, channel.quantity()).ok()).unwrap_or(1.0);
    let (least, greatest) = survey
        .range
        .map_or((String::new(), String::new()), |(least, greatest)| (number(least / factor), number(greatest / factor)));
    let count = |count: u64| if count == 0 { "-".into() } else { count.to_string() };
    let gaps = match survey.times.longest_gap_s() {
        None => "-".into(),
        Some(longest) => format!("{} (to {} s)", survey.times.gaps().count(), number(longest)),
    };
    [
        column.name.clone(),
        column.unit_text.clone().unwrap_or_else(|| column.inner_unit().into()),
        survey.samples.to_string(),
        survey.times.rate_hz().map_or("-".into(), |rate| format!("{rate:.1}")),
        least,
        greatest,
        count(survey.not_finite),
        gaps,
        note(recording, info, survey),
    ]
}

fn note(recording: &Recording, info: &RunInfo, survey: &ColumnSurvey) -> String {
    let controls = recording.info().geometry().controls;
    match survey.channel() {
        None => {
            let name = &survey.column.name;
            let known = Channel::ALL.map(|channel| channel.name(controls));
            match known.into_iter().find(|known| known.eq_ignore_ascii_case(name)) {
                Some(known) => format!("not known (`{known}` would be), carried along"),
                None => "not known, carried along".into(),
            }
        }
        Some(_) if survey.samples == 0 => "never sampled".into(),
        Some(_) if survey.range.is_none() => "no finite value".into(),
        Some(_) if !survey.moves() => "never moves".into(),
        Some(channel) if assumed_names(info).iter().any(|name| name == channel.name(controls)) => "scale assumed".into(),
        Some(_) => String::new(),
    }
}

fn estimable_lines(recording: &Recording, estimable: &EstimableQuantities) -> Vec<String> {
    let controls = recording.info().geometry().controls;
    let mut lines = vec!["  What the channels allow to estimate".into()];
    let mut entry = |title: &str, said: Vec<String>| {
        for (place, said) in said.iter().enumerate() {
            let (title, indent) = if place == 0 { (title, "") } else { ("", "    ") };
            lines.push(format!("    {title:<12}  {indent}{said}"));
        }
    };
    entry("state", verdict(&estimable.state));
    entry("  aided by", listed(&estimable.aids));
    if !estimable.aids_missing.is_empty() {
        entry("  without", listed(&estimable.aids_missing));
    }
    for (force, title) in [(true, "X Y Z"), (false, "L M N")] {
        let axes: Vec<&Feasibility<Axis>> = estimable.axes.iter().filter(|axis| axis.what.is_force() == force).collect();
        match axes.first() {
            Some(first) if axes.iter().all(|axis| axis.reasons == first.reasons) => entry(title, verdict(first)),
            _ => axes.iter().for_each(|axis| entry(axis.what.name(), verdict(axis))),
        }
    }
    let with: Vec<_> =
        estimable.variables.iter().filter(|answer| answer.possible).map(|answer| answer.what.name(controls)).collect();
    entry("  by", listed(&with));
    for answer in estimable.variables.iter().filter(|answer| !answer.reasons.is_empty()) {
        let title = if answer.possible { "  weakly by" } else { "  not by" };
        entry(title, vec![format!("{}: {}", answer.what.name(controls), answer.reasons.join("; "))]);
    }
    entry("Dutch roll", verdict(&estimable.dutch_roll));
    lines
}

fn listed(names: &[&str]) -> Vec<String> {
    vec![if names.is_empty() { "nothing".into() } else { names.join(" ") }]
}

/// Yes or no with the first reason, then a line for each further one.
fn verdict<T>(answer: &Feasibility<T>) -> Vec<String> {
    let word = if answer.possible { "yes" } else { "no" };
    match answer.reasons.split_first() {
        None => vec![word.into()],
        Some((first, more)) => {
            let joint = if answer.possible { "yes, but" } else { "no:" };
            std::iter::once(format!("{joint} {first}")).chain(more.iter().cloned()).collect()
        }
    }
}

fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Six significant digits; powers of ten where the number is very small or large.
fn number(value: f64) -> String {
    let magnitude = libm::fabs(value);
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e9).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    let decimals = decimals(magnitude, 6, 9);
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_six_digits_that_count() {
        for (value, text) in [
            (0.0, "0"),
            (25.0, "25"),
            (129.466_4, "129.466"),
            (-0.056_363, "-0.056363"),
            (1_234_567.0, "1234567"),
            (0.1 + 0.2, "0.3"),
            (1.5e-7, "1.5000e-7"),
            (f64::MAX, "1.7977e308"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
