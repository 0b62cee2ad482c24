//! Faults and disturbances of a variable: what a sensor, a link or an actuator does wrong.
//!
//! A fault acts on the steps of its component that begin in `[from, until)`: on an input or a
//! parameter during the step, on an output from the step's end on. It has a random stream of its
//! own and a state that changes once a step, however often values are asked for, and belongs to
//! snapshots: the same bits in one process, distributed and resumed.

mod acting;
mod kind;
mod random;
mod schema;
mod window;

pub(crate) use acting::{Acting, Way};
pub(crate) use random::{Random, normal_quantile};

pub use kind::{KINDS, Kind, Meant, Meanwhile, Spread, Word};
pub use schema::schema;
pub use window::Window;

use crate::condition::Condition;
use crate::time::Time;

/// A fault as it is described.
#[derive(Debug, Clone)]
pub struct Fault {
    /// The variables that it acts on, as in the results; `*` and `?` make a pattern.
    pub variables: Vec<String>,
    /// What it does.
    pub kind: Kind,
    /// When it is put in its place: what it remembers begins there, and so do its random numbers;
    /// with the run if nothing is said.
    pub installed: Option<Time>,
    /// When it begins.
    pub begin: Begin,
    /// When it ends.
    pub end: End,
    /// During so long after its beginning it grows.
    pub ramp_in: Time,
    /// During so long before its end it fades.
    pub ramp_out: Time,
    /// The time between samples, of kinds that act on samples; 0 if each step is one.
    pub every: Time,
}

/// When a fault begins.
#[derive(Debug, Clone)]
pub enum Begin {
    /// With the run.
    Start,
    /// At this instant.
    At(Time),
    /// At an instant between these two, drawn with equal chances.
    Between(Time, Time),
    /// At the first output instant at which this holds.
    When(Condition),
}

/// When a fault ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// With the run.
    Never,
    /// At this instant.
    At(Time),
    /// So long after its beginning.
    After(Time),
}

impl Fault {
    /// The fault with this number in its list, acting on the `place`th of its variables, with the
    /// random stream that belongs to `seed`, in a run that begins at `start`.
    pub(crate) fn acting(&self, seed: u64, number: u32, place: u32, start: Time) -> Acting {
        let from = self.begins(seed, number, start);
        let own = if self.kind.is_common() { 1 } else { 2 + u64::from(place) };
        let random = Random::new(&[seed, u64::from(number), own]);
        Acting::new(number, self.kind.clone(), from, self.end, random)
            .ramped(self.ramp_in, self.ramp_out)
            .sampled(self.every)
    }

    /// The instant at which the fault begins, the same for all of its variables; none while that
    /// depends on a condition.
    pub(crate) fn begins(&self, seed: u64, number: u32, start: Time) -> Option<Time> {
        match &self.begin {
            Begin::Start => Some(start),
            Begin::At(time) => Some(*time),
            Begin::Between(first, last) => {
                let span = (*last - *first).nanoseconds() as f64;
                let part = Random::new(&[seed, u64::from(number), 0]).uniform();
                Some(*first + Time::from_nanoseconds((part * span) as i64))
            }
            Begin::When(_) => None,
        }
    }
}
