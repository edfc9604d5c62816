//! A map written for the user: what the headers of a table probably mean, to be checked.
//!
//! Consumes the first lines of a file; produces a map in TOML that [`super::map_file`] reads once every unit is there. A unit
//! that the header does not state is left as `?`, which is refused; every guess is marked in a comment. Where two columns
//! look like one channel, the second is a comment.

use super::header_guess::{HeaderGuess, guess_in};
use super::unit_text::{name_and_unit, quantity_of, unit_of, units_of};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::file::time_stamp::{DateOrder, TimeStamp};
use crate::flight::unit::{Quantity, factor_to_si};
use crate::io::telemetry::table::cell::{bare, header_text, number_of};
use crate::io::telemetry::table::clock::{median_step, unit_by_step};
use crate::io::telemetry::table::layout::{TableLayout, cells, unit_row};
use std::collections::HashSet;
use std::fmt::Write;

/// How a quaternion stands in a table.
const QUATERNION: [&str; 4] = ["q[0]", "q[1]", "q[2]", "q[3]"];
/// Columns without a guess that are listed.
const LISTED: usize = 200;

/// The map of one table, by its name in messages and its first lines.
pub fn of_table(name: &str, first: &[u8]) -> String {
    let mut text = head(name);
    let section = SectionTemplate::of(first);
    text.push_str(&section.layout_lines());
    section.write(&mut text, ("", ""), &mut HashSet::new());
    text.push_str(RUN);
    text
}

/// The map of a recording in several tables, each with its name and first lines.
pub fn of_files(name: &str, files: &[(String, Vec<u8>)]) -> String {
    let mut text = head(name);
    let (mut taken, mut without) = (HashSet::new(), Vec::new());
    let begin = common_begin(&files.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>());
    for (name, first) in files {
        let section = SectionTemplate::of(first);
        let ends = name.get(begin..).unwrap_or(name);
        if !section.has_channels(ends) {
            without.push(format!("#   {}: {}", quoted(ends), section.headers.join(" ").escape_debug()));
            continue;
        }
        let _ = writeln!(text, "\n[[file]]\nends = {}", quoted(ends));
        text.push_str(&section.layout_lines());
        section.write(&mut text, ("file.", ends), &mut taken);
    }
    if !without.is_empty() {
        let _ = writeln!(text, "\n# files without a guess, and their columns:\n{}", without.join("\n"));
    }
    text.push_str(RUN);
    text
}

/// How many bytes the names have in common at their beginning, up to the last `_`, `-` or `.` before a difference.
fn common_begin(names: &[&str]) -> usize {
    let Some(first) = names.first() else { return 0 };
    let common = |length: &usize| first.get(..*length).is_some_and(|begin| names.iter().all(|name| name.starts_with(begin)));
    let begins = first.char_indices().filter(|(_, letter)| ['_', '-', '.'].contains(letter)).map(|(at, _)| at);
    let longest = begins.filter(common).max().unwrap_or(0);
    if names.len() > 1 { longest } else { 0 }
}

const RUN: &str = "\n[run]                            # keys of the run, as in the head of a run file\n# aircraft = \"...\"\n\
                   # vane_position_m = [x, y, z]    # of the vanes from the centre of mass, m\n";

fn head(name: &str) -> String {
    format!(
        "# Map of {}: which column is which channel. Guesses by the headers: check every line, fill in units that are `?`, then\n\
         #   sideslip inspect FILE --map THIS        (and --map THIS for every other command)\n\
         # A channel in SI is sign * scale * unit * column. Axes: x forward, y right, z down; ax ay az as accelerometers read.\n\
         # A channel: NAME = \"column\", or NAME = {{ column = \"...\", unit = \"deg\", sign = -1, scale = 0.5 }}.\n",
        name.chars().filter(|letter| !letter.is_control()).collect::<String>()
    )
}

