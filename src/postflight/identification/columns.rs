//! A run as named columns over time, as deviations from its own trim.
//!
//! Consumes the rows of a recording, the positions of its instruments, and the trim window; produces columns by name (SI, NaN
//! where a channel was not sampled) and trim values (means over the window). Inputs are needed at every time: they are linear
//! between their own samples, as everywhere in the program.

use super::resting_controls::hold_resting;
use crate::flight::run::{AircraftProperties, RunGeometry};
use crate::flight::signal::GAP_S;

/// Columns of one run.
#[derive(Clone, Debug)]
pub struct Columns {
    /// Name of the run.
    pub run: String,
    /// Positions of its instruments.
    pub geometry: RunGeometry,
    /// Mass, inertia and reference dimensions; none unless they are set.
    pub properties: AircraftProperties,
    /// When it was recorded, where the run states it; none unless it is set.
    pub recorded_at: Option<String>,
    /// Times of the rows, s, increasing.
    pub times_s: Vec<f64>,
    /// Controls that are commands by a scale that nobody stated.
    pub assumed_scale: Vec<String>,
    names: Vec<String>,
    /// As recorded, by column; NaN where not sampled.
    values: Vec<Vec<f64>>,
    trim_window_s: f64,
}

/// Why a run is refused, or a column cannot be used as a series.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum ColumnError {
    #[error("{run}: expected time that increases, found {before_s} s and then {time_s} s")]
    TimeOrder { run: String, before_s: f64, time_s: f64 },
    #[error("{run}: expected a column `{name}`, found {found}")]
    Missing { run: String, name: String, found: String },
    #[error("{run}: `{name}` has no sample in the first {window_s} s, where the trim is taken")]
    NoTrim { run: String, name: String, window_s: f64 },
    #[error("{run}: `{name}` is not sampled from {from_s} s to {to_s} s; expected no gap longer than {GAP_S} s")]
    Gap { run: String, name: String, from_s: f64, to_s: f64 },
    #[error("{run}: `{name}` is {value} at {time_s} s")]
    NotFinite { run: String, name: String, value: f64, time_s: f64 },
}

impl Columns {
    /// Columns of a run; a cell that was not sampled is NaN.
    ///
    /// # Errors
    /// [`ColumnError`] where time does not increase or a value is infinite.
    pub fn new(
        run: String,
        geometry: RunGeometry,
        times_s: Vec<f64>,
        columns: Vec<(String, Vec<f64>)>,
        trim_window_s: f64,
    ) -> Result<Self, ColumnError> {
        for (&before_s, &time_s) in times_s.iter().zip(times_s.iter().skip(1)) {
            if !(time_s > before_s) {
                return Err(ColumnError::TimeOrder { run, before_s, time_s });
            }
        }
        for (name, values) in &columns {
            if let Some((&time_s, &value)) = times_s.iter().zip(values).find(|(_, value)| value.is_infinite()) {
                return Err(ColumnError::NotFinite { run, name: name.clone(), value, time_s });
            }
        }
        let (names, values) = columns.into_iter().unzip();
        Ok(Columns {
            run,
            geometry,
            properties: AircraftProperties::default(),
            recorded_at: None,
            times_s,
            assumed_scale: Vec::new(),
            names,
            values,
            trim_window_s,
        })
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether there is such a column with any sample in it.
    pub fn has(&self, name: &str) -> bool {
        self.raw(name).is_ok_and(|values| values.iter().any(|value| value.is_finite()))
    }

    /// Samples a second of a column, by the median interval; `None` with fewer than two.
    pub fn rate_hz(&self, name: &str) -> Option<f64> {
        let values = self.raw(name).ok()?;
        let known = self.times_s.iter().zip(values).filter(|(_, value)| value.is_finite());
        let times_s: Vec<f64> = known.map(|(time_s, _)| *time_s).collect();
        let mut intervals_s: Vec<f64> = times_s.iter().zip(times_s.iter().skip(1)).map(|(one, next)| next - one).collect();
        intervals_s.sort_by(f64::total_cmp);
        intervals_s.get(intervals_s.len() / 2).map(|interval_s| 1.0 / interval_s)
    }

    /// Whether both hold the same values at the same times.
    pub fn is_same_recording(&self, other: &Columns) -> bool {
        let same = |one: &[f64], other: &[f64]| {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| one.to_bits() == other.to_bits())
        };
        same(&self.times_s, &other.times_s)
            && self.values.len() == other.values.len()
            && self.values.iter().zip(&other.values).all(|(one, other)| same(one, other))
    }

