//! An instance's messages to its importer: exactly one line for each call that fails, and more on
//! request. Failures are always reported, because a status without a reason helps no one;
//! `loggingOn` and the categories select the debug messages, as the standard defines.

use fmu_standard::{Call, Category, InterfaceType, Phase, Status};

use super::status::Trouble;

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
    pub fn out_of_order(&self, call: Call, phase: Phase, interface: InterfaceType) -> Status {
        let status = if phase == Phase::Fatal { Status::Fatal } else { Status::Error };
        let place = phase.place(call, interface);
        self.failure(status, &format!("{}: not allowed {place}", call.name()))
    }

    /// Reports a call that panicked.
    #[cold]
    pub fn panicked(&self, call: Call, reason: &str) -> Status {
        let text = format!("{}: panicked: {reason}; free the instance", call.name());
        self.failure(Status::Fatal, &text)
    }

    fn failure(&self, status: Status, text: &str) -> Status {
        self.sink.write(status, status.into(), text);
        status
    }

    /// Forwards a message from elsewhere.
    pub fn pass_on(&self, status: Status, text: &str) {
        self.sink.write(status, status.into(), text);
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
