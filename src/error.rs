//! Errors in parameters, and the checks that all modules share.

/// A parameter that cannot be used: its name, its value and the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("parameter `{name}` = {value}: {reason}")]
pub struct ParameterError {
    /// Name of the parameter, with its index if it has one (`thrusters[3].lx`).
    pub name: String,
    /// The given value.
    pub value: String,
    /// Why it cannot be used and which values would be accepted.
    pub reason: String,
}

impl ParameterError {
    pub(crate) fn new(name: impl Into<String>, value: impl ToString, reason: &str) -> Self {
        Self { name: name.into(), value: value.to_string(), reason: reason.into() }
    }

    /// The same error seen from an enclosing structure: `mass` becomes `vehicle.mass`.
    #[must_use]
    pub fn within(mut self, parent: &str) -> Self {
        self.name = format!("{parent}.{}", self.name);
        self
    }
}

pub(crate) fn finite(name: &str, value: f64) -> Result<(), ParameterError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(ParameterError::new(name, value, "must be a finite number"))
}

pub(crate) fn positive(name: &str, value: f64) -> Result<(), ParameterError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(ParameterError::new(name, value, "must be positive and finite"))
}

pub(crate) fn non_negative(name: &str, value: f64) -> Result<(), ParameterError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(ParameterError::new(name, value, "must be zero or positive, and finite"))
}

pub(crate) fn probability(name: &str, value: f64) -> Result<(), ParameterError> {
    within(name, value, 0.0, 1.0)
}

pub(crate) fn within(name: &str, value: f64, min: f64, max: f64) -> Result<(), ParameterError> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(ParameterError::new(name, value, &format!("must lie between {min} and {max}")))
}

/// Applies `check` to each element, naming it by its index: `position[2]`.
pub(crate) fn each(
    name: &str,
    values: &[f64],
    check: fn(&str, f64) -> Result<(), ParameterError>,
) -> Result<(), ParameterError> {
    values.iter().enumerate().try_for_each(|(i, &value)| check(&format!("{name}[{i}]"), value))
}
