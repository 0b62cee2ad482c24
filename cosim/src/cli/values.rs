//! Values of options as typed: `name=value`, `component=seconds`.

use cosim::Input;
use cosim::fmi::InterfaceType;

/// `name=value`; the value may contain further `=`.
pub(crate) fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.to_owned()))
        }
        _ => Err("it must have the form NAME=VALUE".to_owned()),
    }
}

/// `component=seconds`.
pub(crate) fn step(text: &str) -> Result<(String, f64), String> {
    let (name, value) = assignment(text)?;
    Ok((name, seconds(&value)?))
}

/// `component=me` or `component=cs`.
pub(crate) fn interface(text: &str) -> Result<(String, InterfaceType), String> {
    let (name, value) = assignment(text)?;
    Ok((name, value.trim().parse()?))
}

/// A finite number of seconds.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("'{text}' is not a number of seconds")),
    }
}

/// A factor greater than zero.
pub(crate) fn factor(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err(format!("'{text}' is not a factor greater than 0")),
    }
}

/// A non-negative number, for all or for a named variable.
pub(crate) fn tolerance(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.rsplit_once('=').unwrap_or(("*", text));
    match value.trim().parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok((name.trim().to_owned(), number)),
        _ => Err(format!("'{value}' is not a number from 0 on")),
    }
}

/// `hold`, `linear`, or one of these for a named input.
pub(crate) fn input(text: &str) -> Result<(String, Input), String> {
    match text.rsplit_once('=') {
        Some((name, value)) => Ok((name.trim().to_owned(), value.trim().parse()?)),
        None => Ok((String::new(), text.trim().parse()?)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments() {
        assert_eq!(assignment("a.b=c=d"), Ok(("a.b".into(), "c=d".into())));
        assert_eq!(assignment("a="), Ok(("a".into(), String::new())));
        assert!(assignment("a").is_err());
        assert!(assignment("=1").is_err());
        assert!(step("a=nan").is_err());
    }
}
