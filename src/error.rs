//! Errors in parameters, and the check of their declared bounds.

use fmu_quantity::{Count, Declaration, Declarations, Field, Start, Variables};

/// A parameter that cannot be used: its name, its value and the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("parameter `{name}` = {value}: {reason}")]
pub struct ParameterError {
    /// Name of the parameter, with its index if it has one (`thruster[3].lx`).
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

/// Checks quantities as declared: numbers must be finite and within their bounds. Errors have the
/// declared names.
pub(crate) fn declared<Q: Variables>(quantities: &Q) -> Result<(), ParameterError> {
    // Names are made only for an error.
    checked(quantities, &Field::nameless()).or_else(|_| checked(quantities, &Field::default()))
}

fn checked<Q: Variables>(quantities: &Q, at: &Field) -> Result<(), ParameterError> {
    let mut list = Declarations::new();
    let Count { reals, integers, booleans, strings } = Q::COUNT;
    let count = reals + integers + booleans + strings;
    if list.try_reserve_exact(count).is_err() {
        return Err(ParameterError::new("parameters", count, "not enough memory to check them"));
    }
    quantities.declare(at, &mut list);
    list.iter().try_for_each(|Declaration { field, start }| match *start {
        Start::Real(value) => bounded(field, value),
        Start::Integer(value) => bounded(field, f64::from(value)),
        _ => Ok(()),
    })
}

fn bounded(field: &Field, value: f64) -> Result<(), ParameterError> {
    let (min, max) = (field.min.unwrap_or(f64::MIN), field.max.unwrap_or(f64::MAX));
    if (min..=max).contains(&value) {
        return Ok(());
    }
    let reason = match (field.min, field.max) {
        (None, None) => "must be a finite number".to_owned(),
        (Some(0.0), None) => "must be zero or positive, and finite".to_owned(),
        (Some(min), None) => format!("must be at least {min:?}, and finite"),
        (None, Some(max)) => format!("must be at most {max:?}, and finite"),
        (Some(min), Some(max)) => format!("must lie between {min} and {max}"),
    };
    Err(ParameterError::new(field.name.clone(), value, &reason))
}
