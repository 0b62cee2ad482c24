//! Errors that a component may report. The kernel adds instance, function and time.

use std::fmt::Display;

/// A parameter the component cannot work with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{variable}: {reason}")]
pub struct ParameterError {
    variable: String,
    reason: String,
}

impl ParameterError {
    /// `variable` is the FMI name (`thruster.time_constant`); `reason` says which value is wrong,
    /// why, and what would be right.
    pub fn new(variable: impl Into<String>, reason: impl Display) -> Self {
        Self { variable: variable.into(), reason: reason.to_string() }
    }

    /// FMI name of the offending variable.
    #[must_use]
    pub fn variable(&self) -> &str {
        &self.variable
    }
}

/// Why a component cannot continue during a simulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct Fault {
    reason: String,
}

impl Fault {
    /// What happened, to which quantity, and what the user can do about it.
    pub fn new(reason: impl Display) -> Self {
        Self { reason: reason.to_string() }
    }
}
