//! How a distributed run behaves when something fails.

use std::time::Duration;

use super::telemetry::Rate;

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
    /// How many new lives a group may have.
    pub recoveries: u32,
    /// So many times in a row a group may be lost at the same command by a fault of its own.
    pub attempts: u32,
    /// A lost group that has no saved state is the end of the run, not computed again from the
    /// start.
    pub require_resume: bool,
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
            recoveries: 1000,
            attempts: 3,
            require_resume: false,
            telemetry: None,
        }
    }
}
