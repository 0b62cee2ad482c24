//! Logging requests to FMUs, and live output of their messages and calls.
//!
//! A call is written in two parts, before and after it: if an FMU kills the process, the last line
//! names the call. An instance that is not followed costs one comparison per call.
//!
//! ```text
//! tank: fmi2SetReal(u = 0.5) -> OK
//! tank: fmi2DoStep(0.1, 0.1, true)
//! tank: logger: Warning (logAll): nearly empty
//! tank: ... fmi2DoStep -> OK
//! tank: fmi2GetReal(y) -> OK (0.25)
//! ```

use std::fmt;
use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};

use crate::{Fmu, LastCall, Mailbox};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::shown::one_line;

/// Logging requests, and the followers.
#[derive(Debug, Clone, Default)]
pub struct Logging {
    /// Request debug messages (`loggingOn`).
    pub debug: bool,
    /// Request messages of these categories (`fmi2SetDebugLogging`); empty: all.
    pub categories: Vec<String>,
    /// Receives messages, and calls if requested, immediately.
    pub trace: Option<Arc<Trace>>,
    /// Records the last call for the investigation of a dead process.
    pub last: Option<Arc<LastCall>>,
    /// Receives messages that are passed on.
    pub mailbox: Option<Arc<Mailbox>>,
}

/// Writes the calls and messages of instances.
pub struct Trace {
    calls: bool,
    /// The instances that are followed; empty: all.
    instances: Vec<String>,
    output: Mutex<Output>,
}

struct Output {
    writer: Box<dyn Write + Send>,
    /// The last line is incomplete: it waits for the result of the call.
    open: Option<&'static str>,
}

impl Trace {
    /// Follows messages, and also calls if `calls`.
    pub fn new(writer: impl Write + Send + 'static, calls: bool) -> Self {
        let output = Output { writer: Box::new(writer), open: None };
        Self { calls, instances: Vec::new(), output: Mutex::new(output) }
    }

    /// Follows only these instances; all if the list is empty.
    #[must_use]
    pub fn only(mut self, instances: &[String]) -> Self {
        self.instances = instances.to_vec();
        self
    }

    fn follows(&self, instance: &str) -> bool {
        self.instances.is_empty() || self.instances.iter().any(|name| name == instance)
    }

    /// Before a call.
    pub(super) fn begin(&self, instance: &str, function: &'static str, arguments: &str) {
        self.write(|output| {
            output.end_line()?;
            write!(output.writer, "{}: {function}({})", one_line(instance), one_line(arguments))?;
            output.open = Some(function);
            output.writer.flush()
        });
    }

    /// After the call: its status; `more`: its results follow.
    pub(super) fn end(&self, instance: &str, function: &'static str, status: &str, more: bool) {
        self.write(|output| {
            if output.open != Some(function) {
                output.end_line()?;
                write!(output.writer, "{}: ... {function}", one_line(instance))?;
            }
            write!(output.writer, " -> {status}")?;
            output.open = Some(function);
            if more { Ok(()) } else { output.end_line() }
        });
    }

    /// The results of the call that ended last.
    pub(super) fn results(&self, results: &str) {
        self.write(|output| {
            write!(output.writer, " ({})", one_line(results))?;
            output.end_line()
        });
    }

    /// A message of the FMU, which may arrive during a call.
    pub(super) fn message(&self, instance: &str, text: &str) {
        self.write(|output| {
            output.end_line()?;
            writeln!(output.writer, "{}: logger: {}", one_line(instance), one_line(text))
        });
    }

    fn write(&self, write: impl FnOnce(&mut Output) -> std::io::Result<()>) {
        let mut output = self.output.lock().unwrap_or_else(PoisonError::into_inner);
        // A log that cannot be written (a closed pipe, a full disk) does not end a run.
        drop(write(&mut output));
    }
}

impl Output {
    fn end_line(&mut self) -> std::io::Result<()> {
        match self.open.take() {
            Some(_) => writeln!(self.writer),
            None => Ok(()),
        }
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        drop(self.end_line().and_then(|()| self.writer.flush()));
    }
}

impl fmt::Debug for Trace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { calls, instances, .. } = self;
        f.debug_struct("Trace").field("calls", calls).field("instances", instances).finish()
    }
}

impl Logging {
    /// Refuses names of categories and instances that none of these FMUs has.
    pub fn check<'a>(&self, fmus: impl Iterator<Item = (&'a str, &'a Fmu)> + Clone) -> Result<()> {
        let categories: Vec<&str> = fmus
            .clone()
            .flat_map(|(_, fmu)| fmu.description().log_categories.iter().map(String::as_str))
            .collect();
        for category in &self.categories {
            if !categories.is_empty() && !categories.contains(&category.as_str()) {
                return Err(unknown("log category", category, &categories));
            }
        }
        let instances: Vec<&str> = fmus.map(|(name, _)| name).collect();
        let wanted = self.trace.iter().flat_map(|trace| &trace.instances);
        match wanted.clone().find(|name| !instances.contains(&name.as_str())) {
            Some(name) => Err(unknown("instance", name, &instances)),
            None => Ok(()),
        }
    }

    /// The follower of the messages of that instance.
    pub(super) fn messages_of(&self, instance: &str) -> Option<Arc<Trace>> {
        self.trace.clone().filter(|trace| trace.follows(instance))
    }

    /// The follower of its calls.
    pub(super) fn calls_of(&self, instance: &str) -> Option<Arc<Trace>> {
        self.messages_of(instance).filter(|trace| trace.calls)
    }
}

fn unknown(kind: &str, name: &str, known: &[&str]) -> Error {
    Error::new(Code::UnknownName, format!("there is no {kind} '{name}' to log")).help(
        names::did_you_mean(name, known.iter().copied())
            .unwrap_or_else(|| format!("there are: {}", known.join(", "))),
    )
}
