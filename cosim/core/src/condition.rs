//! Conditions on recorded variables, `VARIABLE RELATION NUMBER`: they end runs and start faults.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Whether a value and a number satisfy the relation.
type Holds = fn(f64, f64) -> bool;

/// A variable compared with a number.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Condition {
    /// Its name in the results.
    pub variable: String,
    relation: &'static Relation,
    number: f64,
}

/// A sign with its meaning.
type Relation = (&'static str, Holds);

/// Longer operators first: `<=` is not `<`.
static RELATIONS: [Relation; 7] = [
    ("<=", |a, b| a <= b),
    (">=", |a, b| a >= b),
    ("!=", |a, b| a != b),
    ("==", |a, b| a == b),
    ("<", |a, b| a < b),
    (">", |a, b| a > b),
    ("=", |a, b| a == b),
];

impl Condition {
    /// Whether it holds for this value of the variable.
    pub fn holds(&self, value: f64) -> bool {
        (self.relation.1)(value, self.number)
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.variable, self.relation.0, self.number)
    }
}

impl From<Condition> for String {
    fn from(condition: Condition) -> Self {
        condition.to_string()
    }
}

impl TryFrom<String> for Condition {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted =
            "a condition is VARIABLE, one of = != < <= > >=, and a number or true or false";
        let place = |(sign, _): &Relation| text.find(sign).map(|place| (place, sign.len()));
        let first = RELATIONS.iter().filter_map(|r| Some((place(r)?, r)));
        let first = first.min_by_key(|((place, length), _)| (*place, std::cmp::Reverse(*length)));
        let Some(((place, length), relation)) = first else {
            return Err(format!("'{text}' has no comparison; {wanted}"));
        };
        let (variable, value) = (text[..place].trim(), text[place + length..].trim());
        let number = match value {
            "true" => 1.0,
            "false" => 0.0,
            _ => value.parse().map_err(|_| format!("'{value}' is not a number; {wanted}"))?,
        };
        if variable.is_empty() {
            return Err(format!("'{text}' does not name a variable; {wanted}"));
        }
        Ok(Self { variable: variable.to_owned(), relation, number })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_read_as_they_are_written() {
        let read =
            |text: &str| text.parse::<Condition>().map(|c| (c.variable, c.relation.0, c.number));
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
