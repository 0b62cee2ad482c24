//! FMI's return status, and the failures that lead to a bad one.

use std::fmt::Display;

/// `fmi2Status` (FMI 2.0.4, section 2.1.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// Success.
    Ok = 0,
    /// Not quite right, but the computation can continue.
    Warning = 1,
    /// Not computed; a solver may try again with a shorter step.
    Discard = 2,
    /// The simulation cannot continue with this instance; reset or free it.
    Error = 3,
    /// The instance is corrupt; free it.
    Fatal = 4,
}

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
