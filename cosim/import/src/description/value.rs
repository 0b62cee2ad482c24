//! Values of variables, parsed from text according to the declared type.

use serde::{Deserialize, Serialize};

use std::fmt;

use super::Kind;
use cosim_base::names;

/// A value of one of FMI's types.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are FMI's")]
pub enum Value {
    Real(f64),
    /// Also the value of an Enumeration.
    Integer(i32),
    Boolean(bool),
    String(String),
}

/// Why a text is not a value of a type.
#[derive(Debug)]
pub struct ValueError(pub String);

impl Value {
    /// As a number: a Boolean is 0 or 1, a String 0.
    pub fn number(&self) -> f64 {
        match self {
            Value::Real(value) => *value,
            Value::Integer(value) => f64::from(*value),
            Value::Boolean(value) => f64::from(u8::from(*value)),
            Value::String(_) => 0.0,
        }
    }

    /// Parses `text` as a value of the type `kind`. Enumerations take the name or the number.
    pub fn parse(text: &str, kind: &Kind) -> Result<Self, ValueError> {
        let trimmed = text.trim();
        let wrong = |what: &str| ValueError(format!("'{text}' is not {what}"));
        match kind {
            Kind::Real => match trimmed.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(Value::Real(number)),
                _ => Err(wrong("a finite Real")),
            },
            Kind::Integer => {
                trimmed.parse().map(Value::Integer).map_err(|_| wrong("an Integer of 32 bits"))
            }
            Kind::Boolean => match trimmed {
                "true" | "1" => Ok(Value::Boolean(true)),
                "false" | "0" => Ok(Value::Boolean(false)),
                _ => Err(wrong("a Boolean (true or false)")),
            },
            Kind::String => Ok(Value::String(text.to_owned())),
            Kind::Enumeration(items) => enumeration(trimmed, items),
        }
    }
}

/// The number of items that an error names.
const MOST_SHOWN: usize = 50;

fn enumeration(text: &str, items: &[(String, i32)]) -> Result<Value, ValueError> {
    let number = text.parse::<i32>().ok();
    let found = items.iter().find(|(name, value)| name == text || Some(*value) == number);
    if let Some((_, value)) = found {
        return Ok(Value::Integer(*value));
    }
    let names = || items.iter().map(|(name, _)| name.as_str());
    let hint = names::did_you_mean(text, names()).unwrap_or_default();
    let mut shown: Vec<&str> = names().take(MOST_SHOWN).collect();
    shown.extend((items.len() > MOST_SHOWN).then_some("..."));
    Err(ValueError(format!("'{text}' is not one of {}; {hint}", shown.join(", "))))
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Real(value) => write!(f, "{value:?}"),
            Value::Integer(value) => write!(f, "{value}"),
            Value::Boolean(value) => write!(f, "{value}"),
            Value::String(value) => f.write_str(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_declared_type() {
        let modes = Kind::Enumeration([("Force".into(), 1), ("Speed".into(), 5)].into());
        assert_eq!(Value::parse("Speed", &modes).unwrap(), Value::Integer(5));
        assert_eq!(Value::parse("5", &modes).unwrap(), Value::Integer(5));
        assert!(Value::parse("Forse", &modes).unwrap_err().0.contains("'Force'"));
        assert!(Value::parse("2", &modes).is_err());
        assert!(Value::parse("1e400", &Kind::Real).is_err());
        assert!(Value::parse("nan", &Kind::Real).is_err());
        assert!(Value::parse("3000000000", &Kind::Integer).is_err());
        assert_eq!(Value::parse(" a ", &Kind::String).unwrap(), Value::String(" a ".into()));
    }
}
