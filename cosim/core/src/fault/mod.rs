//! Faults and disturbances of a variable: errors of a sensor, a link or an actuator.
//!
//! A fault acts on the steps of its component that begin in `[from, until)`: on an input or a
//! parameter during the step, on an output from the end of the step on. It has its own random
//! stream and a state that changes once per step, however often values are read, and that is part
//! of snapshots: results have the same bits in one process, distributed and resumed.

mod acting;
mod kind;
mod random;
mod schema;
mod window;

pub(crate) use acting::{Acting, Way};
pub use random::{Random, normal_quantile};

pub use kind::{KINDS, Kind, Meant, Meanwhile, Spread, Word};
pub use schema::schema;
pub use window::Window;

use serde::{Deserialize, Serialize};

use crate::condition::Condition;
use cosim_base::time::Time;

/// The specification of a fault.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Fault {
    /// The variables on which it acts, with their names in the results; `*` and `?` match parts of
    /// names.
    pub variables: Vec<String>,
    /// What it does.
    pub kind: Kind,
    /// When it is installed: its memory and its random numbers start there; by default with the
    /// run.
    pub installed: Option<Time>,
    /// When it begins.
    pub begin: Begin,
    /// When it ends.
    pub end: End,
    /// The time during which it grows after its start.
    pub ramp_in: Time,
    /// The time during which it fades before its end.
    pub ramp_out: Time,
    /// The time between samples, for kinds that act on samples; 0 if each step is one.
    pub every: Time,
}

/// When a fault begins.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Begin {
    /// With the run.
    Start,
    /// At this instant.
    At(Time),
    /// At an instant between these two, uniformly distributed.
    Between(Time, Time),
    /// At the first output instant at which this holds.
    When(Condition),
}

/// When a fault ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum End {
    /// With the run.
    Never,
    /// At this instant.
    At(Time),
    /// This long after its start.
    After(Time),
    /// A time after its start between these two, uniformly distributed.
    AfterBetween(Time, Time),
}

impl Fault {
    /// The fault at position `number` of its list, acting on the `place`th of its variables, with
    /// the random stream of `seed`, in a run that begins at `start`.
    pub(crate) fn acting(&self, seed: u64, number: u32, place: u32, start: Time) -> Acting {
        let from = self.begins(seed, number, start);
        let own = if self.kind.is_common() { 1 } else { 2 + u64::from(place) };
        let random = Random::new(&[seed, u64::from(number), own]);
        let end = self.ends(seed, number);
        Acting::new(number, self.kind.clone(), from, end, random)
            .ramped(self.ramp_in, self.ramp_out)
            .sampled(self.every)
    }

    /// The instant at which the fault begins, the same for all its variables; `None` while that
    /// depends on a condition.
    pub(crate) fn begins(&self, seed: u64, number: u32, start: Time) -> Option<Time> {
        match &self.begin {
            Begin::Start => Some(start),
            Begin::At(time) => Some(*time),
            Begin::Between(first, last) => {
                Some(drawn(&[seed, u64::from(number), 0], *first, *last))
            }
            Begin::When(_) => None,
        }
    }

    /// When the fault ends, with its duration if that is random: the same for all its variables.
    pub(crate) fn ends(&self, seed: u64, number: u32) -> End {
        match self.end {
            End::AfterBetween(least, most) => {
                End::After(drawn(&[seed, u64::from(number), 0, 1], least, most))
            }
            end => end,
        }
    }
}

/// A time between two, uniformly distributed, from the random stream with this address.
fn drawn(address: &[u64], least: Time, most: Time) -> Time {
    let part = Random::new(address).uniform();
    least + Time::from_ns((part * (most - least).ns() as f64) as i64)
}
