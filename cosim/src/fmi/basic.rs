//! The types that value references belong to.

use serde::{Deserialize, Serialize};

use super::Kind;

/// FMI's types as far as value references are concerned: an Enumeration is an Integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are FMI's")]
pub enum Basic {
    Real,
    Integer,
    Boolean,
    String,
}

impl Basic {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Real, Self::Integer, Self::Boolean, Self::String];

    pub(crate) fn of(kind: &Kind) -> Self {
        match kind {
            Kind::Real => Self::Real,
            Kind::Integer | Kind::Enumeration(_) => Self::Integer,
            Kind::Boolean => Self::Boolean,
            Kind::String => Self::String,
        }
    }
}