    /// As recorded; NaN where not sampled.
    ///
    /// # Errors
    /// [`ColumnError::Missing`] where there is no such column.
    pub fn raw(&self, name: &str) -> Result<&[f64], ColumnError> {
        let place = self.names.iter().position(|known| known == name);
        place.and_then(|place| self.values.get(place)).map(Vec::as_slice).ok_or_else(|| ColumnError::Missing {
            run: self.run.clone(),
            name: name.to_owned(),
            found: self.names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
        })
    }

    /// Its mean over the trim's window.
    ///
    /// # Errors
    /// [`ColumnError`] where there is no such column, or no sample of it there.
    pub fn trim(&self, name: &str) -> Result<f64, ColumnError> {
        let values = self.raw(name)?;
        let (mut sum, mut count) = (0.0, 0.0);
        for (_, value) in self.in_trim(values) {
            sum += value;
            count += 1.0;
        }
        if count > 0.0 {
            Ok(sum / count)
        } else {
            Err(ColumnError::NoTrim { run: self.run.clone(), name: name.to_owned(), window_s: self.trim_window_s })
        }
    }

    /// Standard error of that mean, from the scatter in its window, neighbours taken as independent; zero of fewer than two
    /// samples or none.
    pub fn trim_std(&self, name: &str) -> f64 {
        let (Ok(values), Ok(mean)) = (self.raw(name), self.trim(name)) else { return 0.0 };
        let (mut sum, mut count) = (0.0, 0.0);
        for (_, value) in self.in_trim(values) {
            sum += (value - mean) * (value - mean);
            count += 1.0;
        }
        if count > 1.0 { libm::sqrt(sum / (count * (count - 1.0))) } else { 0.0 }
    }

    /// How many rows are in the trim's window.
    pub fn trim_rows(&self) -> usize {
        let end_s = self.times_s.first().map_or(f64::NAN, |first_s| first_s + self.trim_window_s);
        self.times_s.partition_point(|time_s| *time_s <= end_s)
    }

    /// Times and values of those rows that are sampled.
    fn in_trim<'v>(&'v self, values: &'v [f64]) -> impl Iterator<Item = (f64, f64)> + Clone + 'v {
        let rows = self.times_s.iter().copied().zip(values.iter().copied()).take(self.trim_rows());
        rows.filter(|(_, value)| value.is_finite())
    }

    /// Slope of a straight line through its samples in the trim's window, a second; NaN where there are too few.
    pub fn trim_slope(&self, name: &str) -> f64 {
        let Ok(values) = self.raw(name) else { return f64::NAN };
        let known = self.in_trim(values);
        let (t, x, count) =
            known.clone().fold((0.0, 0.0, 0.0), |(t, x, count), (time_s, value)| (t + time_s, x + value, count + 1.0));
        let (tt, tx) = known.fold((0.0, 0.0), |(tt, tx), (time_s, value)| {
            let from = time_s - t / count;
            (tt + from * from, tx + from * (value - x / count))
        });
        if tt > 0.0 { tx / tt } else { f64::NAN }
    }

    /// Deviations from trim; NaN where not sampled.
    ///
    /// # Errors
    /// As for [`Columns::trim`].
    pub fn deviations(&self, name: &str) -> Result<Vec<f64>, ColumnError> {
        let trim = self.trim(name)?;
        Ok(self.raw(name)?.iter().map(|value| value - trim).collect())
    }

    /// Deviations from trim at every row, linear between samples, constant before the first and after the last for at most
    /// [`GAP_S`].
    ///
    /// # Errors
    /// As for [`Columns::trim`], and [`ColumnError::Gap`].
    pub fn lines(&self, name: &str) -> Result<Vec<f64>, ColumnError> {
        self.joined(name, self.deviations(name)?)
    }

