//! How a distributed run behaves when something fails.

use std::time::Duration;

use super::telemetry::Rate;

/// What becomes of a run one of whose FMUs returns `fmi2Fatal`, after which FMI allows no call of
/// any instance of its process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnFatal {
    /// It ends, as in one process.
    End,
    /// The group begins a new life in another process, as after a crash.
    Resume,
}

/// Endpoints with commas between.
pub fn several(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|endpoint| !endpoint.is_empty())
}

/// How a distributed run behaves.
#[derive(Debug, Clone)]
pub struct Options {
    /// A group's state is saved after so many instants; never without.
    pub save_every: Option<u64>,
    /// How long an answer may take.
    pub deadline: Duration,
    /// Or so many times the longest that one took before, if that is more.
    pub slowness: u32,
    /// How long it may take until a new life of a group can be spoken to and is set up.
    pub launch_deadline: Duration,
    /// How long it may take until a lost group is where it was.
    pub give_up: Duration,
    /// How many new lives a group may have.
    pub recoveries: u32,
    /// So many times in a row a group may be lost at the same command by a fault of its own.
    pub attempts: u32,
    /// So many times in a row a group may be lost at the same command, by whosesoever fault.
    pub losses: u32,
    /// What becomes of a run one of whose FMUs returns `fmi2Fatal`.
    pub on_fatal: OnFatal,
    /// A lost group that has no saved state is the end of the run, not computed again from the
    /// start.
    pub require_resume: bool,
    /// Hears of a loss as soon as the coordinator knows it.
    pub report: fn(&str),
    /// What is recorded is sent to observers.
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
