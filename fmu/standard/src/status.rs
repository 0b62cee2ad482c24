//! `fmi2Status` (section 2.1.3), what a status is asked for (section 4.2.3), and the log categories
//! (section 2.2.4).

/// `fmi2Status`.
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
    /// Co-simulation: the step continues in the background.
    Pending = 5,
}

impl Status {
    const ALL: [Self; 6] =
        [Self::Ok, Self::Warning, Self::Discard, Self::Error, Self::Fatal, Self::Pending];

    /// The status of this number.
    #[must_use]
    pub fn from_number(number: i32) -> Option<Self> {
        Self::ALL.into_iter().find(|status| *status as i32 == number)
    }

    /// Name in messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::Warning => "Warning",
            Self::Discard => "Discard",
            Self::Error => "Error",
            Self::Fatal => "Fatal",
            Self::Pending => "Pending",
        }
    }
}

/// `fmi2StatusKind`: what `fmi2GetStatus` and the like are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum StatusKind {
    /// The status of a step in the background.
    DoStepStatus = 0,
    /// A text about such a step.
    PendingStatus = 1,
    /// The end of the last step that was completed.
    LastSuccessfulTime = 2,
    /// Whether the instance wants to end the simulation.
    Terminated = 3,
}

/// Log categories, by the names that the standard recommends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Events, and other debug messages.
    Events,
    /// A warning.
    Warning,
    /// A value or a step that was discarded.
    Discard,
    /// An error.
    Error,
    /// The end of this instance.
    Fatal,
}

impl Category {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Events, Self::Warning, Self::Discard, Self::Error, Self::Fatal];

    /// Name in the description and in each message.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Events => "logEvents",
            Self::Warning => "logStatusWarning",
            Self::Discard => "logStatusDiscard",
            Self::Error => "logStatusError",
            Self::Fatal => "logStatusFatal",
        }
    }

    /// Description in `LogCategories`.
    #[must_use]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Events => "Debug messages, on request",
            Self::Warning => "Warnings, always logged",
            Self::Discard => "Values and steps that were discarded, always logged",
            Self::Error => "Errors, always logged",
            Self::Fatal => "Failures that end the instance, always logged",
        }
    }

    /// Whether a category has that name.
    #[must_use]
    pub fn is_known(name: &str) -> bool {
        Self::ALL.iter().any(|category| category.name() == name)
    }
}

impl From<Status> for Category {
    fn from(status: Status) -> Self {
        match status {
            Status::Ok | Status::Pending => Self::Events,
            Status::Warning => Self::Warning,
            Status::Discard => Self::Discard,
            Status::Error => Self::Error,
            Status::Fatal => Self::Fatal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Status;

    #[test]
    fn every_number_of_the_standard_is_a_status_and_no_other() {
        let found: Vec<i32> =
            (-1..7).filter_map(Status::from_number).map(|status| status as i32).collect();
        assert_eq!(found, [0, 1, 2, 3, 4, 5]);
    }
}