    /// The same of a control, at its mean where samples differ by noise only: see `resting_controls`.
    ///
    /// # Errors
    /// As for [`Columns::lines`].
    pub fn held(&self, name: &str) -> Result<Vec<f64>, ColumnError> {
        let mut values = self.deviations(name)?;
        hold_resting(&self.times_s, &mut values);
        self.joined(name, values)
    }

    fn joined(&self, name: &str, mut values: Vec<f64>) -> Result<Vec<f64>, ColumnError> {
        let known: Vec<(usize, f64, f64)> = values
            .iter()
            .zip(&self.times_s)
            .enumerate()
            .filter(|(_, (value, _))| value.is_finite())
            .map(|(place, (&value, &time_s))| (place, time_s, value))
            .collect();
        let gap = |from_s: f64, to_s: f64| ColumnError::Gap { run: self.run.clone(), name: name.to_owned(), from_s, to_s };
        let (Some(&(first, first_s, at_first)), Some(&(last, last_s, at_last))) = (known.first(), known.last()) else {
            return Ok(values);
        };
        let ends = (self.times_s.first().copied().unwrap_or(first_s), self.times_s.last().copied().unwrap_or(last_s));
        if first_s - ends.0 > GAP_S {
            return Err(gap(ends.0, first_s));
        }
        if ends.1 - last_s > GAP_S {
            return Err(gap(last_s, ends.1));
        }
        values.iter_mut().take(first).for_each(|value| *value = at_first);
        values.iter_mut().skip(last + 1).for_each(|value| *value = at_last);
        for (&(from, from_s, x0), &(to, to_s, x1)) in known.iter().zip(known.iter().skip(1)) {
            if to_s - from_s > GAP_S {
                return Err(gap(from_s, to_s));
            }
            for (value, time_s) in values.iter_mut().zip(&self.times_s).take(to).skip(from + 1) {
                *value = x0 + (x1 - x0) * ((time_s - from_s) / (to_s - from_s));
            }
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(times_s: &[f64], values: &[f64]) -> Columns {
        let geometry = RunGeometry::DEFAULT;
        Columns::new("a".to_owned(), geometry, times_s.to_vec(), vec![("p".to_owned(), values.to_vec())], 0.15).unwrap()
    }

    #[test]
    fn what_was_not_sampled_is_on_the_line_between_its_neighbours() {
        let nan = f64::NAN;
        let run = columns(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5], &[1.0, 3.0, nan, 7.0, nan, nan]);
        assert_eq!(run.trim("p"), Ok(2.0));
        assert!((run.trim_std("p") - 1.0).abs() < 1e-12 && run.trim_std("q").abs() < 1e-12);
        assert_eq!(run.trim_rows(), 2);
        let lines = run.lines("p").unwrap();
        assert!(
            lines.iter().zip([-1.0, 1.0, 3.0, 5.0, 5.0, 5.0]).all(|(found, known)| (found - known).abs() < 1e-12),
            "{lines:?}"
        );
    }

    #[test]
    fn a_gap_a_missing_column_and_an_empty_trim_are_errors_with_names() {
        let nan = f64::NAN;
        let run = columns(&[0.0, 0.1, 0.8, 0.9], &[1.0, 1.0, 2.0, 2.0]);
        assert_eq!(
            run.lines("p").unwrap_err().to_string(),
            "a: `p` is not sampled from 0.1 s to 0.8 s; expected no gap longer than 0.5 s"
        );
        assert_eq!(run.raw("q").unwrap_err().to_string(), "a: expected a column `q`, found `p`");
        assert!(matches!(columns(&[0.0, 0.1, 0.2], &[nan, nan, 1.0]).trim("p"), Err(ColumnError::NoTrim { .. })));
        let backwards = Columns::new("a".to_owned(), RunGeometry::DEFAULT, vec![0.0, 0.0], Vec::new(), 1.0);
        assert!(matches!(backwards, Err(ColumnError::TimeOrder { .. })));
    }
}
