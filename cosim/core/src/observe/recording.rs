//! Results in memory, column by column.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::csv::Form;
use super::csv_read;
use super::{CsvRecorder, Observer, RunInfo};
use crate::signals::Table;
use crate::system::Column;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::texts;
use cosim_base::time::Time;

/// Recorded results: the time and one column for each variable.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    names: Vec<String>,
    forms: Vec<Form>,
    /// Empty if no unit is known; not all files contain units.
    units: Vec<String>,
    /// How the file shows that its writer did not finish it.
    unfinished: Option<&'static str>,
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// The newest rows, at most [`BLOCK`], one after another: columns grow in blocks, because each
    /// is in a different place in memory.
    rows: Vec<f64>,
}

/// The same names and values: nothing else is compared.
impl PartialEq for Recording {
    fn eq(&self, other: &Self) -> bool {
        (&self.names, &self.forms, &self.time, &self.columns, &self.rows)
            == (&other.names, &other.forms, &other.time, &other.columns, &other.rows)
    }
}

/// Number of rows in a block.
const BLOCK: usize = 16;

impl Recording {
    /// A recording without values.
    pub fn new() -> Self {
        Self::default()
    }

    /// From existing columns, all of the same length as `time`.
    pub fn from_columns(names: Vec<String>, time: Vec<f64>, columns: Vec<Vec<f64>>) -> Self {
        let forms = vec![Form::Real; names.len()];
        Self { names, forms, time, columns, ..Self::default() }
    }

    /// Reads results as CSV whose writer may have been killed: an incomplete last sample is ignored.
    pub fn read_unfinished_csv(file: impl AsRef<Path>) -> Result<Self> {
        csv_read::read_unfinished(file.as_ref())
    }

    /// What is missing, if the writer of the file did not finish it.
    pub fn missing(&self) -> Option<String> {
        let because = self.unfinished?;
        let rest = self.time.last().map_or_else(
            || "no sample is complete".to_owned(),
            |last| format!("there is nothing after t = {last} s"),
        );
        Some(format!("the file ends early, as after a run that was killed ({because}): {rest}"))
    }

    /// From a file that its writer did not finish.
    pub fn unfinished(mut self, because: &'static str) -> Self {
        self.unfinished = Some(because);
        self
    }

    /// The types of the columns.
    pub fn with_forms(mut self, forms: Vec<Form>) -> Self {
        self.forms = forms;
        self
    }

    /// The units of the columns, empty where none is known.
    pub fn with_units(mut self, units: Vec<String>) -> Self {
        self.units = units;
        self
    }

    /// These columns, then others of numbers: names, units and values.
    pub fn with_columns(&self, kept: &[usize], more: Vec<(String, &str, Vec<f64>)>) -> Self {
        let unit = |place: usize| self.units.get(place).cloned().unwrap_or_default();
        let (time, unfinished) = (self.time.clone(), self.unfinished);
        let mut all = Self { time, unfinished, ..Self::default() };
        for &place in kept {
            all.names.push(self.names[place].clone());
            all.forms.push(self.forms[place]);
            all.units.push(unit(place));
            all.columns.push(self.columns[place].clone());
        }
        for (name, unit, values) in more {
            all.names.push(name);
            all.forms.push(Form::Real);
            all.units.push(unit.to_owned());
            all.columns.push(values);
        }
        all
    }

    /// Sets the units of the columns for which they are known.
    pub fn units(&self) -> impl Iterator<Item = (&str, &str)> {
        let all = self.names.iter().zip(&self.units);
        all.map(|(name, unit)| (name.as_str(), unit.as_str())).filter(|(_, unit)| !unit.is_empty())
    }

    /// Whether a column holds Strings, by number ([`texts`]).
    pub fn is_text(&self, name: &str) -> bool {
        let position = self.names.iter().position(|own| own == name);
        position.is_some_and(|position| self.forms[position] == Form::Text)
    }

    /// The position of each column by name; the first one if a name occurs several times.
    pub(super) fn places(&self) -> HashMap<&str, usize> {
        let named = self.names.iter().enumerate().rev();
        named.map(|(place, name)| (name.as_str(), place)).collect()
    }

    /// The type of a column.
    pub fn form_at(&self, place: usize) -> Form {
        self.forms[place]
    }

    /// Whether the column at a position holds Strings.
    pub fn is_text_at(&self, place: usize) -> bool {
        self.forms.get(place) == Some(&Form::Text)
    }

    /// A column of Strings by name.
    pub fn text(&self, name: &str) -> Result<Vec<Arc<str>>> {
        let place = self.place(name)?;
        if self.is_text_at(place) {
            return Ok(self.columns[place].iter().map(|number| texts::text(*number)).collect());
        }
        Err(Error::new(Code::UnknownName, format!("'{name}' holds numbers, not Strings")))
    }