/// What the first lines of a table show.
struct SectionTemplate {
    layout: TableLayout,
    header_line: usize,
    headers: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl SectionTemplate {
    fn of(first: &[u8]) -> Self {
        let first = first.strip_prefix(&[0xEF, 0xBB, 0xBF]).unwrap_or(first);
        let all: Vec<&[u8]> = first.split(|byte| *byte == b'\n').collect();
        let at = header_at(&all);
        let lines: Vec<&[u8]> = all.iter().skip(at).copied().filter(|line| !line.trim_ascii().is_empty()).collect();
        let layout = TableLayout::of(&lines, None, None);
        let texts = |line: &[u8]| cells(line, layout.separator).iter().map(|cell| header_text(cell).0).collect::<Vec<_>>();
        let mut headers = lines.first().map(|line| texts(line)).unwrap_or_default();
        if let Some(header) = headers.first_mut() {
            *header = header.trim_start_matches(['#', '%']).trim_start().to_owned();
        }
        let units = unit_row(&lines, layout);
        if let Some(units) = &units {
            for (header, (unit, _)) in headers.iter_mut().zip(units.iter().map(header_text)) {
                if !unit.is_empty() {
                    header.push_str(&format!(" [{}]", unit.trim_matches(['[', ']', '(', ')'])));
                }
            }
        }
        let rows = lines.iter().skip(if units.is_some() { 2 } else { 1 }).map(|line| texts(line)).collect();
        SectionTemplate { layout, header_line: at + 1, headers, rows }
    }

    fn has_quaternion(&self) -> bool {
        QUATERNION.iter().all(|part| self.headers.iter().any(|header| header == part))
    }

    /// Whether a column looks like a channel.
    fn has_channels(&self, context: &str) -> bool {
        let is_channel = |header: &String| guess_in(context, header).is_some_and(|found| found.name != "time");
        self.has_quaternion() || self.headers.iter().any(is_channel)
    }

    fn layout_lines(&self) -> String {
        let mut text = String::new();
        let separator =
            if self.layout.separator == b'\t' { "tab".to_owned() } else { char::from(self.layout.separator).to_string() };
        let _ = writeln!(text, "separator = {:<20} # found out", quoted(&separator));
        let _ = writeln!(text, "decimal = {:<22} # found out", quoted(&char::from(self.layout.decimal).to_string()));
        if self.header_line > 1 {
            let _ = writeln!(text, "header_line = {:<18} # found out", self.header_line);
        }
        text
    }

    /// The time and the channels; `taken` are channels that other sections have.
    fn write(&self, text: &mut String, (prefix, context): (&str, &str), taken: &mut HashSet<&'static str>) {
        let guesses: Vec<Option<HeaderGuess>> = self.headers.iter().map(|header| guess_in(context, header)).collect();
        text.push_str(&self.time_line(&guesses));
        let _ = writeln!(text, "\n[{prefix}channels]");
        if self.has_quaternion() && ["phi", "theta", "psi"].map(|name| taken.insert(name)) == [true; 3] {
            let quaternion = QUATERNION.map(quoted).join(", ");
            let _ = writeln!(text, "attitude = [{quaternion}]  # guess: w, x, y, z; body axes into north, east, down");
        }
        let mut naming = None;
        let mut without = Vec::new();
        for (place, (header, found)) in self.headers.iter().zip(&guesses).enumerate() {
            if found.is_some_and(|found| found.name == "time") {
                continue;
            }
            let Some(found) = found else {
                without.push(self.column_words(place, header));
                continue;
            };
            let own = Channel::from_name(found.name).and_then(|(_, naming)| naming);
            let fits = own.is_none() || *naming.get_or_insert(own) == own;
            // A true airspeed is preferred to one that may be the indicated.
            let is_surer = |other: &HeaderGuess| other.name == found.name && other.doubt.is_none();
            let is_surpassed = found.doubt.is_some() && guesses.iter().flatten().any(is_surer);
            let is_first = fits && !is_surpassed && taken.insert(found.name);
            let (line, comment) = channel_line(header, &found.with_sign_of(&self.numbers(place)));
            let mark = if is_first { "" } else { "# " };
            let again = if is_first { "" } else { "also looks like it; " };
            let _ = writeln!(text, "{mark}{line:<48} # {again}{comment}");
        }
        if !without.is_empty() {
            let _ = writeln!(text, "# columns without a guess:");
            for column in without.iter().take(LISTED) {
                let _ = writeln!(text, "#   {column}");
            }
        }
        if !prefix.is_empty() {
            return;
        }
        let missing: Vec<&str> = Channel::ALL
            .iter()
            .take(crate::flight::channel::MOTION_CHANNELS)
            .map(|channel| channel.name(ControlNames::default()))
            .filter(|name| !taken.contains(name))
            .collect();
        if !missing.is_empty() {
            let _ = writeln!(text, "# channels not found: {}", missing.join(" "));
        }
    }

    fn column_words(&self, place: usize, header: &str) -> String {
        let value = self.rows.first().and_then(|row| row.get(place)).map_or("", |cell| cell.trim());
        let shown: String = value.chars().filter(|letter| !letter.is_control()).take(30).collect();
        format!("{}  (first value {shown})", quoted(header))
    }

    fn time_line(&self, guesses: &[Option<HeaderGuess>]) -> String {
        let place = guesses.iter().position(|found| found.is_some_and(|found| found.name == "time"));
        let grows = |place: &usize| median_step(&self.numbers(*place)).is_some_and(|(_, count)| count + 1 == self.rows.len());
        let place = place.or_else(|| (0..self.headers.len()).find(grows));
        let Some((place, header)) = place.and_then(|place| Some((place, self.headers.get(place)?))) else {
            return "time = \"?\"                         # no column looks like a time: put its header here\n".to_owned();
        };
        let stated = name_and_unit(header).1.and_then(unit_of).filter(|unit| factor_to_si(unit, Quantity::Time).is_ok());
        let is_read = |order| {
            let stamp = |row: &Vec<String>| TimeStamp::parse_ordered(row.get(place)?.trim(), order);
            // The last row may be cut.
            let whole = self.rows.len().max(2) - 1;
            !self.rows.is_empty() && self.rows.iter().take(whole).all(|row| stamp(row).is_some())
        };
        let dates = [DateOrder::Unknown, DateOrder::DayMonthYear, DateOrder::MonthDayYear].map(is_read);
        let (format, comment) = match (dates, stated, median_step(&self.numbers(place))) {
            ([true, ..], ..) => ("format = \"iso8601\"".to_owned(), "by its cells".to_owned()),
            ([_, true, true], ..) => ("format = \"?\"".to_owned(), "DAY OR MONTH FIRST NOT STATED (dmy, mdy)".to_owned()),
            ([_, true, _], ..) => ("format = \"dmy\"".to_owned(), "by its cells".to_owned()),
            ([.., true], ..) => ("format = \"mdy\"".to_owned(), "by its cells".to_owned()),
            (_, Some(unit), _) => (format!("unit = \"{unit}\""), format!("the header states {unit}")),
            (_, None, Some((step, _))) => match unit_by_step(step).filter(|_| !(0.3..3.0).contains(&step)) {
                Some((unit, _)) => (format!("unit = \"{unit}\""), format!("guess: rows are {step} apart; not stated")),
                None => ("unit = \"?\"".to_owned(), format!("UNIT NOT STATED (s, ms, us, ns): rows are {step} apart")),
            },
            (_, None, None) => ("unit = \"?\"".to_owned(), "UNIT NOT STATED (s, ms, us, ns)".to_owned()),
        };
        format!("time = {{ column = {}, {format} }}  # {comment}\n", quoted(header))
    }

    fn numbers(&self, place: usize) -> Vec<f64> {
        let cell = |row: &Vec<String>| number_of(bare(row.get(place)?.as_bytes()), self.layout.decimal).ok()?;
        self.rows.iter().filter_map(cell).collect()
    }
}

/// A channel's line, and what to check.
fn channel_line(header: &str, found: &HeaderGuess) -> (String, String) {
    let expected = quantity_of(found.name).map_or("", units_of);
    let sign = if found.negative { ", sign = -1" } else { "" };
    let column = quoted(header);
    let (line, unit) = match (found.unit, name_and_unit(header).1) {
        (Some(unit), _) if sign.is_empty() => (format!("{} = {column}", found.name), format!("guess; the header states {unit}")),
        (Some(unit), _) => {
            (format!("{} = {{ column = {column}{sign} }}", found.name), format!("guess; the header states {unit}"))
        }
        (None, Some(other)) => (
            format!("{} = {{ column = {column}, unit = \"?\"{sign} }}", found.name),
            format!("guess; the header says `{other}`: UNIT ({expected}) and scale to be said"),
        ),
        (None, None) => (
            format!("{} = {{ column = {column}, unit = \"?\"{sign} }}", found.name),
            format!("guess; UNIT NOT STATED ({expected})"),
        ),
    };
    let doubt = found.doubt.map(|doubt| format!("; {doubt}")).unwrap_or_default();
    (line, format!("{}{doubt}", unit.chars().filter(|letter| !letter.is_control()).collect::<String>()))
}

/// The line of the header, from 0: the first of words that the next has as many cells as.
fn header_at(lines: &[&[u8]]) -> usize {
    let is_header = |place: &usize| {
        let (Some(line), Some(next)) = (lines.get(*place), lines.get(place + 1)) else { return false };
        let layout = TableLayout::of(&[line, next], None, None);
        let record = cells(line, layout.separator);
        let words = record.iter().filter(|cell| !bare(cell).is_empty() && number_of(cell, layout.decimal).is_err()).count();
        record.len() > 1 && record.len() == cells(next, layout.separator).len() && 2 * words > record.len()
    };
    (0..lines.len()).find(is_header).unwrap_or(0)
}

/// A text in quotes, as TOML takes it.
fn quoted(text: &str) -> String {
    let escaped = text.chars().flat_map(|letter| match letter {
        '"' | '\\' => vec!['\\', letter],
        letter if letter.is_control() => vec![' '],
        letter => vec![letter],
    });
    format!("\"{}\"", escaped.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::telemetry::channel_map::map_file::ChannelMap;

    #[test]
    fn a_template_is_a_map_once_its_units_are_said() {
        let first = "Flight 12\n\"Time\";\"Roll Rate [deg/s]\";\"nz [g]\";\"Pitch\";\"gear\";\"Roll Rate 2 [deg/s]\";\"p\"\n\
                     0;1,5;1,0;2;0;1;3\n10;1,5;1,0;2;0;1;3\n20;1,5;1,0;2;0;1;3\n";
        let map = of_table("x.csv", first.as_bytes());
        for words in [
            "separator = \";\"",
            "decimal = \",\"",
            "header_line = 2",
            "time = { column = \"Time\", unit = \"ms\" }  # guess: rows are 10 apart; not stated",
            "p = \"Roll Rate [deg/s]\"",
            "az = { column = \"nz [g]\", sign = -1 }",
            "positive upward by what it reads, az is positive down",
            "theta = { column = \"Pitch\", unit = \"?\" }",
            "# guess; UNIT NOT STATED (rad, deg)",
            "#   \"gear\"  (first value 0)",
            "# p = { column = \"p\", unit = \"?\" }",
            "# channels not found: ax ay q r phi psi tas alpha beta altitude",
        ] {
            assert!(map.contains(words), "{words} is not in\n{map}");
        }
        let down = of_table("x.csv", first.replace(";1,0;2", ";-9,7;2").replace("[g]", "[m/s2]").as_bytes());
        assert!(down.contains("az = \"nz [m/s2]\"") && down.contains("positive down by what it reads, as az is"), "{down}");
        let dated = |cell: &str| of_table("x.csv", format!("UTC;p\n{cell};1\n{cell};2\n").as_bytes());
        for (cell, format) in [
            ("17.05.2024 09:30:01,5", "format = \"iso8601\" }  # by its cells"),
            ("05/17/2024 9:30:01 AM", "format = \"mdy\" }  # by its cells"),
            ("05/06/2024 9:30:01 AM", "format = \"?\" }  # DAY OR MONTH FIRST NOT STATED (dmy, mdy)"),
        ] {
            assert!(dated(cell).contains(format), "{}", dated(cell));
        }
        let serial = of_table("x.csv", b"Time [days];p [deg/s]\n45000,5;1\n45000,6;1\n");
        assert!(serial.contains("time = { column = \"Time [days]\", unit = \"day\" }  # the header states day"), "{serial}");
        let refused = ChannelMap::from_toml(&map).unwrap_err();
        assert!(refused.what.contains("is theta (rad, deg, ...), found `?`"), "{refused}");
        let read = ChannelMap::from_toml(&map.replace("\"?\"", "\"deg\"")).unwrap();
        assert_eq!((read.sections[0].header_line, read.sections[0].channels.len()), (Some(2), 3));
    }
}
