//! An instance's messages to its importer: exactly one line for each call that fails, and more on
//! request. Failures are always reported, because a status without a reason helps no one;
//! `loggingOn` and the categories select the debug messages, as the standard defines.

use super::call::{Call, Phase};
use super::instance::Interface;
use super::status::{Status, Trouble};

/// The categories of messages, by the names the standard recommends (FMI 2.0.4, section 2.2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Debug: initialization and time events.
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
    /// All of them, as listed in the description.
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
            Self::Events => "Initialization and time events, on request",
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

    const fn of(status: Status) -> Self {
        match status {
            Status::Ok => Self::Events,
            Status::Warning => Self::Warning,
            Status::Discard => Self::Discard,
            Status::Error => Self::Error,
            Status::Fatal => Self::Fatal,
        }
    }
}

/// Where messages go: the importer's logger.
pub trait Sink: Send {
    /// Delivers one finished line.
    fn write(&self, status: Status, category: Category, text: &str);
}

/// The log of one instance.
pub struct Log {
    sink: Box<dyn Sink>,
    events: bool,
}

impl Log {
    /// A log that writes to `sink`; `logging_on` requests debug messages.
    #[must_use]
    pub fn new(sink: Box<dyn Sink>, logging_on: bool) -> Self {
        Self { sink, events: logging_on }
    }

    /// Reports a call that failed.
    #[cold]
    pub fn failed(&self, call: Call, trouble: &Trouble) -> Status {
        self.failure(trouble.status, &format!("{}: {}", call.name(), trouble.text))
    }

    /// Reports a call that is not legal in the present state.
    #[cold]
    pub fn out_of_order(&self, call: Call, phase: Phase, interface: Interface) -> Status {
        let status = if phase == Phase::Fatal { Status::Fatal } else { Status::Error };
        let words = match interface {
            _ if call.belongs_to(interface) => phase.words(),
            Interface::ModelExchange => "in model exchange",
            Interface::CoSimulation => "in co-simulation",
        };
        self.failure(status, &format!("{}: not allowed {words}", call.name()))
    }

    /// Reports a call that panicked.
    #[cold]
    pub fn panicked(&self, call: Call, reason: &str) -> Status {
        let text = format!("{}: panicked: {reason}; free the instance", call.name());
        self.failure(Status::Fatal, &text)
    }

    fn failure(&self, status: Status, text: &str) -> Status {
        self.sink.write(status, Category::of(status), text);
        status
    }

    /// Forwards a message from elsewhere.
    pub fn pass_on(&self, status: Status, text: &str) {
        self.sink.write(status, Category::of(status), text);
    }

    /// Reports an event, if requested; `text` is only computed then.
    pub fn event(&self, text: impl FnOnce() -> String) {
        if self.events {
            self.sink.write(Status::Ok, Category::Events, &text());
        }
    }

    /// Selects the debug messages; no categories means all. An unknown name is an error.
    ///
    /// # Errors
    /// The unknown name and the known ones.
    pub fn choose(&mut self, on: bool, categories: &[&str]) -> Result<(), String> {
        if let Some(unknown) = categories.iter().find(|name| !Category::is_known(name)) {
            let names: Vec<_> = Category::ALL.iter().map(|category| category.name()).collect();
            return Err(format!(
                "unknown log category \"{unknown}\"; the categories are {}",
                names.join(", ")
            ));
        }
        self.events =
            on && (categories.is_empty() || categories.contains(&Category::Events.name()));
        Ok(())
    }
}
