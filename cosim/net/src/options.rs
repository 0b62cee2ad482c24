//! How a distributed run behaves when something fails.

use std::time::Duration;

use super::telemetry::Rate;

/// What happens to a run if an FMU returns `fmi2Fatal`, after which FMI allows no calls of any
/// instance in the same process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnFatal {
    /// The run ends, as in one process.
    End,
    /// The group is restarted in another process, as after a crash.
    Resume,
}

/// Endpoints separated by commas.
pub fn several(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|endpoint| !endpoint.is_empty())
}

/// How a distributed run behaves.
#[derive(Debug, Clone)]
pub struct Options {
    /// The state of a group is saved after this many instants; `None`: never.
    pub save_every: Option<u64>,
    /// How long an answer may take.
    pub deadline: Duration,
    /// Or this many times the longest answer so far, if that is more.
    pub slowness: u32,
    /// How long a new incarnation of a group may take to become ready and be set up.
    pub launch_deadline: Duration,
    /// How long a lost group may take to catch up.
    pub give_up: Duration,
    /// How often a group may be restarted.
    pub recoveries: u32,
    /// How many times in a row a group may be lost at the same command by its own fault.
    pub attempts: u32,
    /// How many times in a row a group may be lost at the same command, whatever the cause.
    pub losses: u32,
    /// What happens to a run if an FMU returns `fmi2Fatal`.
    pub on_fatal: OnFatal,
    /// If a lost group has no saved state, the run ends instead of computing it again from the
    /// start.
    pub require_resume: bool,
    /// Reports a loss as soon as the coordinator knows it.
    pub report: fn(&str),
    /// Recorded values are sent to observers.
    pub telemetry: Option<Rate>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            save_every: Some(50),
            deadline: Duration::from_secs(5),
            slowness: 100,
            launch_deadline: Duration::from_secs(30),
            give_up: Duration::MAX,
            recoveries: 1000,
            attempts: 3,
            losses: 10,
            on_fatal: OnFatal::End,
            require_resume: false,
            report: |_| (),
            telemetry: None,
        }
    }
}
