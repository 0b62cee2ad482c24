//! The columns of a recording by name, as far as plots can use them.

use std::collections::HashMap;

use cosim_core::Recording;

/// Columns of numbers, at instants that do not decrease.
pub(super) struct Columns<'a> {
    pub(super) time: Vec<f64>,
    /// In the order of the recording.
    pub(super) names: Vec<&'a str>,
    values: HashMap<&'a str, &'a [f64]>,
    /// The rows to show; `None`: all.
    rows: Option<Vec<usize>>,
    /// Problems of the recording.
    pub(super) notes: Vec<String>,
}

impl<'a> Columns<'a> {
    pub(super) fn of(recording: &'a Recording) -> Self {
        let mut notes: Vec<String> = recording.missing().into_iter().collect();
        let (mut names, mut values, mut texts) = (Vec::new(), HashMap::new(), 0);
        for (place, (name, column)) in recording.columns().enumerate() {
            if recording.is_text_at(place) {
                texts += 1;
            } else if values.insert(name, column).is_none() {
                names.push(name);
            }
        }
        if texts > 0 {
            notes.push(format!("{texts} variables are text and cannot be plotted"));
        }
        let (time, rows) = forward(recording.time());
        if let Some(rows) = &rows {
            let lost = recording.time().len() - rows.len();
            notes
                .push(format!("{lost} rows are left out: their time is not a number or goes back"));
        }
        if time.is_empty() {
            notes.push("no instant is recorded".to_owned());
        }
        Self { time, names, values, rows, notes }
    }

    /// The values of a column at the instants shown.
    pub(super) fn get(&self, name: &str) -> Option<Vec<f64>> {
        let column = *self.values.get(name)?;
        Some(match &self.rows {
            None => column.to_vec(),
            Some(rows) => rows.iter().map(|&row| column[row]).collect(),
        })
    }
}

/// The instants that are not before an earlier one, and their rows unless these are all.
fn forward(time: &[f64]) -> (Vec<f64>, Option<Vec<usize>>) {
    let mut latest = f64::NEG_INFINITY;
    let rows: Vec<usize> = (0..time.len())
        .filter(|&row| {
            let goes = time[row].is_finite() && time[row] >= latest;
            if goes {
                latest = time[row];
            }
            goes
        })
        .collect();
    let kept = rows.iter().map(|&row| time[row]).collect();
    (kept, (rows.len() < time.len()).then_some(rows))
}
