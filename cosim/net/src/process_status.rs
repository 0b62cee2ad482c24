//! How an incarnation of a group ended, or what it is doing, as its worker reports it.

use std::fmt;
use std::os::unix::process::ExitStatusExt;
use std::process::ExitStatus;

use serde::{Deserialize, Serialize};

use cosim_base::time::Time;
use cosim_import::Noted;

/// What a worker knows of an incarnation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ProcessStatus {
    /// Its process.
    pub process: ProcessState,
    /// The last FMI call, if there was one.
    pub call: Option<Call>,
}

/// A process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum ProcessState {
    /// It computes, or waits.
    Runs,
    /// A signal has stopped it.
    Stopped,
    /// A signal has killed it.
    Killed(i32),
    /// It exited with this code.
    Exited(i32),
}

/// An FMI call.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Call {
    function: String,
    component: String,
    time: Time,
    inside: bool,
}

impl ProcessState {
    /// From the exit status of a child.
    pub(crate) fn ended(status: ExitStatus) -> Self {
        match (status.signal(), status.code()) {
            (Some(signal), _) => Self::Killed(signal),
            (None, code) => Self::Exited(code.unwrap_or_default()),
        }
    }

    /// Of a process that still exists.
    pub(crate) fn running(id: u32) -> Self {
        // The state is the first word after the name, which may contain brackets itself.
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        match stat.rsplit_once(") ").map(|(_, rest)| rest.as_bytes().first()) {
            Some(Some(b'T' | b't')) => Self::Stopped,
            _ => Self::Runs,
        }
    }
}

impl From<Noted> for Call {
    fn from(noted: Noted) -> Self {
        let Noted { function, instance: component, time, inside } = noted;
        Self { function, component, time, inside }
    }
}

impl ProcessStatus {
    /// Its process no longer exists.
    pub(crate) fn has_ended(&self) -> bool {
        matches!(self.process, ProcessState::Killed(_) | ProcessState::Exited(_))
    }

    /// The FMU is at fault, rather than a user who killed or stopped its process: it would fail
    /// again.
    pub(crate) fn is_own_fault(&self) -> bool {
        let inside = self.call.as_ref().is_some_and(|call| call.inside);
        match self.process {
            ProcessState::Killed(libc::SIGKILL | libc::SIGTERM | libc::SIGINT | libc::SIGHUP) => {
                false
            }
            ProcessState::Stopped => false,
            ProcessState::Killed(_) | ProcessState::Exited(_) => true,
            ProcessState::Runs => inside,
        }
    }
}

impl fmt::Display for ProcessStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "its process {}", self.process)?;
        self.call.as_ref().map_or(Ok(()), |call| write!(f, ", {call}"))
    }
}

impl fmt::Display for ProcessState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Runs => f.write_str("runs"),
            Self::Stopped => f.write_str("is stopped"),
            Self::Exited(code) => write!(f, "ended with code {code}"),
            Self::Killed(signal) => match SIGNALS.iter().find(|(number, _)| *number == signal) {
                Some((_, name)) => write!(f, "was killed by {name}"),
                None => write!(f, "was killed by signal {signal}"),
            },
        }
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { function, component, time, inside } = self;
        let place = if *inside { "in" } else { "after" };
        write!(f, "{place} {function} of '{component}' at t = {time}")
    }
}

const SIGNALS: [(i32, &str); 15] = [
    (libc::SIGHUP, "SIGHUP"),
    (libc::SIGINT, "SIGINT"),
    (libc::SIGQUIT, "SIGQUIT"),
    (libc::SIGILL, "SIGILL"),
    (libc::SIGTRAP, "SIGTRAP"),
    (libc::SIGABRT, "SIGABRT"),
    (libc::SIGBUS, "SIGBUS"),
    (libc::SIGFPE, "SIGFPE"),
    (libc::SIGKILL, "SIGKILL"),
    (libc::SIGSEGV, "SIGSEGV"),
    (libc::SIGPIPE, "SIGPIPE"),
    (libc::SIGTERM, "SIGTERM"),
    (libc::SIGXCPU, "SIGXCPU"),
    (libc::SIGXFSZ, "SIGXFSZ"),
    (libc::SIGSYS, "SIGSYS"),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn status(process: ProcessState, inside: bool) -> ProcessStatus {
        let (function, component) = ("fmi2DoStep".to_owned(), "x".to_owned());
        let call = Call { function, component, time: Time::from_ns(300_000_000), inside };
        ProcessStatus { process, call: Some(call) }
    }

    #[test]
    fn the_message_names_signal_call_component_and_time() {
        let text = status(ProcessState::Killed(libc::SIGABRT), true).to_string();
        assert_eq!(text, "its process was killed by SIGABRT, in fmi2DoStep of 'x' at t = 0.3 s");
        let text = status(ProcessState::Runs, false).to_string();
        assert_eq!(text, "its process runs, after fmi2DoStep of 'x' at t = 0.3 s");
    }

    #[test]
    fn a_process_killed_from_outside_is_not_at_fault() {
        assert!(!status(ProcessState::Killed(libc::SIGKILL), true).is_own_fault());
        assert!(!status(ProcessState::Stopped, true).is_own_fault());
        assert!(!status(ProcessState::Runs, false).is_own_fault());
        assert!(status(ProcessState::Runs, true).is_own_fault());
        assert!(status(ProcessState::Killed(libc::SIGSEGV), false).is_own_fault());
        assert!(status(ProcessState::Exited(1), false).is_own_fault());
    }
}
