//! The failures that lead to a bad status.

use std::fmt::Display;

use fmu_standard::Status;

/// Why a call failed: the content of the log line and the returned status.
#[derive(Clone, Debug, PartialEq)]
pub struct Trouble {
    /// The status of the call.
    pub status: Status,
    /// What happened, why and what to do.
    pub text: String,
}

impl Trouble {
    /// The simulation cannot continue.
    pub fn error(text: impl Display) -> Self {
        Self { status: Status::Error, text: text.to_string() }
    }

    /// Another step or value may succeed.
    pub fn discard(text: impl Display) -> Self {
        Self { status: Status::Discard, text: text.to_string() }
    }
}
