//! Expressions over recorded variables: `{a.x} - {b.x}`, with variables in braces.

use super::formula::Formula;
use cosim_base::error::{Code, Error, Result};
use cosim_core::observe::Recording;

/// The name of a variable, or a [`Formula`] with names in braces.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Expression {
    text: String,
    /// In the order of the variables of the formula.
    variables: Vec<String>,
}

impl Expression {
    /// Fails with the reason if the text is not an expression.
    pub(super) fn read(text: &str) -> std::result::Result<Self, String> {
        let variables = match text.contains('{') {
            true => parsed(text)?.variables,
            false => vec![text.to_owned()],
        };
        Ok(Self { text: text.to_owned(), variables })
    }

    /// Its variables.
    pub(super) fn variables(&self) -> &[String] {
        &self.variables
    }

    /// Its variables, mutable; the text of the formula keeps the names of its file.
    pub(super) fn variables_mut(&mut self) -> &mut [String] {
        &mut self.variables
    }

    /// Its value at each sample.
    pub(super) fn values(&self, recording: &Recording) -> Result<Vec<f64>> {
        let columns = self.variables.iter().map(|name| recording.column(name));
        let columns = columns.collect::<Result<Vec<_>>>()?;
        if !self.text.contains('{') {
            return Ok(columns[0].to_vec());
        }
        let formula = parsed(&self.text)
            .map_err(|why| Error::new(Code::Campaign, "an expression has no value").why(why))?;
        let (mut row, mut stack) = (vec![0.0; columns.len()], Vec::new());
        let value = |sample: usize| {
            row.iter_mut().zip(&columns).for_each(|(value, column)| *value = column[sample]);
            formula.value(&row, &mut stack)
        };
        Ok((0..recording.time().len()).map(value).collect())
    }
}

impl std::fmt::Display for Expression {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

fn parsed(text: &str) -> std::result::Result<Formula, String> {
    Formula::read(text).map_err(|why| format!("'{text}' is not a valid expression: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_have_values_and_what_is_none_is_refused() {
        let names = ["a.x", "b[1].y"].map(str::to_owned).to_vec();
        let columns = vec![vec![3.0, -6.0], vec![4.0, 8.0]];
        let recording = Recording::from_columns(names, vec![0.0, 1.0], columns);
        let values = |text: &str| Expression::read(text).unwrap().values(&recording).unwrap();
        assert_eq!(values("a.x"), [3.0, -6.0]);
        assert_eq!(values("sqrt({a.x}^2 + {b[1].y}^2)"), [5.0, 10.0]);
        assert_eq!(values("max(abs({a.x}), 2 * {b[1].y}) - 1"), [7.0, 15.0]);
        let error = Expression::read("{a.x} +* 2").unwrap_err();
        assert!(error.contains("'{a.x} +* 2' is not a valid expression"), "{error}");
        let unknown = Expression::read("{c} - 1").unwrap().values(&recording);
        assert!(unknown.unwrap_err().to_string().contains("'c' was not recorded"));
    }
}
