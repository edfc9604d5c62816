//! A table: named columns over time, records one after another.
//!
//! Consumes records, each with its own times and the same columns; produces columns over all rows, and which rows of which
//! record are used. A value that was not sampled is not a number, and its row is used by no term that needs it.

/// Named columns over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RegressionTable {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    time_s: Vec<f64>,
    starts: Vec<usize>,
}

/// Why a record does not fit into a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum TableError {
    #[error("column `{column}`: expected {expected} rows, found {found}")]
    Length { column: String, expected: usize, found: usize },
    #[error("record {record}: expected the columns {expected:?}, found {found:?}")]
    Columns { record: usize, expected: Vec<String>, found: Vec<String> },
    #[error("column `{column}` comes twice")]
    Twice { column: String },
    #[error("record {record}: time does not increase at row {row}")]
    Time { record: usize, row: usize },
}

impl RegressionTable {
    /// A table without records.
    pub fn new() -> Self {
        RegressionTable::default()
    }

    /// Adds a record: its times and its columns in any order, all of one length.
    ///
    /// # Errors
    /// [`TableError`] where it does not fit; the table is then as before.
    pub fn add_record(&mut self, time_s: &[f64], columns: &[(&str, &[f64])]) -> Result<(), TableError> {
        let record = self.starts.len() + 1;
        for (place, (name, values)) in columns.iter().enumerate() {
            if values.len() != time_s.len() {
                return Err(TableError::Length { column: (*name).into(), expected: time_s.len(), found: values.len() });
            }
            if columns.iter().take(place).any(|(other, _)| other == name) {
                return Err(TableError::Twice { column: (*name).into() });
            }
        }
        if let Some(row) = time_s.windows(2).position(|pair| !(pair[1] > pair[0])) {
            return Err(TableError::Time { record, row: row + 2 });
        }
        if self.starts.is_empty() {
            self.names = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
            self.columns = vec![Vec::new(); columns.len()];
        }
        let find = |name: &String| columns.iter().find(|(other, _)| other == name);
        if columns.len() != self.names.len() || !self.names.iter().all(|name| find(name).is_some()) {
            let found = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
            return Err(TableError::Columns { record, expected: self.names.clone(), found });
        }
        self.starts.push(self.time_s.len());
        self.time_s.extend_from_slice(time_s);
        for (name, column) in self.names.iter().zip(&mut self.columns) {
            if let Some((_, values)) = find(name) {
                column.extend_from_slice(values);
            }
        }
        Ok(())
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The column of that name; `time` is a column as well.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        match self.names.iter().position(|other| other == name) {
            Some(place) => self.columns.get(place).map(Vec::as_slice),
            None if name == "time" => Some(&self.time_s),
            None => None,
        }
    }

    /// Times of all rows, each record's own, s.
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// Rows of all records.
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// Records.
    pub fn records(&self) -> usize {
        self.starts.len()
    }

    /// Rows of one record, from 0.
    pub fn rows_of(&self, record: usize) -> std::ops::Range<usize> {
        let start = self.starts.get(record).copied().unwrap_or(self.rows());
        start..self.starts.get(record + 1).copied().unwrap_or(self.rows())
    }

    /// A mask of every row.
    pub fn whole(&self) -> Vec<bool> {
        vec![true; self.rows()]
    }

    /// A mask of the rows of one record between two of its times, both included, s.
    pub fn window(&self, record: usize, from_s: f64, to_s: f64) -> Vec<bool> {
        let of_record = self.rows_of(record);
        let inside = |(row, &time_s): (usize, &f64)| of_record.contains(&row) && time_s >= from_s && time_s <= to_s;
        self.time_s.iter().enumerate().map(inside).collect()
    }

    /// A mask of the rows from which on, to the end of the record, each column stays within its half width of its last value:
    /// free responses, where the columns are controls.
    ///
    /// # Errors
    /// The name of a column that the table does not have.
    pub fn still<'a>(&self, controls: &[(&'a str, f64)]) -> Result<Vec<bool>, &'a str> {
        let mut rows = vec![true; self.rows()];
        for (name, half_width) in controls {
            let column = self.column(name).ok_or(*name)?;
            for record in 0..self.records() {
                let range = self.rows_of(record);
                let Some(&last) = column.get(range.clone()).and_then(<[f64]>::last) else { continue };
                let mut free = true;
                for row in range.rev() {
                    free &= libm::fabs(column[row] - last) <= *half_width;
                    rows[row] &= free;
                }
            }
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_stand_one_after_another_whatever_the_order_of_their_columns() {
        let mut table = RegressionTable::new();
        table.add_record(&[0.0, 0.1], &[("v", &[1.0, 2.0]), ("p", &[3.0, 4.0])]).unwrap();
        table.add_record(&[5.0, 5.1, 5.2], &[("p", &[6.0, 7.0, 8.0]), ("v", &[9.0, 9.0, 9.0])]).unwrap();
        assert_eq!(table.column("p"), Some(&[3.0, 4.0, 6.0, 7.0, 8.0][..]));
        assert_eq!((table.rows(), table.records(), table.rows_of(1)), (5, 2, 2..5));
        assert_eq!(table.window(1, 5.05, 9.0), [false, false, false, true, true]);
        assert_eq!(table.still(&[("p", 1.1)]), Ok(vec![true, true, false, true, true]));
        assert_eq!(table.still(&[("beta", 0.0)]), Err("beta"));
    }

    #[test]
    fn a_record_that_does_not_fit_changes_nothing() {
        let mut table = RegressionTable::new();
        table.add_record(&[0.0, 0.1], &[("v", &[1.0, 2.0])]).unwrap();
        let before = table.clone();
        for (time_s, columns, words) in [
            (&[0.0, 1.0][..], &[("v", &[1.0][..])][..], "column `v`: expected 2 rows, found 1"),
            (&[0.0], &[("p", &[1.0])], "record 2: expected the columns"),
            (&[0.0], &[("v", &[1.0]), ("v", &[1.0])], "comes twice"),
            (&[1.0, 1.0], &[("v", &[1.0, 2.0])], "record 2: time does not increase at row 2"),
        ] {
            let error = table.add_record(time_s, columns).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
            assert_eq!(table, before);
        }
    }
}
