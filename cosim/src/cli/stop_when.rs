//! `--stop-when`: a run that ends when a recorded variable fulfils a condition.

use std::str::FromStr;

use cosim::observe::{RunInfo, Stop};
use cosim::{Code, Error, Observer, Result, Time, names};

/// Whether a value and a number are so related.
type Holds = fn(f64, f64) -> bool;

/// Compared with a number.
#[derive(Clone)]
pub(crate) struct Condition {
    variable: String,
    relation: &'static str,
    holds: Holds,
    number: f64,
}

/// Longer signs first: `<=` is no `<`.
const RELATIONS: [(&str, Holds); 7] = [
    ("<=", |a, b| a <= b),
    (">=", |a, b| a >= b),
    ("!=", |a, b| a != b),
    ("==", |a, b| a == b),
    ("<", |a, b| a < b),
    (">", |a, b| a > b),
    ("=", |a, b| a == b),
];

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted =
            "a condition is VARIABLE, one of = != < <= > >=, and a number or true or false";
        let place = |(sign, _): &(&str, _)| text.find(sign).map(|place| (place, sign.len()));
        let first = RELATIONS.iter().filter_map(|r| Some((place(r)?, r)));
        let first = first.min_by_key(|((place, length), _)| (*place, std::cmp::Reverse(*length)));
        let Some(((place, length), &(relation, holds))) = first else {
            return Err(format!("'{text}' has no comparison; {wanted}"));
        };
        let (variable, value) = (text[..place].trim(), text[place + length..].trim());
        let number = match value {
            "true" => 1.0,
            "false" => 0.0,
            _ => value.parse().map_err(|_| format!("'{value}' is no number; {wanted}"))?,
        };
        if variable.is_empty() {
            return Err(format!("'{text}' names no variable; {wanted}"));
        }
        Ok(Self { variable: variable.to_owned(), relation, holds, number })
    }
}

/// An observer that ends the run at the first sample that fulfils one of the conditions.
pub(crate) struct StopWhen {
    conditions: Vec<Condition>,
    /// Their variables' places among the columns.
    columns: Vec<usize>,
    /// What held, and when.
    held: Option<String>,
}

impl StopWhen {
    pub(crate) fn new(conditions: &[Condition]) -> Self {
        Self { conditions: conditions.to_vec(), columns: Vec::new(), held: None }
    }

    /// Why the run was ended, if it was.
    pub(crate) fn held(&self) -> Option<&str> {
        self.held.as_deref()
    }
}

impl Observer for StopWhen {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        for Condition { variable, .. } in &self.conditions {
            let found = info.columns.iter().position(|column| column.name == *variable);
            let known = || info.columns.iter().map(|column| column.name.as_str());
            self.columns.push(found.ok_or_else(|| {
                Error::new(Code::UnknownName, format!("--stop-when: '{variable}' is not recorded"))
                    .why("conditions are looked at where variables are recorded")
                    .help(names::did_you_mean(variable, known()).unwrap_or_else(|| {
                        format!("record it, too: --output-variable '{variable}'")
                    }))
            })?);
        }
        Ok(())
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        let mut all = self.conditions.iter().zip(&self.columns);
        let found =
            all.find(|(condition, column)| (condition.holds)(values[**column], condition.number));
        self.held = found.map(|(Condition { variable, relation, number, .. }, column)| {
            format!("{variable} {relation} {number} at t = {time}: it is {}", values[*column])
        });
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }

    fn stop(&self) -> Option<Stop> {
        self.held.is_some().then_some(Stop::Enough)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_read_as_they_are_written() {
        let read =
            |text: &str| text.parse::<Condition>().map(|c| (c.variable, c.relation, c.number));
        let is = |variable: &str, relation, number| Ok((variable.to_owned(), relation, number));
        assert_eq!(read("a.b = 1"), is("a.b", "=", 1.0));
        assert_eq!(read("a.b<=-2.5e1"), is("a.b", "<=", -25.0));
        assert_eq!(read("x[1] != true"), is("x[1]", "!=", 1.0));
        assert_eq!(read("x > 0"), is("x", ">", 0.0));
        for wrong in ["x", "x = much", "= 1", "x =="] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