    /// The numbers of the column at a position, also those that a file has as Strings; the first
    /// String that is not a number, and its sample.
    pub(crate) fn numbers(&self, place: usize) -> Result<Cow<'_, [f64]>, (Arc<str>, usize)> {
        let values = self.columns[place].as_slice();
        if !self.is_text_at(place) {
            return Ok(values.into());
        }
        let texts = values.iter().map(|number| texts::text(*number)).enumerate();
        let numbers = texts.map(|(k, text)| csv_read::number_of(&text).ok_or((text, k)));
        numbers.collect::<Result<Vec<f64>, _>>().map(Cow::from)
    }

    /// The column at a position as Strings, by number.
    pub(super) fn strings(&self, place: usize) -> Cow<'_, [f64]> {
        let values = self.columns[place].as_slice();
        match self.is_text_at(place) {
            true => values.into(),
            false => values.iter().map(|value| texts::number(&format!("{value:?}"))).collect(),
        }
    }

    /// Two columns to be compared, and whether they are Strings: numbers that one file has in
    /// quotes are the same numbers.
    pub(super) fn pair<'r>(
        (a, of_a): (&'r Self, usize),
        (b, of_b): (&'r Self, usize),
    ) -> (Cow<'r, [f64]>, Cow<'r, [f64]>, bool) {
        if !(a.is_text_at(of_a) && b.is_text_at(of_b))
            && let (Ok(a), Ok(b)) = (a.numbers(of_a), b.numbers(of_b))
        {
            return (a, b, false);
        }
        (a.strings(of_a), b.strings(of_b), true)
    }

    /// Reads a CSV file with the time in its first column.
    pub fn read_csv(file: impl AsRef<Path>) -> Result<Self> {
        csv_read::read(file.as_ref())
    }

    /// Names of the columns, without `time`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The output instants in seconds.
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    fn place(&self, name: &str) -> Result<usize> {
        self.names.iter().position(|n| n == name).ok_or_else(|| {
            Error::new(Code::UnknownName, format!("'{name}' was not recorded"))
                .maybe_help(names::did_you_mean(name, self.names.iter().map(String::as_str)))
        })
    }

    /// A column of numbers by name.
    pub fn column(&self, name: &str) -> Result<&[f64]> {
        let place = self.place(name)?;
        match self.is_text_at(place) {
            false => Ok(&self.columns[place]),
            true => Err(Error::new(Code::Parameter, format!("'{name}' holds Strings"))
                .why("only numbers can be used here")),
        }
    }

    /// All columns with their names.
    pub fn columns(&self) -> impl Iterator<Item = (&str, &[f64])> {
        self.names.iter().map(String::as_str).zip(self.columns.iter().map(Vec::as_slice))
    }

    /// All columns, as signals for the inputs of an FMU ([`crate::System::single`]).
    pub fn table(&self) -> Table<'_> {
        let numbers = |place: usize| {
            self.numbers(place).map_err(|(text, sample)| {
                format!("{text:?} at t = {} (sample {})", self.time[sample], sample + 1)
            })
        };
        let columns = self.names.iter().enumerate();
        let columns = columns.map(|(place, name)| (name.as_str(), numbers(place))).collect();
        Table { time: self.time(), columns }
    }

    /// Writes CSV in the format of FMPy.
    pub fn write_csv(&self, file: impl AsRef<Path>) -> Result<()> {
        let mut csv = CsvRecorder::create(file)?;
        csv.header(self.names.iter().map(String::as_str), self.forms.clone())?;
        let mut row = vec![0.0; self.columns.len()];
        for (sample, &time) in self.time.iter().enumerate() {
            for (value, column) in row.iter_mut().zip(&self.columns) {
                *value = column[sample];
            }
            csv.row(time, &row)?;
        }
        csv.finish()
    }
}

impl Recording {
    /// Moves the newest rows into their columns, some columns at a time: those of one cache line.
    #[cold]
    fn sort_in(&mut self) {
        const TOGETHER: usize = 8;
        let width = self.columns.len().max(1);
        let mut sorted = [[0.0; BLOCK]; TOGETHER];
        for (part, columns) in self.columns.chunks_mut(TOGETHER).enumerate() {
            let rows = self.rows.chunks_exact(width);
            let count = rows.len();
            for (place, row) in rows.enumerate() {
                for (column, value) in sorted.iter_mut().zip(&row[part * TOGETHER..]) {
                    column[place] = *value;
                }
            }
            for (column, sorted) in columns.iter_mut().zip(&sorted) {
                column.extend_from_slice(&sorted[..count]);
            }
        }
        self.rows.clear();
    }
}

impl Observer for Recording {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        let span = (info.stop - info.start).ns();
        // Only a hint: a wrong guess costs a reallocation, but a run of a year must not allocate
        // all memory at once.
        let samples = (span / info.output_interval.rounded().ns() + 2).clamp(0, 1 << 20);
        self.names = info.columns.iter().map(|c| c.name.clone()).collect();
        self.forms = info.columns.iter().map(|c| Form::of(&c.kind)).collect();
        let unit = |column: &Column| column.unit().unwrap_or_default().to_owned();
        self.units = info.columns.iter().map(unit).collect();
        self.rows.clear();
        self.time = Vec::with_capacity(samples as usize);
        self.columns = info.columns.iter().map(|_| Vec::with_capacity(samples as usize)).collect();
        Ok(())
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        self.time.push(time.seconds());
        self.rows.extend_from_slice(values);
        if self.rows.len() == BLOCK * self.columns.len() {
            self.sort_in();
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        self.sort_in();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_keeps_every_bit() {
        let values = vec![0.1 + 0.2, 1e-320, -0.0, f64::MAX];
        let time = vec![0.0, 1e-9, 0.1, 3e8];
        let recording = Recording::from_columns(vec!["a".into()], time, vec![values]);
        let file = tempfile::NamedTempFile::new().unwrap();
        recording.write_csv(file.path()).unwrap();
        let read = Recording::read_csv(file.path()).unwrap();
        let bits = |r: &Recording| r.columns[0].iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read), bits(&recording));
        assert_eq!(read.time, recording.time);
    }

    #[test]
    fn an_unknown_column_names_the_nearest() {
        let recording = Recording::from_columns(vec!["pose.x".into()], vec![], vec![vec![]]);
        assert!(recording.column("pose.xx").unwrap_err().to_string().contains("'pose.x'"));
    }
}
